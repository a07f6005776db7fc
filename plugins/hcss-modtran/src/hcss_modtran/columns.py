"""Conversion of MODTRAN columns, whose names vary with version and file format, to a :class:`SpectralPath`.

The same quantities appear as ``PTH_THRML`` (tape7 of MODTRAN 5), ``PTH THRML`` (MODTRAN 3 and 4), ``THRML_EM`` (tape7
and JSON of MODTRAN 6) and ``path emission`` (its CSV). Names are compared without regard to case and punctuation.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_modtran.spectral_path import PathGeometry, RadianceUnit, SpectralPath, radiance_factor
from hcss_twin.providers import Array, CatalogError, planck

AxisUnit = Literal["cm1", "um", "nm"]

_NAMES: Mapping[str, tuple[str, ...]] = {
    "transmittance": (
        "TOT_TRANS", "TOTAL_TRANS", "COMBIN_TRANS", "TRANS", "TRAN", "TOTAL_TRANSMITTANCE", "PATH_TRANS",
        "COMBINED_TRANS",
    ),
    "thermal": ("PTH_THRML", "THRML_EM", "PATH_EMISSION", "PATH_EMISS", "PATH_THERMAL"),
    "thermal_scattered": ("THRML_SCT", "PATH_THERMAL_SCAT"),
    "surface": ("SURF_EMIS", "SURFACE_EMISSION", "SURFACE_EMISS"),
    "solar": ("SOL_SCAT", "MULT_SCAT", "PATH_MULTIPLE_SCAT", "PATH_MULTI_SCAT"),
    "single_scattered": ("SING_SCAT", "SNGL_SCAT", "PATH_SINGLE_SCAT"),
    "ground": ("GRND_RFLT", "GROUND_REFLECT", "GROUND_REFLECTED"),
    "sun_reflected": ("DRCT_RFLT", "DIRECT_REFLECT", "DIRECT_REFLECTED"),
    "total": ("TOTAL_RAD", "TOTAL_RADIANCE"),
    "via_end": ("REF_SOL", "REFERENCE_IRRADIANCE", "IRRAD_REF"),
    "at_observer": ("SOL_OBS", "SOL_AT_OBS", "IRRADIANCE_AT_OBSERVER", "IRRAD_OBS"),
    "at_top": ("TOA_SUN", "TOA_RAD", "TOP_OF_ATMOSPHERE_IRRADIANCE", "TOA_IRRAD", "SOLAR"),
    "transmitted": ("SOL_TR",),
    "brightness": ("BBODY_T_K", "BBODY_TK", "BRIGHTNESS_TEMP", "BBODY_TEMP", "BRIGHTNESS_TEMPERATURE"),
}  # fmt: skip

# Names that explicitly denote the unscattered part alone (MODTRAN 6).
_PARTS = {"THRML_EM", "PATH_EMISSION", "PATH_EMISS", "MULT_SCAT", "PATH_MULTIPLE_SCAT", "PATH_MULTI_SCAT"}

_AXES: Mapping[str, AxisUnit] = {
    "FREQ": "cm1", "FREQ_CM_1": "cm1", "FREQUENCY": "cm1", "WAVENUMBER": "cm1", "WAVENUMBER_CM_1": "cm1",
    "WAVLEN_MCRN": "um", "WAVELENGTH_MICRON": "um", "WAVELENGTH_UM": "um", "WAVLEN_UM": "um",
    "WAVELENGTH_MCRN": "um", "WAVELENGTH_MICRONS": "um",
    "WAVLEN_NM": "nm", "WAVELENGTH_NM": "nm",
}  # fmt: skip

_WATT_PER_CM2: Mapping[RadianceUnit, float] = {"per_cm1": 1e4, "per_um": 1e4, "per_nm": 1e-2}
"""Factors from MODTRAN's W cm-2 (per cm-1 and per um) and uW cm-2 (per nm) to W m-2."""

UNIT_NAMES: Mapping[RadianceUnit, str] = {
    "per_cm1": "W cm-2 sr-1 / cm-1",
    "per_um": "W cm-2 sr-1 / um",
    "per_nm": "uW cm-2 sr-1 / nm",
}

_CLOSURE = 2e-3
"""Relative difference between TOTAL_RAD and the sum of its parts that rounding to five digits explains."""

