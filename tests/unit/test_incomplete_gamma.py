"""Incomplete gamma functions against scipy.special, an independent implementation."""

import numpy as np
import pytest
from scipy import special

from hcss_twin.models.optics.size_distribution import lower_and_upper


def test_both_tails_equal_those_of_scipy():
    generator = np.random.default_rng(5)
    shapes = 10.0 ** generator.uniform(-2.0, 2.5, 600)
    arguments = shapes * 10.0 ** generator.uniform(-2.0, 1.0, 600)
    arguments[::2] = np.abs(shapes + 3.0 * generator.normal(size=600) * np.sqrt(shapes))[::2]  # around the mean
    found = np.array([lower_and_upper(float(s), float(t)) for s, t in zip(shapes, arguments, strict=True)]).T
    expected = np.array([special.gammainc(shapes, arguments), special.gammaincc(shapes, arguments)])
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)
    smaller = expected.argmin(axis=0), np.arange(600)
    np.testing.assert_allclose(found[smaller], expected[smaller], rtol=1e-12, atol=1e-290)


@pytest.mark.parametrize("s", [0.01, 3.0, 199.0, 1e6])
def test_limits_are_exact(s):
    assert lower_and_upper(s, 0.0) == (0.0, 1.0)
    assert lower_and_upper(s, float("inf")) == (1.0, 0.0)
