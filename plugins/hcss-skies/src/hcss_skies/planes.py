"""Brightness temperature from files of satellite images: choice of the channel, of one image among several, pixel size.

Files are read as ``hcss import`` reads them: NetCDF variables with more dimensions than an image, such as scene and
time, need the index of one image. If a file has several images, the window channel is chosen by its name or
its wavelength.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hcss_twin.core.reading import Reading
from hcss_twin.models.clouds.imagery.image import SatelliteImage
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.providers import Array, CatalogError

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
    name = variable
    if variable is None and Reading(path, CatalogError).is_netcdf:
        with Reading(path, CatalogError, "not a NetCDF file that can be read").netcdf() as dataset:
            name = window_channel(dataset.variables, pattern)
    return _of_image(path, read_image(path, name, at))


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
