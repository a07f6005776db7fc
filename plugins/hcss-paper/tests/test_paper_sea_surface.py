"""Realisations of the sea against their spectrum; their determinism."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hcss_paper import sea_surface as pm
from hcss_paper.sea_surface import component_frequencies_rad_s, surface_elevation
from scipy.integrate import quad


def spectrum(omega: float, wind: float) -> float:
    return float(pm.spectrum_m2_s(np.array([omega]), wind)[0])


def test_a_calm_sea_is_flat() -> None:
    assert np.all(surface_elevation(np.arange(5.0), np.zeros(5), 1.0, 0.0, 0.0, seed=1) == 0.0)


@pytest.mark.parametrize("wind", [-1.0, np.nan, np.inf])
def test_impossible_wind_is_refused(wind: float) -> None:
    with pytest.raises(ValueError, match="wind_speed_m_s"):
        surface_elevation(np.ones(1), np.ones(1), 0.0, wind, 0.0, seed=1)


def test_the_seed_selects_the_surface_and_nothing_else_does() -> None:
    x, y = np.meshgrid(np.arange(6.0), np.arange(4.0))
    whole = surface_elevation(x, y, 3.0, 8.0, 270.0, seed=7, components=50)
    assert whole.shape == (4, 6)
    part = surface_elevation(x[1:3, 2:], y[1:3, 2:], 3.0, 8.0, 270.0, seed=7, components=50)
    np.testing.assert_allclose(part, whole[1:3, 2:], atol=1e-13)
    other = surface_elevation(x, y, 3.0, 8.0, 270.0, seed=8, components=50)
    assert np.abs(other - whole).max() > 0.1


def test_waves_run_away_from_where_the_wind_comes() -> None:
    # A single wave moves along its own direction; with wind from the west its crests go east.
    time, x = 0.4, np.linspace(0.0, 400.0, 4001)
    omega = component_frequencies_rad_s(8.0, 1)[0]
    for seed in range(5):
        now, later = (surface_elevation(x, np.zeros(1), t, 8.0, 270.0, seed=seed, components=1) for t in (0.0, time))
        shifts = np.arange(-200, 201)
        match = [np.sum((later[200:-200] - np.roll(now, shift)[200:-200]) ** 2) for shift in shifts]
        # The trace along x moves at the phase speed or faster, as the wave runs obliquely.
        assert 0.1 * shifts[int(np.argmin(match))] >= 0.999 * time * 9.81 / omega - 0.1


def test_components_share_the_variance_as_the_spectrum_does() -> None:
    omega = component_frequencies_rad_s(10.0, 2000)
    edges = np.array([0.5, 0.8, 1.0, 1.5, 2.5])
    counted = np.histogram(omega, edges)[0] / 2000
    integrals = [quad(spectrum, a, b, (10.0,))[0] for a, b in pairwise(edges)]
    np.testing.assert_allclose(counted, np.array(integrals) / pm.elevation_variance_m2(10.0), atol=1e-3)


def test_elevations_have_the_spectrums_variance_and_are_gaussian() -> None:
    # Points scattered over 1000 km are independent samples of the one surface.
    x, y = np.random.default_rng(2).uniform(0.0, 1e6, (2, 20_000))
    elevation = surface_elevation(x, y, 0.0, 10.0, 240.0, seed=4, components=200)
    sigma = math.sqrt(pm.elevation_variance_m2(10.0))
    assert elevation.var() == pytest.approx(sigma**2, rel=4.0 * math.sqrt(2.0 / elevation.size))
    assert elevation.mean() == pytest.approx(0.0, abs=4.0 * sigma / math.sqrt(elevation.size))
    assert np.mean(elevation**4) == pytest.approx(3.0 * elevation.var() ** 2, rel=0.1)


def test_slopes_split_three_to_one_between_downwind_and_crosswind() -> None:
    # The mean of cos^2 over the density 2/pi cos^2 is 3/4. Few waves of one surface carry most of its slope
    # (about 7 of 50), so it takes many surfaces.
    x, y = np.random.default_rng(6).uniform(0.0, 1e6, (2, 300))
    step, surfaces, downwind, crosswind = 0.01, 100, 0.0, 0.0
    for seed in range(surfaces):
        middle, east, north = (
            surface_elevation(x + dx, y + dy, 0.0, 10.0, 270.0, seed=seed, components=50)
            for dx, dy in ((0.0, 0.0), (step, 0.0), (0.0, step))
        )
        downwind += float(np.mean((east - middle) ** 2)) / step**2 / surfaces
        crosswind += float(np.mean((north - middle) ** 2)) / step**2 / surfaces
    omega = component_frequencies_rad_s(10.0, 50)
    total = pm.elevation_variance_m2(10.0) * np.mean(omega**4) / 9.81**2
    assert downwind + crosswind == pytest.approx(total, rel=0.03)
    assert downwind / (downwind + crosswind) == pytest.approx(0.75, abs=0.03)


def test_undulation_of_a_patch_at_10_m_per_s_is_the_2_5_m_of_the_paper() -> None:
    """The HCSS paper's largest undulation, around 2.5 m (text on Fig 10), as crest to trough in 100 m."""
    axis = np.linspace(0.0, 100.0, 41)
    ranges = [
        np.ptp(surface_elevation(axis, axis[:, None], 0.0, 10.0, 270.0, seed=seed, components=200))
        for seed in range(15)
    ]
    assert np.median(ranges) == pytest.approx(2.5, abs=0.5)
