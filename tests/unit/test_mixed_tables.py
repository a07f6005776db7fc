"""Few tables tell the tables toward all nodes of a frame."""

import numpy as np
import pytest

from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.mixed_tables import mix, mixed_tables
from hcss_twin.engine.tables.radiance_tables import DenseTable
from hcss_twin.physics import quadrature


def tables_of(orders, channels=2):
    """Tables that are smooth functions of the direction, with a small part of a second shape, at their own nodes."""
    x, y = np.meshgrid(*(quadrature.nodes(order) for order in orders))
    result = []
    for number, (a, b) in enumerate(zip(x.ravel(), y.ravel(), strict=True)):
        nodes = np.geomspace(1.0, 1000.0, 20 + number % 2)
        level = 5.0 + np.arange(channels) + 0.3 * a - 0.2 * b
        alone = level + (1.0 + 0.1 * a * b) * np.log(nodes)[:, None]
        result.append(DenseTable(level, (nodes,), (alone,), None))
    return result


@pytest.mark.parametrize("samples", [1, 2])
def test_mixed_tables_give_the_sum_over_the_tables_of_the_nodes(samples):
    rng, orders = np.random.default_rng(1), (3, 2)
    tables = tables_of(orders)
    thickness = np.where(rng.random((8, 10)) < 0.3, 0.0, rng.uniform(1.0, 1000.0, (8, 10))).astype(np.float32)
    shape = 2, 8 // samples, 10 // samples
    x, y = rng.uniform(-1.0, 1.0, (2, *shape[1:]))
    x[0, 0], y[0, 0] = quadrature.nodes(3)[2], 1.0  # a node
    expected = np.zeros(shape)
    across, up = (quadrature.weights(order, at.ravel()) for order, at in zip(orders, (x, y), strict=True))
    for number, table in enumerate(tables):
        part = np.empty(shape, np.float32)
        LookUp(table).fill(part, [thickness], samples)
        expected += (up[:, number // 4] * across[:, number % 4]).reshape(shape[1:]) * part
    mixed = mixed_tables(tables, orders, 1e-6)
    assert mixed.weights.shape[2] <= 4
    part, found = np.empty((2 * mixed.weights.shape[2], *shape[1:]), np.float32), np.empty(shape, np.float32)
    mixed.look_up.fill(part, [thickness], samples)
    mix(x, y, *mixed.nodes, mixed.weights, part, found)
    assert found == pytest.approx(expected, rel=5e-6)


def test_single_tables_and_those_of_two_layers_stay():
    (table,) = tables_of((0, 0))
    assert mixed_tables([table], (0, 0), 1e-5) is None
    both = np.zeros((20, 20, 2), np.float32)
    two = DenseTable(table.clear, table.nodes_m * 2, table.alone * 2, both)
    assert mixed_tables([two, two], (1, 0), 1e-5) is None


def test_layers_without_cloud_have_no_nodes():
    tables = [DenseTable(each.clear, (np.zeros(0),), (np.zeros((0, 2)),), None) for each in tables_of((2, 1))]
    mixed = mixed_tables(tables, (2, 1), 1e-6)
    found = np.empty((2 * mixed.weights.shape[2], 4, 4), np.float32)
    mixed.look_up.fill(found, [np.zeros((4, 4), np.float32)])
    radiance = np.empty((2, 4, 4), np.float32)
    mix(np.ones((4, 4)), np.ones((4, 4)), *mixed.nodes, mixed.weights, found, radiance)
    assert radiance[:, 0, 0] == pytest.approx(tables[-1].clear, rel=1e-6)
