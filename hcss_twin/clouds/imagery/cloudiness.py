"""Which side of the grey scale is cloud, and where on it cloud begins."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.clouds.imagery.image import Image
from hcss_twin.clouds.imagery.threshold import coverage_threshold, local_threshold, otsu_threshold

Method = Literal["otsu", "local", "coverage"]
CloudIs = Literal["auto", "bright", "dark"]

# In the name of a variable that has values in cloud only.
_CLOUD_TOP = "cloud top"


def has_values_in_cloud_only(image: Image) -> bool:
    """Whether an image is a product of cloud tops: named so, with missing pixels."""
    called = f"{image.variable} {image.long_name}".lower().replace("_", " ")
    return _CLOUD_TOP in called and bool(np.isnan(image.values).any())


def bright_is_cloud(image: Image, cloud_is: CloudIs) -> bool:
    """Whether large values are cloud: as said, or as the image's kind suggests."""
    return image.bright_is_cloud if cloud_is == "auto" else cloud_is == "bright"


def cloudiness_level(image: Image, cloud_is: CloudIs) -> NDArray[np.float64]:
    """Return the values with cloud the larger ones, rows northward and columns eastward."""
    values = image.values[:: -1 if image.north_first else 1, :: -1 if image.east_first else 1]
    return values if bright_is_cloud(image, cloud_is) else -values


def find_threshold(
    level: NDArray[np.float64],
    method: Method,
    window: int | None,
    coverage: float,
    scene: NDArray[np.float64],
) -> tuple[float | NDArray[np.float64], float]:
    """Return the threshold, one for all pixels or one for each, and the lowest, where thickness starts.

    Parameters
    ----------
    level : ndarray of float64 (rows, columns)
        Cloudiness level of the image, NaN where missing.
    method : {"otsu", "local", "coverage"}
        See :mod:`hcss_twin.clouds.imagery.threshold`.
    window : int or None
        Side in pixels of the surroundings of method ``local``; an eighth of the shorter side by default.
    coverage : float
        Fraction of cloudy pixels of ``scene``, for method ``coverage``.
    scene : ndarray of float64
        The part of ``level`` that gets this coverage.

    Raises
    ------
    ValueError
        If the levels have no contrast or the coverage cannot be had.
    """
    if method == "otsu":
        otsu = otsu_threshold(level)
        return otsu, otsu
    if method == "local":
        local = local_threshold(level, window or max(3, min(level.shape) // 8))
        return local, float(np.nanmin(local))
    wanted = coverage_threshold(scene, coverage)
    return wanted, max(wanted, float(np.nanmin(level)))
