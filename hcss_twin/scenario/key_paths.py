"""Paths of keys in nested models: how they are written, which model is at one, and at which a key is known."""

from __future__ import annotations

import typing
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

Location = tuple[int | str, ...]
"""Keys and, in lists, indices from the model down to a value."""

REPEATED = ("layers",)
"""Lists of sections with keys that are also allowed in the parent section."""


def dotted(location: Location) -> str:
    """Write a location as a key path: ``("bands", 0)`` as ``bands[0]``."""
    text = ""
    for part in location:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += f".{part}" if text else part
    return text


def homes(model: type[BaseModel], key: str, path: str = "") -> Iterator[str]:
    """Yield the dotted paths at which a key of this name is known, nested sections after their parents."""
    if key in model.model_fields:
        yield f"{path}{key}"
    for name, field in model.model_fields.items():
        for nested in _models_in(field.annotation):
            single = nested is field.annotation or type(None) in typing.get_args(field.annotation)
            nested_path = f"{path}{name}{'' if single else '[0]'}."
            # the keys of a single layer are allowed in [clouds] itself
            yield from homes(nested, key, path if name in REPEATED else nested_path)


def model_at(model: type[BaseModel], location: Location, key: int | str | None = None) -> type[BaseModel] | None:
    """Return the model at a location; list indices refer to the element model.

    If several models are possible, return the first one with ``key``, or else the first.
    """
    models = models_at(model, location)
    return next((candidate for candidate in models if key in candidate.model_fields), models[0] if models else None)


def models_at(model: type[BaseModel], location: Location) -> list[type[BaseModel]]:
    """Return all models that are possible at a location."""
    current = [model]
    for part in location:
        if isinstance(part, int):
            continue
        fields = [candidate.model_fields[part] for candidate in current if part in candidate.model_fields]
        current = [nested for field in fields for nested in _models_in(field.annotation)]
    return current


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in typing.get_args(annotation):
        yield from _models_in(argument)
