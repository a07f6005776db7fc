"""Thermodynamics, radiation, forcings and rain against laws and independent computations."""

import numpy as np
import pytest
from hcss_skies.les.case import case_of
from hcss_skies.les.forcings import falls_through, subsidence_of_profile, subsidence_weights
from hcss_skies.les.grid import Mesh
from hcss_skies.les.model import Model
from hcss_skies.les.radiation import radiative_heating
from hcss_skies.les.rain import fall_and_change, settle, settling_coefficient
from hcss_skies.les.thermodynamics import CP, GRAVITY, LATENT, R_DRY, ReferenceState, condensate
from les_cases import CLOUDY, case
from scipy.optimize import brentq

FLATAU = [-0.976195544e-15, -0.952447341e-13, 0.640689451e-10, 0.206739458e-7, 0.302950461e-5, 0.264847430e-3,
          0.142986287e-1, 0.443987641, 6.11239921]  # fmt: skip


def vapour_pressure(temperature):
    """D. M. Murphy and T. Koop, QJRMS 131, 1539 (2005), eq. 10, Pa."""
    t = temperature
    return np.exp(
        54.842763 - 6763.22 / t - 4.210 * np.log(t) + 0.000367 * t
        + np.tanh(0.0415 * (t - 218.8)) * (53.878 - 1331.22 / t - 9.44523 * np.log(t) + 0.014025 * t)
    )  # fmt: skip


@pytest.mark.parametrize("excess", [-1.0, 0.0, 0.02, 0.5, 3.0])
@pytest.mark.parametrize(("theta_l", "pressure"), [(240.0, 60000.0), (289.0, 92000.0), (310.0, 101500.0)])
def test_condensation_solves_the_saturation_equation(theta_l, pressure, excess):
    exner = (pressure / 1e5) ** (R_DRY / CP)

    def saturated(temperature):
        es = 100.0 * np.polyval(FLATAU, temperature - 273.15)
        return 622.0 * es / (pressure - 0.378 * es)

    water = max(saturated(exner * theta_l) + excess, 0.0)

    def surplus(liquid):
        return water - saturated(exner * theta_l + 1e-3 * LATENT / CP * liquid) - liquid

    # of the excess a part condenses, as the warmer air holds more
    expected = brentq(surplus, 0.0, excess, xtol=1e-13) if excess > 0.0 else 0.0
    assert condensate(theta_l, water, pressure, exner) == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("temperature", [250.0, 260.0, 280.0, 290.0, 300.0, 310.0])
def test_saturation_is_that_of_liquid_water(temperature):
    es = vapour_pressure(temperature)
    saturated = 622.0 * es / (1e5 - 0.378 * es)
    # water is a little above saturation: what stays vapour is saturated
    vapour = 1.01 * saturated - condensate(temperature, 1.01 * saturated, 1e5, 1.0)
    warmer = temperature + 1e-3 * LATENT / CP * (1.01 * saturated - vapour)
    assert 1e5 * vapour / (622.0 + 0.378 * vapour) == pytest.approx(vapour_pressure(warmer), rel=2e-3)


def test_the_reference_state_is_in_hydrostatic_balance():
    mesh = Mesh((4, 4), 100.0, np.linspace(0.0, 3000.0, 31))
    state = ReferenceState.of_profiles(mesh, np.full(30, 300.0), np.zeros(30), 1e5)
    np.testing.assert_allclose(state.exner, 1.0 - GRAVITY * mesh.centres_m / (CP * 300.0), rtol=1e-12)
    weight = GRAVITY * state.density * mesh.depth_m
    middle = 0.5 * (weight[1:] + weight[:-1])
    np.testing.assert_allclose(-np.diff(state.pressure_Pa), middle, rtol=1e-4)


def test_subsidence_moves_a_linear_profile_down_at_its_speed():
    mesh = Mesh((4, 4), 100.0, np.concatenate([np.linspace(0.0, 500.0, 11), np.linspace(580.0, 1300.0, 10)]))
    for speed in (-0.01, 0.02):
        weights = subsidence_weights(mesh, np.full(mesh.levels, speed))
        np.testing.assert_allclose(subsidence_of_profile(3e-3 * mesh.centres_m, weights), -speed * 3e-3, rtol=1e-12)


def test_a_forcing_acts_from_its_begin():
    cooled = case(
        air={"noise_K": 0.0}, forcing={"theta_l_K_day": [[0, -864.0]], "begin_hours": 0.01}, longest_step_s=4.0
    )
    model = Model(cooled)
    for until, cooling in ((36.0, 0.0), (72.0, 0.36)):
        model.run_until(until)
        below_sponge = (Model(cooled).theta_l - model.theta_l)[:, :, :32]
        np.testing.assert_allclose(below_sponge, cooling, atol=1e-9)


