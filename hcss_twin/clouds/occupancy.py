"""Three-dimensional occupancy: which share of each voxel a cloud of known base and top fills.

Each column holds one slab of cloud between its base and its top (eq 7 and Fig 5 of the HCSS
paper). A voxel is cut by that slab; its share is the cut length over its own height, so that the
shares times the heights add up to the thickness again, whatever the altitude edges are.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import CloudLayer

_MOST_LEVELS = 100_000


def altitude_edges(base_m: float, top_m: float, step_m: float) -> NDArray[np.float64]:
    """Return the multiples of ``step_m`` (Z + 1,) that enclose the altitudes from ``base_m`` to ``top_m``.

    Parameters
    ----------
    base_m, top_m : float
        Lowest base and highest top, metres above the sea, ``base_m <= top_m``.
    step_m : float
        Height of a voxel in metres, greater than 0.

    Raises
    ------
    ValueError
        If an argument is out of its range, or there would be more than 100 000 levels.
    """
    if not (math.isfinite(base_m) and math.isfinite(top_m) and base_m <= top_m):
        raise ValueError(f"altitudes: {base_m} to {top_m} m given, allowed: finite, base at or below top")
    if not 0.0 < step_m < math.inf:
        raise ValueError(f"step_m: {step_m} given, allowed: greater than 0 and finite")
    first, last = math.floor(base_m / step_m), math.ceil(top_m / step_m)
    # The quotient may have been rounded to the whole number on the wrong side.
    first -= first * step_m > base_m
    last += last * step_m < top_m
    last = max(last, first + 1)
    if last - first > _MOST_LEVELS:
        raise ValueError(
            f"step_m: {step_m} given, which makes {last - first} levels; allowed: up to {_MOST_LEVELS}, "
            f"closest is {(top_m - base_m) / (_MOST_LEVELS - 2):g}"
        )
    return np.arange(first, last + 1, dtype=np.float64) * step_m


def occupancy(
    base_m: NDArray[np.floating], top_m: NDArray[np.floating], altitude_edges_m: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return the share of each voxel that lies between base and top of its column.

    Parameters
    ----------
    base_m, top_m : ndarray (Y, X)
        Altitudes of the cloud's base and top in metres, base at or below top. NaN in both: clear sky.
    altitude_edges_m : ndarray of float64 (Z + 1,)
        Altitudes of the voxels' lower and upper faces, ascending.

    Returns
    -------
    ndarray of float32 (Z, Y, X)
        Shares in [0, 1]; ``(shares * diff(edges)).sum(axis=0)`` is ``top_m - base_m`` to single precision.

    Raises
    ------
    ValueError
        If shapes do not fit, the edges do not ascend, a base lies above its top, or cloud reaches
        beyond the edges: cutting it off would lose volume silently.
    """
    edges = np.asarray(altitude_edges_m, dtype=np.float64)
    if edges.ndim != 1 or edges.size < 2 or not np.all(np.diff(edges) > 0.0):
        raise ValueError(
            "altitude_edges_m: allowed are at least 2 ascending altitudes, "
            f"{edges.size if edges.ndim == 1 else edges.shape} given{_not_ascending(edges)}"
        )
    low, high = np.asarray(base_m, dtype=np.float64), np.asarray(top_m, dtype=np.float64)
    if low.ndim != 2 or low.shape != high.shape:
        raise ValueError(
            f"base_m, top_m: shapes {low.shape} and {high.shape} given, allowed: one shape (Y, X)"
        )
    cloudy = ~(np.isnan(low) & np.isnan(high))
    if np.any(cloudy):
        # Comparisons with NaN are false: a column where only one of the two is missing is caught too.
        if not np.all(low[cloudy] <= high[cloudy]):
            raise ValueError("base_m: a base lies above its top, or only one of the two is missing")
        lowest, highest = float(low[cloudy].min()), float(high[cloudy].max())
        if not (edges[0] <= lowest and highest <= edges[-1]):
            raise ValueError(
                f"altitude_edges_m: {edges[0]:g} to {edges[-1]:g} m given, but cloud reaches from {lowest:g} "
                f"to {highest:g} m; allowed: edges that enclose it"
            )
    shares = np.zeros((edges.size - 1, *low.shape), dtype=np.float32)
    # Clear columns become slabs of no height.
    low, high = np.where(cloudy, low, edges[0]), np.where(cloudy, high, edges[0])
    for level, (lower, upper) in enumerate(pairwise(edges)):
        cut = np.minimum(high, upper) - np.maximum(low, lower)
        shares[level] = np.maximum(cut, 0.0) / (upper - lower)
    return shares


def layer_occupancy(
    thickness_m: NDArray[np.floating], layer: CloudLayer, altitude_edges_m: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return the share of each voxel that a layer fills, with base and top by the layer's anchor.

    Parameters
    ----------
    thickness_m : ndarray (Y, X)
        Geometric thickness in metres; 0 is clear sky.
    layer : CloudLayer
        Its ``anchor`` says whether base or top stays at the layer's altitude.
    altitude_edges_m : ndarray of float64 (Z + 1,)
        Altitudes of the voxels' lower and upper faces, ascending.

    Returns
    -------
    ndarray of float32 (Z, Y, X)
        Shares in [0, 1].

    Raises
    ------
    ValueError
        If a thickness is negative, not finite or greater than the layer's greatest, or as :func:`occupancy`.
    """
    thickness = np.asarray(thickness_m, dtype=np.float64)
    if not np.all((thickness >= 0.0) & (thickness <= layer.thickness_max_m)):
        raise ValueError(
            f"thickness_m: {thickness.min():g} to {thickness.max():g} m given, allowed: 0 to "
            f"{layer.thickness_max_m:g} m, the depth of the layer '{layer.name}'"
        )
    top = layer.cloud_top_m(thickness)
    cloudy = thickness > 0.0
    return occupancy(
        np.where(cloudy, top - thickness, np.nan), np.where(cloudy, top, np.nan), altitude_edges_m
    )


def _not_ascending(edges: NDArray[np.float64]) -> str:
    if edges.ndim != 1 or edges.size < 2:
        return ""
    place = int(np.argmin(np.diff(edges) > 0.0))
    return f", where {edges[place + 1]:g} m follows {edges[place]:g} m"
