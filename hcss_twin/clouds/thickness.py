"""Cloud thickness from the cloud fraction value: eq 7 of the HCSS paper."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def map_thickness(
    brightness: NDArray[np.float64], cloudy: NDArray[np.bool_], thickness_min_m: float, thickness_max_m: float
) -> NDArray[np.float32]:
    """Map the values C of the cloudy pixels linearly to thickness.

    Th = Th_min + (Th_max - Th_min) (C - C_min) / (C_max - C_min), with the extremes over the
    cloudy pixels of this frame, and 0 in the clear ones.

    Parameters
    ----------
    brightness : ndarray of float64 (N,)
        C (the p of eq 5, or grey levels of an image) of the N cloudy pixels, in flat order.
    cloudy : ndarray of bool (rows, columns)
        Mask with N true pixels.
    thickness_min_m, thickness_max_m : float
        Thickness of the thinnest and of the thickest cloudy pixel, 0 <= min <= max, max > 0.

    Returns
    -------
    ndarray of float32 (rows, columns)
        Metres. Where all cloudy pixels have one value (a single pixel, say), eq 7 is 0/0; they get
        Th_max. Cloudy pixels are greater than 0 even for Th_min = 0, when the thinnest gets the
        smallest normal number, 1.2e-38 m, so that the mask can be read from the thickness.
        Rounding to single precision goes inward: no pixel leaves [Th_min, Th_max], unless no
        single-precision number lies between them.

    Raises
    ------
    ValueError
        If the limits are not in order.
    """
    if not 0.0 <= thickness_min_m <= thickness_max_m < np.inf or thickness_max_m == 0.0:
        raise ValueError(
            f"thickness: {thickness_min_m} to {thickness_max_m} m given, allowed 0 <= minimum <= maximum "
            f"with maximum > 0; closest is {max(0.0, min(thickness_min_m, thickness_max_m))} "
            f"to {max(thickness_min_m, thickness_max_m, 1.0)} m"
        )
    thickness = np.zeros(cloudy.shape, dtype=np.float32)
    if brightness.size == 0:
        return thickness
    lowest = brightness.min()
    span = brightness.max() - lowest
    # A subnormal span would lose its digits in the division.
    scaled = (brightness - lowest) / span if span > np.finfo(np.float64).tiny else np.ones_like(brightness)
    values = (thickness_min_m + (thickness_max_m - thickness_min_m) * scaled).astype(np.float32)
    low, high = _inward(thickness_min_m, thickness_max_m)
    thickness[cloudy] = np.minimum(np.maximum(values, low), high)
    return thickness


def _inward(low_m: float, high_m: float) -> tuple[np.float32, np.float32]:
    """Round the ends of an interval to the single-precision numbers inside it, greater than 0."""
    low, high = np.float32(low_m), np.float32(high_m)
    # As Python floats: numpy would compare in single precision, where the rounding cannot be seen.
    if float(low) < low_m:
        low = np.nextafter(low, np.float32(np.inf))
    if float(high) > high_m:
        high = np.nextafter(high, np.float32(0.0))
    smallest = np.finfo(np.float32).tiny
    return max(low, smallest), max(high, smallest)
