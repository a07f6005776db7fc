"""Tables of any numbers for tests of the look-up."""

import numpy as np

from hcss_twin.engine.tables.radiance_tables import DenseTable
from hcss_twin.engine.tables.tensor_train import TensorTrain


def dense_table(nodes_m, values):
    """Table of values (1 + N, 1 + M, ..., C): without cloud, then at the nodes of each layer that has some."""
    nodes_m = tuple(np.asarray(nodes, dtype=np.float64) for nodes in nodes_m)
    clear = values[(0,) * (values.ndim - 1)][None]
    cores, rest = [], np.moveaxis(values, -1, 0)[:, None]
    while rest.ndim > 3:  # the first nodes as they are, and all others as many functions of the rest
        channels, rank, size = rest.shape[:3]
        core = np.zeros((channels, rank, size, rank * size))
        for row in range(rank):
            core[:, row, np.arange(size), row * size + np.arange(size)] = 1.0
        cores.append(core)
        rest = rest.reshape(channels, rank * size, *rest.shape[3:])
    return DenseTable(clear, nodes_m, TensorTrain((*cores, rest[..., None])) if rest.ndim == 3 else TensorTrain(()))


def of_point(nodes_m, values, thickness_m):
    """Interpolate values of such a table linearly at a point, written out."""
    for nodes, metres in zip(nodes_m, thickness_m, strict=True):
        if metres <= 0.0:
            values = values[0]
            continue
        below = np.clip(np.searchsorted(nodes, metres) - 1, 0, len(nodes) - 2)
        share = np.clip((metres - nodes[below]) / (nodes[below + 1] - nodes[below]), 0.0, 1.0)
        values = (1.0 - share) * values[1 + below] + share * values[2 + below]
    return values
