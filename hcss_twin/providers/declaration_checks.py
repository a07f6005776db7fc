"""Checks of what a provider declares, before anything relies on it: names, ranges and types of its fields."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Set
from dataclasses import fields
from typing import Any

from hcss_twin.core.errors import choose_from
from hcss_twin.providers.common import LEGS


def check_declaration(declares: Any) -> None:
    """Check the names, ranges and types of a declaration.

    Raises
    ------
    ValueError
        If it names an unknown dependency or range, a range is not (low, high), the native grid does not ascend, or
        another field has the wrong type.
    """
    for field in fields(declares):
        check = _CHECKS.get(field.name)
        if check is not None:
            check(f"declares.{field.name}", getattr(declares, field.name), field.metadata.get("among", ()))


def _check_dependencies(name: str, value: Any, allowed: tuple[str, ...]) -> None:
    for dependency in value or ():
        if dependency not in allowed:
            raise ValueError(f"{name} names '{dependency}'; {choose_from(dependency, allowed)}")


def _check_ranges(name: str, value: Any, allowed: tuple[str, ...]) -> None:
    for quantity, bounds in value.items():
        if quantity not in allowed:
            raise ValueError(
                f"{name} names '{quantity}', which the engine does not use; {choose_from(quantity, allowed)}"
            )
        if len(bounds) != 2 or not bounds[0] <= bounds[1]:
            raise ValueError(f"{name}['{quantity}'] is {bounds}; expected (low, high)")


def _check_legs(name: str, value: Any, _: tuple[str, ...]) -> None:
    if value not in LEGS:
        raise ValueError(f"{name} is {value!r}; {choose_from(str(value), LEGS)}")


def _check_resolution(name: str, value: Any, _: tuple[str, ...]) -> None:
    if not (math.isfinite(value) and value >= 0.0):
        raise ValueError(f"{name} is {value!r}; allowed: 0 or more")


def _check_texts(name: str, value: Any, _: tuple[str, ...] = ()) -> None:
    # a single string is a sequence of letters, each of which would become a note
    if not isinstance(value, tuple) or not all(isinstance(text, str) for text in value):
        raise ValueError(f"{name} is {value!r}; expected a tuple of strings")


def _check_texts_by_name(name: str, value: Any, _: tuple[str, ...]) -> None:
    for key, texts in value.items():
        _check_texts(f"{name}['{key}']", texts)


def _check_materials(name: str, value: Any, _: tuple[str, ...]) -> None:
    if (
        not isinstance(value, Set)
        or not value
        or not all(isinstance(material, str) and re.fullmatch("[a-z][a-z0-9-]*", material) for material in value)
    ):
        raise ValueError(f"{name} is {value!r}; expected a set of names of lower-case letters, digits and hyphens")


def _check_flag(name: str, value: Any, _: tuple[str, ...]) -> None:
    if not isinstance(value, bool):
        raise ValueError(f"{name} is {value!r}; expected True or False")


def _check_reach(name: str, value: Any, _: tuple[str, ...]) -> None:
    if value is not None and (isinstance(value, bool) or not isinstance(value, int) or value < 0):
        raise ValueError(f"{name} is {value!r}; expected None or a whole number, 0 or more")


def _check_grid(name: str, value: Any, _: tuple[str, ...]) -> None:
    if value is None:
        return
    import numpy as np

    nodes = np.asarray(value)
    if nodes.ndim != 1 or nodes.size < 2 or nodes.dtype.kind != "f" or not np.all(np.diff(nodes) > 0.0):
        raise ValueError(
            f"{name} has shape {nodes.shape} and type {nodes.dtype}; expected two or more "
            "ascending floating-point wavenumbers"
        )


_CHECKS: Mapping[str, Callable[[str, Any, tuple[str, ...]], None]] = {
    "depends_on": _check_dependencies,
    "valid": _check_ranges,
    "legs": _check_legs,
    "resolution_cm1": _check_resolution,
    "notes": _check_texts,
    "own_errors": _check_texts,
    "notes_by_material": _check_texts_by_name,
    "notes_by_phase": _check_texts_by_name,
    "materials": _check_materials,
    "evolves": _check_flag,
    "tileable": _check_flag,
    "remembers": _check_flag,
    "reach_pixels": _check_reach,
    "native_grid_cm1": _check_grid,
}
