"""The model that Pyxel calls at each step of its readout."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_pyxel.exposure import BETWEEN, Between, frame_weights
from hcss_pyxel.files import frame_times_s
from hcss_pyxel.radiometry import black_body_wavelength_um, etendue_m2_sr, photons
from hcss_twin import open_cube
from hcss_twin.providers import choose_from

if TYPE_CHECKING:
    import xarray as xr
    from pyxel.detectors import Detector

Array = NDArray[np.float64]

UNITS = "W m-2 sr-1"
WAVELENGTHS = ("central", "black-body")


def load_cube(
    detector: Detector,
    cube: str | os.PathLike[str],
    band: str | None = None,
    *,
    f_number: float | None = None,
    aperture_diameter: float | None = None,
    focal_length: float | None = None,
    transmission: float = 1.0,
    wavelength_um: float | str = "central",
    frames: Between = "hold",
    integration_time: float | None = None,
    time_offset: float = 0.0,
    window: Sequence[int] | None = None,
    variable: str = "radiance",
) -> None:
    """Add the photons of one readout step of a cube to ``detector.photon``.

    A pixel receives L A Omega transmission t lambda / (h c) photons: L is the mean band radiance of the exposure, A
    Omega follows from the pixel's size (``detector.geometry``) and the f-number. The exposure ends at
    ``detector.absolute_time`` and lasts as long as the step, ``detector.time_step``, or ``integration_time``. Pyxel's
    time is that of the cube: 0 is the scenario's start. Row 0 of the detector is row 0 of the cube, the southernmost.

    Parameters
    ----------
    detector : Detector
        Of any kind; ``pixel_vert_size`` and ``pixel_horz_size`` (um) are needed.
    cube : path-like
        A finished cube, clean or with the effects of a sensor's optics.
    band : str, optional
        Name of the band; needed where the cube has several.
    f_number : float, optional
        Focal length over diameter of the aperture; or give both of these.
    aperture_diameter, focal_length : float, optional
        m.
    transmission : float
        Of the optics, above 0, at most 1.
    wavelength_um : float or {"central", "black-body"}
        Mean wavelength of the radiance in the band, by which it is turned into photons: a number; ``central``, the
        middle of the band; or ``black-body``, for each pixel that of a black body with the same radiance in the band.
    frames : {"hold", "interpolate"}
        What is there between two frames: the earlier one, or straight lines in time. The last frame is held as long
        as the one before it.
    integration_time : float, optional
        s; default: the whole step.
    time_offset : float
        s, added to Pyxel's time.
    window : (int, int), optional
        Row and column of the cube that the detector's first pixel sees. Without it cube and detector must have the
        same size.
    variable : str
        A radiance of the cube; a term of it, for example.

    Raises
    ------
    ValueError
        If an argument is not valid or does not fit the cube, the sizes differ, or the exposure lies outside the
        cube's time.
    CubeError
        If the cube cannot be read.
    """
    throughput = _etendue(detector, f_number, aperture_diameter, focal_length) * _transmission(transmission)
    end = float(detector.absolute_time) + _finite("time_offset", time_offset)
    seconds = _exposure_s(float(detector.time_step), integration_time)
    if frames not in BETWEEN:
        raise ValueError(f"frames: '{frames}'; {choose_from(str(frames), BETWEEN)}")
    with open_cube(cube) as dataset:
        data, number = _band_of(dataset, variable, band)
        rows, columns = _window(detector, data, window)
        weights = frame_weights(frame_times_s(dataset), end - seconds, end, frames)
        radiance = _mean(data.isel(band=number, y=rows, x=columns), weights)
        wavelength = _wavelength(dataset, number, radiance, wavelength_um)
    detector.photon += _with_overscan(detector, photons(radiance, throughput, seconds, wavelength))


def _etendue(detector: Detector, f_number: float | None, diameter: float | None, focal_length: float | None) -> float:
    if (f_number is None) == (diameter is None and focal_length is None):
        raise ValueError("f_number: give either it, or both of aperture_diameter and focal_length (m)")
    if f_number is None:
        if diameter is None or focal_length is None:
            missing = "aperture_diameter" if diameter is None else "focal_length"
            raise ValueError(f"{missing}: missing; aperture_diameter and focal_length (m) go together")
        f_number = _positive("focal_length", focal_length) / _positive("aperture_diameter", diameter)
    geometry = detector.geometry
    area_m2 = float(geometry.pixel_vert_size) * float(geometry.pixel_horz_size) * 1e-12
    return etendue_m2_sr(area_m2, _positive("f_number", f_number))


def _transmission(value: float) -> float:
    if not 0.0 < _finite("transmission", value) <= 1.0:
        raise ValueError(f"transmission: {value:g}; allowed: above 0, at most 1")
    return value


def _exposure_s(step_s: float, integration_time: float | None) -> float:
    if integration_time is None:
        return step_s
    # readout times such as 0.1, 0.2, 0.3 have steps that differ in their last bits
    if not 0.0 < _finite("integration_time", integration_time) <= step_s * (1.0 + 1e-9):
        raise ValueError(
            f"integration_time: {integration_time:g} s; allowed: above 0, at most the step of the readout, {step_s:g} s"
        )
    return min(integration_time, step_s)


def _positive(name: str, value: float) -> float:
    if not _finite(name, value) > 0.0:
        raise ValueError(f"{name}: {value:g}; allowed: above 0")
    return float(value)


def _finite(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{name}: {value!r}; a finite number is needed")
    return float(value)


def _band_of(dataset: xr.Dataset, variable: str, band: str | None) -> tuple[xr.DataArray, int]:
    radiances = [
        str(name)
        for name, data in dataset.data_vars.items()
        if data.dims == ("time", "band", "y", "x") and data.attrs.get("units") == UNITS
    ]
    if variable not in radiances:
        raise ValueError(
            f"variable: '{variable}' is no band radiance ({UNITS}) of the cube; {choose_from(variable, radiances)}"
        )
    bands = [str(name) for name in dataset["band"].to_numpy()]
    if band is None and len(bands) == 1:
        band = bands[0]
    if band not in bands:
        told = "the cube has several" if band is None else f"the cube has no '{band}'"
        raise ValueError(f"band: {told}; {choose_from(str(band or ''), bands)}")
    return dataset[variable], bands.index(band)


def _window(detector: Detector, data: xr.DataArray, window: Sequence[int] | None) -> tuple[slice, slice]:
    rows, columns = _lit_rows(detector), int(detector.geometry.col)
    size = {"y": data.sizes["y"], "x": data.sizes["x"]}
    if window is None:
        if (rows, columns) != (size["y"], size["x"]):
            raise ValueError(
                f"the detector has {rows} x {columns} pixels (rows x columns), the cube {size['y']} x {size['x']}; "
                "make them equal, or say with window: [row, column] where the detector's first pixel lies in the cube"
            )
        return slice(None), slice(None)
    first = list(window)
    if len(first) != 2 or any(isinstance(number, bool) or not isinstance(number, int) for number in first):
        raise ValueError(f"window: {first}; two whole numbers, a row and a column of the cube, are needed")
    for name, start, length, whole in (("row", first[0], rows, size["y"]), ("column", first[1], columns, size["x"])):
        if not 0 <= start <= whole - length:
            allowed = f"0 to {whole - length}" if length <= whole else "none, the detector is larger than the cube"
            raise ValueError(
                f"window: {name} {start} for {length} {name}s of the detector, {whole} of the cube; allowed: {allowed}"
            )
    return slice(first[0], first[0] + rows), slice(first[1], first[1] + columns)


def _lit_rows(detector: Detector) -> int:
    """Return the illuminated rows: all except the overscan of a CCD."""
    geometry = detector.geometry
    return int(geometry.image_row if getattr(geometry, "has_overscan", False) else geometry.row)


def _with_overscan(detector: Detector, lit: Array) -> Array:
    dark = int(detector.geometry.row) - lit.shape[0]
    return np.vstack((lit, np.zeros((dark, lit.shape[1])))) if dark else lit


def _mean(data: xr.DataArray, weights: Array) -> Array:
    """Return the weighted mean of frames; those without weight are not read."""
    total = np.zeros((data.sizes["y"], data.sizes["x"]))
    for index in np.flatnonzero(weights):
        total += weights[index] * data.isel(time=int(index)).to_numpy().astype(np.float64)
    if not np.isfinite(total).all():
        raise ValueError(f"{data.name}: {int(np.sum(~np.isfinite(total)))} values are not finite")
    return total


def _wavelength(dataset: xr.Dataset, number: int, radiance: Array, wanted: float | str) -> Array | float:
    lower, upper = (float(bound) for bound in dataset["wavelength_bounds"].to_numpy()[number])
    if wanted == "central":
        return float(dataset["wavelength"].to_numpy()[number])
    if wanted == "black-body":
        return black_body_wavelength_um(radiance, lower, upper)
    if isinstance(wanted, str):
        raise ValueError(
            f"wavelength_um: '{wanted}'; a number from {lower:g} to {upper:g}, or {choose_from(wanted, WAVELENGTHS)}"
        )
    if not lower <= _finite("wavelength_um", wanted) <= upper:
        raise ValueError(f"wavelength_um: {wanted:g}; the band lies between {lower:g} and {upper:g} um")
    return float(wanted)
