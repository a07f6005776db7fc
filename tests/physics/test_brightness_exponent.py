"""The exponent between the cloud fraction value and thickness changes thickness and nothing else."""

import math
from pathlib import Path

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import CloudInputs, CloudLayer, Grid, Microphysics, Motion

STILL = Motion(0.0, (0.0, 0.0), math.inf, 0.0)
PARTICLES = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))
LOW, HIGH = 100.0, 1100.0


def thickness(exponent, mode="frame", taper=0.0, coverage=0.4, size=256, cells=30.0):
    layer = CloudLayer("x", 0.0, HIGH, "base", LOW, coverage, None, PARTICLES, mode, taper)
    inputs = CloudInputs(layer, Grid(size, size, 20.0), STILL, 5, Catalog(root=Path("none")))
    shape = FractalParameters(gamma=3.0, H=0.7, L=(cells, cells), k=(0, 4), brightness_exponent=exponent)
    return FractalClouds(inputs, shape).thickness_m(0.0, slice(0, size), slice(0, size))


@pytest.mark.parametrize("mode", ["frame", "field"])
@pytest.mark.parametrize("exponent", [0.4, 2.5])
def test_scaled_thickness_is_raised_to_the_exponent_and_the_mask_stays(mode, exponent):
    linear, curved = thickness(1.0, mode), thickness(exponent, mode)
    np.testing.assert_array_equal(curved > 0, linear > 0)
    cloudy = linear > 0
    scaled = (linear[cloudy].astype(np.float64) - LOW) / (HIGH - LOW)
    expected = LOW + (HIGH - LOW) * scaled**exponent
    # What single precision leaves of a scaled thickness near 0, a power below 1 magnifies.
    np.testing.assert_allclose(curved[cloudy], expected, atol=(HIGH - LOW) * 1e-6 ** min(exponent, 1.0))
    assert curved.max() <= HIGH
    assert curved[cloudy].min() >= LOW


def test_the_mean_over_an_unbounded_sky_is_that_of_a_power_of_a_uniform_number():
    for exponent in (0.5, 1.0, 3.0):
        made = thickness(exponent, "field", size=800, cells=2000.0)
        scaled = (made[made > 0].mean(dtype=np.float64) - LOW) / (HIGH - LOW)
        assert scaled == pytest.approx(1.0 / (1.0 + exponent), abs=5e-3)


def test_the_taper_belongs_to_the_area_and_not_to_the_thickness():
    linear, tapered = thickness(2.0, taper=0.0), thickness(2.0, taper=0.5)
    uniform = thickness(1.0)
    inner = uniform > LOW + 0.5001 * (HIGH - LOW)
    np.testing.assert_array_equal(tapered[inner], linear[inner])
    outer = (uniform > 0) & (uniform < LOW + 0.49 * (HIGH - LOW))
    assert np.all(tapered[outer] <= linear[outer])
    assert np.any(tapered[outer] < linear[outer])


def test_an_exponent_out_of_range_is_refused():
    with pytest.raises(ValueError, match="brightness_exponent"):
        FractalParameters(brightness_exponent=0.0)
