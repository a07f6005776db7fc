"""Functions of the sky's zenith cosine, given by their values at nodes."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Basis = Literal["linear", "lagrange"]


def checked_nodes(mu_nodes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the nodes (N,) as float64.

    Raises
    ------
    ValueError
        If they do not have one axis, do not ascend, or leave (0, 1].
    """
    nodes = np.asarray(mu_nodes, dtype=np.float64)
    inside = nodes.ndim == 1 and nodes.size > 0 and bool(np.all((nodes > 0.0) & (nodes <= 1.0)))
    if not (inside and np.all(np.diff(nodes) > 0.0)):
        raise ValueError(
            f"mu_nodes {np.array2string(nodes, threshold=9)}: needs (N,), ascending in 0 < mu <= 1"
        )
    return nodes


def basis_values(mu: NDArray[np.float64], nodes: NDArray[np.float64], basis: Basis) -> NDArray[np.float64]:
    """Return the weights (P, N) that interpolate a function from the nodes to ``mu`` (P,); rows sum to 1.

    ``linear`` holds the outermost values beyond the nodes; ``lagrange`` is the polynomial through all nodes,
    which suits the nodes of a Gauss rule only.
    """
    if nodes.size == 1:
        return np.ones((mu.size, 1))
    if basis == "linear":
        right, part = _interval(mu, nodes)
        weights = np.zeros((mu.size, nodes.size))
        row = np.arange(mu.size)
        weights[row, right - 1] = 1.0 - part
        weights[row, right] = part
        return weights
    difference = nodes[:, None] - nodes[None, :] + np.eye(nodes.size)
    barycentric = 1.0 / np.prod(difference, axis=1)
    distance = mu[:, None] - nodes[None, :]
    # On a node the quotient would be 0 / 0; this far from it the result is the node's value to the last digit.
    distance = np.where(np.abs(distance) < 1e-300, 1e-300, distance)
    weights = barycentric[None, :] / distance
    return np.asarray(weights / weights.sum(axis=1, keepdims=True), dtype=np.float64)


def gathered_linearly(
    mu: NDArray[np.float64], nodes: NDArray[np.float64], values: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return ``basis_values(mu, nodes, "linear").T @ values`` (N, K) for values (P, K), and two or more nodes."""
    # imported here: only seas with a second reflection need it
    from scipy.sparse import csc_array

    right, part = _interval(mu, nodes)
    places = np.stack((right - 1, right), axis=1).ravel()
    weights = np.stack((1.0 - part, part), axis=1).ravel()
    transposed = csc_array((weights, places, np.arange(0, 2 * mu.size + 1, 2)), shape=(nodes.size, mu.size))
    return np.asarray(transposed @ values, dtype=np.float64)


def _interval(
    mu: NDArray[np.float64], nodes: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return the node to the right of each ``mu`` (P,) and how near it is, 0 to 1; the end beyond the outermost."""
    right = np.clip(np.searchsorted(nodes, mu), 1, nodes.size - 1)
    part = np.clip((mu - nodes[right - 1]) / (nodes[right] - nodes[right - 1]), 0.0, 1.0)
    return right, part
