"""Measured spectral responses: one reader for the tables that agencies and laboratories publish.

Published tables differ in everything but their form: lines of text, then rows of numbers, one column of which is a
wavelength or wavenumber, another a response. Labels above the columns say which and in what unit; where they say
nothing, the numbers do. What was assumed is returned in words (:attr:`Response.read_as`), and what can be read in two
ways is an error.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, Problem
from hcss_twin.core.reading import Reading

NARROWEST = 1e-6
"""Minimum relative bandwidth; below it, rounding affects the spectral grid."""

SHORTEST_UM, LONGEST_UM = 0.1, 1000.0

Unit = Literal["um", "nm", "cm-1"]

PLAIN = ("wavelength_um", "response")
"""Labels of the form that needs no words."""

NOISE = 0.01
"""Negative responses down to this share of the peak are noise of the measurement, and count as 0."""

_COMMENT = ("#", "!", "%", "//", "*")
_SEPARATORS = (";", "\t", ",", None)
_WAVENUMBER = re.compile(r"wave[ _-]?num|cm\s*\^?\s*\(?-\s*1|cm\u207b\u00b9|1/cm|(?<![a-z])wn(?![a-z])", re.I)
_NM = re.compile(r"(?<![a-z])nm(?![a-z])|nanomet", re.I)
_UM = re.compile(r"(?<![a-z])[u\u00b5\u03bc]m(?![a-z])|micro", re.I)
_WAVELENGTH = re.compile(
    rf"wave[ _-]?len|lambda|\u03bb|(?<![a-z])(wl|wvl|wave)(?![a-z])|{_NM.pattern}|{_UM.pattern}", re.I
)
_NAME = re.compile(r"wave|lambda|\u03bb|(?<![a-z])w[ln](?![a-z])|wvl", re.I)
_RESPONSE = re.compile(r"resp|rsr|srf|transm|throughput", re.I)
_PERCENT = re.compile(r"%|percent", re.I)
_SEVERAL_WORDS = re.compile(r"\t|\s{2,}")
_WORD_AND_UNIT = re.compile(r"\S+(?:\s*[(\[][^)\]]*[)\]])?")


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


@dataclass(frozen=True)
class ResponseTable:
    """The numbers of a file, by column.

    Attributes
    ----------
    labels : tuple of str
        Of the columns; empty texts where no line above the numbers labels them.
    rows : tuple of tuple of (float or None)
        None: an empty field.
    lines : tuple of int
        Number of each row's line in the file.
    header : str
        All text above the numbers.
    """

    labels: tuple[str, ...]
    rows: tuple[tuple[float | None, ...], ...]
    lines: tuple[int, ...]
    header: str

    def name(self, column: int) -> str:
        """Return how a column is called in messages, and in the key ``column`` of a band."""
        return self.labels[column] or str(column + 1)

    def is_filled(self, column: int) -> bool:
        """Whether any row has a value."""
        return any(row[column] is not None for row in self.rows)


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
    try:
        return _response(table, name, column, unit)
    except CatalogError as error:
        raise CatalogError(f"{path}{error}") from error


def read_response_table(path: Path) -> ResponseTable:
    """Read the rows of numbers of a text file, and what is above them.

    Raises
    ------
    CatalogError
        If it is no text, has no rows of numbers, or a row differs from the others.
    """
    with Reading(path, CatalogError, "not a text file; allowed: text such as CSV (of a spreadsheet: export the sheet)"):
        text = _decoded(path.read_bytes())
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    data = [(number, line) for number, line in lines if not line.lstrip().startswith(_COMMENT)]
    found = ((separator, _first_row(data, separator)) for separator in _SEPARATORS)
    separator, start = next(((each, index) for each, index in found if index is not None), (None, None))
    if start is None:
        raise CatalogError(
            f"{path}{_first_wrong(data)}: no rows of numbers; allowed: at least two columns, wavelength or wavenumber "
            "and response, separated by comma, semicolon, tab or blanks, with decimal points"
        )
    first = data[start]
    count = len(_fields(first[1], separator))
    above = [(number, line.strip().lstrip("#!%/* ")) for number, line in lines if number < first[0]]
    labelled, labels = _labels(above, separator, count)
    for number, line in data[:start]:
        fields = _fields(line, separator)
        is_row = any(_number(field) is not None for field in fields[: 1 if number < labelled else None])
        if is_row and (len(fields) == count or number > labelled):
            wrong = next((field for field in fields if _number(field) is None), None)
            problem = f"{len(fields)} fields, line {first[0]} has {count}" if wrong is None else _no_number(wrong)
            raise CatalogError(f"{path}, line {number}: {problem}")
    rows = []
    for number, line in data[start:]:
        fields = _fields(line, separator)
        if len(fields) != count:
            raise CatalogError(f"{path}, line {number}: {len(fields)} fields, line {first[0]} has {count}")
        for field in fields:
            if field and _number(field) is None:
                raise CatalogError(f"{path}, line {number}: {_no_number(field)}")
        rows.append(tuple(_number(field) if field else None for field in fields))
    text_above = "\n".join(line for _, line in above)
    return ResponseTable(labels, tuple(rows), tuple(number for number, _ in data[start:]), text_above)


def _decoded(content: bytes) -> str:
    """Return the text; older files have the micro sign in Latin-1."""
    try:
        text = content.decode("utf-8-sig")  # spreadsheets write a byte-order mark
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    if re.search(r"[\x00-\x08\x0e-\x1f\x7f-\x9f]", text):
        raise ValueError("it has bytes that are no characters")
    return text


def _fields(line: str, separator: str | None) -> list[str]:
    return [field.strip().strip("\"'").strip() for field in line.split(separator)]


def _number(field: str) -> float | None:
    try:
        return float(field)
    except ValueError:
        return None


def _no_number(field: str) -> str:
    return f"{Problem.shown(field)} is not a number"


def _first_row(data: Sequence[tuple[int, str]], separator: str | None) -> int | None:
    """Return the index of the first row of the table, whose rows have the number of fields that occurs most."""
    counts = [_numbers_in(line, separator) for _, line in data]
    usual = Counter(filter(None, counts)).most_common(1)
    return counts.index(usual[0][0]) if usual else None


def _numbers_in(line: str, separator: str | None) -> int:
    """Return the number of fields of a row of numbers, of which single ones may be empty; 0 for other lines."""
    fields = _fields(line, separator)
    values = [_number(field) for field in fields if field]
    return len(fields) if len(values) > 1 and None not in values else 0


def _first_wrong(data: Sequence[tuple[int, str]]) -> str:
    """Name the first line that begins with a digit, which was meant as a row."""
    number = next((number for number, line in data if line.lstrip("\"'+-.")[:1].isdigit()), None)
    return "" if number is None else f", line {number}"


def _labels(above: Sequence[tuple[int, str]], separator: str | None, count: int) -> tuple[float, tuple[str, ...]]:
    """Return the labels of columns, and the number of their line.

    They are in the last line above the numbers that has as many, one of them spectral. Without such a line they are
    empty, and the number is infinite.
    """
    found = []
    for number, line in reversed(above):
        fields = _fields(line, separator)
        ways = [fields, [*fields, ""]]  # rows may end with a separator where labels do not
        if separator is None:
            ways += [_SEVERAL_WORDS.split(line), _WORD_AND_UNIT.findall(line)]
        found += [(number, tuple(way)) for way in ways if len(way) == count and any(map(_is_spectral, way))]
    names = [each for each in found if any(map(_NAME.search, each[1]))]  # a line below them may have units alone
    if names or found:
        return (names or found)[0]
    return math.inf, ("",) * count


def _is_spectral(label: str) -> bool:
    return bool(_WAVENUMBER.search(label) or _WAVELENGTH.search(label)) and not _RESPONSE.search(label)


def _response(table: ResponseTable, name: str, column: str | None, given: Unit | None) -> Response:
    """Return the response of a table; errors begin where those of the file name go on."""
    spectral = _spectral_columns(table)
    responses = [index for index in range(len(table.labels)) if index not in spectral and table.is_filled(index)]
    chosen = _chosen(table, responses, name, column)
    # Tables with a spectral column beside each response have it on the left; wavelengths go before wavenumbers.
    left = [index for index in spectral if index < chosen] or spectral[:1]
    of_chosen = ([index for index in left if _is_wavelength(table, index)] or left)[-1]
    unit, why = (given, "as given") if given else _unit(table, of_chosen, spectral)
    kept = [
        (line, row[of_chosen], row[chosen])
        for line, row in zip(table.lines, table.rows, strict=True)
        if len(responses) == 1 or (row[of_chosen] is not None and row[chosen] is not None)
    ]
    for line, *pair in kept:
        if None in pair:
            raise CatalogError(f", line {line}: a field is empty; allowed: a number")
        if not all(value is not None and math.isfinite(value) for value in pair):
            raise CatalogError(f", line {line}: a value is not finite")
    lines = [line for line, _, _ in kept]
    at, values = np.array([pair for _, *pair in kept], dtype=np.float64).reshape(-1, 2).T
    if np.any(at <= 0.0):
        raise CatalogError(f", line {lines[int(np.argmax(at <= 0.0))]}: {unit} must be positive")
    wavelength, values = _ascending({"cm-1": 1e4 / at, "nm": at / 1e3, "um": at}[unit], values, lines)
    scaled, words = _relative(values, table.labels[chosen])
    if wavelength[-1] - wavelength[0] < NARROWEST * wavelength[-1]:
        raise CatalogError(f": too narrow; allowed: at least {NARROWEST:g} of the wavelength")
    if wavelength[0] < SHORTEST_UM or wavelength[-1] > LONGEST_UM:
        raise CatalogError(
            f": wavelengths of {wavelength[0]:.4g} to {wavelength[-1]:.4g} um ({unit} {why}); allowed: {SHORTEST_UM:g} "
            f"to {LONGEST_UM:g} um"
        )
    positive = np.flatnonzero(scaled > 0.0)
    inside = slice(max(positive[0] - 1, 0), positive[-1] + 2)
    is_plain = (table.labels[of_chosen], table.labels[chosen]) == PLAIN and not words
    of_response = Problem.shown(table.name(chosen))
    read_as = f"{unit} {why} from column {Problem.shown(table.name(of_chosen))}, response from column {of_response}"
    return Response(wavelength[inside], scaled[inside], "" if is_plain else "; ".join((read_as, *words)))


def _spectral_columns(table: ResponseTable) -> list[int]:
    labelled = [index for index, label in enumerate(table.labels) if _is_spectral(label)]
    if labelled:
        return labelled
    if len(table.labels) > 2 and _is_reciprocal(table, 0, 1):
        return [0, 1]
    return [0]


def _is_wavelength(table: ResponseTable, column: int) -> bool:
    """Whether a spectral column does not have wavenumbers, by its label or its size."""
    label = table.labels[column]
    return not _WAVENUMBER.search(label) if label else max(row[column] or 0.0 for row in table.rows) <= 100.0


def _is_reciprocal(table: ResponseTable, one: int, other: int) -> bool:
    """Whether two columns are wavelength and wavenumber: their product is 1e4 (um) or 1e7 (nm)."""
    products = np.array([(row[one] or 0.0) * (row[other] or 0.0) for row in table.rows])
    return any(bool(np.all(np.abs(products / exact - 1.0) < 1e-3)) for exact in (1e4, 1e7))


def _unit(table: ResponseTable, column: int, spectral: Sequence[int]) -> tuple[Unit, str]:
    """Return ``um``, ``nm`` or ``cm-1``, and how it is known."""
    label = table.labels[column]
    of_any: list[tuple[Unit, re.Pattern[str]]] = [("nm", _NM), ("um", _UM), ("cm-1", _WAVENUMBER)]
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
    if _WAVELENGTH.search(label or table.header) and low >= 200.0:
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
    like = [index for index in responses if _RESPONSE.search(table.labels[index])]
    for alone in (responses, like):
        if len(alone) == 1:
            return alone[0]
    if name.lower() in names:
        return names[name.lower()]
    raise CatalogError(f": responses in several columns; allowed: column = one of {listed}, or a band of that name")


def _ascending(wavelength: Array, response: Array, lines: Sequence[int]) -> tuple[Array, Array]:
    """Return both in ascending order, and rows that occur twice once."""
    if wavelength.size < 2:
        raise CatalogError(": one row of numbers; allowed: at least two")
    step = np.diff(wavelength) * (1.0 if wavelength[-1] > wavelength[0] else -1.0)
    if np.any(step < 0.0):
        raise CatalogError(
            f", line {lines[int(np.argmax(step < 0.0)) + 1]}: neither ascending nor descending; allowed: rows that "
            "ascend or descend throughout"
        )
    other = (step == 0.0) & (np.diff(response) != 0.0)
    if np.any(other):
        line = lines[int(np.argmax(other)) + 1]
        raise CatalogError(f", line {line}: another response for the same wavelength; allowed: rows that ascend")
    kept = np.append(True, step > 0.0)
    order = slice(None) if wavelength[-1] > wavelength[0] else slice(None, None, -1)
    return wavelength[kept][order], response[kept][order]


def _relative(response: Array, label: str) -> tuple[Array, list[str]]:
    """Return the response from 0 to 1, and what was done to it."""
    peak, words = float(np.max(response)), []
    if peak <= 0.0:
        raise CatalogError(": response must lie in 0..1 and be positive somewhere")
    percent = bool(_PERCENT.search(label))
    if percent or 1.5 < peak <= 100.0:
        words.append(f"in percent {'by its label' if percent else 'by magnitude'}")
        response, peak = response / 100.0, peak / 100.0
    if peak > 1.05:
        raise CatalogError(f": response reaches {peak:.4g}; allowed: 0..1, or 0..100 in percent")
    if peak > 1.0:
        words.append(f"divided by its peak, {peak:.6g}")
        response = response / peak
    lowest = float(np.min(response))
    if lowest < -NOISE * min(peak, 1.0):
        raise CatalogError(f": response falls to {lowest:.4g}; allowed: 0..1, and noise down to {-NOISE:g} of the peak")
    if lowest < 0.0:
        words.append(f"{int(np.sum(response < 0.0))} negative values, down to {lowest:.2g}, taken as 0")
    return np.maximum(response, 0.0), words
