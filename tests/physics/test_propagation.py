"""Spread of radiance where it is known: a clear sky and a sea of uncertain temperature."""

import numpy as np
import pytest
from cheap import CHEAP

import hcss_twin

SIGMA = 0.4
CLEAR = {
    **CHEAP,
    "clouds.coverage": 0.0,
    "image.rows": 4,
    "image.columns": 4,
    "frames.count": 1,
    "bands": [[10.3, 11.3]],
    "time": "2024-04-20T14:30:00Z",
}


def radiance_at(temperature):
    cube = hcss_twin.simulate(hcss_twin.Scenario.load("stratus", {**CLEAR, "sea.temperature": temperature}))
    return cube["radiance"].values.astype(np.float64).mean(axis=(0, 2, 3))


@pytest.fixture(scope="module")
def found():
    return hcss_twin.propagate(
        "stratus", draws=16, uncertain={"sea.temperature": f"normal:291:{SIGMA}"}, overrides=CLEAR
    ).dataset


def test_the_spread_of_a_linear_scene_is_the_slope_times_that_of_the_input(found):
    slope = (radiance_at(291.0 + SIGMA) - radiance_at(291.0 - SIGMA)) / (2.0 * SIGMA)
    spread = found["radiance_standard_deviation"].sel({"class": "clear"}).values
    drawn = found["input_value"].values[:, 0]
    np.testing.assert_allclose(spread, slope * drawn.std(ddof=1), rtol=0.01)
    error = found["radiance_standard_deviation_error"].sel({"class": "clear"}).values
    np.testing.assert_array_less(np.abs(spread - slope * SIGMA), 4.0 * error)
    assert np.all(error < 0.4 * spread)


def test_all_of_it_is_the_share_of_the_only_input(found):
    own = found.sel({"class": "clear"})
    np.testing.assert_allclose(own["radiance_first_order"].sel(source="sea.temperature"), 1.0, atol=1e-3)
    np.testing.assert_array_equal(own["radiance_total"].sel(source="seed"), 0.0)


def test_classes_without_pixels_have_no_numbers(found):
    own = found.sel({"class": "thick"})
    assert np.all(np.isnan(own["radiance_mean"]))
    assert np.all(own["radiance_draws"] == 0)
    assert np.all(np.isnan(found["metric_mean"].sel(metric_name=["entropy", "fractal_dimension"])))
    assert float(found["metric_mean"].sel(metric_name="coverage")) == 0.0
