"""Nodes and weights of Gauss-Legendre quadrature, computed once for each number of nodes."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@cache
def gauss_legendre(count: int) -> tuple[Array, Array]:
    """Return nodes on [-1, 1] and weights, (count,), not to be changed.

    numpy computes them from the eigenvalues of a matrix, in milliseconds, each time it is asked.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights
