"""Output of libRadtran's ``uvspec`` with a user-defined ``output_user`` line.

A uvspec output file has numbers only. The input file defines them; its lines are passed here as settings
(``output_user``, ``source``, ``umu``, ``sza``, ``altitude``, ``zout``, ``output_quantity``, ``output_process``,
``sur_temperature``). uvspec does not output path transmittance or path radiance, so a path takes two runs:

* ``source solar`` with ``output_quantity transmittance`` (or ``reflectivity``): the direct beam ``edir`` at the
  ground of a sun at zenith ``sza`` is the transmittance from the ground to space (times its cosine);
* ``source thermal`` with ``albedo 0`` and ``zout toa``: ``uu`` upwards is the path radiance plus the transmitted
  emission of the ground at ``sur_temperature``, which is subtracted when the two runs are combined.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_modtran.spectral_path import PathGeometry, RadianceUnit, SpectralPath, radiance_factor, read_text
from hcss_twin.providers import Array, CatalogError, choose_from

TOP_M = 120_000.0
"""Altitude of uvspec's ``toa``: the top of its standard atmospheres."""

_SCALARS = (
    "lambda", "wavenumber", "sza", "zout", "edir", "eglo", "edn", "eup", "enet", "esum", "fdir", "fglo", "fdn",
    "fup", "f", "uavgdir", "uavgglo", "uavgdn", "uavgup", "uavg", "albedo", "spher_alb", "p", "T", "heat",
)  # fmt: skip

_SHORT = {"wvl": "lambda", "wavelength": "lambda", "wvn": "wavenumber"}

_PROCESSED: Mapping[str, RadianceUnit] = {"per_nm": "per_nm", "per_cm-1": "per_cm1"}
"""Spectral unit of radiance for each ``output_process``; by default it depends on the absorption scheme."""


_CHANGES = ("mol_modify", "mixing_ratio", "mol_file")
"""Settings that change amounts of gases."""


def read_settings(lines: Sequence[str]) -> dict[str, list[str]]:
    """Read lines of a uvspec input file: maps the first word to the words after it; drops comments."""
    settings: dict[str, list[str]] = {}
    for line in lines:
        words = line.split("#", 1)[0].split()
        if words:
            settings[words[0]] = words[1:]
    return settings


def read_libradtran(path: Path, settings: Mapping[str, Sequence[str]]) -> list[SpectralPath]:
    """Read a uvspec output file.

    Parameters
    ----------
    path : Path
        uvspec output file.
    settings : mapping of str to sequence of str
        From :func:`read_settings`; ``output_user`` and ``source`` are required.

    Returns
    -------
    list of SpectralPath
        A solar run gives one with transmittance; a thermal run one per ``umu`` with total radiance.

    Raises
    ------
    CatalogError
        If a setting is missing or unsuitable, or a row does not match ``output_user``; the message names the line.
    """
    source = (settings.get("source") or ["?"])[0]
    if source not in ("solar", "thermal"):
        raise CatalogError(f"{path}: setting 'source' is '{source}'; {choose_from(source, ('solar', 'thermal'))}")
    names = _columns(path, settings)
    table, lines = _table(path, names)
    column = {name: table[:, index] for index, name in enumerate(names)}
    if "wavenumber" in column:
        wavenumber = column["wavenumber"]
    elif "lambda" in column:
        wavenumber = 1e7 / column["lambda"]
    else:
        raise CatalogError(f"{path}: output_user needs lambda or wavenumber; found {' '.join(names)}")
    keep = _level(path, settings, column, source)
    column = {name: values[keep] for name, values in column.items()}
    lines = [line for line, used in zip(lines, keep, strict=True) if used]
    order = np.argsort(wavenumber[keep])
    wavenumber = wavenumber[keep][order]
    if np.any(np.diff(wavenumber) <= 0):
        row = int(order[int(np.argmax(np.diff(wavenumber) <= 0)) + 1])
        raise CatalogError(
            f"{path}, line {lines[row]}: a wavelength appears twice; with several zout put zout into output_user"
        )
    column = {name: values[order] for name, values in column.items()}
    ground_m = _one(path, settings, "altitude", 0.0) * 1e3
    read = _solar if source == "solar" else _thermal
    paths = read(path, settings, column, wavenumber, ground_m, [lines[at] for at in order])
    return [replace(path, changes=tuple(name for name in _CHANGES if name in settings)) for path in paths]


