"""The expected variogram is the mean of what the generator makes."""

import math

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import CloudInputs, CloudLayer, Grid, Microphysics, Motion

KERNEL = KernelCorrelation.tabulate()
STILL = Motion(0.0, (0.0, 0.0), math.inf, 0.0)
LAYER = CloudLayer("x", 0.0, 1000.0, "base", 33.0, 0.5, None, Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0)))
SIMULATED = FractalParameters(gamma=4.0, H=0.8, L=(3.0, 7.0), k=(0, 10))
CIRRUS = FractalParameters(gamma=3.0, H=0.4, L=(50.0, 10.0), k=(0, 4))


def fields(shape, count, rows, columns):
    for seed in range(count):
        inputs = CloudInputs(LAYER, Grid(rows, columns, 20.0), STILL, seed, Catalog())
        yield FractalClouds(inputs, shape).field(0.0, slice(0, rows), slice(0, columns))


@pytest.mark.parametrize("shape", [SIMULATED, CIRRUS], ids=["simulated", "cirrus"])
def test_the_expected_variogram_is_the_mean_over_realisations_at_any_direction(shape):
    lags = [(1, 0), (0, 1), (2, 0), (9, 0), (0, 9), (31, 0), (4, 4), (10, -7)]
    sums = []
    for v in fields(shape, 60, 120, 160):
        row = []
        for dx, dy in lags:
            here = v[max(0, -dy) : v.shape[0] - max(0, dy), : v.shape[1] - dx]
            there = v[max(0, dy) : v.shape[0] + min(0, dy), dx:]
            row.append(0.5 * np.mean((there - here) ** 2))
        sums.append(row)
    mean, error = np.mean(sums, axis=0), np.std(sums, axis=0) / math.sqrt(len(sums))
    dx, dy = np.array(lags).T
    expected = KERNEL.expected_variogram(shape, 20.0, dx, dy)
    assert np.all(np.abs(mean - expected) < 4.5 * error + 2e-3 * expected)
    # The comparison can fail: the errors are small.
    assert np.all(error < 0.1 * expected)


def test_the_frame_variance_is_the_mean_over_realisations():
    rows, columns = 60, 90
    shape = FractalParameters(gamma=2.0, H=0.6, L=(30.0, 12.0), k=(0, 5))
    measured = np.array([float(v.var()) for v in fields(shape, 300, rows, columns)])
    expected = KERNEL.frame_variance(shape, 20.0, rows, columns)
    error = measured.std() / math.sqrt(measured.size)
    assert expected < 0.9
    assert measured.mean() == pytest.approx(expected, abs=4.5 * error)
    assert error < 0.1 * expected
