"""Normal quantiles, exceedance, thresholds, thickness, fractal fields: any parameters, against double precision."""

import math
from pathlib import Path

import numpy as np
import pytest
from examples import examples
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.special import ndtri

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.clouds.coverage import cloudy_pixels, highest_values
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.models.clouds.fractal.rows import cubic_weights, split
from hcss_twin.models.clouds.thickness import field_thickness, frame_thickness
from hcss_twin.providers import CloudInputs, CloudLayer, Grid, Microphysics, Motion

MANY = examples(200)
FEW = examples(30)
WATER = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))
SHARE = st.one_of(st.sampled_from([0.0, 1.0, 1e-12, 1.0 - 1e-12, 0.5]), st.floats(0.0, 1.0))
FIELDS = st.one_of(
    hnp.arrays(np.float32, st.tuples(st.integers(1, 12), st.integers(1, 12)), elements=st.floats(-9.0, 9.0, width=32)),
    st.tuples(st.integers(1, 12), st.floats(-9.0, 9.0, width=32)).map(
        lambda drawn: np.full((drawn[0], 7), drawn[1], np.float32)
    ),
)
"""Random fields, and those of one value."""


@st.composite
def cloud_layers(draw):
    most = 10.0 ** draw(st.floats(-2.0, 4.3))
    least = min(most * 10.0 ** draw(st.one_of(st.just(0.0), st.floats(-6.0, 0.0))), most)
    taper = draw(st.one_of(st.just(0.0), st.just(1.0), st.floats(1e-9, 1.0)))
    return CloudLayer("x", 0.0, most, "base", least, draw(SHARE), None, WATER, edge_taper=taper)


@MANY
@given(FIELDS, SHARE)
def test_exactly_the_coverage_of_any_field_is_cloud_and_it_is_the_highest(field, coverage):
    mask = cloudy_pixels(field, coverage)
    assert np.count_nonzero(mask) == round(coverage * field.size)
    if mask.any() and not mask.all():
        assert field[mask].min() >= field[~mask].max()
    double, _ = highest_values(field.astype(np.float64), coverage)
    single, _ = highest_values(field, coverage)
    assert single == double


@pytest.mark.parametrize("coverage", [1e-4, 0.02, 0.3, 0.5, 0.999])
@pytest.mark.parametrize("kind", ["white", "trend", "few values", "outliers", "stripes"])
def test_the_threshold_of_a_large_field_is_that_of_sorting_it(kind, coverage):
    random = np.random.default_rng(4)
    field = random.standard_normal((300, 256)).astype(np.float32)
    if kind == "trend":
        field = np.sort(field, axis=None).reshape(field.shape)
    elif kind == "few values":
        field = np.round(field)
    elif kind == "outliers":
        field[:2] = 1e30 * field[:2]
    elif kind == "stripes":
        field[:, ::19] = np.float32(-9.0)
    lowest, _ = highest_values(field, coverage)
    assert lowest == np.sort(field, axis=None)[field.size - round(coverage * field.size)]
    assert np.count_nonzero(cloudy_pixels(field, coverage)) == round(coverage * field.size)


@MANY
@given(FIELDS, cloud_layers(), st.sampled_from([0.05, 0.5, 1.0, 3.0, 20.0]))
def test_thickness_of_any_field_lies_within_the_limits_of_its_layer(field, layer, exponent):
    for mapped in (frame_thickness, field_thickness):
        thickness = mapped(field, layer, exponent)
        assert thickness.dtype == np.float32
        cloudy = thickness[thickness != 0.0].astype(np.float64)
        # One step inward where the limits are no single-precision numbers: none may lie between them.
        assert np.all(cloudy >= layer.thickness_min_m * (1 - 1.2e-7))
        assert np.all(cloudy <= layer.thickness_max_m * (1 + 1.2e-7))
    assert np.count_nonzero(frame_thickness(field, layer, exponent)) == round(layer.coverage * field.size)
    inside = field_thickness(field, layer, exponent) > 0.0
    threshold = -ndtri(layer.coverage)
    sure = np.abs(field - threshold) > 1e-5 if np.isfinite(threshold) else np.ones(field.shape, bool)
    np.testing.assert_array_equal(inside[sure], (field >= threshold)[sure])