_BRIGHTNESS = 0.05
"""Allowed relative difference between TOTAL_RAD and the Planck radiance at the brightness temperature."""


@dataclass(frozen=True)
class Run:
    """Metadata of a run, apart from its columns.

    Attributes
    ----------
    file : str
        Name of the file, for messages.
    lines : sequence of int
        Line number of each row; a single one where the format has no rows (JSON).
    code, source : str
        As in :class:`SpectralPath`.
    """

    file: str
    lines: Sequence[int]
    code: str
    source: str
    geometry: PathGeometry | None = None
    model: int | None = None
    resolution_cm1: float | None = None
    notes: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()

    def error(self, row: int, message: str) -> CatalogError:
        """Return an error that names the line of a row."""
        return CatalogError(f"{self.file}, line {self.lines[min(row, len(self.lines) - 1)]}: {message}")


def normalised(name: str) -> str:
    """Return a column name in upper case, with other characters replaced by single underscores."""
    return re.sub(r"[^A-Z0-9]+", "_", name.upper()).strip("_")


def axis_unit(name: str) -> AxisUnit | None:
    """Return the unit of a spectral coordinate column, or None for other columns."""
    return _AXES.get(normalised(name))


def is_known(name: str) -> bool:
    """Whether a name is a known column or the spectral coordinate."""
    plain = normalised(name)
    return plain in _AXES or any(plain in names for names in _NAMES.values())


def path_from_columns(
    axis: Array, unit: AxisUnit, columns: Mapping[str, Array], run: Run, radiance: RadianceUnit | None = None
) -> SpectralPath:
    """Check MODTRAN columns and convert them.

    Parameters
    ----------
    axis : ndarray (V,)
        Spectral coordinate in ``unit``, ascending or descending.
    columns : mapping of str to ndarray (V,)
        Keyed by the names in the file; unknown ones are ignored.
    run : Run
        Metadata of the run.
    radiance : RadianceUnit, optional
        Spectral unit of radiance; that of the axis by default, as in MODTRAN's convolved output.

    Raises
    ------
    CatalogError
        If the axis is not monotonic, a value is impossible, the parts do not add up to the total, or the
        total contradicts the brightness temperature (wrong unit). The message names the line.

    Notes
    -----
    Versions differ in whether the thermal and solar columns include their scattered part. TOTAL_RAD decides: it must be
    the sum of its parts in one of the two interpretations.
    """
    names = _by_meaning(columns)
    wavenumber, order = _wavenumber(axis, unit, run)
    values = {key: columns[name] for key, name in names.items()}
    for key, array in values.items():
        _require(np.isfinite(array), run, f"{names[key]} is not a finite number", array)
    if "transmittance" in values:
        tau = values["transmittance"]
        _require((tau >= 0) & (tau <= 1), run, f"{names['transmittance']}: allowed 0 to 1", tau)
    for key in ("thermal", "surface", "solar", "ground", "total"):
        if key in values:
            _require(values[key] >= 0, run, f"{names[key]} must not be negative", values[key])
    radiance = radiance or ("per_cm1" if unit == "cm1" else "per_um" if unit == "um" else "per_nm")
    native = 1e4 / axis if unit == "um" else 1e7 / axis if unit == "nm" else axis
    factor = _WATT_PER_CM2[radiance] * radiance_factor(native, radiance)
    thermal, sunlight = _with_scattered(values, names, run)
    _check_brightness(native, values, factor, radiance, run)

    def converted(array: Array | None) -> Array | None:
        return None if array is None else (array * factor)[order]

    solar = {
        name: (array * factor)[order]
        for name, array in (
            ("scattered", sunlight),
            ("single_scattered", values.get("single_scattered")),
            ("ground_reflected", values.get("ground")),
            ("sun_reflected", values.get("sun_reflected")),
            ("via_end", values.get("via_end")),
            ("at_observer", values.get("at_observer")),
            ("at_top", values.get("at_top")),
            ("transmitted", values.get("transmitted")),
        )
        if array is not None
    }
    transmittance = values.get("transmittance")
    return SpectralPath(
        wavenumber_cm1=wavenumber,
        transmittance=None if transmittance is None else transmittance[order],
        path_radiance=converted(thermal),
        geometry=run.geometry,
        code=run.code,
        source=run.source,
        line=run.lines[0],
        solar=solar,
        total_radiance=converted(values.get("total")),
        surface_emission=converted(values.get("surface")),
        model=run.model,
        resolution_cm1=run.resolution_cm1,
        notes=run.notes,
        changes=run.changes,
    )


