"""The height spectrum's limits and ranges."""

import numpy as np
import pytest

from hcss_twin.models.sea import pierson_moskowitz as pm
from hcss_twin.models.sea.wave_spectrum import WaveSpectrum


def test_a_calm_sea_is_flat() -> None:
    assert np.all(pm.spectrum_m2_s(np.array([0.0, 0.5, 3.0]), 0.0) == 0.0)
    assert pm.significant_wave_height_m(0.0) == 0.0
    assert WaveSpectrum("pierson-moskowitz", 0.0).resolved_mean_square_slope(5.0) == 0.0


def test_spectrum_vanishes_toward_zero_frequency_without_overflow() -> None:
    found = pm.spectrum_m2_s(np.array([0.0, 1e-300, 1e-80, 1e-3, 0.01]), 10.0)
    assert np.all(found == 0.0)


@pytest.mark.parametrize("wind", [-1.0, np.nan, np.inf])
def test_impossible_wind_is_refused(wind: float) -> None:
    with pytest.raises(ValueError, match="wind_speed_m_s"):
        pm.spectrum_m2_s(np.ones(1), wind)


def test_negative_frequency_is_refused() -> None:
    with pytest.raises(ValueError, match="omega_rad_s"):
        pm.spectrum_m2_s(np.array([-0.1, 1.0]), 10.0)


def test_a_calm_sea_has_no_peak() -> None:
    with pytest.raises(ValueError, match="no peak"):
        pm.peak_frequency_rad_s(0.0)
