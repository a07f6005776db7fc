"""Conversion of validation errors to sentences: field, value, allowed values, closest valid choice."""

from __future__ import annotations

import math
import typing
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ScenarioError, choose_from, listed
from hcss_twin.core.units import QuantityOf, in_plain_units, meant_in
from hcss_twin.scenario.key_paths import Location, dotted, homes, model_at, models_at

Model = TypeVar("Model", bound=BaseModel)

_BOUNDS = (("ge", ">="), ("gt", ">"), ("le", "<="), ("lt", "<"))
_RANGE_KINDS = {"greater_than_equal": "ge", "greater_than": "gt", "less_than_equal": "le", "less_than": "lt"}


def problems_from(error: ValidationError, model: type[BaseModel], prefix: str = "", raw: Any = None) -> list[Problem]:
    """Convert every error of a pydantic validation.

    Parameters
    ----------
    error : ValidationError
        Raised by the validation of ``model``.
    model : type
        The validated model, for ranges and known keys.
    prefix : str
        Prefix of every field path, for example ``clouds.layers[0].parameters``.
    raw : mapping, optional
        Validated data, to quote values as typed (``'130%'`` instead of 1.3).
    """
    # A union reports every branch it tried; the first is the relevant one.
    details: dict[Location, ErrorDetails] = {}
    for detail in error.errors(include_url=False):
        details.setdefault(_keys(detail, model), detail)
    problems = []
    for location, detail in details.items():
        inside = (other for other in details if other[: len(location)] == location != other)
        if detail["type"] == "too_short" and any(inside):
            continue  # pydantic counts the remaining entries
        if detail["type"] == "invalid_key":
            location = tuple(map(str, detail["loc"]))
        name = dotted((prefix, *location) if prefix else location) or "scenario"
        problems.append(Problem(name, _sentence(detail, model, location, raw)))
    return problems


def read_model(model: type[Model], catalog: Catalog, path: Path) -> Model:
    """Read a TOML file of a catalog as a model; raises ScenarioError with the file as its ``origin``."""
    raw = catalog.toml(path)
    try:
        return model.model_validate(raw)
    except ValidationError as error:
        raise ScenarioError(problems_from(error, model, raw=raw), str(path)) from error


def _sentence(detail: ErrorDetails, model: type[BaseModel], location: Location, raw: Any) -> str:
    kind, value = detail["type"], detail.get("input")
    if kind == "extra_forbidden":
        return _unknown_key(model, location)
    if kind == "missing":
        return f"is missing; {_description(model, location)}"
    if kind == "invalid_key":
        return "is not a key; keys are text"
    if kind in _RANGE_KINDS:
        typed, number = _typed(value, location, raw)
        meant = _in_another_unit(model, location, number) if typed == Problem.shown(number) else None
        return f"{typed} is out of range; {_range(model, location, number, detail, meant)}"
    if kind == "finite_number":
        return f"{Problem.shown(value)} is not a finite number; {_range(model, location) or 'allowed: a finite number'}"
    if kind == "literal_error":
        expected = str(detail.get("ctx", {}).get("expected", "")).replace("'", "")
        choices = expected.replace(" or ", ", ").split(", ")
        return f"{Problem.shown(value)} is not a choice; {choose_from(str(value), choices)}"
    if kind in ("too_long", "too_short", "string_too_short", "string_too_long"):
        return _wrong_length(detail)
    if kind in ("model_type", "dict_type"):
        owner = model_at(model, location)
        keys = f" with the keys {', '.join(owner.model_fields)}" if owner else ""
        return f"{Problem.shown(value)} is not a table; allowed: a table{keys}"
    if kind == "tuple_type":
        # A single entry without brackets.
        guess = listed(value) if _takes_text(_annotation(model, location)) else None
        hint = f"; closest valid choice is {guess}" if guess else ""
        return (
            f"{Problem.shown(value)} is not a list; allowed: a list ({_description(model, location).rstrip('.')}){hint}"
        )
    if kind.endswith(("_type", "_parsing", "_parsing_size")) or kind == "int_from_float":
        return _wrong_type(kind, value, model, location)
    return detail["msg"].removeprefix("Value error, ")


