import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from hcss_twin.physics.monotone_cubic import WINDOW, pchip_in_window, window_start


@pytest.mark.parametrize("count", [4, 5, 9, 21])
def test_agrees_with_scipys_pchip_everywhere(count):
    generator = np.random.default_rng(count)
    nodes = np.sort(generator.random(count))
    values = generator.normal(size=(count, 6))
    x = nodes[0] + (nodes[-1] - nodes[0]) * generator.random(500)
    x[:count] = nodes
    around = window_start(nodes, x)[:, None] + np.arange(WINDOW)
    np.testing.assert_allclose(
        pchip_in_window(nodes[around], values[around], x), PchipInterpolator(nodes, values)(x), rtol=0, atol=1e-12
    )


@given(
    st.lists(st.floats(0.01, 10), min_size=3, max_size=3),
    st.lists(st.floats(0, 5, allow_subnormal=False), min_size=3, max_size=3),
)
def test_monotone_data_stay_monotone(steps, rises):
    nodes = np.concatenate(([0.0], np.cumsum(steps)))
    values = np.concatenate(([0.0], np.cumsum(rises)))
    x = np.linspace(0, nodes[-1], 101)
    rows = np.broadcast_to(nodes, (101, 4))
    found = pchip_in_window(rows, np.broadcast_to(values, (101, 4)), x)
    assert np.all(np.diff(found) >= -1e-9)
