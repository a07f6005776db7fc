"""Laws of the tiers: uniform limit, closed enclosure, energy, Monte Carlo, extremes."""

import numpy as np
import pytest
from hcss_light.monte_carlo import radiance
from hcss_light.orders import DIRECTIONS, coupling, exchange, mix
from hcss_light.slices import MOST_SLICES, Slices, slices_of
from hcss_light.source import Direction, Particles, Surroundings, absorbed_radiance, sourced_radiance
from hcss_light.sums import fitted_weights, sun_integrals
from hcss_light.voxels import LightError, Voxels, henyey_greenstein

from hcss_twin.physics.multiple_scattering.sunlight import solve_sun

THERMAL = Particles(0.03, 0.5, np.array([1.0, 0.9]))


def broken(rows=14, columns=10, most=600.0):
    """Clouds of all thicknesses over half of an area."""
    draw = np.random.default_rng(3)
    return (draw.uniform(20.0, most, (rows, columns)) * (draw.random((rows, columns)) < 0.5)).astype(np.float32)


def light(slices, emitted=None, sky=0.0, below=0.0, sunlight=0.0, gas=0.0):
    """Surroundings with the same of each at all heights."""
    count = slices.count
    emission = np.zeros(count) if emitted is None else emitted
    return Surroundings(emission, sky, below, np.full(count, sunlight), np.full(count, gas))


@pytest.mark.parametrize("zenith", [0.0, 50.0, 80.0])
@pytest.mark.parametrize("gas", [0.0, 1e-4])
def test_an_isothermal_enclosure_with_broken_cloud_is_black(zenith, gas):
    slices = Slices(100.0, 700.0, 40, "base", 100.0)
    around, view = light(slices, np.ones(40), 1.0, 1.0, 0.0, gas), Direction(zenith, 30.0)
    for particles in (THERMAL, Particles(0.05, 0.999, np.array([1.0, 0.85]))):
        for tier in (sourced_radiance, absorbed_radiance):
            sun = (None,) if tier is sourced_radiance else ()
            _, seen = tier(slices, slices.density(broken()), particles, around, view, *sun, 100.0)
            np.testing.assert_allclose(seen, 1.0, atol=1e-3)


def test_light_exchanged_between_directions_is_conserved():
    matrix = exchange(0.46)
    np.testing.assert_allclose(matrix.sum(axis=0), 1.0, rtol=1e-9)
    np.testing.assert_allclose(matrix, matrix.T)


@pytest.mark.parametrize("shape", ["uniform", "adiabatic"])
@pytest.mark.parametrize("anchor", ["base", "top"])
def test_slices_keep_the_amount_of_cloud(shape, anchor):
    """Of columns, and in the mean over the area of slanted rays."""
    slices = Slices(100.0, 700.0, 23, anchor, 100.0)
    density = slices.density(broken(), shape)
    np.testing.assert_allclose(density.sum(axis=0) * slices.height_m, broken(), rtol=1e-5)
    amount, _ = absorbed_radiance(slices, density, THERMAL, light(slices), Direction(65.0, 110.0), 100.0)
    assert amount.mean() == pytest.approx(broken().mean(), rel=1e-5)


def test_a_cloud_appears_where_the_line_of_sight_meets_it():
    """Thin cloud at 600 m, seen from the east: over the point 600 m tan(45 deg) west of it."""
    slices = Slices(0.0, 640.0, 32, "top", 100.0)
    thickness = np.zeros((9, 20), dtype=np.float32)
    thickness[4, 12] = 20.0
    amount, _ = absorbed_radiance(
        slices, slices.density(thickness), THERMAL, light(slices), Direction(45.0, 90.0), 30.0
    )  # fmt: skip
    row, column = np.unravel_index(np.argmax(amount), amount.shape)
    assert (row, column) == (4, 6)


@pytest.mark.parametrize("tau", [1.0, 4.0, 16.0])
def test_uniform_cloud_reflects_nearly_as_adding_doubling_finds(tau):
    """Sixteen directions are within 7 %; scenarios use their difference between broken and uniform cloud only."""
    slices, view, sun = Slices(0.0, 400.0, 64, "base", 100.0), Direction(40.0, 0.0), Direction(60.0, 40.0)
    particles = Particles(tau / 400.0, 0.9, np.array([1.0, 0.8]))
    uniform = slices.density(np.full((1, 1), 400.0, np.float32))
    _, seen = sourced_radiance(slices, uniform, particles, light(slices, sunlight=1.0), view, sun, 0.0)
    up, down = np.cos(np.radians([40.0, 60.0]))
    layer = np.array([[tau]]), np.array([0.9]), np.array([[1.0], [0.8]])
    brdf, _ = solve_sun(*layer, np.array([up]), float(down), np.radians([40.0]), 32, 32, kept_moments=64)
    assert seen.item() / down == pytest.approx(brdf.item(), rel=0.07)


