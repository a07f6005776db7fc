"""Cloud thickness from the cloud fraction value: eq 7 of the HCSS paper."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from hcss_twin.models.clouds.coverage import exceedance, highest_values
from hcss_twin.providers import CloudLayer

_f4 = np.float32


def frame_thickness(field: NDArray[np.float32], layer: CloudLayer, exponent: float = 1.0) -> NDArray[np.float32]:
    """Cloud in exactly the layer's coverage of a frame, of thickness from its minimum to its maximum.

    Eqs 5 and 7 of the HCSS paper, p of the cloudy pixels of this frame taken linearly to thickness.

    Parameters
    ----------
    field : ndarray of float32 (rows, columns)
        The normal field V of the whole frame.
    layer : CloudLayer
        Coverage, limits of thickness, taper.
    exponent : float
        s: thickness goes with p_c^s, p_c being p scaled to 0 to 1 over the cloud. Eq 7 has s = 1.

    Returns
    -------
    ndarray of float32 (rows, columns)
        Metres; 0 is clear sky. Where all cloudy pixels have one value (a single pixel, say), eq 7 is 0/0;
        they get the greatest thickness.
    """
    lowest, surplus = highest_values(field, layer.coverage)
    if lowest is None:
        return np.zeros(field.shape, dtype=np.float32)
    highest = float(field.max())
    thickness = scaled_thickness(field, layer, float(lowest), ndtr(-float(lowest)), ndtr(-highest), exponent)
    thickness.ravel()[surplus] = 0.0
    return thickness


def field_thickness(field: NDArray[np.float32], layer: CloudLayer, exponent: float = 1.0) -> NDArray[np.float32]:
    """Cloud where the field exceeds a fixed threshold, the coverage's quantile of the normal distribution.

    The coverage is exact in the mean over an unbounded field; a pixel does not depend on others. Eq 7 takes
    p from 1 - coverage to 1.

    Parameters
    ----------
    field : ndarray of float32 (rows, columns)
        The normal field V of any window.
    layer : CloudLayer
        Coverage, limits of thickness, taper.
    exponent : float
        s: thickness goes with p_c^s, p_c being p scaled to 0 to 1 over the cloud. Eq 7 has s = 1.

    Returns
    -------
    ndarray of float32 (rows, columns)
        Metres; 0 is clear sky.
    """
    if layer.coverage == 0.0:
        return np.zeros(field.shape, dtype=np.float32)
    return scaled_thickness(field, layer, float(-ndtri(layer.coverage)), layer.coverage, 0.0, exponent)


def scaled_thickness(
    field: NDArray[np.float32],
    layer: CloudLayer,
    lowest: float,
    share_lowest: float,
    share_highest: float,
    exponent: float,
) -> NDArray[np.float32]:
    """Map V >= ``lowest`` to thickness, by a power of its exceedance scaled between two values of that.

    Parameters
    ----------
    field : ndarray of float32 (rows, columns)
        The normal field V of any window.
    lowest : float
        Of cloudy pixels.
    share_lowest, share_highest : float
        Exceedance of the lowest and of the highest field value, where the scale begins and ends.
    """
    _require_limits(layer.thickness_min_m, layer.thickness_max_m)
    thickness = np.empty(field.shape, dtype=np.float32)
    flat = np.ascontiguousarray(field).reshape(-1)
    low, high = _inward(layer.thickness_min_m, layer.thickness_max_m)
    span = share_lowest - share_highest
    _map_field(
        flat,
        thickness.reshape(-1),
        _f4(lowest),
        _f4(share_lowest),
        _f4(1.0 / span if span > 1e-30 else 0.0),
        _f4(0.0 if span > 1e-30 else 1.0),
        low,
        high,
        _f4(layer.edge_taper),
        float(exponent),
    )
    return thickness


@njit(cache=True, nogil=True, error_model="numpy")
def _map_field(
    field: Any,
    thickness: Any,
    lowest: Any,
    share: Any,
    slope: Any,
    start: Any,
    low: Any,
    high: Any,
    taper: Any,
    exponent: float,
) -> None:
    step = 4096
    work = np.empty(step, dtype=np.float32)
    for first in range(0, field.size, step):
        values = field[first : first + step]
        result = thickness[first : first + step]
        above = work[: values.size]
        exceedance(values, above)
        if exponent != 1.0:
            for i in range(values.size):
                u = min(max(start + (share - above[i]) * slope, _f4(0.0)), _f4(1.0))
                # In double precision: what rounds differently in another build is lost in the rounding to single.
                power = _f4(np.float64(u) ** exponent)
                if taper > _f4(0.0):
                    s = min(u / taper, _f4(1.0))
                    power *= s * s * (_f4(3.0) - _f4(2.0) * s)
                above[i] = power
        elif taper > _f4(0.0):
            for i in range(values.size):
                u = min(max(start + (share - above[i]) * slope, _f4(0.0)), _f4(1.0))
                s = min(u / taper, _f4(1.0))
                above[i] = u * (s * s * (_f4(3.0) - _f4(2.0) * s))
        else:
            for i in range(values.size):
                above[i] = min(max(start + (share - above[i]) * slope, _f4(0.0)), _f4(1.0))
        for i in range(values.size):
            metres = min(max(low + (high - low) * above[i], low), high)
            result[i] = metres if values[i] >= lowest else _f4(0.0)


def _require_limits(thickness_min_m: float, thickness_max_m: float) -> None:
    if not 0.0 <= thickness_min_m <= thickness_max_m < np.inf or thickness_max_m == 0.0:
        raise ValueError(
            f"thickness: {thickness_min_m} to {thickness_max_m} m given, allowed 0 <= minimum <= maximum "
            f"with maximum > 0; closest is {max(0.0, min(thickness_min_m, thickness_max_m))} "
            f"to {max(thickness_min_m, thickness_max_m, 1.0)} m"
        )


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
    _require_limits(thickness_min_m, thickness_max_m)
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
