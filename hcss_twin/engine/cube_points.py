"""Small elements of a finished cube, which a sensor draws: their places and what they add, from its variables."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.variables import ELEMENT_PLACE, ELEMENT_POINT_RADIANCE, ELEMENT_RATE
from hcss_twin.providers import Points

_NEEDED = (ELEMENT_POINT_RADIANCE, *ELEMENT_PLACE, *ELEMENT_RATE)

Read = Callable[[str], NDArray[Any]]
"""Returns a variable of a frame, without the time."""


def require_points(present: Collection[Any], name: str) -> None:
    """Raise a :class:`CubeError` if a cube with elements lacks what a sensor needs to draw them."""
    missing = [each for each in _NEEDED if each not in present]
    if missing:
        raise CubeError(
            f"{name}: a sensor draws elements at their places within the pixels, and the cube lacks "
            f"{', '.join(missing)}; allowed: a cube with these output.variables, or a run of its scenario with [sensor]"
        )


def points_apart(read: Read, corner: tuple[int, int], name: str) -> tuple[NDArray[np.float32], Points | None]:
    """Return the radiance (B, y, x) of a frame without its small elements, and these; as they add up in each pixel.

    Parameters
    ----------
    corner : (int, int)
        Row and column of the first pixel in the image, from which places count.

    Raises
    ------
    CubeError
        If the places are not in the pixels of the cube.
    """
    radiance, added = np.asarray(read("radiance")), np.asarray(read(ELEMENT_POINT_RADIANCE))
    row, column = (np.asarray(read(each), dtype=np.float64) for each in ELEMENT_PLACE)
    y, x = np.nonzero(np.isfinite(row))
    if not y.size:
        return radiance, None
    places = [each[y, x] - first for each, first in zip((row, column), corner, strict=True)]
    # Stored in single precision, a place may lie on the border of its pixel.
    if any(np.any((at < pixel - 0.01) | (at > pixel + 1.01)) for at, pixel in zip(places, (y, x), strict=True)):
        raise CubeError(
            f"{name}: its elements are not in the pixels that it has; allowed: a cube or window with the pixels of its "
            "scenario, none left out and none averaged"
        )
    rates = [np.asarray(read(each), dtype=np.float64)[y, x] for each in ELEMENT_RATE]
    light = added[:, y, x].astype(np.float64)
    return radiance - added, Points(places[0], places[1], rates[0], rates[1], light)
