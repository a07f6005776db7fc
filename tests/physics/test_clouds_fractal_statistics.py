"""The fractal field has the law that eqs 2-5 promise."""

import dataclasses
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.clouds.coverage import cloud_fraction_value
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.lattice import lattice_normals, unit_offset
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import CloudInputs, CloudLayer, Grid, Microphysics, Motion

STRATUS = {"gamma": 3.0, "H": 0.8, "L": [10, 10], "k": [0, 4]}
SIMULATED = {"gamma": 4.0, "H": 0.8, "L": [3, 7], "k": [0, 10]}
SEEDS = 400
STILL = Motion(0.0, (0.0, 0.0), math.inf, 1.0)
LAYER = CloudLayer("x", 0.0, 1000.0, "base", 33.0, 0.5, None, Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0)))


def generator(shape, seed=1, motion=STILL, pixel=20.0, layer=LAYER):
    inputs = CloudInputs(layer, Grid(256, 256, pixel), motion, seed, Catalog(root=Path("none")), shape)
    return FractalClouds(inputs, FractalParameters())


def node(seed, octave, t, y, x):
    """One number of the lattice; planes of a sky without noise have phases 0, 0."""
    return lattice_normals(seed, octave, t, np.array([y]), np.array([x]))[0, 0]


def kernel(distance):
    """Keys' cubic convolution kernel, a = -1/2, written as a function of distance."""
    d = np.abs(distance)
    inner = 1.5 * d**3 - 2.5 * d**2 + 1.0
    outer = -0.5 * d**3 + 2.5 * d**2 - 4.0 * d + 2.0
    return np.where(d < 1.0, inner, np.where(d < 2.0, outer, 0.0))


def correlation(lag_cells):
    """Autocorrelation of the normalised interpolation, averaged over the phase in the cell."""
    if lag_cells >= 4.0:
        return 0.0
    phase = (np.arange(400) + 0.5)[:, None] / 400
    nodes = np.arange(-3, 9)[None, :]
    here, there = kernel(phase - nodes), kernel(phase + lag_cells - nodes)
    norm = np.sqrt(np.sum(here**2, axis=1) * np.sum(there**2, axis=1))
    return float(np.mean(np.sum(here * there, axis=1) / norm))


def expected_structure(shape, lag_pixels, cells, pixel=20.0):
    """E[(V(x + h) - V(x))^2] of eq 2 along one axis."""
    numbers = range(shape["k"][0], shape["k"][1] + 1)
    powers = np.array([shape["gamma"] ** (-2 * k * shape["H"]) for k in numbers])
    rho = np.array([correlation(lag_pixels * cells * shape["gamma"] ** k * pixel / 16000) for k in numbers])
    return float(2.0 * np.sum(powers / powers.sum() * (1.0 - rho)))


def measured_structure(shape, lags, axis, seeds=range(40), pixel=20.0):
    """Mean square differences over pixels of many realisations, with their standard error."""
    size = max(lags) + 64
    window = (slice(0, size), slice(0, 128)) if axis == 0 else (slice(0, 128), slice(0, size))
    values = []
    for seed in seeds:
        v = generator(shape, seed, pixel=pixel).field(0.0, *window)
        v = v.T if axis == 0 else v
        values.append([np.mean((v[:, lag:] - v[:, :-lag]) ** 2) for lag in lags])
    return np.mean(values, axis=0), np.std(values, axis=0) / math.sqrt(len(values))


@pytest.mark.parametrize("motion", [STILL, Motion(300.0, (10.0, -5.0), 60.0, 1.0)], ids=["still", "moving"])
def test_one_pixel_is_standard_normal_and_its_p_uniform_over_seeds(motion):
    values = np.array(
        [generator(SIMULATED, seed, motion).field(7.3, slice(11, 12), slice(5, 6))[0, 0] for seed in range(SEEDS)]
    )
    assert stats.kstest(values, "norm").pvalue > 1e-3
    assert stats.kstest(cloud_fraction_value(values), "uniform").pvalue > 1e-3
    assert abs(values.var() - 1.0) < 4 * math.sqrt(2 / SEEDS)


def test_the_variance_over_realisations_does_not_depend_on_place_or_time():
    # Plain cubic interpolation would fall to about a half between nodes, in every such map.
    shape = {"gamma": 2.0, "H": 0.5, "L": [200, 200], "k": [0, 0]}
    motion = Motion(0.0, (0.0, 0.0), 10.0, 1.0)
    # Many far-apart copies of the same phases stand for realisations: 4 pixels per cell of 80 m.
    field = generator(shape, 3, motion)
    stack = np.stack([field.field(float(t), slice(0, 800), slice(0, 800)) for t in range(0, 200, 8)])
    maps = stack.reshape(25, 200, 4, 200, 4).var(axis=(0, 1, 3))
    assert np.abs(maps - 1.0).max() < 0.02


