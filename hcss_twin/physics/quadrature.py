"""Nodes and weights of Gauss-Legendre quadrature, computed once for each number of nodes.

Polynomials through Chebyshev's nodes of the second kind.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from hcss_twin.core.arrays import Array


@cache
def gauss_legendre(count: int) -> tuple[Array, Array]:
    """Return nodes on [-1, 1] and weights, (count,), not to be changed.

    numpy computes them from the eigenvalues of a matrix, in milliseconds, each time it is asked.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights


def nodes(order: int) -> Array:
    """Return the nodes (order + 1,) on [-1, 1]; the middle for order 0.

    Those of half the order are among them, to the bit.
    """
    if order == 0:
        return np.zeros(1)
    return np.sin(0.5 * np.pi * ((2.0 * np.arange(order + 1) - order) / order))


def between(order: int) -> Array:
    """Return places between the nodes of an order, a power of 2: the nodes that twice the order has beside them.

    Of order 0 the ends. Of order 1 those of order 4, because in the middle alone what is odd cannot be seen.
    """
    if order == 0:
        return np.array([-1.0, 1.0])
    return nodes(4)[1:-1] if order == 1 else nodes(2 * order)[1::2]


def weights(order: int, places: Array) -> Array:
    """Return the weights (N, order + 1) with which values at the nodes make those of their polynomial at places (N,).

    The barycentric formula: J.-P. Berrut and L. N. Trefethen, Barycentric Lagrange interpolation, SIAM Review 46,
    501-517 (2004), eq 5.4.
    """
    if order == 0:
        return np.ones((places.size, 1))
    sign = np.where(np.arange(order + 1) % 2 == 0, 1.0, -1.0)
    sign[[0, -1]] *= 0.5
    distance = places[:, None] - nodes(order)
    at_node = distance == 0.0
    terms = sign / np.where(at_node, 1.0, distance)
    terms = np.where(np.any(at_node, axis=1, keepdims=True), at_node, terms)
    return np.asarray(terms / np.sum(terms, axis=1, keepdims=True), dtype=np.float64)
