"""MODTRAN's tape7 (``.tp7``), filtered (``.fl7``) and convolved (``.7sc``, ``tape7.scn``) text files.

A file holds one or several runs. Each begins with an echo of its input cards, followed by one line (IEMSCT 1, 2, 3) or
two lines (IEMSCT 0) of column names and rows of numbers, and ends with ``-9999.``.

======  ==========================================================================================
IEMSCT  columns used
======  ==========================================================================================
0       total transmittance (``COMBIN TRANS``)
1       total transmittance, path thermal and surface radiance
2       the same with scattered and reflected sunlight
3       transmittance to the sun, transmitted and extraterrestrial solar irradiance
======  ==========================================================================================

Radiances are W cm-2 sr-1 / cm-1; in convolved files over wavelength they are W cm-2 sr-1 / um or uW cm-2 sr-1 / nm,
according to the name of the first column.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hcss_modtran.columns import Run, axis_unit, normalised, path_from_columns
from hcss_modtran.spectral_path import PathGeometry, SpectralPath, read_text
from hcss_twin.providers import CatalogError

_SENTINEL = "-9999"
_HEADER = re.compile(r"^\s*(FREQ|WAVLEN|WAVELENGTH)\b", re.IGNORECASE)

# Two-word names of MODTRAN 3 and 4, joined by an underscore so that all characters keep their positions.
_TWO_WORDS = re.compile(
    r"\b(TOT|PTH|THRML|SURF|SOL|SING|SNGL|GRND|DRCT|TOTAL|REF|WAVLEN|FREQ|TOA|DIR) "
    r"(TRANS|THRML|SCT|EMIS|SCAT|RFLT|RAD|SOL|TR|MCRN|NM|CM-1|SUN|EM)\b",
    re.IGNORECASE,
)

# MODTRN, SPEED, BINARY, LYMOLC (letters or blank), MODEL, T_BEST (letter or blank), ITYPE, IEMSCT, IMULT.
_CARD_1 = re.compile(r"^[A-Z ]{0,4}?\s*(\d{1,2})[A-Z]?\s+(-?\d+)\s+(\d)\s+(-?\d+)\b", re.IGNORECASE)

_CARDS_BEFORE_NAMES = 5
"""Card 3 (geometry) is this many lines above the column names, whatever optional cards precede it."""


@dataclass(frozen=True)
class _Cards:
    model: int | None
    iemsct: int | None
    geometry: PathGeometry | None
    resolution_cm1: float | None
    notes: tuple[str, ...]


def read_tape7(path: Path) -> list[SpectralPath]:
    """Read every run of a tape7 or convolved tape7 file.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    list of SpectralPath
        One per run; for IEMSCT 3 the transmittance is that of the path to the sun.

    Raises
    ------
    CatalogError
        If the file is not in this format, ends without ``-9999.``, or has impossible numbers; the message names the
        line.
    """
    lines = read_text(path, "latin-1").splitlines()
    paths: list[SpectralPath] = []
    start = 0
    while start < len(lines) and any(line.strip() and not line.strip().startswith(_SENTINEL) for line in lines[start:]):
        paths_read, start = _read_run(path, lines, start, len(paths) + 1)
        paths.append(paths_read)
    if not paths:
        raise CatalogError(f"{path}, line 1: the file is empty")
    return paths


def _read_run(path: Path, lines: list[str], start: int, number: int) -> tuple[SpectralPath, int]:
    """Read one run; return it and the index of the line after it."""
    header = next((at for at in range(start, len(lines)) if _HEADER.match(lines[at])), None)
    if header is None:
        raise CatalogError(f"{path}, line {start + 1}: no line of column names (FREQ ... or WAVLEN ...) follows")
    names, edges, first = _column_names(path, lines, header)
    end = next((at for at in range(first, len(lines)) if lines[at].strip().startswith(_SENTINEL)), None)
    if end is None:
        raise CatalogError(f"{path}, line {len(lines)}: the file ends without -9999.; it is truncated")
    unit = axis_unit(names[0])
    if unit is None:
        raise CatalogError(
            f"{path}, line {header + 1}: the first column is '{names[0]}'; expected FREQ, WAVLEN(MCRN) or WAVLEN(NM)"
        )
    numbers = [at for at in range(first, end) if lines[at].strip()]
    if not numbers:
        raise CatalogError(f"{path}, line {end + 1}: the run has no rows")
    if any(normalised(name) == "LOS" for name in names):
        raise CatalogError(
            f"{path}, line {header + 1}: several lines of sight in one run are not supported; "
            "run one line of sight at a time"
        )
    table = np.array([_row(path, at + 1, lines[at], names, edges) for at in numbers], dtype=np.float64)
    kind = _kind_of_columns(names)
    cards = _cards(lines[start:header])
    if cards.iemsct is not None and cards.iemsct not in kind:
        raise CatalogError(
            f"{path}, line {start + 1}: card 1 says IEMSCT = {cards.iemsct}, the columns belong to IEMSCT "
            f"{' or '.join(map(str, kind))}"
        )
    run = Run(
        file=str(path),
        lines=[at + 1 for at in numbers],
        code=f"MODTRAN tape7, IEMSCT {cards.iemsct if cards.iemsct is not None else '/'.join(map(str, kind))}",
        source=f"{path.name} run {number}",
        geometry=cards.geometry,
        model=cards.model,
        resolution_cm1=cards.resolution_cm1,
        notes=cards.notes,
    )
    columns = {name: table[:, index] for index, name in enumerate(names) if index}
    return path_from_columns(table[:, 0], unit, columns, run), end + 1


def _column_names(path: Path, lines: list[str], header: int) -> tuple[list[str], list[int], int]:
    """Return the column names, the right edges of their fields, and the index of the first row."""
    line = _TWO_WORDS.sub(r"\1_\2", lines[header].expandtabs().rstrip())
    tokens = list(re.finditer(r"\S+", line))
    names, edges = [token.group() for token in tokens], [token.end() for token in tokens]
    first = header + 1
    if first < len(lines) and lines[first].strip() and not _is_number(lines[first].split()[0]):
        # IEMSCT 0: COMBIN over TRANS, H2O over TRANS, ...; the upper names may touch (H2-CH4CH4-CH4).
        below = list(re.finditer(r"\S+", lines[first].expandtabs().rstrip()))
        edges = [token.end() for token in below]
        above = [line[left:right].strip() for left, right in zip([0, *edges[:-1]], edges, strict=True)]
        if len(line) > edges[-1]:
            raise CatalogError(
                f"{path}, line {first + 1}: the two lines of column names differ in length ({len(names)} and "
                f"{len(below)} names)"
            )
        names = [f"{upper}_{token.group()}" for upper, token in zip(above, below, strict=True)]
        first += 1
    return names, edges, first


def _kind_of_columns(names: list[str]) -> tuple[int, ...]:
    plain = {normalised(name) for name in names}
    if "SOL_TR" in plain:
        return (3,)
    if plain & {"PTH_THRML", "THRML_EM", "TOTAL_RAD"}:
        return (1, 2)
    return (0,)


def _row(path: Path, number: int, line: str, names: list[str], edges: list[int]) -> list[float]:
    text = line.expandtabs().rstrip()
    fields = text.split()
    if "SOL_TR" in {normalised(name) for name in names}:
        # IEMSCT 3: the names are not aligned with their fields; an unnamed optical depth may follow.
        fields = fields[: len(names)]
    else:
        fields = _fields(path, number, text, names, edges)
    if len(fields) != len(names):
        raise CatalogError(f"{path}, line {number}: {len(fields)} fields under {len(names)} column names")
    values: list[float] = []
    for name, field in zip(names, fields, strict=True):
        # The run did not compute blank fields (scattered thermal radiance without multiple scattering).
        value = 0.0 if not field else _number(field)
        if value is None or (not field and not values):
            raise CatalogError(f"{path}, line {number}: column '{name}': '{field}' is not a number")
        values.append(value)
    return values


def _fields(path: Path, number: int, text: str, names: list[str], edges: list[int]) -> list[str]:
    """Split a row into fields: at the right edges of the names, or at blanks where the file was re-spaced.

    Fields may be blank and numbers may touch, so splitting at blanks is only the fallback.
    """
    ends = [word.end() for word in re.finditer(r"\S+", text)]
    if all(end in edges for end in ends[:-1]) and ends[-1] > edges[-1]:
        raise CatalogError(f"{path}, line {number}: more fields than the {len(names)} column names")
    if all(end in edges for end in ends) and ends[-1] == edges[-1]:
        return [text[left:right].strip() for left, right in zip([0, *edges[:-1]], edges, strict=True)]
    words = text.split()
    if len(words) != len(names) and len(text) < edges[-1]:
        raise CatalogError(f"{path}, line {number}: the row ends before column '{names[-1]}'; it is truncated")
    return words


def _number(text: str) -> float | None:
    """Read a Fortran number; three-digit exponents have no E (1.2-103)."""
    try:
        return float(text)
    except ValueError:
        repaired = re.fullmatch(r"([-+]?\d*\.?\d+)[dDeE]?([-+]\d+)", text)
        return float(f"{repaired.group(1)}e{repaired.group(2)}") if repaired else None


def _is_number(text: str) -> bool:
    return _number(text) is not None


def _cards(lines: list[str]) -> _Cards:
    """Return the settings in the echo of the input cards; None for missing ones."""
    if not lines:
        return _Cards(None, None, None, None, ("no input cards in the file",))
    card = _CARD_1.match(lines[0])
    model, itype, iemsct = (int(card.group(at)) for at in (1, 2, 3)) if card else (None, None, None)
    if len(lines) < _CARDS_BEFORE_NAMES + 1:
        return _Cards(model, iemsct, None, None, ("no geometry card in the file",))
    geometry = _geometry(lines[-_CARDS_BEFORE_NAMES], itype)
    notes = () if geometry else ("the geometry card was not recognised",)
    return _Cards(model, iemsct, geometry, _resolution(lines[-2]), notes)


def _geometry(card: str, itype: int | None) -> PathGeometry | None:
    """Card 3: H1, H2, ANGLE, ... in fields of ten characters, which may touch."""
    fields = [_number(card[left : left + 10].strip()) for left in (0, 10, 20)]
    height, end, angle = fields
    if height is None or end is None or angle is None:
        return None
    if not (0 <= height <= 1e5 and 0 <= end <= 1e5 and 0 <= angle <= 180):
        return None
    return PathGeometry(height * 1e3, end * 1e3, angle, horizontal=itype == 1)


def _resolution(card: str) -> float | None:
    """Card 4: V1, V2, DV, FWHM in fields of ten characters; the first of FLAGS (column 51) is FWHM's unit."""
    width = _number(card[30:40].strip())
    if width is None or width <= 0 or card[50:51].upper() in ("M", "N"):
        return None
    return width
