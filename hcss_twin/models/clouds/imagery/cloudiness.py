"""Which side of the grey scale is cloud, and where on it cloud begins.

From grey levels of cloud to thickness: eq 7 of the HCSS paper for images.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.models.clouds.imagery.image import Image
from hcss_twin.models.clouds.imagery.threshold import coverage_threshold, local_threshold, otsu_threshold

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
    level: NDArray[np.float64], method: Method, window: int | None, coverage: float, scene: NDArray[np.float64]
) -> tuple[float | NDArray[np.float64], float]:
    """Return the threshold, one for all pixels or one for each, and the lowest, where thickness starts.

    Parameters
    ----------
    level : ndarray of float64 (rows, columns)
        Cloudiness level of the image, NaN where missing.
    method : {"otsu", "local", "coverage"}
        See :mod:`hcss_twin.models.clouds.imagery.threshold`.
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


# Of the cloudy pixels, this percentile of the grey levels and all above it get the greatest
# thickness: a few glinting or noisy pixels would otherwise make all the other clouds thin.
TOP_PERCENTILE = 99.9


def relative_grey(level: NDArray[np.float64], lowest: float) -> NDArray[np.float64]:
    """Return (C - C_min) / (C_max - C_min) of cloudy pixels, confined to 0 to 1.

    Parameters
    ----------
    level : ndarray of float64 (N,)
        Cloudiness level C of the cloudy pixels.
    lowest : float
        C_min, the threshold. Pixels below it, from filled holes, get 0.

    Returns
    -------
    ndarray of float64 (N,)
        C_max is the 99.9th percentile of ``level``. All 1 where it does not exceed C_min.
    """
    if level.size == 0:
        return np.zeros(0)
    top = float(np.percentile(level, TOP_PERCENTILE))
    if top <= lowest:
        return np.ones_like(level)
    relative: NDArray[np.float64] = np.clip((level - lowest) / (top - lowest), 0.0, 1.0)
    return relative


def thickness_of(relative: NDArray[np.float64], thickness_min_m: float, thickness_max_m: float) -> NDArray[np.float32]:
    """Return Th_min + (Th_max - Th_min) C' for relative grey levels C' (any shape) of cloudy pixels.

    Rounding to single precision neither leaves the layer nor reaches 0, which is clear sky.
    """
    values = (thickness_min_m + (thickness_max_m - thickness_min_m) * relative).astype(np.float32)
    highest = np.float32(thickness_max_m)
    if float(highest) > thickness_max_m:
        highest = np.nextafter(highest, np.float32(0.0))
    inside: NDArray[np.float32] = np.maximum(np.minimum(values, highest), np.finfo(np.float32).tiny)
    return inside
