"""A colour scale in kelvin shows clear sky and cloud both with their structure, and says honestly which is which."""

import numpy as np
import pytest

from hcss_twin.reports.colour_scale import ENDS_PERCENT, ColourScale, sight_rank


def sky(clouds=0.1, size=60_000):
    """Sea of 288.8 K within hundredths of a kelvin under clouds between 280 and 288 K: few shades if linear."""
    random = np.random.default_rng(3)
    clear = 288.8 + 0.02 * random.standard_normal(round(size * (1.0 - clouds)))
    cloud = random.uniform(280.0, 288.0, round(size * clouds))
    return clear, cloud


def spread(scale, values):
    low, high = np.percentile(values, ENDS_PERCENT)
    return float(scale.share_of(np.array(high)) - scale.share_of(np.array(low)))


def test_the_sea_gets_several_times_the_shades_of_a_linear_scale_and_the_clouds_keep_most():
    clear, cloud = sky()
    planes = np.concatenate([clear, cloud])
    linear = ColourScale.of(planes, "gray_r")
    stretched = ColourScale.of(planes, "gray_r", stretched=True)
    assert spread(stretched, clear) > 4.0 * spread(linear, clear)
    assert spread(stretched, cloud) > 0.5


def test_rare_clouds_are_within_the_ends_and_rarer_faulty_pixels_are_not():
    clear, cloud = sky(clouds=0.005)
    scale = ColourScale.of(np.concatenate([clear, cloud]), "gray_r", stretched=True)
    assert scale.low < 281.0
    assert ColourScale.of(np.concatenate([clear, cloud]), "gray_r").low > 280.1
    faulty = np.concatenate([*sky(), np.full(20, 900.0)])
    assert ColourScale.of(faulty, "gray_r", stretched=True).high < 290.0


def test_shares_rise_with_values_and_lead_back_to_them():
    scale = ColourScale.of(np.concatenate(sky()), "gray_r", stretched=True)
    values = np.linspace(scale.low, scale.high, 1000)
    shares = scale.share_of(values)
    assert np.all(np.diff(shares) > 0.0)
    assert shares[[0, -1]] == pytest.approx([0.0, 1.0])
    np.testing.assert_allclose(scale.value_at(shares), values, atol=1e-9)


def test_labels_of_ticks_do_not_touch_and_are_within_the_scale():
    scale = ColourScale.of(np.concatenate(sky()), "gray_r", stretched=True)
    ticks = np.array(scale.ticks())
    assert ticks.size >= 3
    assert np.all(np.diff(scale.share_of(ticks)) > 0.1)
    assert scale.low <= ticks[0] < ticks[-1] <= scale.high


def test_values_of_one_kind_and_a_single_value_have_scales():
    noise = np.random.default_rng(1).standard_normal((50, 50))
    scale = ColourScale.of(noise, "gray_r", stretched=True)
    assert scale.low == pytest.approx(np.quantile(noise, 0.003), abs=0.4)
    assert ColourScale.of(np.full((4, 4), 280.0), "gray_r", stretched=True).knots == ()


def test_a_band_without_sunlight_goes_before_one_with_more_contrast_and_less_noise_before_more():
    random = np.random.default_rng(2)
    steps = np.repeat([280.0, 290.0], 32)[None, :] + np.zeros((64, 1))
    noisy = steps + random.standard_normal((64, 64))
    window, reflected, grainy = (
        sight_rank(low, plane) for low, plane in ((8.0, steps), (2.7, 3.0 * steps), (10.3, noisy))
    )
    assert window < grainy < reflected
    assert sight_rank(8.0, np.full((4, 4), np.nan)) > reflected
