"""Cloud thickness from the fractal field V: eq 7 of the HCSS paper, for frames, windows and an unbounded sky.

Th = Th_min + (Th_max - Th_min) (C - C_min) / (C_max - C_min), where C is the cloud fraction value p of eq 5, with its
extremes over the cloudy pixels. (For images see :mod:`hcss_twin.models.clouds.imagery.cloudiness`.)

Two extensions have no effect by default: C is p_c^s, where p_c is p scaled to 0 to 1 over the cloud (``exponent`` s, 1
in the paper), and the thickness may rise smoothly from the cloud's edge (``layer.edge_taper``, 0 in the paper).
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Any

import numpy as np

from hcss_twin.core.kernels import kernel
from hcss_twin.models.clouds.coverage import Field, FrameSummary, exceedance, highest_values
from hcss_twin.providers import CloudLayer

_f4 = np.float32


def frame_thickness(field: Field, layer: CloudLayer, exponent: float = 1.0) -> Field:
    """Return the thickness of a frame with exactly the layer's coverage, spanning its whole range (eqs 5 and 7).

    Parameters
    ----------
    field : ndarray of float32 (rows, columns)
        The normal field V of the whole frame.
    layer : CloudLayer
        Coverage, limits of thickness, taper.
    exponent : float
        s of p_c^s.

    Returns
    -------
    ndarray of float32 (rows, columns)
        Metres; 0 is clear sky. If all cloudy pixels have the same value (a single pixel, for example), eq 7 is 0/0;
        they get the maximum thickness.
    """
    lowest, surplus = highest_values(field, layer.coverage)
    if lowest is None:
        return np.zeros(field.shape, dtype=np.float32)
    highest = float(field.max())
    thickness = _scaled_thickness(
        field.copy(), layer, float(lowest), _share_above(float(lowest)), _share_above(highest), exponent
    )
    thickness.ravel()[surplus] = 0.0
    return thickness


def thickness_in_frame(
    field: Field, first: int, columns: int, summary: FrameSummary, layer: CloudLayer, exponent: float
) -> Field:
    """Return the thickness in a window of the frame, bit-identical to :func:`frame_thickness`.

    Parameters
    ----------
    field : ndarray of float32 (y, x)
        V in the window.
    first, columns : int
        Flat index of the window's first pixel in the frame, and columns of the frame.
    summary : FrameSummary
        Of the frame.
    """
    if summary.lowest is None:
        return np.zeros(field.shape, dtype=np.float32)
    shares = _share_above(summary.lowest), _share_above(summary.highest)
    thickness = _scaled_thickness(field.copy(), layer, summary.lowest, *shares, exponent)
    if first + (field.shape[0] - 1) * columns + field.shape[1] - 1 > summary.last:
        y, x = np.nonzero(field == np.float32(summary.lowest))
        late = first + y * columns + x > summary.last
        thickness[y[late], x[late]] = 0.0
    return thickness


def field_thickness(field: Field, layer: CloudLayer, exponent: float = 1.0, in_place: bool = False) -> Field:
    """Return the thickness in m where V exceeds a fixed threshold, the normal quantile of the coverage (eqs 5 and 7).

    The coverage is exact on average over an unbounded field, and a pixel does not depend on others. In eq 7, p ranges
    from 1 - coverage to 1. Parameters and result are as for :func:`frame_thickness`, for any window; with ``in_place``
    the result replaces the field, because a new array takes as long as the computation.
    """
    if layer.coverage == 0.0:
        return np.zeros(field.shape, dtype=np.float32)
    lowest = -NormalDist().inv_cdf(layer.coverage) if layer.coverage < 1.0 else -math.inf
    result = field if in_place else field.copy()
    return _scaled_thickness(result, layer, lowest, layer.coverage, 0.0, exponent)


def _share_above(value: float) -> float:
    """Return the share Q = 1 - p of a standard normal field above a value (eq 5)."""
    return 0.5 * math.erfc(value * math.sqrt(0.5))


def _scaled_thickness(
    field: Field, layer: CloudLayer, lowest: float, share_lowest: float, share_highest: float, exponent: float
) -> Field:
    """Replace V >= ``lowest`` by thickness; the shares are 1 - p at the lowest and the highest cloudy value."""
    low_m, high_m = layer.thickness_min_m, layer.thickness_max_m
    if not 0.0 <= low_m <= high_m < np.inf or high_m == 0.0:
        raise ValueError(
            f"thickness: {low_m} to {high_m} m given, allowed 0 <= minimum <= maximum with maximum > 0; "
            f"closest is {max(0.0, min(low_m, high_m))} to {max(low_m, high_m, 1.0)} m"
        )
    thickness = np.ascontiguousarray(field)
    span = share_lowest - share_highest
    _map_field(
        thickness.reshape(-1),
        _f4(lowest),
        _f4(share_lowest),
        _f4(1.0 / span if span > 1e-30 else 0.0),
        _f4(0.0 if span > 1e-30 else 1.0),
        *_inward(low_m, high_m),
        _f4(layer.edge_taper),
        float(exponent),
    )
    return thickness


@kernel()
def _map_field(
    field: Any, lowest: Any, share: Any, slope: Any, start: Any, low: Any, high: Any, taper: Any, exponent: float
) -> None:
    # Blocks of 4096 pixels stay in the processor cache from one pass to the next.
    step = 4096
    work = np.empty(step, dtype=np.float32)
    for first in range(0, field.size, step):
        values = field[first : first + step]
        above = work[: values.size]
        exceedance(values, above)
        # u = (C - C_min) / (C_max - C_min) of eq 7, with C = p = 1 - exceedance of eq 5.
        if exponent != 1.0:
            for i in range(values.size):
                u = min(max(start + (share - above[i]) * slope, _f4(0.0)), _f4(1.0))
                # The power is in double precision: builds may round it differently, which single precision hides.
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
            # Th = Th_min + (Th_max - Th_min) C' of eq 7.
            metres = min(max(low + (high - low) * above[i], low), high)
            values[i] = metres if values[i] >= lowest else _f4(0.0)


def _inward(low_m: float, high_m: float) -> tuple[np.float32, np.float32]:
    """Round the ends of an interval inward to single-precision numbers greater than 0."""
    low, high = np.float32(low_m), np.float32(high_m)
    # Compared as Python floats: numpy would compare in single precision, which hides the rounding.
    if float(low) < low_m:
        low = np.nextafter(low, np.float32(np.inf))
    if float(high) > high_m:
        high = np.nextafter(high, np.float32(0.0))
    smallest = np.finfo(np.float32).tiny
    return max(low, smallest), max(high, smallest)
