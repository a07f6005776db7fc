"""Directions in which radiance is computed: one Gauss quadrature per hemisphere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Streams:
    """Quadrature over the cosines of zenith angles of one hemisphere.

    The flux of radiance I is ``2 pi sum(mu weight I)``, its mean over the hemisphere ``sum(weight I)``.

    Attributes
    ----------
    mu : ndarray (N,)
        Cosines, ascending, inside (0, 1).
    weight : ndarray (N,)
        Weights; their sum is 1.
    """

    mu: Array
    weight: Array


def gauss_streams(count: int) -> Streams:
    """Gauss-Legendre quadrature on (0, 1), exact for polynomials of degree 2 ``count`` - 1.

    A quadrature for each hemisphere ("double Gauss") integrates radiance that jumps at the horizon;
    J. B. Sykes, Mon. Not. R. Astron. Soc. 111, 377 (1951).

    Raises
    ------
    ValueError
        If ``count`` is not a whole number of at least 1.
    """
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 1:
        raise ValueError(f"streams {count}: allowed whole numbers from 1; closest is {_closest(count)}")
    node, weight = np.polynomial.legendre.leggauss(int(count))
    return Streams(0.5 * (1.0 + node), 0.5 * weight)


def _closest(count: object) -> int:
    if isinstance(count, float) and np.isfinite(count):
        return max(1, round(count))
    return 1
