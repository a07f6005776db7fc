"""What files of images have in common: one plane is chosen, upright, of square pixels, in grey."""

from __future__ import annotations

import math
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CatalogError, choose_from
from hcss_twin.models.clouds.imagery.image import SatelliteImage

SQUARE = 0.01
"""Maximum relative scatter of coordinate steps, and difference of the two sides, for square pixels."""

# ITU-R BT.601, section 2.5.1: luminance from the colour components.
_LUMINANCE = np.array([0.299, 0.587, 0.114])


def luminance(colours: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return luminance (rows, columns) of red, green, blue and optional opacity (rows, columns, 3 or 4).

    Transparent pixels are missing: NaN.
    """
    grey: NDArray[np.float64] = colours[..., :3] @ _LUMINANCE
    return grey if colours.shape[2] == 3 else np.where(colours[..., 3] > 0.0, grey, np.nan)


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
    raise SatelliteImage.SeveralImagesError(path, planes, hint)


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
