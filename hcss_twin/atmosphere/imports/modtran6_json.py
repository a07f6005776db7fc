"""MODTRAN 6 JSON output (``JSONOPT`` with WRT_OUTPUT).

Read are ``MODTRAN[n].MODTRANOUTPUT.SPECTRA.RADIANCE | TRANSMITTANCE | IRRADIANCE`` (one array per column) and,
where the file carries it, ``MODTRAN[n].MODTRANINPUT`` (GEOMETRY, SPECTRAL, ATMOSPHERE).
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.atmosphere.imports.columns import AxisUnit, Run, axis_unit, path_from_columns
from hcss_twin.atmosphere.imports.spectral_path import Geometry, RadianceUnit, SpectralPath
from hcss_twin.errors import CatalogError, choose_from

Array = NDArray[np.float64]

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
        If the text is not JSON, a case has no spectra, arrays differ in length, or numbers are impossible;
        with the line.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise CatalogError(f"{path}: cannot be read as text: {error}") from error
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
        odd = next(each for each in arrays if arrays[each].size != arrays[name].size)
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
    )
    axis = arrays.pop(name)
    # Without a unit in its name a wavelength is in that of XFLAG.
    return path_from_columns(axis, axis_unit(name) or coordinate, arrays, run, radiance)


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


def _geometry(card: Any) -> Geometry | None:
    if not isinstance(card, dict) or card.get("MLOS"):
        sights = card.get("MLOS") if isinstance(card, dict) else None
        if not sights or len(sights) != 1:
            return None
        card = {**card, **sights[0]}
    values = [card.get(key) for key in ("H1ALT", "H2ALT", "OBSZEN")]
    if not all(isinstance(value, (int, float)) for value in values):
        return None
    height, end, angle = (float(value) for value in values)
    return Geometry(height * 1e3, end * 1e3, angle, horizontal=card.get("ITYPE") == 1)


def _resolution(spectral: dict[str, Any]) -> float | None:
    width, flags = spectral.get("FWHM"), str(spectral.get("FLAGS", " "))
    if not isinstance(width, (int, float)) or width <= 0 or flags[:1].upper() in ("M", "N"):
        return None
    return float(width)


def _line(text: str, key: str, number: int) -> int:
    """Line on which a key stands for the ``number``-th time (the first where it does not)."""
    places = [match.start() for match in re.finditer(rf'"{re.escape(key)}"\s*:', text)]
    if not places:
        return 1
    return text.count("\n", 0, places[min(number, len(places)) - 1]) + 1
