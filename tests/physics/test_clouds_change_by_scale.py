"""Fractal clouds with lifetimes by scale change as measured ones do, and layers can have winds of their own."""

from __future__ import annotations

import numpy as np
import pytest

from hcss_twin import Scenario
from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.plan.assemble import CELL_LIFETIME_S_PER_M
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.providers import Grid, Motion

MEASURED = {
    (64, 96): (0.93, 0.87, 0.80),
    (32, 64): (0.86, 0.74, 0.63),
    (16, 32): (0.72, 0.52, 0.38),
    (8, 16): (0.48, 0.26, 0.15),
}
"""Coherence of 10.8 um images of clouds over sea after 15, 30 and 45 min, by wavelength in km."""

SHAPE = FractalParameters(gamma=2.0, H=0.5, L=(0.125, 0.125), k=(0, 7))  # cells of 128 km to 1 km


def octaves(motion: Motion):
    return Octave.separate(SHAPE, Grid(256, 256, 3000.0), motion, noise=False)


@pytest.mark.parametrize(("band", "measured"), MEASURED.items(), ids=str)
def test_coherence_by_scale_is_the_measured_one(band: tuple[int, int], measured: tuple[float, ...]) -> None:
    correlation = KernelCorrelation.tabulate()
    lag = np.arange(-4.0, 4.0, 1 / 64)
    spectrum = np.abs(np.fft.rfft(np.fft.ifftshift(correlation(lag))))
    frequency = np.fft.rfftfreq(lag.size, 1 / 64)
    wave = 1.0 / np.geomspace(*band, 20)[:, None]
    turn = np.linspace(0.0, np.pi / 2, 16)
    power, at = [], []
    for each in octaves(Motion(0.0, (0.0, 0.0), 1800.0, 900.0, CELL_LIFETIME_S_PER_M)):
        cell_km = 3.0 / each.x.step
        along = [np.interp(cell_km * wave * part, frequency, spectrum) for part in (np.cos(turn), np.sin(turn))]
        power.append(each.variance * cell_km**2 * np.sum(along[0] * along[1] * wave**2))
        at.append(correlation(np.array([900.0, 1800.0, 2700.0]) * each.t.step))
    coherence = np.average(at, axis=0, weights=power)
    np.testing.assert_allclose(coherence, measured, atol=0.15)


def test_lifetimes_are_in_proportion_to_cells_where_measured_and_below_those_of_turbulence() -> None:
    each = octaves(Motion(0.0, (0.0, 0.0), 1800.0, 900.0, CELL_LIFETIME_S_PER_M))
    cell_m, lifetime_s = np.array([(3000.0 / o.x.step, 1.0 / o.t.step) for o in each]).T
    measured = cell_m >= 4000.0
    np.testing.assert_allclose(lifetime_s[measured], cell_m[measured] * CELL_LIFETIME_S_PER_M)
    at_limit = 4000.0 * CELL_LIFETIME_S_PER_M
    assert np.count_nonzero(~measured) == 2
    np.testing.assert_allclose(lifetime_s[~measured], at_limit * (cell_m[~measured] / 4000.0) ** (2 / 3))
    assert octaves(Motion(0.0, (0.0, 0.0), 1800.0, 900.0))[0].t.step == 1 / 1800.0


CHANGE_IN_1_S = {"cumulus": (0.011, 0.010), "stratus": (0.0038, 0.0033), "stratocumulus": (0.011, 0.099)}
"""Of the field, in standard deviations, with lifetimes by scale and with 1800 s for the largest structures."""


@pytest.mark.parametrize(("kind", "changes"), CHANGE_IN_1_S.items(), ids=str)
def test_pixels_of_20_m_change_little_in_a_second(kind: str, changes: tuple[float, float]) -> None:
    correlation, found = KernelCorrelation.tabulate(), []
    for motion in ({}, {"evolution_time": 1800.0}):
        layer = {"type": kind, "coverage": 0.3, "coverage_mode": "field"}
        scene = SCENE | {"image": {"rows": 16, "columns": 16, "pixel_size": 20.0}, "motion": motion}
        (generator,) = make_plan(Scenario.from_dict(scene | {"clouds": {"layers": [layer]}})).assembly.generators
        steps = [(o.variance, float(correlation(np.array([o.t.step]))[0])) for o in generator.octaves]
        found.append(np.sqrt(2.0 * sum(share * (1.0 - after) for share, after in steps)))
    np.testing.assert_allclose(found, changes, rtol=0.05)


SCENE = {
    "time": "2024-04-20T02:30:00+00:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "output": {"variables": ["cloud_mask"]},
}


def plan_of(**keys: object):
    layers = [
        {"type": "cumulus", "coverage": 0.3, "coverage_mode": "field"},
        {"type": "cirrus", "coverage": 0.3, "coverage_mode": "field", **keys},
    ]
    data = SCENE | {
        "image": {"rows": 64, "columns": 64, "pixel_size": 100.0},
        "motion": {"wind_speed": 10.0, "wind_from": 270.0, "evolution_time": "frozen"},
        "clouds": {"layers": layers},
    }
    return make_plan(Scenario.from_dict(data))


def test_a_layer_drifts_with_its_own_wind() -> None:
    low, high = plan_of(wind_speed=30.0, wind_from=180.0).assembly.generators
    whole = slice(0, 64)
    still = [each.thickness_m(0.0, whole, whole) for each in (low, high)]
    np.testing.assert_array_equal(low.thickness_m(10.0, whole, whole)[:, 1:], still[0][:, :-1])
    np.testing.assert_array_equal(high.thickness_m(10.0, whole, whole)[3:], still[1][:-3])
