"""Radiance against thickness between exact columns: a spline of degree 5 in ln(thickness)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DEGREE = 5
"""At 1e-3 a cubic needs twice as many exact columns, which are dear; between two levels radiance is smooth."""


def spline_through(thickness_m: Array, values: Array) -> Callable[[Array], Array]:
    """Spline through values at some thicknesses.

    Parameters
    ----------
    thickness_m : ndarray (N,)
        Ascending, above 0, m; up to ``DEGREE`` + 1 of them give the polynomial through all.
    values : ndarray (N, ...)

    Returns
    -------
    callable
        Maps ln(thickness) (M,) to (M, ...).
    """
    # imported here: runs that find their tables should not wait for it
    from scipy.interpolate import make_interp_spline

    place = np.log(thickness_m)
    degree = min(DEGREE, place.size - 1)
    # A polynomial has its knots at the ends; older versions of scipy place none for even degrees by themselves.
    ends = np.repeat(place[[0, -1]], degree + 1) if place.size <= DEGREE + 1 else None
    spline: Callable[[Array], Array] = make_interp_spline(place, values, k=degree, t=ends, axis=0)
    return spline


def curve_through(thickness_m: Array, values: Array) -> Callable[[Array], Array]:
    """Return :func:`spline_through` the values (N, ...) that does not undershoot zero.

    A term that fades to nothing (the sea under a thick cloud) would swing below zero by less than the tolerance; its
    exact columns say that it does not.
    """
    spline = spline_through(thickness_m, values)
    floor = np.minimum(np.min(values, axis=0), 0.0)

    def evaluate(ln_thickness: Array) -> Array:
        result: Array = np.maximum(spline(ln_thickness), floor)
        return result

    return evaluate