@pytest.mark.parametrize("moved", [-300.0, 0.0, 200.0])
def test_a_forcing_follows_the_inversion(moved):
    # least where water falls through 6 g/kg, at 1000 m in the beginning; 500 m halfway below, 1100 m a little above it
    forcing = {"theta_l_K_day": [[0, 0.0], [500, -400.0], [1000, -864.0], [1100, 0.0]], "inversion_water_g_kg": 6.0}
    air = {"noise_K": 0.0, "water_g_kg": [[0, 8.0], [975, 8.0], [1025, 4.0], [2000, 4.0]]}
    model = Model(case(air=air, forcing=forcing))
    z = model.mesh.centres_m
    model.water[...] = np.interp(z - moved, [975.0, 1025.0], [8.0, 4.0])
    before = model.theta_l[0, 0].copy()
    model.advance(1.0)
    top = 1000.0 + moved
    expected = np.interp(z, [0.0, 0.5 * top, top, top + 100.0], [0.0, -400.0, -864.0, 0.0]) / 86400.0
    np.testing.assert_allclose(model.theta_l[0, 0] - before, expected, atol=1e-9)


def test_a_profile_falls_through_a_value_between_levels():
    heights = np.array([0.0, 10.0, 20.0, 30.0])
    assert falls_through(heights, np.array([9.0, 5.0, 7.0, 1.0]), 4.0) == pytest.approx(25.0)
    assert falls_through(heights, np.full(4, 9.0), 4.0) == 30.0


def test_cooling_by_radiation_adds_up_to_the_published_fluxes():
    faces = np.linspace(0.0, 1500.0, 151)
    centres = 0.5 * (faces[1:] + faces[:-1])
    density, exner = np.full(150, 1.12), np.full(150, 0.98)
    liquid = np.broadcast_to(
        np.where((centres > 600) & (centres < 840), 0.45 * (centres - 600) / 240, 0.0), (2, 2, 150)
    )
    water = np.broadcast_to(np.where(centres < 840.0, 9.0, 1.5), (2, 2, 150))
    heating, mean = np.zeros((2, 2, 150)), np.zeros(150)
    law = (70.0, 22.0, 85.0, 1.0, 3.75e-6, 1.12, 8.0)
    radiative_heating(liquid.copy(), water.copy(), faces, density, exner, CP, law, heating, mean)
    flux = -(density * CP * exner * mean * 10.0)
    path = 1e-3 * 1.12 * liquid[0, 0].sum() * 10.0
    # the cloud as a whole: eq. 3 at its top less eq. 3 at its base
    expected = 70.0 + 22.0 * np.exp(-85.0 * path) - (70.0 * np.exp(-85.0 * path) + 22.0)
    assert flux[centres < 840.0].sum() == pytest.approx(expected, rel=1e-10)
    above = 1.12 * CP * 3.75e-6 * (0.25 * 660.0 ** (4 / 3) + 840.0 * 660.0 ** (1 / 3))
    assert flux[centres > 840.0].sum() == pytest.approx(above, rel=1e-10)
    assert mean.argmin() == np.flatnonzero(centres < 840.0)[-1]
    np.testing.assert_allclose(heating[1, 1], mean, rtol=1e-12)


def test_wind_without_friction_turns_once_in_an_inertial_period():
    coriolis = 1e-4
    turning = case(
        air={"u_m_s": [[0, 5.0]], "v_m_s": [[0, 0.0]], "noise_K": 0.0, "frame_m_s": [1.0, -2.0]},
        forcing={"coriolis_s": coriolis},
        grid={"columns": [4, 4], "sponge_rate_s": 0.0}, longest_step_s=60.0, courant=1.2,
    )  # fmt: skip
    model = Model(turning)
    for part in (0.25, 0.5):
        model.run_until(part * 2.0 * np.pi / coriolis)
        u, v = model.u.mean() + 1.0, model.v.mean() - 2.0
        angle = -coriolis * model.time_s
        assert (u, v) == (pytest.approx(5 * np.cos(angle), abs=1e-3), pytest.approx(5 * np.sin(angle), abs=1e-3))


def rain_column(rain, water, liquid, seconds=10.0, theta=290.0):
    """One column of rain after one step: its fields, and what fell."""
    levels = len(rain)
    fields = [np.full((1, 1, levels), float(x)) if np.isscalar(x) else np.array(x, float).reshape(1, 1, levels)
              for x in (0.0, water, rain, liquid)]  # fmt: skip
    pressure = np.full(levels, 95000.0)
    exner, density, depth = (pressure / 1e5) ** (R_DRY / CP), np.full(levels, 1.1), np.full(levels, 50.0)
    heating = np.empty(levels)
    fallen = fall_and_change(
        *fields, theta, 1e-3 * LATENT / CP, pressure, exner, density, depth, 50.0, seconds, heating
    )
    return [field[0, 0] for field in fields], fallen, heating, exner