def _unknown_key(model: type[BaseModel], location: Location) -> str:
    key = str(location[-1])
    keys = list(dict.fromkeys(name for owner in models_at(model, location[:-1]) for name in owner.model_fields))
    # A known key in the wrong section is a better match than a similarly spelt key of this section.
    known = [repr(home) for home in dict.fromkeys(homes(model, key))]
    if not known:
        return f"unknown key; {choose_from(key, keys)}"
    where = " at the top level" if known == [repr(key)] else ""
    return f"unknown key; allowed: {', '.join(sorted(keys))}; closest is {' or '.join(known)}{where}"


def _wrong_type(kind: str, value: object, model: type[BaseModel], location: Location) -> str:
    wanted = {"float": "a number", "int": "a whole number", "string": "text", "bool": "true or false"}.get(
        kind.split("_")[0], kind.split("_")[0]
    )
    allowed = _range(model, location)
    if isinstance(value, int) and not isinstance(value, bool) and kind.startswith("float"):
        wanted = "in the range of floating-point numbers"
    return f"{Problem.shown(value)} is not {wanted}" + (f"; {allowed}" if allowed else "")


def _wrong_length(detail: ErrorDetails) -> str:
    context, value = detail.get("ctx", {}), detail.get("input")
    noun = ("character", "characters") if detail["type"].startswith("string") else ("entry", "entries")
    size = len(value) if isinstance(value, str | list | tuple) else int(context.get("actual_length") or 0)
    given = count(size, *noun) if size else "is empty"
    if "max_length" in context:
        return f"{given}; allowed: at most {context['max_length']}"
    return f"{given}; allowed: at least {count(context.get('min_length', 1), *noun)}"


def _typed(value: object, location: Location, raw: Any) -> tuple[str, object]:
    """Quote a value as typed; also return its number."""
    for part in location:
        try:
            raw = raw[part]
        except (KeyError, IndexError, TypeError):
            raw = value
            break
    text = next((candidate for candidate in (raw, value) if isinstance(candidate, str)), None)
    if text is None:
        return Problem.shown(value), value
    number = in_plain_units(text) if isinstance(value, str) else value
    plain = f" = {number:g}" if isinstance(number, float) and text.strip() != f"{number:g}" else ""
    return f"{Problem.shown(text)}{plain}", number


def _range(
    model: type[BaseModel],
    location: Location,
    value: object = None,
    detail: ErrorDetails | None = None,
    meant: str | None = None,
) -> str:
    """Allowed range of a number, and the closest or probably intended valid value."""
    bounds = _bounds(model, location)
    if not bounds and detail is not None:
        numbers = {key: bound for key, bound in detail.get("ctx", {}).items() if isinstance(bound, int | float)}
        bounds = {key: numbers[key] for key, _ in _BOUNDS if key in numbers}
    if not bounds:
        return ""
    parts = [f"{sign} {_bound(bounds[key])}" for key, sign in _BOUNDS if key in bounds]
    sentence = f"allowed: {' and '.join(parts)}"
    guess = meant or _nearest(bounds, value, detail, _annotation(model, location) is int)
    return f"{sentence}; closest valid choice is {guess}" if guess else sentence


def _in_another_unit(model: type[BaseModel], location: Location, value: object) -> str | None:
    """Value in plain units if a plain number was probably meant in another unit, such as percent or km."""
    owner, name = model_at(model, location[:-1], location[-1] if location else None), str(location[-1:])
    if owner is None or location[-1] not in owner.model_fields or not isinstance(value, int | float):
        return None
    field, bounds = owner.model_fields[str(location[-1])], _bounds(model, location)
    dimension = next(_dimensions(field.metadata, field.annotation), "temperature" if "temperature" in name else "")
    low = max(bounds.get("ge", -math.inf), bounds.get("gt", -math.inf))
    return meant_in(dimension, value, low, min(bounds.get("le", math.inf), bounds.get("lt", math.inf)))


