"""Look-up, thickness axes and pairs of them: any nodes, thicknesses, scales; single against double precision."""

import numpy as np
import pytest
from dense_tables import dense_table, of_point
from examples import examples
from hypothesis import given
from hypothesis import strategies as st

from hcss_twin.core.errors import ProviderError
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.thickness_axis import Source, place_thickness
from hcss_twin.providers import CloudLayer, Microphysics

PARTICLES = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))
SOME = examples(50)


@st.composite
def axes(draw):
    """Ascending nodes between 1e-6 m and 20 km: even, by factors, crowded, or two that nearly touch."""
    low = 10.0 ** draw(st.floats(-6.0, 4.2))
    high = low * draw(st.sampled_from([1.0 + 1e-6, 1.001, 3.0, 1e3]))
    count = draw(st.sampled_from([2, 3, 17, 400]))
    even = draw(st.booleans())
    nodes = np.linspace(low, high, count) if even else np.geomspace(low, high, count)
    nodes[0], nodes[-1] = low, high
    return np.unique(nodes)


@st.composite
def skies(draw, nodes, shape):
    """Thickness of points: clear, at the ends, at nodes, anywhere between."""
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    thickness = nodes[0] + random.random(shape) * (nodes[-1] - nodes[0])
    thickness[random.random(shape) < 0.2] = random.choice(nodes)
    thickness[random.random(shape) < 0.1] = nodes[0]
    thickness[random.random(shape) < 0.1] = nodes[-1]
    clear = draw(st.sampled_from([0.0, 0.3, 1.0]))
    thickness[random.random(shape) < clear] = 0.0
    return thickness.astype(np.float32)


@SOME
@given(st.data(), axes(), axes(), axes(), st.sampled_from([1, 2, 5]), st.integers(-30, 30), st.integers(1, 3))
def test_the_look_up_in_single_precision_is_interpolation_in_double(data, first, second, third, samples, power, layers):
    # Of three axes few nodes: the train of cores of a dense table grows with the square of their product.
    nodes = (first[:30], second[:30], third[:5]) if layers == 3 else (first, second)[:layers]
    values = np.random.default_rng(3).random((*(1 + each.size for each in nodes), 2)) * 10.0**power
    shape = (3 * samples, 4 * samples)
    thickness = [data.draw(skies(each, shape)) for each in nodes]
    radiance = np.full((2, 3, 4), np.nan, np.float32)
    LookUp(dense_table(nodes, values)).fill(radiance, thickness, samples)
    points = np.empty((2, *shape))
    for place in np.ndindex(shape):
        metres = [
            np.clip(float(of[place]), each[0] if of[place] > 0.0 else 0.0, each[-1])
            for of, each in zip(thickness, nodes, strict=True)
        ]
        points[:, *place] = of_point(nodes, values, metres)
    exact = points.reshape(2, 3, samples, 4, samples).mean(axis=(2, 4))
    assert np.all(radiance >= 0.0)
    np.testing.assert_allclose(radiance, exact, rtol=1.5e-7, atol=0.0)


@SOME
@given(st.data(), axes(), st.sampled_from([np.nan, np.inf, 0.99, 1.01]))
def test_what_lies_outside_the_table_is_refused_and_not_moved_inside(data, nodes, wrong):
    table = dense_table((nodes,), np.ones((1 + nodes.size, 1)))
    thickness = data.draw(skies(nodes, (4, 5)))
    bad = {0.99: nodes[0] * 0.99, 1.01: nodes[-1] * 1.01}.get(wrong, wrong)
    thickness[2, 3] = bad
    radiance = np.empty((1, 4, 5), np.float32)
    with pytest.raises(ProviderError, match="thickness"):
        LookUp(table).fill(radiance, [thickness])


@SOME
@given(
    st.floats(-2.0, 4.0).map(lambda x: 10.0**x),
    st.one_of(st.just(1.0), st.floats(-4.0, 0.0).map(lambda x: 10.0**x)),
    st.sampled_from(["base", "top"]),
    st.sampled_from(["constant", "zero term", "zero", "fading", "rising"]),
    st.integers(-250, 250),
    st.sampled_from([1e-2, 1e-4]),
)
def test_an_axis_of_any_layer_keeps_its_tolerance_and_no_term_turns_negative(
    depth, share, anchor, kind, power, tolerance
):
    layer = CloudLayer("x", 100.0, 100.0 + depth, anchor, depth * share, 0.5, None, PARTICLES)
    scale = 10.0**power

    def columns(metres):
        tau = metres / (0.1 * depth)
        first = {
            "constant": np.ones_like(tau), "zero term": np.ones_like(tau), "zero": np.zeros_like(tau),
            "fading": np.exp(-tau), "rising": -np.expm1(-tau),
        }[kind]  # fmt: skip
        second = np.zeros_like(tau) if kind.startswith("zero") else 1e-3 * np.exp(-3.0 * tau) + 1e-9
        return scale * np.stack([first, second], axis=1)[:, :, None]

    axis = place_thickness(columns, layer, np.array([0.0, 500.0, 2000.0]), tolerance, Source("a model", ("all",)))
    assert np.all(np.diff(axis.dense_m) > 0.0)
    low = min(layer.thickness_min_m, layer.thickness_max_m * (1 - 1e-6))
    assert (axis.dense_m[0], axis.dense_m[-1]) == (low, layer.thickness_max_m)
    values = axis.interpolate(columns(axis.exact_m))
    assert np.all(np.isfinite(values))
    assert np.all(values >= 0.0)
    metres = np.linspace(low, layer.thickness_max_m, 257)
    found = np.interp(metres, axis.dense_m, values.sum(axis=1)[:, 0])
    np.testing.assert_allclose(found, columns(metres).sum(axis=1)[:, 0], rtol=2.0 * tolerance)