def test_sums_of_exponentials_reproduce_the_columns_that_they_are_fitted_to():
    slices, view, sun = Slices(0.0, 400.0, 64, "base", 100.0), Direction(40.0, 0.0), Direction(60.0, 40.0)
    particles, around = Particles(0.04, 0.9, np.array([1.0, 0.8])), light(slices, sunlight=1.0)
    columns = [slices.density(np.full((1, 1), thickness_m, np.float32)) for thickness_m in np.linspace(0.0, 400.0, 33)]
    radiances = np.array(
        [sourced_radiance(slices, column, particles, around, view, sun, 0.0)[1].item() for column in columns]
    )
    integrals = np.array(
        [sun_integrals(slices, column, particles, around.sunlight, view, sun, 0.0)[:, 0, 0] for column in columns]
    )
    weights = fitted_weights(integrals.T, radiances)
    assert np.all(weights >= 0.0)
    np.testing.assert_allclose(integrals @ weights, radiances, rtol=0.05, atol=0.05 * radiances.max())


@pytest.mark.parametrize("view", [0.0, 60.0])
def test_thinner_slices_do_not_change_the_mean_of_sunlit_broken_cloud(view):
    """Light mixed between neighbours in each slice made thin slices brighter by 5 to 16 %."""
    draw = np.random.default_rng(0)
    thickness = np.kron(draw.choice([0.0, 100.0, 200.0, 300.0, 400.0], (10, 10)), np.ones((3, 3))).astype(np.float32)
    particles = Particles(0.06, 0.93, np.array([1.0, 0.81]))
    means = []
    for count in (16, 64):
        slices = Slices(600.0, 1000.0, count, "base", 100.0)
        arguments = particles, light(slices, sunlight=1.0), Direction(view, 0.0), Direction(37.0, 260.0), 600.0
        means.append(sourced_radiance(slices, slices.density(thickness), *arguments)[1].mean())
    assert means[0] == pytest.approx(means[1], rel=0.02)


@pytest.mark.parametrize(("asymmetry", "albedo"), [(0.45, 1.0), (-0.3, 0.7)])
def test_harmonics_of_azimuth_exchange_as_much_light_as_the_whole_matrix(asymmetry, albedo):
    light_in = np.random.default_rng(1).random((DIRECTIONS, 300), dtype=np.float32)
    scattered = np.empty_like(light_in)
    mix(light_in, *coupling(albedo * exchange(asymmetry)), 0, 300, scattered)
    np.testing.assert_allclose(scattered, albedo * exchange(asymmetry) @ light_in, rtol=1e-5)


@pytest.mark.parametrize(("zenith", "limit"), [(0.0, 0.003), (60.0, 0.01)])
def test_thermal_radiance_of_broken_cloud_agrees_with_monte_carlo(zenith, limit):
    """Opaque cloud with a lapse over warm ground; 1 % is about .6 K at 10.8 um, mostly that of uniform cloud, too."""
    slices = Slices(0.0, 600.0, 36, "base", 100.0)
    emitted, sky = np.linspace(1.0, 0.9, 36), 0.2
    density = slices.density(broken())
    voxels = Voxels(
        np.moveaxis(density, 0, 2).astype(float) * THERMAL.extinction_m1, np.linspace(0.0, 600.0, 37), (100.0, 100.0),
        THERMAL.albedo, np.zeros(36), emitted, surface_source=1.1, sky_source=sky,
    )  # fmt: skip
    mean, error = radiance(
        voxels, henyey_greenstein(0.9), view_zenith_deg=zenith, view_azimuth_deg=20.0, photons=3000
    )  # fmt: skip
    _, seen = sourced_radiance(
        slices, density, THERMAL, light(slices, emitted, sky, 1.1), Direction(zenith, 20.0), None, 600.0
    )  # fmt: skip
    away = seen - mean
    assert abs(away.mean()) < limit
    assert np.sqrt(max(np.mean(away**2) - np.mean(error**2), 0.0)) < 1.5 * limit + 0.005


@pytest.mark.parametrize(
    ("particles", "view", "sun"),
    [
        (Particles(0.05, 1.0 - 1e-12, np.array([1.0, 0.85])), 30.0, 40.0),
        (Particles(5.0, 0.9, np.array([1.0, 0.99])), 45.0, 60.0),
        (Particles(1e-9, 0.5, np.array([1.0, 0.0])), 0.0, 0.0),
        (Particles(0.05, 0.0, np.array([1.0, 0.5])), 60.0, 20.0),
        (Particles(0.05, 0.9, np.array([1.0, -0.4])), 85.0, 84.9),
    ],
    ids=["conservative", "opaque", "vanishing", "black", "grazing, backward"],
)
def test_extreme_clouds_have_finite_radiance(particles, view, sun):
    single = np.zeros((5, 7), dtype=np.float32)
    single[2, 3] = 300.0
    for thickness in (single, single[2:3, 3:4], broken(5, 7, 300.0)):
        slices = slices_of(0.0, 300.0, "base", 50.0, max(view, sun), 1.0)
        around = light(slices, np.ones(slices.count), 0.5, 1.0, 2.0, 1e-4)
        arguments = slices, slices.density(thickness), particles, around, Direction(view, 0.0)
        _, seen = sourced_radiance(*arguments, Direction(sun, 77.0), 0.0)
        assert np.all(np.isfinite(seen) & (seen >= 0.0))
        assert np.all(np.isfinite(absorbed_radiance(*arguments, 0.0)[1]))


def test_rays_that_are_too_slanted_are_refused():
    with pytest.raises(LightError, match=rf"needs \d+ slices at 1 m; allowed: {MOST_SLICES}"):
        slices_of(0.0, 3000.0, "base", 1.0, 60.0, 10.0)