def _dimensions(metadata: Iterable[object], annotation: Any) -> Iterator[str]:
    """Dimension of a quantity, from its field or, if it is optional, from the type inside."""
    parsers = (getattr(constraint, "func", None) for constraint in metadata)
    yield from (parser.dimension for parser in parsers if isinstance(parser, QuantityOf))
    for argument in typing.get_args(annotation):
        yield from _dimensions(getattr(argument, "__metadata__", ()), None)


def _nearest(bounds: Mapping[str, float], value: object, detail: ErrorDetails | None, whole: bool) -> str | None:
    broken = _RANGE_KINDS.get(detail["type"]) if detail else None
    if broken is None or broken not in bounds:
        return None
    bound = bounds[broken]
    if bounds.get("ge") == 0 and bounds.get("lt") == 360 and isinstance(value, int | float):
        return f"{value % 360:g}, the same direction"
    if broken in ("ge", "le"):
        return _bound(bound)
    if whole:
        return str(bound + 1 if broken == "gt" else bound - 1)
    return f"just {'above' if broken == 'gt' else 'below'} {_bound(bound)}"


def _bound(value: float) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _bounds(model: type[BaseModel], location: Location) -> dict[str, float]:
    """Limits of the number at a location, from its field or, inside a list, from the element type."""
    *path, last = location or ("",)
    element_index = 0
    while isinstance(last, int) and path:
        element_index, last = last, path.pop()
    owner = model_at(model, tuple(path), last)
    if owner is None or last not in owner.model_fields:
        return {}
    field = owner.model_fields[str(last)]
    inside = isinstance(location[-1], int)
    metadata = list(_element_metadata(field.annotation, element_index)) if inside else field.metadata
    bounds: dict[str, float] = {}
    for constraint in metadata:
        for key, _ in _BOUNDS:
            bound = getattr(constraint, key, None)
            if isinstance(bound, int | float):
                bounds[key] = bound
    return bounds


def _element_metadata(annotation: Any, element_index: int) -> Iterator[object]:
    """Constraints of one element of a tuple type, or of the tuple inside an optional type."""
    arguments = typing.get_args(annotation)
    if typing.get_origin(annotation) is not tuple:
        for argument in arguments:
            yield from _element_metadata(argument, element_index)
    elif arguments:
        element = arguments[min(element_index, len(arguments) - 1)]
        element = arguments[0] if element is Ellipsis else element
        for constraint in getattr(element, "__metadata__", ()):
            yield from getattr(constraint, "metadata", (constraint,))


def _description(model: type[BaseModel], location: Location) -> str:
    owner = model_at(model, location[:-1], location[-1] if location else None)
    if owner is None or not location or location[-1] not in owner.model_fields:
        return "required"
    return owner.model_fields[str(location[-1])].description or "required"


def _annotation(model: type[BaseModel], location: Location) -> Any:
    owner = model_at(model, location[:-1], location[-1] if location else None)
    known = owner is not None and location and location[-1] in owner.model_fields
    return owner.model_fields[str(location[-1])].annotation if owner and known else None


def _takes_text(annotation: Any) -> bool:
    return annotation is str or any(map(_takes_text, typing.get_args(annotation)))


def _keys(detail: ErrorDetails, model: type[BaseModel]) -> Location:
    """Location without the tags added by unions (they name a type, not a key)."""
    location, keys = detail["loc"], list[int | str]()
    for index, part in enumerate(location):
        owner = model_at(model, tuple(keys), part)
        is_last = index == len(location) - 1
        is_key = owner is not None and part in owner.model_fields
        if isinstance(part, int) or is_key or (is_last and detail["type"] == "extra_forbidden"):
            keys.append(part)
    return tuple(keys)


def count(number: int, noun: str, plural: str) -> str:
    """Write a number with its noun: ``1 entry``, ``2 entries``."""
    return f"{number} {noun if number == 1 else plural}"