def _solar(
    path: Path,
    settings: Mapping[str, Sequence[str]],
    column: Mapping[str, Array],
    wavenumber: Array,
    ground_m: float,
    lines: Sequence[int],
) -> list[SpectralPath]:
    if "edir" not in column:
        raise CatalogError(f"{path}: a solar run needs edir in output_user")
    zenith = _one(path, settings, "sza", None)
    quantity = (settings.get("output_quantity") or ["radiance"])[0]
    if quantity not in ("transmittance", "reflectivity"):
        raise CatalogError(
            f"{path}: setting 'output_quantity' is '{quantity}'; "
            f"{choose_from(quantity, ('transmittance', 'reflectivity'))}"
        )
    share = math.cos(math.radians(zenith)) if quantity == "transmittance" else 1.0
    # With six printed digits, transmittance may be slightly above 1 at a transparent wavenumber.
    transmittance = column["edir"] / share
    bad = (transmittance < 0) | (transmittance > 1 + 2e-6) | ~np.isfinite(transmittance)
    if np.any(bad):
        row = int(np.argmax(bad))
        raise CatalogError(
            f"{path}, line {lines[row]}: direct transmittance {transmittance[row]:g}; allowed 0 to 1 "
            "(check output_quantity and sza)"
        )
    return [
        SpectralPath(
            wavenumber_cm1=wavenumber,
            transmittance=np.minimum(transmittance, 1.0),
            path_radiance=None,
            geometry=PathGeometry(ground_m, TOP_M, zenith, refracted=False),
            code="libRadtran uvspec, solar",
            source=path.name,
            line=lines[0],
        )
    ]


def _thermal(
    path: Path,
    settings: Mapping[str, Sequence[str]],
    column: Mapping[str, Array],
    wavenumber: Array,
    ground_m: float,
    lines: Sequence[int],
) -> list[SpectralPath]:
    cosines = _numbers(path, settings, "umu")
    if _one(path, settings, "albedo", 0.0) != 0.0:
        raise CatalogError(f"{path}: a thermal run needs 'albedo 0': reflected sky radiance is not path radiance")
    temperature = _one(path, settings, "sur_temperature", None)
    quantity = (settings.get("output_quantity") or ["radiance"])[0]
    if quantity != "radiance":
        raise CatalogError(f"{path}: a thermal run needs radiances; output_quantity is '{quantity}'")
    process = (settings.get("output_process") or ["missing"])[0]
    if process not in _PROCESSED:
        raise CatalogError(f"{path}: setting 'output_process' is '{process}'; {choose_from(process, _PROCESSED)}")
    unit = _PROCESSED[process]
    paths = []
    for index, cosine in enumerate(cosines):
        radiance = column[f"uu[{index}]"]
        bad = ~np.isfinite(radiance) | (radiance < 0)
        if np.any(bad):
            row = int(np.argmax(bad))
            raise CatalogError(f"{path}, line {lines[row]}: radiance {radiance[row]:g}; allowed 0 and above")
        if cosine <= 0:
            continue
        angle = 180.0 - math.degrees(math.acos(min(cosine, 1.0)))
        paths.append(
            SpectralPath(
                wavenumber_cm1=wavenumber,
                transmittance=None,
                path_radiance=None,
                geometry=PathGeometry(TOP_M, ground_m, angle, refracted=False),
                code="libRadtran uvspec, thermal",
                source=f"{path.name} umu {cosine:g}",
                line=lines[0],
                total_radiance=radiance * radiance_factor(wavenumber, unit),
                surface_temperature_K=temperature,
            )
        )
    if not paths:
        raise CatalogError(f"{path}: no positive umu: only radiance seen from above can be used")
    return paths


