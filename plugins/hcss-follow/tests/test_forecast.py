"""The forecast against closed forms: what only moves, what stays, and energies of what is drawn."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import field, images, state_of
from hcss_follow.bands import COUNT, bands_of, local_energy
from hcss_follow.coefficients import Coefficients, read_coefficients
from hcss_follow.forecast import PEAK, Forecast, displaced
from hcss_follow.motion import departures
from hcss_follow.sky import FollowedSky


def staying():
    """Coefficients with which the image stays as it is, and half of each band's energy is unknown."""
    mean = np.zeros((3, 4, COUNT))
    mean[:, 0] = 1.0
    variance = np.zeros((3, 2, COUNT))
    variance[1:, 1, :-1] = 0.5
    return Coefficients(np.array([0.0, 900.0, 1800.0]), mean, variance, np.ones((3, 3)), "made", "none")


def test_bands_sum_to_the_field():
    made = field(96).astype(np.float32)
    np.testing.assert_allclose(bands_of(made).sum(axis=0), made, atol=2e-4)


def test_a_field_that_moves_is_forecast():
    """Moved by (2, -3) pixels per 15 min, it is known where it will be."""
    sky = FollowedSky(state_of(images()), 1, None, staying())
    at = np.arange(-32.0, 32.0) + 0.5
    forecast = sky.at(1800.0, at, at)[..., 0]
    truth = images(steps=(3,))[0].kelvin[32:96, 32:96]
    persistence = images(steps=(1,))[0].kelvin[32:96, 32:96]
    assert np.sqrt(np.mean((forecast - truth) ** 2)) < 0.08 * np.sqrt(np.mean((persistence - truth) ** 2))


def test_trajectories_in_a_turning_flow():
    """Solid rotation: what is at a place has come along a circle."""
    turn, middle = 1.0e-4, 50.0
    y, x = np.meshgrid(np.arange(101.0) - middle, np.arange(101.0) - middle, indexing="ij")
    velocity = np.stack([turn * x, -turn * y]).astype(np.float32)
    at = np.array([35.0, 50.0, 61.0])
    found = departures(velocity, 3000.0, at, at)
    angle = turn * 3000.0
    dy, dx = np.meshgrid(at - middle, at - middle, indexing="ij")
    expected = np.cos(angle) * dy - np.sin(angle) * dx, np.sin(angle) * dy + np.cos(angle) * dx
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one - middle, other, atol=0.05)


@pytest.mark.parametrize("time_s", [900.0, 1800.0, 2700.0])
def test_time_is_continuous_at_the_ends_of_steps(time_s):
    sky = FollowedSky(state_of(images()), 1, 4)
    at = np.arange(-20.0, 20.0)
    before, after = (sky.at(time_s + by, at, at)[..., 0] for by in (-0.01, 0.01))
    between = np.abs(sky.at(time_s + 60.0, at, at)[..., 0] - before).mean()
    assert np.abs(after - before).max() < 0.02
    assert between > 10.0 * np.abs(after - before).mean()


def test_members_differ_by_what_is_unknown():
    """Local energies of what is drawn are 1, so that the spread of members is that of the coefficients."""
    state = state_of(images(256, fine=6.0))
    members = np.stack([Forecast(state, seed, staying()).kelvin(900.0) for seed in range(40)])
    mean = Forecast(state, None, staying()).kelvin(900.0)
    inside = (slice(32, -32),) * 2
    unlimited = mean[inside] < np.percentile(mean, 60)  # the warmest cannot become warmer
    bands = bands_of(state.kelvin)
    energy = 0.5 * np.mean(bands[:-1].sum(axis=0)[inside][unlimited] ** 2)  # neighbouring bands are correlated
    spread = np.mean(members.var(axis=0)[inside][unlimited])
    assert spread == pytest.approx(energy, rel=0.35)
    assert np.corrcoef((members[0] - mean)[inside].ravel(), (members[1] - mean)[inside].ravel())[0, 1] < 0.5


def test_what_is_drawn_has_energy_1():
    image = np.random.default_rng(0).normal(size=(COUNT, 64, 64)).astype(np.float32) * 5.0
    drawn = displaced(image, np.full_like(image, 25.0), 3)
    assert np.mean(drawn[:-1] ** 2) == pytest.approx(1.0, rel=0.1)


def test_deviations_are_small_in_most_pixels_and_large_in_few(monkeypatch):
    """u |u|^(1/4) times what gives it the variance of u, by quadrature over the normal distribution."""
    x, weight = np.polynomial.hermite_e.hermegauss(200)
    assert np.sum(weight * (PEAK * np.abs(x) ** 1.25) ** 2) / np.sqrt(2.0 * np.pi) == pytest.approx(1.0, rel=1e-4)
    state, of = state_of(images(fine=8.0)), staying()
    of.variance[:, 1, 1:] = 0.0  # the finest band alone
    mean = Forecast(state, None, of).kelvin(900.0)

    def drawn(u):
        monkeypatch.setattr("hcss_follow.forecast.displaced", lambda *_: np.full((COUNT, 128, 128), u, np.float32))
        return (Forecast(state, 1, of).kelvin(900.0) - mean)[20:-20, 20:-20]

    once, twice = drawn(-1.0), drawn(-2.0)  # colder, as the clear sky limits what is warmer
    energy = local_energy(bands_of(state.kelvin))[0, 20:-20, 20:-20]
    np.testing.assert_allclose(once, -PEAK * np.sqrt(0.5 * energy), rtol=1e-2, atol=2e-4)
    np.testing.assert_allclose(twice, once * 2.0**1.25, rtol=1e-2, atol=4e-4)


def test_beyond_the_last_lead_energy_is_kept():
    of = staying()
    of.mean[1, 0], of.mean[2, 0] = 0.9, 0.8
    mean, variance, _ = of.at(3600.0)
    assert np.all(mean[0] < 0.8)
    np.testing.assert_allclose(mean[0] ** 2 + variance[1], 0.8**2 + of.variance[2, 1])


def test_shipped_coefficients_say_where_they_come_from():
    of = read_coefficients()
    assert "2020-09-06" in of.data
    assert "fit.py" in of.command
    np.testing.assert_array_equal(of.at(0.0)[0][0], 1.0)
    np.testing.assert_array_equal(of.at(0.0)[1], 0.0)


def test_members_spread_more_where_the_factor_of_their_depth_says_so():
    """Four times the variance of thin cloud is twice the spread there, and changes no clear sky."""
    state = state_of(images(fine=8.0))
    plain, wide = staying(), replace(staying(), spread=np.array([[1.0, 1.0, 1.0], [1.0, 4.0, 4.0], [1.0, 4.0, 4.0]]))
    mean = Forecast(state, None, plain).kelvin(900.0)
    one, other = (Forecast(state, 3, of).kelvin(900.0) - mean for of in (plain, wide))
    depth = state.clear_K - state.kelvin
    thin = (depth > 8.0) & (one < 0.0) & (other < 0.0)  # above, the clear sky limits both
    assert thin.sum() > 20
    np.testing.assert_allclose(other[thin], 2.0 * one[thin], rtol=1e-3, atol=1e-3)
    np.testing.assert_allclose(other[depth < 0.5], one[depth < 0.5], atol=1e-4)
