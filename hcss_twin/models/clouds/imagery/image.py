"""One plane of a satellite image in memory, from any file format."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CatalogError, choose_from

SQUARE = 0.01
"""Maximum relative scatter of coordinate steps, and difference of the two sides, for square pixels."""

WINDOW_UM = 10.0, 12.6
"""Wavelengths at which the air is transparent enough for the inversion of brightness temperature at 10.8 um."""


@dataclass(frozen=True)
class SatelliteImage:
    """One plane of an image with its metadata.

    Attributes
    ----------
    values : ndarray of float64 (rows, columns)
        As stored, in physical units if the file gives them; NaN where missing.
    pixel_size_m : float or None
        Side of a pixel on the ground; None where the file does not give it.
    bright_is_cloud : bool
        Whether cloud has the larger values.
    units, long_name : str
        Of the values; empty if the file does not give them.
    source : str
        Name of the file.
    pixel_size_is_nominal : bool
        True for a geostationary image: its pixel size applies at the sub-satellite point; pixels elsewhere are larger.
    north_first, east_first : bool
        Whether the first row is the northernmost, and the first column the easternmost. Files without coordinates are
        assumed to have north in the first row and west in the first column.
    pixel_size_note : str
        Why the grid of the file gives no pixel size; else empty.
    variable, band, date, rights : str
        Name of the plane in the file, spectral band, time of observation and terms of use, as stated in the file;
        otherwise empty.
    notes : tuple of str
        What the user should know of pixels that show nothing although the file does not say so.
    """

    values: NDArray[np.float64]
    pixel_size_m: float | None
    bright_is_cloud: bool
    units: str
    long_name: str
    source: str
    pixel_size_is_nominal: bool = False
    north_first: bool = True
    east_first: bool = False
    pixel_size_note: str = ""
    variable: str = ""
    band: str = ""
    date: str = ""
    rights: str = ""
    notes: tuple[str, ...] = ()

    @property
    def is_temperature(self) -> bool:
        """Whether the values are in kelvin."""
        return self.units == "K"

    @property
    def wavelength_um(self) -> float | None:
        """Wavelength of the band, if the file states it."""
        stated = re.search(r"([\d.]+) um", self.band)
        return float(stated[1]) if stated else None


CELSIUS_ZERO_K = 273.15

_KELVIN = re.compile(r"(deg(rees?)?[ _]?)?(k|kelvins?)", re.IGNORECASE)
_CELSIUS = re.compile(r"(\u00b0|deg(rees?)?[ _]?)?c(elsius)?|deg(rees?)?[ _]?celsius", re.IGNORECASE)

_FAHRENHEIT = re.compile(r"(\u00b0|deg(rees?)?[ _]?)f(ahrenheit)?|fahrenheit", re.IGNORECASE)
_PARTS_OF_KELVIN = MappingProxyType({"mK": 1e-3, "cK": 1e-2, "dK": 1e-1})


def in_kelvin(image: SatelliteImage) -> SatelliteImage:
    """Return an image of temperature in K, whose cold is cloud, if its unit is one of temperature, in any spelling."""
    units = image.units.strip()
    if _KELVIN.fullmatch(units):
        return replace(image, units="K", bright_is_cloud=False)
    if _CELSIUS.fullmatch(units):
        return replace(image, values=image.values + CELSIUS_ZERO_K, units="K", bright_is_cloud=False)
    if _FAHRENHEIT.fullmatch(units):
        kelvin = (image.values - 32.0) / 1.8 + CELSIUS_ZERO_K
        return replace(image, values=kelvin, units="K", bright_is_cloud=False)
    if units in _PARTS_OF_KELVIN:
        return replace(image, values=image.values * _PARTS_OF_KELVIN[units], units="K", bright_is_cloud=False)
    return image


# ITU-R BT.601, section 2.5.1: luminance from the colour components.
_LUMINANCE = np.array([0.299, 0.587, 0.114])


def luminance(colours: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return luminance (rows, columns) of red, green, blue and optional opacity (rows, columns, 3 or 4).

    Transparent pixels are missing: NaN.
    """
    grey: NDArray[np.float64] = colours[..., :3] @ _LUMINANCE
    return grey if colours.shape[2] == 3 else np.where(colours[..., 3] > 0.0, grey, np.nan)


class SeveralImagesError(CatalogError):
    """A file has several images, and none of them is chosen.

    Parameters
    ----------
    path : Path
        The file.
    planes : iterable of str
        Names of the images.
    hint : str
        What is known of them.
    option : str
        What chooses one of them.
    """

    def __init__(self, path: Path, planes: Iterable[str], hint: str = "", option: str = "variable") -> None:
        self._parts = path, tuple(planes), hint
        listed = ", ".join(sorted(planes))
        super().__init__(f"{path}: several images; set {option} to one of: {listed}{f'; {hint}' if hint else ''}")

    def chosen_with(self, option: str) -> SeveralImagesError:
        """Return the same error of a command whose option chooses the image."""
        return SeveralImagesError(*self._parts, option)


def choose_plane(path: Path, variable: str | None, planes: list[str], known: list[str], hint: str = "") -> str:
    """Return the variable to read: ``variable``, or the only one of ``planes``.

    Parameters
    ----------
    path : Path
        The file, for messages.
    variable : str or None
        The user's choice.
    planes, known : list of str
        Names of the planes, and of all variables that the user may choose.
    hint : str
        What is known of the planes.

    Raises
    ------
    CatalogError
        If there is no such variable, or if there are several planes without a choice.
    """
    if variable is not None:
        if variable not in known:
            raise CatalogError(f"{path}: no variable '{variable}'; {choose_from(variable, planes)}")
        return variable
    if len(planes) == 1:
        return planes[0]
    if not planes:
        raise CatalogError(f"{path}: no image: none of its variables has two dimensions")
    raise SeveralImagesError(path, planes, hint)


ORIENTATION = 274
"""Tag of TIFF and EXIF; 1 is upright, and values beyond 8 mean nothing."""

_ORIENTATIONS = MappingProxyType(
    {
        2: "mirrored left to right",
        3: "turned by 180 degrees",
        4: "mirrored top to bottom",
        5: "mirrored and turned by 90 degrees",
        6: "turned by 90 degrees clockwise",
        7: "mirrored and turned by 270 degrees",
        8: "turned by 90 degrees anticlockwise",
    }
)


def require_upright(path: Path, orientation: object) -> None:
    """Refuse a picture that viewers turn or mirror: north would not be where the user sees it.

    Raises
    ------
    CatalogError
        If its orientation is one of 2 to 8.
    """
    if isinstance(orientation, int) and orientation in _ORIENTATIONS:
        raise CatalogError(
            f"{path}: orientation {int(orientation)} in TIFF or EXIF data (shown {_ORIENTATIONS[orientation]}); "
            "allowed: 1, stored as shown; turn the pixels and save the picture"
        )


def square_side(path: Path, side_x: float, side_y: float) -> float:
    """Return the side, in m, of a square pixel of the same area.

    Raises
    ------
    CatalogError
        If the sides differ by more than 1 %.
    """
    if abs(side_x - side_y) > SQUARE * max(side_x, side_y):
        raise CatalogError(
            f"{path}: pixels of {side_x:g} m x {side_y:g} m are not square; allowed: sides that differ by at "
            "most 1 %; resample the image"
        )
    return math.sqrt(side_x * side_y)
