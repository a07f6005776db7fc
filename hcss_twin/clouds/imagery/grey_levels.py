"""From grey levels of cloud to thickness: eq 7 of the HCSS paper for images."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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


def thickness_of(
    relative: NDArray[np.float64], thickness_min_m: float, thickness_max_m: float
) -> NDArray[np.float32]:
    """Return Th_min + (Th_max - Th_min) C' for relative grey levels C' (any shape) of cloudy pixels.

    Rounding to single precision neither leaves the layer nor reaches 0, which is clear sky.
    """
    values = (thickness_min_m + (thickness_max_m - thickness_min_m) * relative).astype(np.float32)
    highest = np.float32(thickness_max_m)
    if float(highest) > thickness_max_m:
        highest = np.nextafter(highest, np.float32(0.0))
    inside: NDArray[np.float32] = np.maximum(np.minimum(values, highest), np.finfo(np.float32).tiny)
    return inside
