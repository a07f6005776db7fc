"""Measured spectral responses: one reader for the tables that agencies and laboratories publish.

Published tables differ in everything but their form: lines of text, then rows of numbers, one column of which is a
wavelength or wavenumber, another a response. Labels above the columns say which and in what unit; where they say
nothing, the numbers do. What was assumed is returned in words (:attr:`Response.read_as`), and what can be read in two
ways is an error.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, Problem
from hcss_twin.scenario.response_table import (
    NM,
    OTHER_UNIT,
    RESPONSE,
    UM,
    WAVELENGTH,
    WAVENUMBER,
    ResponseTable,
    is_spectral,
    read_response_table,
)

NARROWEST = 1e-6
"""Minimum relative bandwidth; below it, rounding affects the spectral grid."""

SHORTEST_UM, LONGEST_UM = 0.1, 1000.0

Unit = Literal["um", "nm", "cm-1"]


def _not_of_response(value: object) -> object:
    """Answer who states the unit of the response in place of that of the wavelength."""
    if isinstance(value, str) and value.strip().lower() in ("%", "percent", "per cent", "fraction", "1"):
        raise PydanticCustomError(
            "unit",
            f"{Problem.shown(value)} is a unit of the response, which needs none: numbers above 1.5 or a label with % "
            "mean percent; allowed: the unit of the wavelengths or wavenumbers (um, nm, cm-1), or none",
        )
    return value


StatedUnit = Annotated[Unit, BeforeValidator(_not_of_response)]
"""Unit as a key of a scenario."""

PLAIN = ("wavelength_um", "response")
"""Labels of the form that needs no words."""

NOISE = 0.01
"""Negative responses down to this share of the peak are noise of the measurement, and count as 0."""

_MISSING = frozenset(-(10.0**digits - 1.0) for digits in range(2, 7))
"""Responses that mean that there is none: -99, -999, ..."""

_PERCENT = re.compile(r"%|percent", re.I)


@dataclass(frozen=True)
class Response:
    """A spectral response.

    Attributes
    ----------
    wavelength_um, response : ndarray (N,)
        Ascending; 0 to 1. Of zeros at either end, one is kept.
    read_as : str
        How columns, units and values were understood; empty for columns ``wavelength_um`` and ``response``.
    """

    wavelength_um: Array
    response: Array
    read_as: str


def read_response(
    file: str, catalog: Catalog, name: str = "", column: str | None = None, unit: Unit | None = None
) -> Response:
    """Read a measured spectral response.

    Parameters
    ----------
    file : str
        Path, relative to the scenario.
    catalog : Catalog
    name : str
        Name of the band: of several responses, the column with this label is read.
    column : str, optional
        Label or number (from 1) of the column with the response.
    unit : str, optional
        ``um``, ``nm`` or ``cm-1``, for files that do not say it.

    Raises
    ------
    CatalogError
        If the file is missing or malformed, or can be understood in several ways.
    """
    path = catalog.file(file)
    table: ResponseTable = catalog.shelf.parsed(path, read_response_table)
    faults = dict(table.faults)
    try:
        response = _response(table, name, column, unit, faults)
    except CatalogError as error:
        raise CatalogError(f"{path}{_listed(faults)}{error}") from error
    if response is None:
        raise CatalogError(f"{path}{_listed(faults)}")
    return response


_MOST_LISTED = 5
"""Lines with faults in a message."""


def _listed(faults: _Faults) -> str:
    """Return the first faults by line, as the part of a message after the name of the file."""
    first = sorted(faults.items())[:_MOST_LISTED]
    more = [f"and {len(faults) - len(first)} more"] if len(faults) > len(first) else []
    return "; ".join([*(f", line {line}: {fault}" for line, fault in first), *more]).replace("; , line", "; line")


def _response(
    table: ResponseTable, name: str, column: str | None, given: Unit | None, faults: _Faults
) -> Response | None:
    """Return the response of a table, and add faults of its rows; errors begin where those of the file name go on.

    None if rows have faults: what is wrong with the others may follow from those that are left out.
    """
    if not table.rows:
        return None
    if table.names:
        table = _of_band(table, name)
    groups = _group_columns(table)
    spectral = _spectral_columns(table, groups)
    responses = [
        index for index in range(len(table.labels)) if index not in (*spectral, *groups) and table.is_filled(index)
    ]
    chosen = _chosen(table, responses, name, column)
    # Tables with a spectral column beside each response have it on the left; wavelengths go before wavenumbers.
    left = [index for index in spectral if index < chosen] or spectral[:1]
    of_chosen = ([index for index in left if _is_wavelength(table, index)] or left)[-1]
    unit, why = _unit(table, of_chosen, spectral, given)
    kept, words = _values(table, of_chosen, chosen, len(responses) == 1, unit, faults)
    members = [_in_order(member, unit, words, faults) for member in _members(table, groups, kept)]
    if faults:
        return None
    tables = [_by_wavelength(member, unit) for member in members]
    wavelength, values, lines = tables[0]
    if len(tables) > 1:
        values = _mean(table, groups, tables, words)
    scaled = _relative(values, lines, table.labels[chosen], chosen in table.percent, words)
    if wavelength[-1] - wavelength[0] < NARROWEST * wavelength[-1]:
        raise CatalogError(f": too narrow; allowed: at least {NARROWEST:g} of the wavelength")
    if wavelength[0] < SHORTEST_UM or wavelength[-1] > LONGEST_UM:
        raise CatalogError(
            f": wavelengths of {wavelength[0]:.4g} to {wavelength[-1]:.4g} um ({unit} {why}); allowed: {SHORTEST_UM:g} "
            f"to {LONGEST_UM:g} um"
        )
    positive = np.flatnonzero(scaled > 0.0)
    inside = slice(max(positive[0] - 1, 0), positive[-1] + 2)
    words = [*table.notes, *words]
    is_plain = (table.labels[of_chosen], table.labels[chosen]) == PLAIN and not words
    of_response = Problem.shown(table.name(chosen))
    read_as = f"{unit} {why} from column {Problem.shown(table.name(of_chosen))}, response from column {of_response}"
    return Response(wavelength[inside], scaled[inside], "" if is_plain else "; ".join((read_as, *words)))


def _of_band(table: ResponseTable, name: str) -> ResponseTable:
    """Return the rows that begin with the name of the band, or all if they begin with one word."""
    known = list(dict.fromkeys(table.names))
    if len(known) == 1:
        return table
    rows = [index for index, word in enumerate(table.names) if word.lower() == name.lower()]
    if not rows:
        raise CatalogError(f": rows of several bands; allowed: a band with one of the names {', '.join(known)}")
    return replace(
        table, rows=tuple(table.rows[row] for row in rows), lines=tuple(table.lines[row] for row in rows), names=()
    )


def _group_columns(table: ResponseTable) -> list[int]:
    """Return the first columns if they have numbers of bands or detectors: whole, and the same in several rows."""
    groups = []
    for index in range(len(table.labels) - 2):
        values = [row[index] for row in table.rows]
        blocks = 1 + sum(one != other for one, other in itertools.pairwise(values))
        if is_spectral(table.labels[index]) or 2 * blocks > len(values) or not all(map(_is_whole, values)):
            break
        groups.append(index)
    return groups


def _is_whole(value: float | None) -> bool:
    return value is not None and value.is_integer()


_Faults = dict[int, str]
"""What is wrong, by line."""

_Rows = list[tuple[int, float, float]]
"""Line, position in the spectrum in the unit of the file, and response."""


def _values(
    table: ResponseTable, spectral: int, chosen: int, alone: bool, unit: Unit, faults: _Faults
) -> tuple[_Rows, list[str]]:
    """Return the rows with both values, and words on those without; an empty field of the only response is a fault."""
    kept: _Rows = []
    missing = []
    for line, row in zip(table.lines, table.rows, strict=True):
        at, value = row[spectral], row[chosen]
        if at is None or value is None:
            if alone:
                faults[line] = "a field is empty; allowed: a number"
        elif not (math.isfinite(at) and math.isfinite(value)):
            wrong = value if math.isfinite(at) else at
            faults[line] = f"{wrong:g} is not finite; allowed: finite numbers"
        elif at <= 0.0:
            faults[line] = f"{at:g} {unit}; allowed: positive numbers"
        elif value in _MISSING:
            missing.append(line)
        else:
            kept.append((line, at, value))
    if not kept and not faults:
        raise CatalogError(": no row with a response; allowed: at least two")
    return kept, [f"{_rows(missing)} without a response (-99) not used"] if missing else []


def _rows(lines: Sequence[int]) -> str:
    """Return how many rows, with the first lines, for messages."""
    shown = ", ".join(map(str, lines[:5])) + (", ..." if len(lines) > 5 else "")
    return f"{len(lines)} row{'s' * (len(lines) > 1)} (line{'s' * (len(lines) > 1)} {shown})"


def _members(table: ResponseTable, groups: Sequence[int], kept: _Rows) -> list[_Rows]:
    """Return the rows of each detector."""
    group_of = {line: tuple(row[index] for index in groups) for line, row in zip(table.lines, table.rows, strict=True)}
    members: dict[tuple[float | None, ...], _Rows] = {}
    for row in kept:
        members.setdefault(group_of[row[0]], []).append(row)
    return list(members.values())


def _mean(
    table: ResponseTable, groups: Sequence[int], tables: Sequence[tuple[Array, Array, list[int]]], words: list[str]
) -> Array:
    """Return the mean response of detectors at the same wavelengths."""
    wavelength = tables[0][0]
    for other, _, lines in tables[1:]:
        if other.shape != wavelength.shape or not np.allclose(other, wavelength, rtol=1e-6):
            named = ", ".join(Problem.shown(table.name(index)) for index in groups)
            raise CatalogError(
                f", line {min(lines)}: another {named} with other wavelengths; allowed: rows of one, or the same "
                "wavelengths for all"
            )
    words.append(f"mean of {len(tables)} detectors")
    mean: Array = np.mean([values for _, values, _ in tables], axis=0)
    return mean


def _spectral_columns(table: ResponseTable, groups: Sequence[int]) -> list[int]:
    labelled = [index for index, label in enumerate(table.labels) if is_spectral(label)]
    if labelled:
        return labelled
    first = len(groups)
    if len(table.labels) > first + 2 and _is_reciprocal(table, first, first + 1):
        return [first, first + 1]
    return [first]


def _is_wavelength(table: ResponseTable, column: int) -> bool:
    """Whether a spectral column does not have wavenumbers, by its label or its size."""
    label = table.labels[column]
    return not WAVENUMBER.search(label) if label else max(row[column] or 0.0 for row in table.rows) <= 100.0


def _is_reciprocal(table: ResponseTable, one: int, other: int) -> bool:
    """Whether two columns are wavelength and wavenumber: their product is 1e4 (um) or 1e7 (nm)."""
    products = np.array([(row[one] or 0.0) * (row[other] or 0.0) for row in table.rows])
    return any(bool(np.all(np.abs(products / exact - 1.0) < 1e-3)) for exact in (1e4, 1e7))


def _unit(table: ResponseTable, column: int, spectral: Sequence[int], given: Unit | None) -> tuple[Unit, str]:
    """Return ``um``, ``nm`` or ``cm-1``, and how it is known."""
    label = table.labels[column]
    of_any: list[tuple[Unit, re.Pattern[str]]] = [("nm", NM), ("um", UM), ("cm-1", WAVENUMBER)]
    of_label = [unit for unit, pattern in of_any if pattern.search(label)]
    if OTHER_UNIT.search(label) and not of_label:
        raise CatalogError(
            f": column {Problem.shown(label)} is in none of the allowed units; allowed: wavelength or wavenumber in "
            "um, nm, cm-1"
        )
    if given and len(of_label) == 1 and given not in of_label:
        raise CatalogError(f": unit {given} with a column {Problem.shown(label)}; allowed: {of_label[0]}, or no unit")
    if given:
        return given, "as given"
    for text, why, known in (
        (label, "by its label", of_any),
        (table.header, "by the text above it", of_any[:2] if label else of_any),
    ):
        units = [unit for unit, pattern in known if pattern.search(text)]
        if len(units) == 1:
            return units[0], why
    values = [value for row in table.rows if (value := row[column]) is not None]
    low, high = min(values, default=0.0), max(values, default=0.0)
    if high <= 100.0:
        return "um", "by magnitude"
    beside = [other for other in spectral if other != column and max(row[other] or 0.0 for row in table.rows) <= 100.0]
    if beside and _is_reciprocal(table, column, beside[0]):
        return "cm-1", "by magnitude"
    if WAVELENGTH.search(label or table.header) and low >= 200.0:
        return "nm", "by magnitude"
    raise CatalogError(
        f", line {table.lines[0]}: {low:g} to {high:g} in column {Problem.shown(table.name(column))} may be nm or "
        "cm-1; allowed: unit = one of um, nm, cm-1, or a label above the numbers that names it, such as wavenumber_cm-1"
    )


def _chosen(table: ResponseTable, responses: Sequence[int], name: str, column: str | None) -> int:
    """Return the column with the response."""
    names = {table.name(index).lower(): index for index in responses}
    listed = ", ".join(table.name(index) for index in responses)
    if column is not None:
        by_number = {str(index + 1): index for index in responses}
        found = names.get(column.lower(), by_number.get(column))
        if found is None:
            raise CatalogError(f": no response in column {Problem.shown(column)}; allowed: {listed}")
        return found
    if not responses:
        raise CatalogError(f": no column with a response beside {Problem.shown(table.name(0))}")
    like = [index for index in responses if RESPONSE.search(table.labels[index])]
    for alone in (responses, like):
        if len(alone) == 1:
            return alone[0]
    if name.lower() in names:
        return names[name.lower()]
    raise CatalogError(f": responses in several columns; allowed: column = one of {listed}, or a band of that name")


def _in_order(rows: _Rows, unit: Unit, words: list[str], faults: _Faults) -> _Rows:
    """Return the rows without those that occur twice; others that do not ascend or descend as the most are faults."""
    if len(rows) < 2:
        if faults:
            return rows
        raise CatalogError(": one row of numbers; allowed: at least two")
    rises = sum(1 if after[1] > before[1] else -1 for before, after in itertools.pairwise(rows))
    sign = 1.0 if (rises or rows[-1][1] - rows[0][1]) >= 0 else -1.0  # as many of both: the ends decide
    kept, twice = [rows[0]], []
    for line, at, value in rows[1:]:
        _, before, value_before = kept[-1]
        if sign * (at - before) < 0.0:
            faults[line] = f"{at:.10g} after {before:.10g}; allowed: rows that ascend or descend throughout"
        elif at > before or at < before:
            kept.append((line, at, value))
        elif math.isclose(value, value_before, rel_tol=1e-6, abs_tol=1e-9):
            twice.append(line)
        else:
            faults[line] = (
                f"{value:.6g} for {at:.10g} {unit}, which has {value_before:.6g} in the row before; allowed: one "
                "response for each"
            )
    if twice:
        words.append(f"{_rows(twice)} that repeats the one before not used")
    return kept


def _by_wavelength(kept: _Rows, unit: Unit) -> tuple[Array, Array, list[int]]:
    """Return wavelengths in um, responses and lines in ascending order."""
    at, values = np.array([pair for _, *pair in kept], dtype=np.float64).T
    wavelength = {"cm-1": 1e4 / at, "nm": at / 1e3, "um": at}[unit]
    order = np.argsort(wavelength)
    return wavelength[order], values[order], [kept[index][0] for index in order]


def _relative(response: Array, lines: Sequence[int], label: str, has_signs: bool, words: list[str]) -> Array:
    """Return the response from 0 to 1, and add to the words what was done to it."""
    peak, highest, lowest = float(np.max(response)), int(np.argmax(response)), int(np.argmin(response))
    if peak <= 0.0:
        raise CatalogError(": response must lie in 0..1 and be positive somewhere")
    why = "by its label" if _PERCENT.search(label) else "by its signs" if has_signs else ""
    if why and peak <= 1.5:
        raise CatalogError(
            f", line {lines[highest]}: {peak:.6g} at most in percent {why}; allowed: numbers up to 100, or a label "
            "without percent"
        )
    scale = 1.0
    if why or 1.5 < peak <= 100.0:
        words.append(f"in percent {why or 'by magnitude'}")
        scale = 100.0
    faults: _Faults = {}
    if peak > 1.05 * scale:
        faults[lines[highest]] = f"{peak:.6g}; allowed: 0..1, or 0..100 in percent"
    elif peak > scale:
        words.append(f"divided by its peak, {peak / scale:.6g}")
        scale = peak
    least = float(response[lowest])
    if least < -NOISE * peak:
        faults[lines[lowest]] = f"{least:.6g}; allowed: 0..1, and noise down to {-NOISE:g} of the peak"
    if faults:
        raise CatalogError(_listed(faults))
    if least < 0.0:
        negative = sorted(line for line, value in zip(lines, response, strict=True) if value < 0.0)
        words.append(f"{_rows(negative)} with negative values, down to {least / scale:.2g}, taken as 0")
    return np.maximum(response / scale, 0.0)
