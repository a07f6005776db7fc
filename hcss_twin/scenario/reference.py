"""JSON schema of scenario files, and descriptions of pydantic fields for reference pages."""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from annotated_types import Ge, Gt, Le, Lt, MaxLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from hcss_twin.scenario.models import ScenarioModel


@dataclass(frozen=True)
class FieldText:
    """Description of a field in Markdown.

    Attributes
    ----------
    name, type, allowed, default, description : str
        ``allowed`` contains the limits of numbers and lists; the default is empty if it is None.
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
    """Return whether an annotation is a pydantic model."""
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


def json_schema(owned: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """JSON schema of scenario files, with the schemas of sections that plugins own."""
    schema = ScenarioModel.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "hcss_twin scenario"
    # Text with a unit is allowed for every quantity, and the keys of a single layer in [clouds].
    for definition in (schema, *schema.get("$defs", {}).values()):
        for name, entry in definition.get("properties", {}).items():
            _allow_quantity(name, entry)
    # Part of a file for `hcss sweep`, which checks it.
    schema["properties"]["sweep"] = {"type": "object", "description": "Keys with many values (docs/how-to/sweeps.md)."}
    for name, section_schema in (owned or {}).items():
        schema["$defs"].update(section_schema.pop("$defs", {}))
        for key, entry in section_schema.get("properties", {}).items():
            _allow_quantity(key, entry)
        schema["properties"][name] = section_schema
    layer = schema["$defs"]["Layer"]["properties"]
    schema["$defs"]["Clouds"]["properties"].update(layer)
    return schema


def _allow_quantity(name: str, entry: dict[str, Any]) -> None:
    if entry.get("type") == "number" and name not in _PLAIN:
        entry["anyOf"] = [{key: entry.pop(key) for key in list(entry) if key in _NUMBER_KEYS}]
    choices = entry.get("anyOf", [])
    for choice in choices:
        # Pydantic does not rename the limits of optional numbers.
        for key, keyword in _KEYWORDS.items():
            if key in choice:
                choice[keyword] = choice.pop(key)
    if name not in _PLAIN and any(choice.get("type") == "number" for choice in choices):
        text = {"type": "string", "pattern": _NEDT if name == "nedt" else _QUANTITY}
        choices.append(text)
        for choice in choices:
            if choice.get("additionalProperties") == {"type": "number"}:  # a table by band
                choice["additionalProperties"] = {"anyOf": [{"type": "number"}, text]}


_PLAIN = ("water_vapour_scale", "water_vapour_column", "effective_variance", "strength", "f_number", "cold_shield")
"""Plain numbers only."""

_QUANTITY = r"^\s*[-+0-9.eE]+\s*\S*\s*$"
_NEDT = r"^\s*[-+0-9.eE]+\s*\S*(\s+at\s+[-+0-9.eE]+\s*\S*)?\s*$"
"""Text of a quantity, and of a temperature difference at a temperature."""

_KEYWORDS = {"ge": "minimum", "le": "maximum", "gt": "exclusiveMinimum", "lt": "exclusiveMaximum"}
_NUMBER_KEYS = ("type", *_KEYWORDS.values())
