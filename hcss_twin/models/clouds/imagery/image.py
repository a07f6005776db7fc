"""One plane of a satellite image in memory.

Grey levels of colour pictures.

Choice of one plane of a file that holds several.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CatalogError, choose_from


@dataclass(frozen=True)
class Image:
    """One plane of an image.

    Attributes
    ----------
    values : ndarray of float64 (rows, columns)
        As stored, in physical units where the file gives them; NaN where missing.
    pixel_size_m : float or None
        Side of a pixel on the ground; None where the file does not say.
    bright_is_cloud : bool
        Whether cloud has the larger values.
    units, long_name : str
        What the values are; empty where the file does not say.
    source : str
        Name of the file.
    pixel_size_is_nominal : bool
        True for a geostationary image: its pixel size is that below the satellite, and pixels
        elsewhere are larger.
    north_first, east_first : bool
        Whether the first row is the northernmost, and the first column the easternmost. Files
        without coordinates are taken to have the north in the first row, the west in the first column.
    pixel_size_note : str
        Why there is no pixel size, where the file has a grid that gives none; else empty.
    variable, band, date, rights : str
        Name of the plane in the file, spectral band, time of observation and terms of use, as the file
        states them; empty where it does not.
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


# ITU-R BT.601, section 2.5.1: luminance from the colour components.
_LUMINANCE = np.array([0.299, 0.587, 0.114])


def luminance(colours: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return luminance (rows, columns) of red, green, blue and, where given, opacity (rows, columns, 3 or 4).

    Transparent pixels are missing: NaN.
    """
    grey: NDArray[np.float64] = colours[..., :3] @ _LUMINANCE
    return grey if colours.shape[2] == 3 else np.where(colours[..., 3] > 0.0, grey, np.nan)


def choose_plane(path: Path, variable: str | None, planes: list[str], known: list[str]) -> str:
    """Return the variable to read: the one asked for, or the only one there is.

    Parameters
    ----------
    path : Path
        The file, for messages.
    variable : str or None
        What was asked for.
    planes, known : list of str
        Names of the planes, and of all that can be asked for.

    Raises
    ------
    CatalogError
        If there is no such variable, or several planes and none was asked for.
    """
    if variable is not None:
        if variable not in known:
            raise CatalogError(f"{path}: no variable '{variable}'; {choose_from(variable, planes)}")
        return variable
    if len(planes) == 1:
        return planes[0]
    if not planes:
        raise CatalogError(f"{path}: no image: none of its variables has two dimensions")
    listed = ", ".join(sorted(planes))
    raise CatalogError(f"{path}: several images; set variable to one of: {listed}")
