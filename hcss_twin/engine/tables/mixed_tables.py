"""Few tables whose combinations are the tables toward all directions of a frame.

Radiance is nearly a sum of few products of a function of the cloud and one of the direction: of the 16 tables of a
frame 4 or 5 combinations tell all of them within 1e-5. They are the singular vectors of the table of all tables, and
are looked up together, as channels of one table.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.radiance_tables import DenseTable
from hcss_twin.physics import quadrature

MOST_NODES = 2**12
"""Thicknesses up to which tables are mixed."""


class MixedTables(NamedTuple):
    """Tables that are combined, and how.

    Attributes
    ----------
    look_up : LookUp
        Of R tables with C channels each: R x C channels.
    nodes : (ndarray (X,), ndarray (Y,))
        Positions of the frame's nodes along x and y.
    weights : ndarray (Y, X, R)
        Of each table at the nodes.
    """

    look_up: LookUp
    nodes: tuple[Array, Array]
    weights: Array


def mixed_tables(tables: Sequence[DenseTable], orders: tuple[int, int], lost: float) -> MixedTables | None:
    """Return the fewest tables whose combinations equal those of a frame's nodes within a relative error.

    None for one table, for tables with clouds in two layers, which are as large as an image, and for those whose
    thicknesses differ too much.
    """
    if len(tables) == 1 or any(table.both is not None for table in tables):
        return None
    nodes_m, alone = on_common_nodes(tables)
    if any(nodes.size > MOST_NODES for nodes in nodes_m):
        return None
    channels, number = tables[0].clear.size, len(tables)
    clear = np.stack([table.clear for table in tables])
    every = np.concatenate((clear, *(columns.reshape(number, -1) for columns in alone)), axis=1)
    largest = np.max(np.abs(every), axis=0)
    scale = np.where(largest > 0.0, largest, 1.0)
    size = np.maximum(np.abs(every), 1e-6 * largest.max() + 1e-300)
    of_table, strength, of_column = np.linalg.svd(every / scale, full_matrices=False)
    for count in range(1, strength.size + 1):
        weights, components = of_table[:, :count], strength[:count, None] * of_column[:count] * scale
        if np.max(np.abs(weights @ components - every) / size) <= lost:
            break
    ends = np.cumsum([channels, *(nodes.size * channels for nodes in nodes_m)])
    clear, *parts = np.split(components, ends[:-1], axis=1)
    mixed = tuple(
        np.ascontiguousarray(part.reshape(count, nodes.size, channels).swapaxes(0, 1)).reshape(
            nodes.size, count * channels
        )
        for part, nodes in zip(parts, nodes_m, strict=True)
    )
    at = quadrature.nodes(orders[0]), quadrature.nodes(orders[1])
    return MixedTables(
        LookUp(DenseTable(clear.ravel(), nodes_m, mixed, None)),
        at,
        np.ascontiguousarray(weights).reshape(at[1].size, at[0].size, count),
    )


def on_common_nodes(tables: Sequence[DenseTable]) -> tuple[tuple[Array, ...], list[Array]]:
    """Return the thicknesses (N,) of each layer at which any of the tables has values, and all values (M, N, C) there.

    Between the nodes of all of them every table is linear.
    """
    nodes = tuple(_union([table.nodes_m[layer] for table in tables]) for layer in range(len(tables[0].nodes_m)))
    return nodes, [
        np.stack([_at(node, table.nodes_m[layer], table.alone[layer]) for table in tables])
        for layer, node in enumerate(nodes)
    ]


def _union(nodes: Sequence[Array]) -> Array:
    first = nodes[0]
    if all(node.size == first.size and np.array_equal(node, first) for node in nodes):
        return first
    return np.unique(np.concatenate(nodes))


def _at(nodes: Array, known_nodes: Array, values: Array) -> Array:
    """Return values (N, C), linear between their own nodes, at others."""
    if nodes is known_nodes or nodes.size == 0:
        return values
    interval = np.clip(np.searchsorted(known_nodes, nodes, side="right") - 1, 0, known_nodes.size - 2)
    share = np.clip((nodes - known_nodes[interval]) / (known_nodes[interval + 1] - known_nodes[interval]), 0.0, 1.0)
    result: Array = values[interval] + share[:, None] * (values[interval + 1] - values[interval])
    return result


@kernel(error_model="numpy")
def mix(x: Any, y: Any, nodes_x: Any, nodes_y: Any, weights: Any, part: Any, radiance: Any) -> None:
    """Write the radiance (C, y, x), at least 0, of pixels at positions x and y (y, x) from R x C channels (R C, y, x).

    Each pixel is computed alone: it has the same bits in every window.
    """
    channels, count = radiance.shape[0], weights.shape[2]
    across, up = np.empty(nodes_x.size), np.empty(nodes_y.size)
    of_table = np.empty((count, radiance.shape[2]))
    for i in range(radiance.shape[1]):
        for j in range(radiance.shape[2]):
            _barycentric(x[i, j], nodes_x, across)
            _barycentric(y[i, j], nodes_y, up)
            for r in range(count):
                total = 0.0
                for b in range(nodes_y.size):
                    along = 0.0
                    for a in range(nodes_x.size):
                        along += across[a] * weights[b, a, r]
                    total += up[b] * along
                of_table[r, j] = total
        for c in range(channels):
            for j in range(radiance.shape[2]):
                total = 0.0
                for r in range(count):
                    total += of_table[r, j] * np.float64(part[r * channels + c, i, j])
                # A vanishing term can become negative between nodes.
                radiance[c, i, j] = max(total, 0.0)


@kernel(error_model="numpy")
def _barycentric(position: Any, nodes: Any, weights: Any) -> None:
    """Write the weights of nodes as :func:`hcss_twin.physics.quadrature.weights`."""
    last, total = nodes.size - 1, 0.0
    for k in range(nodes.size):
        distance = position - nodes[k]
        if distance == 0.0 or last == 0:
            weights[:] = 0.0
            weights[k] = 1.0
            return
        weights[k] = (1.0 if k % 2 == 0 else -1.0) * (0.5 if k == 0 or k == last else 1.0) / distance
        total += weights[k]
    for k in range(nodes.size):
        weights[k] /= total
