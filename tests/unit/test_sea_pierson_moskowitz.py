"""The height spectrum's limits and ranges, and determinism of its realisations."""

import numpy as np
import pytest

from hcss_twin.models.sea import pierson_moskowitz as pm


def test_a_calm_sea_is_flat() -> None:
    assert np.all(pm.spectrum_m2_s(np.array([0.0, 0.5, 3.0]), 0.0) == 0.0)
    assert pm.significant_wave_height_m(0.0) == 0.0
    assert pm.resolved_mean_square_slope(0.0, 5.0) == 0.0
    assert np.all(pm.surface_elevation(np.arange(5.0), np.zeros(5), 1.0, 0.0, 0.0, seed=1) == 0.0)


def test_spectrum_vanishes_toward_zero_frequency_without_overflow() -> None:
    found = pm.spectrum_m2_s(np.array([0.0, 1e-300, 1e-80, 1e-3, 0.01]), 10.0)
    assert np.all(found == 0.0)


@pytest.mark.parametrize("wind", [-1.0, np.nan, np.inf])
def test_impossible_wind_is_refused(wind: float) -> None:
    with pytest.raises(ValueError, match="wind_speed_m_s"):
        pm.spectrum_m2_s(np.ones(1), wind)
    with pytest.raises(ValueError, match="wind_speed_m_s"):
        pm.surface_elevation(np.ones(1), np.ones(1), 0.0, wind, 0.0, seed=1)


def test_negative_frequency_is_refused() -> None:
    with pytest.raises(ValueError, match="omega_rad_s"):
        pm.spectrum_m2_s(np.array([-0.1, 1.0]), 10.0)


def test_a_calm_sea_has_no_peak() -> None:
    with pytest.raises(ValueError, match="no peak"):
        pm.peak_frequency_rad_s(0.0)


@pytest.mark.parametrize("cutoff", [0.0, -1.0, np.inf])
def test_slope_needs_a_finite_cutoff(cutoff: float) -> None:
    with pytest.raises(ValueError, match="cutoff_rad_s"):
        pm.resolved_mean_square_slope(10.0, cutoff)


def test_the_seed_selects_the_surface_and_nothing_else_does() -> None:
    x, y = np.meshgrid(np.arange(6.0), np.arange(4.0))
    whole = pm.surface_elevation(x, y, 3.0, 8.0, 270.0, seed=7, components=50)
    assert whole.shape == (4, 6)
    part = pm.surface_elevation(x[1:3, 2:], y[1:3, 2:], 3.0, 8.0, 270.0, seed=7, components=50)
    np.testing.assert_allclose(part, whole[1:3, 2:], atol=1e-13)
    other = pm.surface_elevation(x, y, 3.0, 8.0, 270.0, seed=8, components=50)
    assert np.abs(other - whole).max() > 0.1


def test_waves_run_away_from_where_the_wind_comes() -> None:
    # A single wave moves along its own direction; with wind from the west its crests go east.
    time, x = 0.4, np.linspace(0.0, 400.0, 4001)
    omega = pm.component_frequencies_rad_s(8.0, 1)[0]
    for seed in range(5):
        now, later = (pm.surface_elevation(x, np.zeros(1), t, 8.0, 270.0, seed=seed, components=1) for t in (0.0, time))
        shifts = np.arange(-200, 201)
        match = [np.sum((later[200:-200] - np.roll(now, shift)[200:-200]) ** 2) for shift in shifts]
        # The trace along x moves at the phase speed or faster, as the wave runs obliquely.
        assert 0.1 * shifts[int(np.argmin(match))] >= 0.999 * time * 9.81 / omega - 0.1