@pytest.mark.parametrize(
    ("shape", "motion"),
    [(STRATUS, Motion(1000.0, (10.0, 4.0), 600.0, 1.0)), (SIMULATED, Motion(990.0, (-3.0, 4.0), 60.0, 1.0))],
    ids=["stratus", "simulated"],
)
def test_the_field_is_the_written_out_sum_of_eqs_2_to_4(shape, motion):
    seed, time, row, column = 9, 12.25, 17, -23
    layer = dataclasses.replace(LAYER, coverage_mode="field")
    made = generator(shape, seed, motion, layer=layer)
    x = (column + 0.5 - 128) * 20.0 + (motion.platform_speed_m_s - motion.cloud_velocity_m_s[0]) * time
    y = (row + 0.5 - 128) * 20.0 - motion.cloud_velocity_m_s[1] * time
    total = 0.0
    for octave in made.octaves:
        scale = shape["gamma"] ** octave.k
        coordinates = [
            scale * y * shape["L"][1] / 16000.0 + unit_offset(seed, octave.k, 1),
            scale * x * shape["L"][0] / 16000.0 + unit_offset(seed, octave.k, 0),
            scale * time / motion.evolution_time_s + unit_offset(seed, octave.k, 2),
        ]
        taps = []
        for coordinate, axis in zip(coordinates, (octave.y, octave.x, octave.t), strict=True):
            cell = math.floor(coordinate)
            weights = kernel(coordinate - cell + 1 - np.arange(4))
            weights /= math.sqrt(np.sum(weights**2))
            nearest = [(round(coordinate), 1.0)]
            taps.append(nearest if axis.nearest else [(cell + i - 1, weights[i]) for i in range(4)])
        total += math.sqrt(octave.variance) * sum(
            wy * wx * wt * node(seed, octave.k, t, i, j) for i, wy in taps[0] for j, wx in taps[1] for t, wt in taps[2]
        )
    window = made.field(time, slice(row, row + 1), slice(column, column + 1))
    assert window[0, 0] == pytest.approx(total, abs=3e-6)


def test_octaves_have_the_amplitudes_of_eq_2():
    octaves = generator(STRATUS).octaves
    ratios = [b.variance / a.variance for a, b in pairwise(octaves)]
    np.testing.assert_allclose(ratios, 3.0**-1.6)
    assert math.fsum(octave.variance for octave in octaves) == pytest.approx(1.0)


def test_merged_white_octaves_keep_the_variance_of_the_sum():
    made = generator(SIMULATED)
    assert [octave.k for octave in made.octaves] == [0, 1, 2, 3, 4, 5]
    powers = [4.0 ** (-1.6 * k) for k in range(11)]
    assert made.octaves[-1].variance == pytest.approx(sum(powers[5:]) / sum(powers))
    fine = {"gamma": 4.0, "H": 0.5, "L": [3, 7], "k": [5, 9]}
    v = generator(fine).field(0.0, slice(0, 500), slice(0, 500))
    assert v.var() == pytest.approx(1.0, abs=0.012)
    assert abs(np.corrcoef(v[:, 1:].ravel(), v[:, :-1].ravel())[0, 1]) < 0.01


@pytest.mark.parametrize("axis", [0, 1], ids=["y", "x"])
@pytest.mark.parametrize("shape", [STRATUS, {**SIMULATED, "L": [30, 70]}], ids=["stratus", "anisotropic"])
def test_structure_function_is_that_of_the_kernel_and_the_octaves(shape, axis):
    lags = [1, 3, 9, 27]
    measured, error = measured_structure(shape, lags, axis)
    cells = shape["L"][1 - axis]
    expected = np.array([expected_structure(shape, lag, cells) for lag in lags])
    assert np.all(np.abs(measured - expected) < 4.5 * error + 2e-3 * expected)


@pytest.mark.parametrize("hurst", [0.3, 0.5, 0.8])
def test_structure_function_grows_with_twice_the_hurst_exponent_between_octaves(hurst):
    # Cells from 320 km to 5 m: the lags lie far from both ends of the sum, and a factor gamma apart, so that
    # the log-periodic wiggle drops out. The ends still bend the expected slope by .05 (H = .3), .01, -.02;
    # the sampling error of 40 realisations is .03.
    shape = {"gamma": 2.0, "H": hurst, "L": [0.05, 0.05], "k": [0, 16]}
    lags = [2, 4, 8, 16, 32]
    measured, _ = measured_structure(shape, lags, axis=1)
    slope = np.polyfit(np.log(lags), np.log(measured), 1)[0]
    assert slope == pytest.approx(2 * hurst, abs=0.1)


def test_frames_decorrelate_over_the_evolution_time_and_not_before():
    motion = Motion(0.0, (0.0, 0.0), 600.0, 1.0)
    made = generator({**STRATUS, "L": [200, 200], "k": [0, 0]}, 5, motion)
    window = slice(0, 800), slice(0, 800)
    start = made.field(0.0, *window)

    def overlap(time):
        return float(np.corrcoef(start.ravel(), made.field(time, *window).ravel())[0, 1])

    assert overlap(6.0) > 0.99
    assert 0.2 < overlap(300.0) < 0.9
    assert abs(overlap(2400.0)) < 0.03


def test_wind_carries_the_clouds_downwind():
    calm, windy = (generator(STRATUS, 4, Motion(0.0, wind, math.inf, 1.0)) for wind in ((0.0, 0.0), (20.0, -40.0)))
    start = calm.field(0.0, slice(0, 50), slice(0, 60))
    # After 3 s at one pixel a second in x and minus two in y.
    np.testing.assert_array_equal(windy.field(3.0, slice(-6, 44), slice(3, 63)), start)