def _by_meaning(columns: Mapping[str, Array]) -> dict[str, str]:
    plain = {normalised(name): name for name in columns}
    return {
        key: plain[next(name for name in names if name in plain)]
        for key, names in _NAMES.items()
        if any(name in plain for name in names)
    }


def _wavenumber(axis: Array, unit: AxisUnit, run: Run) -> tuple[Array, NDArray[np.intp]]:
    _require(np.isfinite(axis) & (axis > 0), run, "the spectral coordinate must be positive", axis)
    step = np.diff(axis)
    if step.size and np.any(np.sign(step) != np.sign(step[0])):
        row = int(np.argmax(np.sign(step) != np.sign(step[0]))) + 1
        raise run.error(row, f"the spectral coordinate reverses direction at {axis[row]:g}; it must be monotonic")
    if np.any(step == 0):
        raise run.error(int(np.argmax(step == 0)) + 1, "the spectral coordinate repeats a value")
    wavenumber = axis if unit == "cm1" else (1e4 if unit == "um" else 1e7) / axis
    order: NDArray[np.intp] = np.argsort(wavenumber)
    return wavenumber[order], order


def _with_scattered(
    values: Mapping[str, Array], names: Mapping[str, str], run: Run
) -> tuple[Array | None, Array | None]:
    """Return thermal path radiance and scattered sunlight, each including its scattered part."""
    thermal = values.get("thermal")
    if thermal is None:
        return None, values.get("solar")
    zero = np.zeros_like(thermal)
    sunlight, single = values.get("solar"), values.get("single_scattered", zero)
    scattered = values.get("thermal_scattered", zero)
    whole = (thermal, sunlight)
    summed = (thermal + scattered, None if sunlight is None else sunlight + single)
    parts_first = normalised(names["thermal"]) in _PARTS
    readings = (summed, whole) if parts_first else (whole, summed)
    if "total" not in values:
        return readings[0]
    total, rest = values["total"], values.get("surface", zero) + values.get("ground", zero)
    defects = []
    for warm, sun in readings:
        defect = np.abs(warm + (zero if sun is None else sun) + rest - total)
        worst = defect - _CLOSURE * total
        if np.all(worst <= 0):
            return warm, sun
        defects.append(worst)
    better = min(defects, key=lambda worst: float(worst.max()))
    row = int(np.argmax(better))
    raise run.error(
        row,
        f"{names['total']} {total[row]:.4E} is not the sum of the path's thermal, surface, solar and "
        "ground parts; a column is misplaced or the file is damaged",
    )


def _check_brightness(
    wavenumber: Array, values: Mapping[str, Array], factor: Array, unit: RadianceUnit, run: Run
) -> None:
    if "total" not in values or "brightness" not in values:
        return
    total, temperature = values["total"], values["brightness"]
    # Below 100 K the Planck radiance is lost in the rounding to five printed digits.
    use = (temperature > 100.0) & (total > 0)
    if not np.any(use):
        return
    # With a coordinate in the wrong unit, wavelengths may be so short that the Planck radiance underflows.
    expected = np.maximum(planck(wavenumber[use], temperature[use]), 1e-300)
    ratio = total[use] * factor[use] / expected
    wrong = np.abs(ratio - 1.0) > _BRIGHTNESS
    if not np.any(wrong):
        return
    row = int(np.flatnonzero(use)[np.argmax(wrong)])
    fitting = [
        UNIT_NAMES[other]
        for other in _WATT_PER_CM2
        if np.all(
            np.abs(total[use] * _WATT_PER_CM2[other] * radiance_factor(wavenumber[use], other) / expected - 1.0)
            <= _BRIGHTNESS
        )
    ]
    hint = f"; the file's numbers fit {fitting[0]}" if fitting else ""
    raise run.error(
        row,
        f"radiance taken as {UNIT_NAMES[unit]} contradicts the brightness temperature "
        f"{temperature[row]:.2f} K by a factor {float(ratio[wrong][0]):.3g}{hint}",
    )


def _require(good: NDArray[np.bool_], run: Run, message: str, array: Array) -> None:
    if not np.all(good):
        row = int(np.argmin(good))
        raise run.error(row, f"{message}; found {array[row]:g}")
