"""MODTRAN 6 CSV output (``CSVPRNT``), also its ``_scan.csv``.

Lines of description, a row of column names (found by its names, not by its place), at most two rows of units, rows
of numbers, and possibly a footer. A CSV file does not carry the geometry; it has to be given.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from hcss_twin.atmosphere.imports.columns import AxisUnit, Run, axis_unit, is_known, path_from_columns
from hcss_twin.atmosphere.imports.spectral_path import Geometry, SpectralPath
from hcss_twin.errors import CatalogError

_UNIT_WORDS: dict[str, AxisUnit] = {
    "cm-1": "cm1",
    "1/cm": "cm1",
    "micron": "um",
    "microns": "um",
    "um": "um",
    "nm": "nm",
}


def read_modtran6_csv(path: Path, geometry: Geometry | None = None) -> list[SpectralPath]:
    """Read the one run of a MODTRAN 6 CSV file.

    Parameters
    ----------
    path : Path
        The file.
    geometry : Geometry, optional
        Line of sight, which the file does not tell.

    Raises
    ------
    CatalogError
        If no row of column names is found, a row has another number of fields, or numbers are impossible;
        with the line.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise CatalogError(f"{path}: cannot be read as text: {error}") from error
    rows = [[field.strip() for field in row] for row in csv.reader(text.splitlines())]
    header = next((at for at, row in enumerate(rows) if sum(map(is_known, row)) >= 2), None)
    if header is None:
        raise CatalogError(
            f"{path}, line {max(len(rows), 1)}: no row of column names (freq, combin trans, path emission, ...)"
        )
    names = rows[header]
    while names and not names[-1]:
        names = names[:-1]
    first, unit = header + 1, axis_unit(names[0])
    while first < len(rows) and first <= header + 2 and rows[first] and not _is_number(rows[first][0]):
        unit = _UNIT_WORDS.get(rows[first][0].strip("()[] ").lower(), unit)
        first += 1
    if unit is None:
        raise CatalogError(
            f"{path}, line {header + 1}: the first column is '{names[0]}'; expected a frequency in cm-1 or a "
            "wavelength with its unit"
        )
    values, lines = [], []
    for at in range(first, len(rows)):
        row = rows[at]
        if not row or not _is_number(row[0]) or row[0].startswith("-9999"):
            _require_footer(path, rows, at)
            break
        while len(row) > len(names) and not row[-1]:
            row = row[:-1]
        if len(row) != len(names):
            raise CatalogError(f"{path}, line {at + 1}: {len(row)} fields, the header has {len(names)}")
        try:
            values.append([float(field) if field else 0.0 for field in row])
        except ValueError as error:
            raise CatalogError(f"{path}, line {at + 1}: {error}") from error
        lines.append(at + 1)
    if not values:
        raise CatalogError(f"{path}, line {first + 1}: no rows of numbers")
    table = np.array(values, dtype=np.float64)
    run = Run(str(path), lines, "MODTRAN6 CSV", path.name, geometry)
    columns = {name: table[:, index] for index, name in enumerate(names) if index and name}
    return [path_from_columns(table[:, 0], unit, columns, run)]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _require_footer(path: Path, rows: list[list[str]], at: int) -> None:
    """Refuse numbers below what looks like the end."""
    for later in range(at + 1, len(rows)):
        row = rows[later]
        if len(row) > 1 and all(_is_number(field) for field in row if field):
            raise CatalogError(
                f"{path}, line {at + 1}: '{','.join(rows[at])[:40]}' stands between rows of numbers"
            )
