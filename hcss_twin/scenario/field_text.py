"""What a field of a pydantic model takes, in words: for the reference of scenarios and for ``hcss plugins NAME``."""

from __future__ import annotations

import types
import typing
from dataclasses import dataclass
from typing import Any

from annotated_types import Ge, Gt, Le, Lt, MaxLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo


@dataclass(frozen=True)
class FieldText:
    """A field in words; Markdown.

    Attributes
    ----------
    name, type, allowed, default, description : str
        ``allowed`` has the limits of numbers and lists; the default is empty where it is None.
    """

    name: str
    type: str
    allowed: str
    default: str
    description: str


def field_text(name: str, field: FieldInfo) -> FieldText:
    """Describe a field of a model."""
    return FieldText(name, _type(field.annotation), _allowed(field), _default(field), field.description or "")


def is_model(annotation: Any) -> bool:
    """Whether an annotation is a pydantic model."""
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _type(annotation: Any) -> str:
    if annotation is type(None):
        return ""
    origin = typing.get_origin(annotation)
    if origin is typing.Annotated:
        return _type(typing.get_args(annotation)[0])
    if origin is typing.Literal:
        return " or ".join(f'`"{value}"`' for value in typing.get_args(annotation))
    if origin in (typing.Union, types.UnionType):
        return " or ".join(text for text in map(_type, typing.get_args(annotation)) if text)
    if origin in (tuple, list):
        return "list"
    if origin is dict:
        return "table"
    names = {float: "number", int: "whole number", str: "text", bool: "true/false"}
    return names.get(annotation, "table" if is_model(annotation) else "date and time")


def _allowed(field: FieldInfo) -> str:
    parts = []
    for constraint in field.metadata:
        for kind, sign in ((Ge, "≥"), (Gt, ">"), (Le, "≤"), (Lt, "<")):
            if isinstance(constraint, kind):
                parts.append(f"{sign} {getattr(constraint, kind.__name__.lower()):g}")
        if isinstance(constraint, MaxLen):
            parts.append(f"length ≤ {constraint.max_length}")
    return ", ".join(parts)


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "**required**"
    if field.default_factory is not None or field.default is None:
        return ""
    default = field.default
    if isinstance(default, tuple):
        return f"`{list(default)}`" if default else "none"
    if isinstance(default, bool):
        return f"`{str(default).lower()}`"
    if default == "":
        return "empty"
    return f"`{default:g}`" if isinstance(default, float) else f"`{default}`"
