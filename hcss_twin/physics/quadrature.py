"""Quadrature and interpolation on fixed nodes: Gauss-Legendre, and polynomials through Chebyshev points."""

from __future__ import annotations

from functools import cache

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel


@cache
def gauss_legendre(count: int) -> tuple[Array, Array]:
    """Return read-only nodes on [-1, 1] and weights, (count,).

    Cached, because numpy computes them from the eigenvalues of a matrix, in milliseconds.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights


def nodes(order: int) -> Array:
    """Return the Chebyshev points of the second kind (order + 1,) on [-1, 1]; the middle for order 0.

    Those of half the order are among them, bit for bit.
    """
    if order == 0:
        return np.zeros(1)
    return np.sin(0.5 * np.pi * ((2.0 * np.arange(order + 1) - order) / order))


def between(order: int) -> Array:
    """Return test points between the nodes of an order, a power of 2: the nodes that twice the order adds.

    For order 0 the ends. For order 1 the inner nodes of order 4, because odd errors vanish in the middle.
    """
    if order == 0:
        return np.array([-1.0, 1.0])
    return nodes(4)[1:-1] if order == 1 else nodes(2 * order)[1::2]


def weights(order: int, places: Array) -> Array:
    """Return the weights (N, order + 1) of the values at the nodes in their polynomial at ``places`` (N,).

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


def lagrange(nodes: Array, places: Array) -> Array:
    """Return the weights (N, n) of the values at any nodes (n,) in their polynomial at ``places`` (N,).

    The same formula, with weights from the products of the distances of the nodes.
    """
    if nodes.size == 1:
        return np.ones((places.size, 1))
    # Distances in units of the interval's capacity, a quarter of its length, neither overflow nor underflow.
    capacity = 0.25 * (np.max(nodes) - np.min(nodes))
    apart = (nodes[:, None] - nodes) / capacity
    np.fill_diagonal(apart, 1.0)
    distance = places[:, None] - nodes
    at_node = distance == 0.0
    terms = 1.0 / (np.prod(apart, axis=1) * np.where(at_node, 1.0, distance))
    terms = np.where(np.any(at_node, axis=1, keepdims=True), at_node, terms)
    return np.asarray(terms / np.sum(terms, axis=1, keepdims=True), dtype=np.float64)


@kernel(inner=True)
def weigh_row(found, row, columns, values):  # type: ignore[no-untyped-def]
    """Set R polynomials in the pixels of a row (x, R), from values at nodes (Y, X, R).

    The order of the sums is fixed, so that a pixel has the same bits in every window.

    ``row`` (Y,) and ``columns`` (x, X) are the weights of the nodes.
    """
    for r in range(values.shape[2]):
        for x in range(columns.shape[0]):
            found[x, r] = 0.0
        for k in range(values.shape[1]):
            along = 0.0
            for n in range(values.shape[0]):
                along += row[n] * values[n, k, r]
            for x in range(columns.shape[0]):
                found[x, r] += columns[x, k] * along
