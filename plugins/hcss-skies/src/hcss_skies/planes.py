"""Brightness temperature from files of satellite images: choice of the channel, of one image among several, pixel size.

Files with one image per variable are read as ``hcss import`` reads them. NetCDF variables with more dimensions, such as
scene and time, need the index of one image. If a file has several images, the window channel is chosen by its name or
its wavelength.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin.core.reading import Reading
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.providers import Array, CatalogError, choose_from

_EARTH_RADIUS_M = 6.371e6


FIRST = r"(ir|bt|tb|cmi|rad|ch)?_?(108|10\.8|c13|103|10\.3)(_?um)?"
SECOND = r"(ir|bt|tb|cmi|rad|ch)?_?(120|12\.0|c15|123)(_?um)?"
"""Names of window channels near 10.8 and 12.0 um: of SEVIRI (IR_108), of GOES ABI in files of all bands (CMI_C13)."""


@dataclass(frozen=True)
class Plane:
    """Brightness temperature of one image.

    Attributes
    ----------
    kelvin : ndarray (rows, columns)
        North and east last; NaN where missing.
    pixel_size_m : float or None
        Square root of a pixel's area; None if the file does not give it.
    variable, source, rights : str
        Name in the file; file, variable and time; terms of use, empty if not stated.
    notes : tuple of str
        What the user should know.
    """

    kelvin: Array
    pixel_size_m: float | None
    variable: str
    source: str
    rights: str
    notes: tuple[str, ...] = ()


def read_plane(path: Path, variable: str | None, at: Mapping[str, int], pattern: str = FIRST) -> Plane:
    """Read one image.

    Parameters
    ----------
    path : Path
        NetCDF, or another format of ``hcss import``.
    variable : str, optional
        Default: the only image, or the one whose name matches ``pattern``.
    at : mapping of str to int
        Index along each dimension that is not of the image.
    pattern : str
        Regular expression of the whole name, upper or lower case.

    Raises
    ------
    CatalogError
        If there is no such image, or an index is missing or out of range.
    """
    if not Reading(path, CatalogError).is_netcdf:
        if at:
            raise CatalogError(f"{path}: --at {next(iter(at))}: allowed for NetCDF variables of several images only")
        return _of_image(path, read_image(path, variable))
    with Reading(path, CatalogError, "not a NetCDF file that can be read").netcdf() as dataset:
        name = variable or window_channel(dataset.variables, pattern)
        item = None if name is None else dataset.variables.get(name)
        if item is not None and (at or sum(size > 1 for size in item.shape) > 2):
            return _of_stack(path, dataset, item, at)
    if at:
        raise CatalogError(f"{path}: --at {next(iter(at))}: allowed with a variable of several images; name it")
    return _of_image(path, read_image(path, name))


def window_channel(variables: Mapping[str, Any], pattern: str) -> str | None:
    """Return the only variable of at least two dimensions whose name matches a pattern; None if there is none."""
    matching = [
        name
        for name, variable in variables.items()
        if variable.ndim >= 2 and re.fullmatch(pattern, name, re.IGNORECASE)
    ]
    return matching[0] if len(matching) == 1 else None


def _of_image(path: Path, image: SatelliteImage) -> Plane:
    kelvin = image.north_and_east_last
    if image.planck is not None:
        kelvin = image.planck.kelvin(kelvin)
    elif image.units not in ("", "K"):
        raise CatalogError(f"{path}: {image.variable or 'the image'} has the unit '{image.units}'; allowed: K")
    source = ", ".join(part for part in (image.source, f"{image.long_name} {image.date}".strip()) if part)
    notes = ["the image is taken for brightness temperature in kelvin", *image.notes]
    if image.pixel_size_is_nominal:
        notes.append(f"pixels have {image.pixel_size_m:.5g} m below the satellite and are larger elsewhere")
    low, high = image.WINDOW_UM
    if image.wavelength_um is not None and not low <= image.wavelength_um <= high:
        notes.append(f"{image.band} is no window channel ({low:g} to {high:g} um): heights of clouds are wrong")
    return Plane(kelvin, image.pixel_size_m, image.variable, source, image.rights, tuple(notes))


def _of_stack(path: Path, dataset: Any, item: Any, at: Mapping[str, int]) -> Plane:
    """Return one image of a variable with several."""
    others = item.dimensions[:-2]
    for name in at:
        if name not in others:
            raise CatalogError(f"{path}: --at {name}: no such dimension of {item.name}; {choose_from(name, others)}")
    index, stated = [], []
    for name, size in zip(others, item.shape, strict=False):
        if name not in at and size > 1:
            raise CatalogError(
                f"{path}: {item.name} has {size} images along {name}; choose one with --at {name}=0 to {size - 1}"
            )
        number = at.get(name, 0)
        if not 0 <= number < size:
            raise CatalogError(f"{path}: --at {name}={number}; allowed: 0 to {size - 1}")
        index.append(number)
        if size > 1:
            stated.append(f"{name} {number}")
    values = np.ma.filled(np.ma.asarray(item[tuple(index)]).astype(np.float64), np.nan)
    units = str(getattr(item, "units", "K"))
    image = SatelliteImage(values, None, False, units, item.name, path.name).examined(path)
    if not image.is_temperature:
        raise CatalogError(f"{path}: {item.name} has the unit '{units}'; allowed: K")
    plane = Plane(
        image.values, None, item.name, f"{path.name}, {item.name} {', '.join(stated)}".rstrip(),
        str(getattr(dataset, "license", "") or getattr(dataset, "rights", "")), image.notes,
    )  # fmt: skip
    places = [_coordinate(dataset, name, item.dimensions, index) for name in ("latitude", "longitude")]
    return plane if any(coordinate is None for coordinate in places) else _located(plane, *places)


def _coordinate(dataset: Any, name: str, dimensions: tuple[str, ...], index: list[int]) -> Any:
    """Return a coordinate of all pixels of an image; None if there is none."""
    coordinate = dataset.variables.get(name)
    if coordinate is None or coordinate.dimensions[-2:] != dimensions[-2:]:
        return None
    chosen = dict(zip(dimensions[:-2], index, strict=True))
    if any(dimension not in chosen for dimension in coordinate.dimensions[:-2]):
        return None
    return np.ma.filled(
        np.ma.asarray(coordinate[tuple(chosen[dimension] for dimension in coordinate.dimensions[:-2])]).astype(
            np.float64
        ),
        np.nan,
    )


def _located(plane: Plane, latitude: Array, longitude: Array) -> Plane:
    """Return an image with north and east last, and with the pixel size of its coordinates, in degrees."""
    kelvin = plane.kelvin
    if np.nanmean(np.diff(latitude, axis=0)) < 0.0:
        kelvin, latitude, longitude = (values[::-1] for values in (kelvin, latitude, longitude))
    if np.nanmean(np.diff(longitude, axis=1)) < 0.0:
        kelvin, latitude, longitude = (values[:, ::-1] for values in (kelvin, latitude, longitude))
    sides = []
    for axis in (0, 1):
        north, east = (np.radians(np.diff(degrees, axis=axis)) for degrees in (latitude, longitude))
        middle = np.radians(latitude[:-1] if axis == 0 else latitude[:, :-1])
        sides.append(_EARTH_RADIUS_M * float(np.nanmedian(np.hypot(north, np.cos(middle) * east))))
    tall, wide = sides
    notes = plane.notes
    if max(sides) > 1.1 * min(sides):
        notes = (*notes, f"pixels of {tall:.4g} m (rows) x {wide:.4g} m: taken as squares of the same area")
    return replace(plane, kelvin=kelvin, pixel_size_m=float(np.sqrt(tall * wide)), notes=notes)
