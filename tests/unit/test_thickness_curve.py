"""Radiance between exact columns."""

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from hcss_twin.engine.tables.thickness_axis import DEGREE, curve_through, spline_through


@pytest.mark.parametrize("count", [2, 3, 4, 5, 6, 7, 8, 17])
def test_a_polynomial_in_ln_thickness_is_reproduced(count):
    thickness = np.geomspace(10.0, 900.0, count)
    degree = min(count - 1, DEGREE)
    weights = np.random.default_rng(count).normal(size=(degree + 1, 3))

    def law(ln_thickness):
        return np.polynomial.polynomial.polyval(ln_thickness - 4.0, weights).T

    between = np.linspace(np.log(10.0), np.log(900.0), 101)
    found = spline_through(thickness, law(np.log(thickness)))(between)
    np.testing.assert_allclose(found, law(between), rtol=1e-9, atol=1e-9 * np.max(np.abs(law(between))))


@pytest.mark.parametrize("count", [7, 8, 17])
def test_splines_are_those_of_scipy(count):
    random = np.random.default_rng(count)
    thickness, values = np.sort(random.uniform(10.0, 900.0, count)), random.normal(size=(count, 2, 3))
    between = np.linspace(np.log(thickness[0]) - 0.01, np.log(thickness[-1]) + 0.01, 101)
    expected = make_interp_spline(np.log(thickness), values, k=DEGREE)(between)
    scale = np.max(np.abs(expected))
    np.testing.assert_allclose(spline_through(thickness, values)(between) / scale, expected / scale, atol=1e-9)


def test_a_term_that_fades_does_not_swing_below_nothing():
    thickness = np.geomspace(1.0, 1000.0, 9)
    fading = np.exp(-thickness)[:, None]
    between = np.linspace(0.0, np.log(1000.0), 400)
    assert np.min(spline_through(thickness, fading)(between)) < 0.0
    assert np.min(curve_through(thickness, fading)(between)) == 0.0


def test_negative_values_are_kept():
    thickness = np.geomspace(1.0, 100.0, 7)
    values = -thickness[:, None]
    assert curve_through(thickness, values)(np.log(thickness)) == pytest.approx(values)
