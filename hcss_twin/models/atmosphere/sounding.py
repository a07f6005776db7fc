"""Reader for user profiles and radiosonde soundings in CSV, IGRA 2 or NetCDF; see docs/how-to/atmospheres.md.

Levels of measured ascents are kept as far as a profile can use them: those without a value, and those that repeat a
pressure, are left out and reported.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.reading import Reading
from hcss_twin.models.atmosphere.igra import is_igra, read_igra
from hcss_twin.models.atmosphere.moist_air import GRAVITY_M_S2
from hcss_twin.models.atmosphere.profile_columns import (
    HUMIDITIES,
    QUANTITIES,
    ProfileQuantity,
    Unit,
    named,
    recognised,
    unit_of,
)
from hcss_twin.models.atmosphere.time_choice import TimeChoice
from hcss_twin.models.atmosphere.usable_levels import usable_levels

_IGRA_UNITS = {"pressure": (1.0, 0.0), "geopotential_height": (1.0, 0.0), "temperature": (1.0, 273.15),
               "relative_humidity": (0.01, 0.0), "dewpoint": (1.0, 273.15)}  # fmt: skip

NETCDF_SUFFIXES = (".nc", ".nc4", ".cdf", ".netcdf")
MAX_LEVELS = 100_000

PACKING = 1e-3
"""Largest negative value that packing into 16 bits can make of a humidity near 0, relative to the largest value."""

UNREADABLE = "not a readable NetCDF file"


@dataclass(frozen=True)
class Sounding:
    """Levels of a profile file, in SI units.

    Attributes
    ----------
    name : str
        Name of the file as the user gave it, for messages.
    where : tuple of str (L,)
        Position of each level in the file, for messages: ``line 12`` or ``level 3``.
    columns : mapping of str to ndarray (L,)
        ProfileQuantity (``profile_columns``) to values; every value finite and within its physical limits.
    notes : tuple of str
        Notes on unused columns and levels.
    """

    name: str
    where: tuple[str, ...]
    columns: Mapping[str, Array]
    notes: tuple[str, ...] = ()


def read_sounding(path: Path, name: str, time: datetime | None = None) -> Sounding:
    """Read the levels of a profile file.

    Parameters
    ----------
    path : Path
        NetCDF according to its suffix, otherwise text: comma-separated, or soundings of IGRA 2.
    name : str
        For messages.
    time : datetime, optional
        Of several times in the file, the nearest to this one is read.

    Raises
    ------
    CatalogError
        If the file is malformed, a quantity is missing, or a value is missing or impossible; the message names the line
        or level.
    """
    if path.suffix.lower() in NETCDF_SUFFIXES:
        with Reading(path, CatalogError, UNREADABLE).netcdf() as dataset:
            choice = TimeChoice.of(dataset, name, time)
            variables = profile_variables(dataset, name)
            arrays = [_one_column(choice.values_of(each.data), each.label, name) for each in variables]
            return sounding_of(name, variables, arrays, choice.notes)
    with Reading(path, CatalogError, "not a text file"):
        text = path.read_text(encoding="utf-8-sig")
    if is_igra(text):
        where, values, notes = read_igra(text, name, time)
        si = {
            field: _in_si(values[field], QUANTITIES[field], unit, field, where, name)
            for field, unit in _IGRA_UNITS.items()
        }
        return _finished(name, where, si, notes)
    return _finished(name, *_read_csv(text, name), ())


def _finished(name: str, where: tuple[str, ...], columns: dict[str, Array], notes: tuple[str, ...] = ()) -> Sounding:
    """Return the sounding of a file's columns, which must contain one humidity and one height."""
    if "geopotential" in columns:
        columns["geopotential_height"] = columns.pop("geopotential") / GRAVITY_M_S2
    for required in ("pressure", "temperature"):
        if required not in columns:
            quantity = QUANTITIES[required]
            raise CatalogError(
                f"{name}: {required} is missing; allowed names: {', '.join(quantity.spellings)} in "
                f"{', '.join(quantity.units)}"
            )
    told = [*notes, *_set_aside(columns, name)]
    where, columns, left_out = usable_levels(name, where, columns)
    return Sounding(name, where, columns, (*told, *left_out))


def _read_csv(text: str, name: str) -> tuple[tuple[str, ...], dict[str, Array]]:
    lines = _lines(text)
    number, header = next(lines, (0, None))
    if header is None:
        raise CatalogError(f"{name}: no row of column names")
    used: dict[int, tuple[ProfileQuantity, Unit, str]] = {}
    for index, head in enumerate(header):
        try:
            match = recognised(head)
        except ValueError as error:
            raise CatalogError(f"{name}, line {number}: {error}") from error
        if match is None:
            continue
        quantity, unit = match
        _refuse_twice(used, quantity, head, f"{name}, line {number}")
        used[index] = (quantity, unit, head)
    where, rows = [], []
    for number, fields in lines:
        line = f"line {number}"
        if len(fields) != len(header):
            raise CatalogError(f"{name}, {line}: {len(fields)} fields, the header has {len(header)}")
        rows.append([_number(fields[index], used[index][2], f"{name}, {line}") for index in used])
        where.append(line)
        if len(rows) > MAX_LEVELS:
            raise CatalogError(f"{name}: more than {MAX_LEVELS} levels")
    if not rows:
        raise CatalogError(f"{name}: no levels; at least 2 are needed")
    table = np.array(rows, dtype=np.float64)
    columns = {}
    for position, (quantity, unit, head) in enumerate(used.values()):
        columns[quantity.name] = _in_si(table[:, position], quantity, unit, head, where, name)
    return tuple(where), columns