@MANY
@given(hnp.arrays(np.float64, st.integers(1, 20), elements=st.floats(-4e18, 4e18)))
def test_any_coordinate_is_a_cell_and_a_fraction_whose_weights_keep_the_variance(coordinate):
    cell, fraction = split(coordinate)
    assert np.all((fraction >= 0.0) & (fraction <= 1.0))
    np.testing.assert_allclose(cell.astype(np.float64) + fraction, coordinate, rtol=1e-15, atol=1e-15)
    np.testing.assert_allclose(np.sum(cubic_weights(fraction) ** 2, axis=1), 1.0, rtol=1e-14)
    for wrong in (math.nan, math.inf, -math.inf, 5e18):
        with pytest.raises(ValueError, match="not finite or beyond"):
            split(np.append(coordinate, wrong))


@st.composite
def skies(draw):
    """A fractal generator with any shape, motion and pixel, and the corner of a window up to 1e9 pixels out."""
    first, last = sorted((draw(st.integers(0, 16)), draw(st.integers(0, 16))))
    shape = {
        "gamma": draw(st.one_of(st.sampled_from([1.01, 8.0]), st.floats(1.01, 8.0))),
        "H": draw(st.one_of(st.sampled_from([0.01, 0.99]), st.floats(0.01, 0.99))),
        "L": [10.0 ** draw(st.floats(-3.0, 4.0)), 10.0 ** draw(st.floats(-3.0, 4.0))],
        "k": [first, last],
    }
    pixel = 10.0 ** draw(st.floats(-2.0, 5.0))
    evolution = draw(st.one_of(st.just(math.inf), st.floats(-3.0, 12.0).map(lambda x: 10.0**x)))
    motion = Motion(
        draw(st.sampled_from([0.0, 7500.0, -1e5])),
        (draw(st.floats(-150, 150)), draw(st.floats(-150, 150))),
        evolution,
        draw(st.sampled_from([1e-3, 1.0, 100.0])),
    )
    mode = draw(st.sampled_from(["frame", "field"]))
    layer = CloudLayer("x", 0.0, 1000.0, "base", 33.0, 0.4, None, WATER, coverage_mode=mode)
    inputs = CloudInputs(layer, Grid(40, 40, pixel), motion, draw(st.integers(0, 2**63 - 1)),
                         Catalog(root=Path("none")), shape)  # fmt: skip
    made = FractalClouds(inputs, FractalParameters())
    farthest = st.one_of(st.integers(-(10**9), 10**9), st.sampled_from([-(10**9), 0, 10**9]))
    return made, draw(farthest), draw(farthest), draw(st.sampled_from([0.0, 3.7, 1e4]))


@FEW
@given(skies(), st.integers(1, 30), st.integers(1, 30), st.integers(0, 9), st.integers(0, 9))
def test_any_window_of_any_field_is_finite_and_a_part_of_the_whole(drawn, rows, columns, top, left):
    made, row, column, time = drawn
    try:
        whole = made.field(time, slice(row, row + 40), slice(column, column + 40))
    except ValueError as error:
        # 1e9 pixels of 100 km are 6e9 cells of the widest octave, and gamma^16 times as many of the finest.
        refused = str(error)
    else:
        refused = ""
    if refused:
        assert "beyond +-2**62 cells" in refused
        assert max(max(octave.x.step, octave.y.step) for octave in made.octaves) * 3e9 > 2.0**60
        return
    assert whole.dtype == np.float32
    assert np.all(np.isfinite(whole))
    # Of 17 octaves in quadrature, 32 bits reaching 6.3 deviations: no sum of so few comes near.
    assert np.abs(whole).max() < 8.0
    part = made.field(time, slice(row + top, row + top + rows), slice(column + left, column + left + columns))
    np.testing.assert_array_equal(part, whole[top : top + rows, left : left + columns])


@pytest.mark.parametrize("shape", [(1, 4096), (4096, 1), (1, 1), (2, 4095)], ids=str)
@pytest.mark.parametrize("coverage", [0.0, 1.0, 0.3])
def test_images_of_1_to_4096_pixels_have_their_coverage(shape, coverage):
    layer = CloudLayer("x", 0.0, 1000.0, "base", 33.0, coverage, None, WATER)
    shape_parameters = {"gamma": 3, "H": 0.8, "L": [10, 10], "k": [0, 4]}
    inputs = CloudInputs(
        layer, Grid(*shape, 20.0), Motion(0.0, (10.0, 0.0), 600.0, 1.0), 3, Catalog(root=Path("none")),
        shape_parameters,
    )  # fmt: skip
    thickness = FractalClouds(inputs, FractalParameters()).thickness_m(1e9, slice(None), slice(None))
    assert thickness.shape == shape
    assert np.count_nonzero(thickness) == round(coverage * thickness.size)
    assert np.all((thickness == 0.0) | ((thickness >= 33.0) & (thickness <= 1000.0)))