def _columns(path: Path, settings: Mapping[str, Sequence[str]]) -> list[str]:
    """Return the names of all columns; ``uu`` expands to one per umu (and phi)."""
    words = [word for word in settings.get("output_user", ()) if word]
    if not words:
        raise CatalogError(f"{path}: setting 'output_user' is missing; for example: output_user lambda edir uu")
    names: list[str] = []
    for word in words:
        name = _SHORT.get(word, word)
        if name == "uu":
            if len(settings.get("phi", [])) > 1:
                raise CatalogError(f"{path}: several phi; path radiance needs one azimuth")
            names += [f"uu[{index}]" for index in range(len(_numbers(path, settings, "umu")))]
        elif name in _SCALARS or name[:2] in ("n_", "rh", "vm", "mm"):
            names.append(name)
        else:
            raise CatalogError(f"{path}: output_user names '{word}'; {choose_from(word, (*_SCALARS, 'uu'))}")
    return names


def _table(path: Path, names: Sequence[str]) -> tuple[Array, list[int]]:
    text = read_text(path)
    rows, lines = [], []
    for number, line in enumerate(text.splitlines(), start=1):
        fields = line.split("#", 1)[0].split()
        if not fields:
            continue
        if len(fields) != len(names):
            raise CatalogError(
                f"{path}, line {number}: {len(fields)} numbers; output_user ({' '.join(names)}) has {len(names)}"
            )
        try:
            rows.append([float(field) for field in fields])
        except ValueError as error:
            raise CatalogError(f"{path}, line {number}: {error}") from error
        lines.append(number)
    if not rows:
        raise CatalogError(f"{path}, line 1: no rows of numbers")
    return np.array(rows, dtype=np.float64), lines


def _level(
    path: Path, settings: Mapping[str, Sequence[str]], column: Mapping[str, Array], source: str
) -> NDArray[np.bool_]:
    """Return the rows of the required output level: the ground for a solar run, the top for a thermal run."""
    levels = list(settings.get("zout", ["sur"]))
    rows = next(iter(column.values())).size
    wanted = "the ground" if source == "solar" else "the top (zout toa)"
    if len(levels) == 1:
        at_top = levels[0].lower() == "toa" or (_float(levels[0]) or 0.0) * 1e3 >= 80_000.0
        at_ground = levels[0].lower() in ("sur", "boa") or _float(levels[0]) == 0.0
        if not (at_ground if source == "solar" else at_top):
            raise CatalogError(f"{path}: setting 'zout' is '{levels[0]}'; a {source} run is needed at {wanted}")
        return np.ones(rows, dtype=bool)
    if "zout" not in column:
        raise CatalogError(f"{path}: several zout; put zout into output_user, or write {wanted} alone")
    height = column["zout"]
    extreme = height.min() if source == "solar" else height.max()
    keep: NDArray[np.bool_] = height == extreme
    return keep


def _float(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _numbers(path: Path, settings: Mapping[str, Sequence[str]], name: str) -> list[float]:
    words = settings.get(name, ())
    values = [_float(word) for word in words]
    if not values or any(value is None for value in values):
        raise CatalogError(f"{path}: setting '{name}' is needed as numbers; found '{' '.join(words)}'")
    return [value for value in values if value is not None]


def _one(path: Path, settings: Mapping[str, Sequence[str]], name: str, default: float | None) -> float:
    if default is not None and name not in settings:
        return default
    values = _numbers(path, settings, name)
    if len(values) != 1:
        raise CatalogError(f"{path}: setting '{name}' must be one number; found {len(values)}")
    return values[0]
