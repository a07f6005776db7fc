"""Planes of NetCDF files, including GOES ABI."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError, choose_from
from hcss_twin.core.netcdf import NetcdfFile
from hcss_twin.core.reading import MAX_IMAGE_PIXELS, Reading, require_size
from hcss_twin.models.clouds.database import FORMAT as ENTRY
from hcss_twin.models.clouds.imagery.image import PlanckCoefficients, SatelliteImage
from hcss_twin.models.clouds.imagery.located import located
from hcss_twin.models.clouds.imagery.planes import SQUARE, choose_plane, square_side

_UNITS = "mW m-2 sr-1 (cm-1)-1"
"""Unit of the radiances to which :class:`PlanckCoefficients` apply."""

_PLANCK = ("planck_fk1", "planck_fk2", "planck_bc1", "planck_bc2")

_METRES = {"m": 1.0, "metre": 1.0, "meter": 1.0, "km": 1e3, "kilometre": 1e3, "kilometer": 1e3}
_RADIANS = {"rad", "radian"}

# Beyond this wavelength an image is taken as thermal emission, in which high cloud is cold. This is wrong near 4 um in
# daylight, where the user has to set cloud_is.
_THERMAL_UM = 3.0

_OF_AN_ENTRY = (
    "it is an entry of the cloud database, whose 'image' is the imported one; a scenario names it with parameters.entry"
)

_USABLE = ("good", "conditionally_usable")


def read_netcdf(path: Path, variable: str | None, at: Mapping[str, int] = MappingProxyType({})) -> SatelliteImage:
    """Read one plane of a NetCDF file; see :func:`hcss_twin.models.clouds.imagery.reader.read_image`."""
    what = "it is NetCDF, but damaged, truncated or unsupported"
    with Reading(path, CatalogError, what), Reading.quiet(), NetcdfFile(path) as dataset:
        hint = _OF_AN_ENTRY if _text(dataset, "format") == ENTRY else ""
        known = list(dataset.variables)
        name = choose_plane(path, variable, _planes(dataset, at) or _planes(dataset, {}), known, hint)
        item = dataset.variables[name]
        index = _index(path, item, at, dataset)
        shape = [size for size, place in zip(item.shape, index, strict=True) if isinstance(place, slice)]
        require_size(path, tuple(shape), CatalogError, MAX_IMAGE_PIXELS, "pixels")
        return _netcdf_plane(path, dataset, item, index)


def _text(item: Any, name: str) -> str:
    return str(getattr(item, name, ""))


def _long_dimensions(variable: Any) -> list[str]:
    return [name for name, size in zip(variable.dimensions, variable.shape, strict=True) if size > 1]


def _is_plane(variable: Any, at: Mapping[str, int] = MappingProxyType({})) -> bool:
    is_stack = len(_long_dimensions(variable)) > 2 or bool(at)
    fits = is_stack and len(variable.dimensions) > 2 and set(at) <= set(variable.dimensions[:-2])
    return (fits or len(_long_dimensions(variable)) == 2) and getattr(variable.dtype, "kind", "") in "iuf"


def _index(path: Path, variable: Any, at: Mapping[str, int], dataset: Any) -> tuple[int | slice, ...]:
    """Return the index of one image in a variable: all of its rows and columns, which are last in one with several."""
    others = variable.dimensions[:-2]
    for name in at:
        if name not in others:
            raise CatalogError(f"{path}: at {name}: no such dimension of {variable.name}; {choose_from(name, others)}")
    if not _is_plane(variable, at):
        raise CatalogError(
            f"{path}: '{variable.name}' of type {variable.dtype} has the shape {tuple(variable.shape)}; "
            "allowed: numbers with two dimensions longer than 1; "
            f"{choose_from(variable.name, _planes(dataset, at))}"
        )
    long = _long_dimensions(variable)
    images = long if len(long) == 2 and not at else list(variable.dimensions[-2:])
    index: list[int | slice] = []
    for name, size in zip(variable.dimensions, variable.shape, strict=True):
        if name in images:
            index.append(slice(None))
            continue
        if name not in at and size > 1:
            raise CatalogError(
                f"{path}: {variable.name} has {size} images along {name}; allowed: one, chosen with at {name}=0 to "
                f"{size - 1}"
            )
        if not 0 <= at.get(name, 0) < size:
            raise CatalogError(f"{path}: at {name}={at[name]}; allowed: 0 to {size - 1}")
        index.append(at.get(name, 0))
    return tuple(index)


def _planes(dataset: Any, at: Mapping[str, int]) -> list[str]:
    """List the variables that are images, not coordinates, bounds or flags; those of several if there are no others."""
    auxiliary = {
        name
        for variable in dataset.variables.values()
        for attribute in ("coordinates", "ancillary_variables", "bounds")
        for name in _text(variable, attribute).split()
    }
    found = [
        name
        for name, variable in dataset.variables.items()
        if _is_plane(variable, at)
        and name not in auxiliary
        and name.lower() not in ("latitude", "longitude", "lat", "lon")
        and _text(variable, "standard_name") not in ("latitude", "longitude", "status_flag")
    ]
    single = [name for name in found if len(_long_dimensions(dataset.variables[name])) == 2]
    return found if at else single or found


def _netcdf_plane(path: Path, dataset: Any, variable: Any, index: tuple[int | slice, ...]) -> SatelliteImage:
    values = _numbers(variable, index)
    for flag_name in _text(variable, "ancillary_variables").split():
        flags = dataset.variables.get(flag_name)
        if flags is not None and flags.shape == variable.shape:
            values[_unusable(flags, index)] = np.nan
    places = dict(zip(variable.dimensions, index, strict=True))
    y_name, x_name = (name for name, place in places.items() if isinstance(place, slice))
    chosen = {name: place for name, place in places.items() if isinstance(place, int)}
    if _is_eastward(dataset.variables.get(y_name)):
        values, y_name, x_name = values.T, x_name, y_name
    step_y, step_x = (_step(path, dataset.variables.get(name)) for name in (y_name, x_name))
    size, nominal = _pixel_size(path, dataset, variable, (y_name, x_name), (step_y, step_x))
    north_first, east_first = step_y is None or step_y < 0.0, step_x is not None and step_x < 0.0
    place = None if size is not None else located(dataset, variable, (y_name, x_name), chosen)
    if place is not None:
        size, north_first, east_first = place.size_m, place.north_first, place.east_first
    stated = ", ".join(f"{name} {number}" for name, number in chosen.items() if dataset.dimensions[name].size > 1)
    return SatelliteImage(
        values=values,
        pixel_size_m=size,
        bright_is_cloud=not _is_thermal(dataset, variable),
        units=_text(variable, "units") or ("K" if _is_brightness_temperature(variable) else ""),
        long_name=_text(variable, "long_name") or variable.name,
        source=f"{path.name}, {stated}" if stated else path.name,
        pixel_size_is_nominal=nominal,
        north_first=north_first,
        east_first=east_first,
        variable=variable.name,
        band=_band(dataset),
        date=_text(dataset, "time_coverage_start"),
        planck=_planck(dataset) if _text(variable, "units") == _UNITS else None,
        rights=_text(dataset, "license") or _text(dataset, "rights"),
        notes=() if place is None else place.notes,
    )


def _band(dataset: Any) -> str:
    """Return the name of the spectral band of a GOES ABI file; empty for other files."""
    parts = []
    for name, form in (("band_id", "band {:g}"), ("band_wavelength", "{:.4g} um")):
        item = dataset.variables.get(name)
        if item is not None and item.size == 1:
            parts.append(form.format(float(_numbers(item).ravel()[0])))
    return ", ".join(parts)


def _numbers(variable: Any, index: Any = ...) -> Array:
    """Return an unpacked variable with NaN for fill values and values outside its valid range."""
    return np.ma.filled(np.ma.asarray(variable[index]).astype(np.float64), np.nan)


def _unusable(flags: Any, index: tuple[int | slice, ...]) -> NDArray[np.bool_]:
    """Return True where a quality flag is neither good nor conditionally usable; all False for other flags."""
    meanings = _text(flags, "flag_meanings").split()
    usable = [index for index, meaning in enumerate(meanings) if meaning.startswith(_USABLE)]
    codes = np.atleast_1d(getattr(flags, "flag_values", []))
    if not usable or codes.size != len(meanings):
        return np.zeros(flags[index].shape, dtype=np.bool_)
    return ~np.isin(_numbers(flags, index), codes[usable].astype(np.float64))


def _is_eastward(coordinate: Any) -> bool:
    return coordinate is not None and (
        _text(coordinate, "axis") == "X"
        or _text(coordinate, "standard_name") in ("projection_x_coordinate", "longitude")
    )


def _is_brightness_temperature(variable: Any) -> bool:
    name = f"{_text(variable, 'standard_name')} {_text(variable, 'long_name')}".casefold().replace(" ", "_")
    return "brightness_temperature" in name


def _is_thermal(dataset: Any, variable: Any) -> bool:
    """Whether an image shows brightness temperature or thermal radiance, which are low for high, cold cloud."""
    units = _text(variable, "units").casefold()
    if _is_brightness_temperature(variable):
        return True
    wavelength = dataset.variables.get("band_wavelength")
    if "sr-1" not in units or wavelength is None or _text(wavelength, "units") != "um":
        return False
    return bool(np.all(_numbers(wavelength) > _THERMAL_UM))


def _step(path: Path, coordinate: Any) -> float | None:
    """Return the step of a coordinate in its own units; None without a coordinate."""
    if coordinate is None or coordinate.ndim != 1 or coordinate.shape[0] < 2:
        return None
    positions = _numbers(coordinate)
    if _text(coordinate, "units").startswith("degree") and _is_eastward(coordinate):
        positions = np.unwrap(positions, period=360.0)  # across the date line
    step = float(positions[-1] - positions[0]) / (positions.size - 1)
    if not np.all(np.abs(np.diff(positions) - step) <= SQUARE * abs(step)) or step == 0.0:
        raise CatalogError(f"{path}: coordinate '{coordinate.name}' is not evenly spaced; resample the image")
    return step


def _pixel_size(
    path: Path, dataset: Any, variable: Any, names: tuple[str, str], steps: tuple[float | None, float | None]
) -> tuple[float | None, bool]:
    """Return the pixel size in metres (None if unknown) and whether it is nominal.

    On the fixed grid of a geostationary imager (GOES-R Product Definition and Users' Guide, vol. 3, section 5.1.2) x
    and y are scan angles; multiplied by the satellite height, they give lengths at the sub-satellite point.
    """
    mapping = dataset.variables.get(_text(variable, "grid_mapping").split(":")[0].strip())
    geostationary = _text(mapping, "grid_mapping_name") == "geostationary"
    height = float(getattr(mapping, "perspective_point_height", np.nan))
    sides = []
    for name, step in zip(names, steps, strict=True):
        units = _text(dataset.variables.get(name), "units").casefold().removesuffix("s")
        metres = height if units in _RADIANS else _METRES.get(units, np.nan)
        if step is None or not np.isfinite(metres):
            return None, False
        sides.append(abs(step) * metres)
    return square_side(path, sides[1], sides[0]), geostationary


def _planck(dataset: Any) -> PlanckCoefficients | None:
    """Return the coefficients in a file; None if it has none, or not a number, as for solar reflective bands."""
    if not all(name in dataset.variables for name in _PLANCK):
        return None
    values = [float(_numbers(dataset.variables[name]).ravel()[0]) for name in _PLANCK]
    return PlanckCoefficients(*values) if np.all(np.isfinite(values)) else None
