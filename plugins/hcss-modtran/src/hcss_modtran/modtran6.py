"""MODTRAN 6 output in JSON (``JSONOPT`` with WRT_OUTPUT) and CSV (``CSVPRNT``, also ``_scan.csv``).

JSON: ``MODTRAN[n].MODTRANOUTPUT.SPECTRA.RADIANCE | TRANSMITTANCE | IRRADIANCE`` (one array per column) and, if present,
``MODTRAN[n].MODTRANINPUT`` (GEOMETRY, SPECTRAL, ATMOSPHERE).

CSV: description lines, a row of column names (recognised by the names, not by its position), at most two rows of units,
rows of numbers, and possibly a footer. A CSV file lacks the geometry, which the user has to give.
"""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from hcss_modtran.columns import AxisUnit, Run, axis_unit, is_known, path_from_columns
from hcss_modtran.spectral_path import PathGeometry, RadianceUnit, SpectralPath, read_text
from hcss_twin.providers import Array, CatalogError, choose_from

_KINDS = ("RADIANCE", "TRANSMITTANCE", "IRRADIANCE")

_FLAGGED: dict[str, tuple[AxisUnit, RadianceUnit]] = {
    "W": ("cm1", "per_cm1"),
    "M": ("um", "per_um"),
    "N": ("nm", "per_nm"),
}

_WAVELENGTHS = ("WAVELENGTH", "WAVLEN", "WAVELEN")

_MODELS = {
    "ATM_TROPICAL": 1,
    "ATM_MIDLAT_SUMMER": 2,
    "ATM_MIDLAT_WINTER": 3,
    "ATM_SUBARC_SUMMER": 4,
    "ATM_SUBARC_WINTER": 5,
    "ATM_US_STANDARD_1976": 6,
}


def read_modtran6_json(path: Path) -> list[SpectralPath]:
    """Read every case of a MODTRAN 6 JSON output file.

    Raises
    ------
    CatalogError
        If the text is not JSON, a case has no spectra, arrays differ in length, or numbers are impossible; the message
        names the line.
    """
    text = read_text(path)
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise CatalogError(f"{path}, line {error.lineno}: not valid JSON: {error.msg}") from error
    cases = document.get("MODTRAN") if isinstance(document, dict) else None
    if not isinstance(cases, list) or not cases:
        raise CatalogError(f"{path}, line 1: no list 'MODTRAN' of cases")
    return [_case(path, text, case, number) for number, case in enumerate(cases, start=1)]


def _case(path: Path, text: str, case: Any, number: int) -> SpectralPath:
    spectra = _inside(case, "MODTRANOUTPUT", "SPECTRA")
    kind = next((kind for kind in _KINDS if isinstance(spectra, dict) and kind in spectra), None)
    line = _line(text, "SPECTRA", number)
    if kind is None:
        raise CatalogError(
            f"{path}, line {line}: case {number} has no MODTRANOUTPUT.SPECTRA with {', '.join(_KINDS)}; "
            "run MODTRAN with JSONOPT = WRT_OUTPUT or WRT_ALL"
        )
    arrays = {
        name: _array(path, text, name, values, number)
        for name, values in spectra[kind].items()
        if isinstance(values, list)
    }
    inputs = _inside(case, "MODTRANINPUT") or {}
    spectral = inputs.get("SPECTRAL", {})
    flag = str(spectral.get("XFLAG", "W")).strip().upper() or "W"
    if flag not in _FLAGGED:
        raise CatalogError(
            f"{path}, line {_line(text, 'XFLAG', number)}: XFLAG is '{flag}'; {choose_from(flag, _FLAGGED)}"
        )
    name = next((name for name in arrays if axis_unit(name) or name.upper() in _WAVELENGTHS), None)
    if name is None:
        raise CatalogError(
            f"{path}, line {line}: case {number} has no spectral coordinate (FREQ or WAVELENGTH); "
            f"found {', '.join(arrays) or 'no arrays'}"
        )
    sizes = {array.size for array in arrays.values()}
    if len(sizes) != 1:
        odd = next(name_of_array for name_of_array in arrays if arrays[name_of_array].size != arrays[name].size)
        raise CatalogError(
            f"{path}, line {_line(text, odd, number)}: '{odd}' has {arrays[odd].size} values, "
            f"'{name}' {arrays[name].size}; the file is truncated"
        )
    coordinate, radiance = _FLAGGED[flag]
    run = Run(
        file=str(path),
        lines=[_line(text, name, number)],
        code=f"MODTRAN6 JSON, {kind.lower()}",
        source=f"{path.name} case {number}",
        geometry=_geometry(inputs.get("GEOMETRY", {})),
        model=_MODELS.get(str(_inside(inputs, "ATMOSPHERE", "MODEL"))),
        resolution_cm1=_resolution(spectral),
        changes=tuple(name for name in _CHANGES if _inside(inputs, "ATMOSPHERE", name)),
    )
    axis = arrays.pop(name)
    # A wavelength without a unit in its name has the unit that XFLAG sets.
    return path_from_columns(axis, axis_unit(name) or coordinate, arrays, run, radiance)