def _lines(text: str) -> Iterator[tuple[int, list[str]]]:
    for number, line in enumerate(text.splitlines(), start=1):
        stripped = line.strip()
        if stripped and not stripped.startswith("#"):
            yield number, [field.strip() for field in stripped.split(",")]


def _number(text: str, head: str, where: str) -> float:
    """Return a number; NaN for an empty field."""
    if text.lower() in ("", "nan"):
        return math.nan
    try:
        value = float(text)
    except ValueError:
        raise CatalogError(f"{where}: {head} '{text}' is not a number; {_REMEDY}") from None
    if not math.isfinite(value):
        raise CatalogError(f"{where}: {head} is {text}; {_REMEDY}")
    return value


_REMEDY = "leave out the level, or end the profile below it (levels above are completed from a model)"


@dataclass(frozen=True)
class ProfileVariable:
    """A profile variable of an open NetCDF file."""

    quantity: ProfileQuantity
    unit: Unit
    label: str
    data: Any


def profile_variables(dataset: Any, name: str) -> list[ProfileVariable]:
    """Return the variables of a file that belong to a profile.

    Raises
    ------
    CatalogError
        If a unit is unknown, or two variables contain the same quantity.
    """
    used: dict[int, tuple[ProfileQuantity, Unit, str]] = {}
    variables = []
    for index, (label, variable) in enumerate(dataset.variables.items()):
        quantity = named((str(getattr(variable, "standard_name", "")), label), str(getattr(variable, "units", "")))
        if quantity is None:
            continue
        _refuse_twice(used, quantity, label, name)
        try:
            unit = unit_of(quantity, str(getattr(variable, "units", "")), label)
        except ValueError as error:
            raise CatalogError(f"{name}: {error}") from error
        used[index] = (quantity, unit, label)
        variables.append(ProfileVariable(quantity, unit, label, variable))
    return variables


def sounding_of(
    name: str, variables: Sequence[ProfileVariable], arrays: Sequence[Array], notes: tuple[str, ...] = ()
) -> Sounding:
    """Return the sounding at one place from the values (L,) of its variables.

    Raises
    ------
    CatalogError
        As :func:`read_sounding`.
    """
    sizes = {variable.label: array.size for variable, array in zip(variables, arrays, strict=True)}
    if len(set(sizes.values())) > 1:
        listed = ", ".join(f"{label} {size}" for label, size in sizes.items())
        raise CatalogError(f"{name}: the variables have different numbers of levels: {listed}")
    levels = next(iter(sizes.values()), 0)
    if sizes and not 2 <= levels <= MAX_LEVELS:
        raise CatalogError(f"{name}: {levels} levels; at least 2 are needed and {MAX_LEVELS} are allowed")
    where = tuple(f"level {number}" for number in range(1, levels + 1))
    columns = {}
    for variable, array in zip(variables, arrays, strict=True):
        bad = np.flatnonzero(~np.isfinite(array))
        if bad.size:
            raise CatalogError(f"{name}, {where[bad[0]]}: {variable.label} is missing; {_REMEDY}")
        array, noise = _without_noise(array, variable.quantity)
        if noise:
            notes = (*notes, f"profile '{name}': {noise} negative values of {variable.label} by packing taken as 0")
        columns[variable.quantity.name] = _in_si(array, variable.quantity, variable.unit, variable.label, where, name)
    return _finished(name, where, columns, notes)


def _without_noise(values: Array, quantity: ProfileQuantity) -> tuple[Array, int]:
    """Return values that cannot be negative without those that packing into integers made so, and their number."""
    if quantity.low != 0.0:
        return values, 0
    noise = (values < 0.0) & (values >= -PACKING * np.max(values))
    return np.where(noise, 0.0, values), int(np.sum(noise))


def _one_column(values: Array, label: str, name: str) -> Array:
    squeezed: Array = np.squeeze(values)
    if squeezed.ndim != 1:
        raise CatalogError(
            f"{name}: '{label}' has the shape {values.shape}; allowed: one column of levels (select one place and time)"
        )
    return squeezed


def _refuse_twice(
    used: Mapping[int, tuple[ProfileQuantity, Unit, str]], quantity: ProfileQuantity, label: str, where: str
) -> None:
    for other, _, first in used.values():
        if other.name == quantity.name:
            raise CatalogError(f"{where}: '{first}' and '{label}' both hold {quantity.name}; keep one")


def _in_si(
    values: Array, quantity: ProfileQuantity, unit: Unit, label: str, where: tuple[str, ...] | list[str], name: str
) -> Array:
    factor, offset = unit
    result = factor * values + offset
    bad = np.flatnonzero((result < quantity.low) | (result > quantity.high))
    if bad.size:
        first = int(bad[0])
        low, high = ((limit - offset) / factor for limit in (quantity.low, quantity.high))
        raise CatalogError(f"{name}, {where[first]}: {label} is {values[first]:g}; allowed: {low:g} to {high:g}")
    return result


def _set_aside(columns: dict[str, Array], name: str) -> list[str]:
    """Delete all but one humidity and one height column; return a note on the others."""
    given = {humidity: int(np.sum(np.isfinite(columns[humidity]))) for humidity in HUMIDITIES if humidity in columns}
    present = sorted(given, key=lambda humidity: -given[humidity])  # stable: of equally many values the first
    if not present or not given[present[0]]:
        listed = ", ".join(HUMIDITIES)
        raise CatalogError(f"{name}: humidity is missing; give one of {listed} (h2o = 0 for dry air)")
    spare = present[1:]
    if "altitude" in columns and "geopotential_height" in columns:
        spare.append("geopotential_height")
    for column in spare:
        del columns[column]
    return [f"profile '{name}': columns not used: {', '.join(spare)}"] if spare else []