def test_rain_keeps_water_and_heat():
    rain = [0.5, 0.2, 0.0, 0.3, 1.0, -0.01]
    liquid = [0.0, 0.0, 0.0, 0.4, 0.6, 0.2]
    (theta, water, after, _), fallen, heating, exner = rain_column(rain, 12.0, liquid)
    mass = 1.1 * 50.0 * 1e-3
    before = mass * (12.0 * 6 + sum(rain))
    assert mass * (water + after).sum() + fallen == pytest.approx(before, rel=1e-12)
    assert fallen > 0.0
    assert after.min() >= 0.0
    # what evaporates or condenses warms by its latent heat: theta_l + L/(cp Pi) q_t is kept, the negative rain apart
    filled = np.array([0, 0, 0, 0, 0, -0.01])
    np.testing.assert_allclose(theta, LATENT / CP / exner * 1e-3 * (12.0 + filled - water), rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(heating, theta, rtol=1e-12)


def test_rain_evaporates_in_dry_air_and_not_in_saturated_air():
    (_, dry, _, _), *_ = rain_column([1.0] * 4, 4.0, 0.0)
    (_, saturated, _, _), *_ = rain_column([1.0] * 4, 30.0, 0.0)
    assert np.all(dry > 4.0)
    np.testing.assert_array_equal(saturated, 30.0)


def test_rain_falls_at_the_speed_of_its_drops():
    # rho q_r = 1e-3 kg m-3: 36.34 * 1e-6 ^ .1346 = 5.66 m/s (Klemp and Wilhelmson 1978)
    _, fallen, _, _ = rain_column([1.0 / 1.1] * 4, 30.0, 0.0, seconds=1.0)
    assert fallen == pytest.approx(36.34 * (1e-6) ** 0.1346 * 1e-3, rel=0.02)


def test_droplets_settle_by_the_law_of_stokes():
    # of one size: 2/9 g r^2 (rho_w - rho) / viscosity (1.19e8 m-1 s-1 r^2), times their water
    radius = 10e-6
    content = 100e6 * 1000.0 * 4.0 / 3.0 * np.pi * radius**3
    flux = settling_coefficient(100.0, 1.0) * content ** (5.0 / 3.0)
    assert flux / content == pytest.approx(1.19e8 * radius**2)
    assert flux / content == pytest.approx(2.0 / 9.0 * GRAVITY * radius**2 * 1000.0 / 1.8e-5, rel=0.03)
    assert settling_coefficient(100.0, 1.5) / settling_coefficient(100.0, 1.0) == pytest.approx(2.275, rel=1e-3)


def test_settling_keeps_water_temperature_and_vapour():
    levels, seconds = 6, 10.0
    liquid = np.array([0.1, 0.4, 0.0, 0.2, 0.6, 0.0]).reshape(1, 1, levels)
    theta_l, water = np.zeros((1, 1, levels)), 8.0 + liquid
    exner, density, depth = np.linspace(1.0, 0.98, levels), np.linspace(1.2, 1.1, levels), np.full(levels, 10.0)
    heating = np.empty(levels)
    coefficient = settling_coefficient(50.0, 1.5)
    args = exner, density, depth, coefficient, seconds, heating
    fallen = settle(theta_l, water, liquid, 1e-3 * LATENT / CP, *args)
    change = (water - 8.0 - liquid)[0, 0]
    # each level loses its flux and gains that of the level above; what the lowest one loses has fallen
    flux = np.append(coefficient * (1e-3 * density * liquid[0, 0]) ** (5.0 / 3.0), 0.0)
    np.testing.assert_allclose(1e-3 * density * depth * change, seconds * (flux[1:] - flux[:-1]), rtol=1e-9, atol=1e-15)
    assert fallen == pytest.approx(seconds * flux[0])
    np.testing.assert_allclose(theta_l[0, 0], -1e-3 * LATENT / CP / exner * change, rtol=1e-9)
    np.testing.assert_allclose(heating, theta_l[0, 0], rtol=1e-12)


@pytest.mark.parametrize(("precision", "limit"), [("double", 1e-10), ("single", 1e-7)])
def test_every_step_explains_its_water_and_heat(precision, limit):
    model = Model(case_of({**CLOUDY, "precision": precision}, "test"))
    model.run_until(20.0)
    for until in range(30, 300, 10):
        model.run_until(float(until))
        budget = model.budget
        assert abs(budget.water_error) < limit
        assert abs(budget.heat_K_kg_m2 - budget.expected_heat_K_kg_m2) < limit * 300.0 * model.mass.sum()
        assert min(model.water.min(), model.liquid.min(), model.rain.min()) >= 0.0
    # something happened: cloud, rain and fluxes
    assert model.liquid.max() > 0.1
    assert model.rain.max() > 1e-3
    assert np.abs(budget.water_kg_m2) > 1e-6


def test_single_and_double_precision_have_the_same_statistics():
    means = []
    for precision in ("single", "double"):
        model = Model(case_of({**CLOUDY, "precision": precision}, "test"))
        model.run_until(300.0)
        means.append(((model.liquid @ model.mass).mean(), (model.w**2).mean(), model.theta_l.mean()))
    np.testing.assert_allclose(means[0], means[1], rtol=0.05)