_CHANGES = ("CO2MX", "H2OSTR", "O3STR", "C_PROF", "S_XSMOL")
"""Keys that scale amounts of gases; 0 or empty: as in the model."""


def _inside(document: Any, *keys: str) -> Any:
    for key in keys:
        if not isinstance(document, dict) or key not in document:
            return None
        document = document[key]
    return document


def _array(path: Path, text: str, name: str, values: list[Any], number: int) -> Array:
    line = _line(text, name, number)
    if any(isinstance(value, list) for value in values):
        raise CatalogError(
            f"{path}, line {line}: '{name}' has several lines of sight in one case, which is not supported; "
            "run one line of sight at a time"
        )
    try:
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise CatalogError(f"{path}, line {line}: '{name}' is not an array of numbers: {error}") from error


def _geometry(card: Any) -> PathGeometry | None:
    if not isinstance(card, dict) or card.get("MLOS"):
        sights = card.get("MLOS") if isinstance(card, dict) else None
        if not sights or len(sights) != 1:
            return None
        card = {**card, **sights[0]}
    values = [card.get(key) for key in ("H1ALT", "H2ALT", "OBSZEN")]
    if not all(isinstance(value, (int, float)) for value in values):
        return None
    height, end, angle = (float(value) for value in values)
    return PathGeometry(height * 1e3, end * 1e3, angle, horizontal=card.get("ITYPE") == 1)


def _resolution(spectral: dict[str, Any]) -> float | None:
    width, flags = spectral.get("FWHM"), str(spectral.get("FLAGS", " "))
    if not isinstance(width, (int, float)) or width <= 0 or flags[:1].upper() in ("M", "N"):
        return None
    return float(width)


def _line(text: str, key: str, number: int) -> int:
    """Return the line of the ``number``-th occurrence of a key (1 if there is none)."""
    places = [match.start() for match in re.finditer(rf'"{re.escape(key)}"\s*:', text)]
    if not places:
        return 1
    return text.count("\n", 0, places[min(number, len(places)) - 1]) + 1


_UNIT_WORDS: dict[str, AxisUnit] = {
    "cm-1": "cm1",
    "1/cm": "cm1",
    "micron": "um",
    "microns": "um",
    "um": "um",
    "nm": "nm",
}


def read_modtran6_csv(path: Path, geometry: PathGeometry | None = None) -> list[SpectralPath]:
    """Read the single run of a MODTRAN 6 CSV file.

    Parameters
    ----------
    path : Path
        The file.
    geometry : PathGeometry, optional
        Line of sight, which the file does not contain.

    Raises
    ------
    CatalogError
        If there is no row of column names, a row has a different number of fields, or numbers are impossible; the
        message names the line.
    """
    text = read_text(path)
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
    """Reject rows of numbers below the presumed end."""
    for later in range(at + 1, len(rows)):
        row = rows[later]
        if len(row) > 1 and all(_is_number(field) for field in row if field):
            raise CatalogError(f"{path}, line {at + 1}: '{','.join(rows[at])[:40]}' stands between rows of numbers")
