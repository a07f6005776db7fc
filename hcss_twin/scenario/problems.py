"""Turn validation errors into sentences: field, value, what is allowed, closest valid choice."""

from __future__ import annotations

import typing
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from hcss_twin.errors import Problem, choose_from


def problems_from(error: ValidationError, model: type[BaseModel], prefix: str = "") -> list[Problem]:
    """Translate every error of one pydantic validation.

    Parameters
    ----------
    error : ValidationError
        From validating ``model``.
    model : type
        The model that was validated; used to look up ranges and known keys.
    prefix : str
        Path put before every field, for example ``clouds.layers[0].parameters``.
    """
    return [_problem(detail, model, prefix) for detail in _first_per_location(error.errors())]


def dotted(location: tuple[int | str, ...]) -> str:
    """Write a location as a key path: ``("bands", 0)`` as ``bands[0]``."""
    text = ""
    for part in location:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += f".{part}" if text else part
    return text


def _problem(detail: ErrorDetails, model: type[BaseModel], prefix: str) -> Problem:
    location = _known_location(detail["loc"], model)
    name = dotted((prefix, *location) if prefix else location) or "scenario"
    return Problem(name, _sentence(detail, model, location))


def _sentence(detail: ErrorDetails, model: type[BaseModel], location: tuple[int | str, ...]) -> str:
    kind, value = detail["type"], detail.get("input")
    if kind == "extra_forbidden":
        owner = _model_at(model, location[:-1])
        return f"unknown key; {choose_from(str(location[-1]), owner.model_fields if owner else ())}"
    if kind == "missing":
        return f"is missing; {_description(model, location)}"
    if kind in ("greater_than_equal", "greater_than", "less_than_equal", "less_than", "finite_number"):
        return f"{value} is out of range; {_range(model, location, value)}"
    if kind == "timezone_aware":
        return f"{value} has no zone; allowed: date and time with zone; closest is {value}+00:00"
    if kind == "literal_error":
        choices = (
            str(detail.get("ctx", {}).get("expected", "")).replace("'", "").replace(" or ", ", ").split(", ")
        )
        return f"'{value}' is not a choice; {choose_from(str(value), choices)}"
    if kind in ("too_long", "too_short", "string_too_short", "string_too_long"):
        return f"{detail['msg'][0].lower()}{detail['msg'][1:]}"
    if kind in ("model_type", "dict_type"):
        owner = _model_at(model, location)
        keys = f" with the keys {', '.join(owner.model_fields)}" if owner else ""
        return f"{value!r} is not a table; allowed: a table{keys}"
    if kind.endswith(("_type", "_parsing")) or kind == "int_from_float":
        wanted = {
            "float": "a number",
            "int": "a whole number",
            "string": "text",
            "bool": "true or false",
            "tuple": "a list",
            "datetime": "a date and time with zone, for example 2024-04-20T12:30:00+10:00",
        }.get(kind.split("_")[0], kind.split("_")[0])
        return f"{value!r} is not {wanted}; {_range(model, location, value)}".rstrip("; ")
    return detail["msg"]


def _range(model: type[BaseModel], location: tuple[int | str, ...], value: object) -> str:
    """Allowed range of a number and the valid value closest to ``value``."""
    low, high, text = None, None, []
    for constraint in _constraints(model, location):
        for attribute, sign in (("ge", ">="), ("gt", ">"), ("le", "<="), ("lt", "<")):
            bound = getattr(constraint, attribute, None)
            if isinstance(bound, int | float):
                text.append(f"{sign} {bound:g}" if isinstance(bound, float) else f"{sign} {bound}")
                if attribute == "ge":
                    low = bound
                elif attribute == "le":
                    high = bound
    if not text:
        return ""
    sentence = f"allowed: {' and '.join(text)}"
    if isinstance(value, int | float) and not isinstance(value, bool):
        if low is not None and value < low:
            sentence += f"; closest valid choice is {low}"
        elif high is not None and value > high:
            sentence += f"; closest valid choice is {high}"
    return sentence


def _constraints(model: type[BaseModel], location: tuple[int | str, ...]) -> Iterator[object]:
    owner = _model_at(model, location[:-1])
    name = location[-1] if location else None
    if owner is None or name not in owner.model_fields:
        return
    yield from owner.model_fields[str(name)].metadata


def _description(model: type[BaseModel], location: tuple[int | str, ...]) -> str:
    owner = _model_at(model, location[:-1])
    if owner is None or not location or location[-1] not in owner.model_fields:
        return "required"
    return owner.model_fields[str(location[-1])].description or "required"


def _known_location(location: tuple[int | str, ...], model: type[BaseModel]) -> tuple[int | str, ...]:
    """Drop the tags that unions add to a location (they name a type, not a key)."""
    kept: list[int | str] = []
    for index, part in enumerate(location):
        owner = _model_at(model, tuple(kept))
        is_key = owner is not None and part in owner.model_fields
        # The last part of an unknown key is no field, yet must be kept.
        if isinstance(part, int) or is_key or (index == len(location) - 1 and owner is not None):
            kept.append(part)
    return tuple(kept)


def _model_at(model: type[BaseModel], location: tuple[int | str, ...]) -> type[BaseModel] | None:
    """Model found by walking the keys of a location; list indices stay inside their element's model."""
    current = model
    for part in location:
        if isinstance(part, int):
            continue
        if part not in current.model_fields:
            return None
        nested = next(_models_in(current.model_fields[part].annotation), None)
        if nested is None:
            return None
        current = nested
    return current


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in typing.get_args(annotation):
        yield from _models_in(argument)


def _first_per_location(details: list[ErrorDetails]) -> list[ErrorDetails]:
    """Keep one error per value: a union reports every branch it tried, tagged with the branch's type."""
    kept: dict[tuple[int | str, ...], ErrorDetails] = {}
    for detail in details:
        location = tuple(part for part in detail["loc"] if not _is_union_tag(part))
        kept.setdefault(location, detail)
    return list(kept.values())


def _is_union_tag(part: int | str) -> bool:
    return isinstance(part, str) and (part[:1].isupper() or "[" in part or part in ("float", "str", "int"))
