"""Laws of Monte Carlo radiance, closed forms, and published values of a step cloud."""

import numpy as np
import pytest
from hcss_light.monte_carlo import Sunlight, radiance
from hcss_light.voxels import LightError, ScatteringTable, Voxels, henyey_greenstein

from hcss_twin.physics.multiple_scattering.sunlight import solve_sun

ISOTROPIC = ScatteringTable([-1.0, 1.0], [1.0, 1.0])


def broken(**changes):
    """Clouds of optical thickness 0 to 6 over half of an area, with gas."""
    thickness = np.random.default_rng(1).uniform(0.0, 6.0, (6, 5, 4)) * (np.arange(6) % 2)[:, None, None]
    given = {"albedo": 0.7, "gas": np.full(4, 1e-4), "source": np.zeros(4)} | changes
    return Voxels(thickness / 400.0, np.arange(5) * 100.0, (150.0, 80.0), **given)


def step_cloud(albedo):
    """I3RC phase I, case 1: cells of 15.625 m, optical thickness 2 and 18, 250 m thick, black ground."""
    thickness = np.repeat([2.0, 18.0], 16)
    return Voxels((thickness / 250.0)[:, None, None], [0.0, 250.0], (15.625, 15.625), albedo, [0.0], [0.0])


def mean_of(found):
    """Mean over the domain, and its standard error."""
    mean, error = found
    return mean.mean(), np.sqrt(np.sum(error**2)) / mean.size


@pytest.mark.parametrize("zenith", [0.0, 60.0, 85.0])
def test_an_isothermal_enclosure_is_black(zenith):
    """Broken cloud, gas, grey surface and sky of one temperature."""
    warm = broken(source=np.ones(4), surface_albedo=0.4, surface_source=1.0, sky_source=1.0)
    mean, error = radiance(warm, henyey_greenstein(0.85), view_zenith_deg=zenith, view_azimuth_deg=30.0, photons=2000)
    assert np.all(np.abs(mean - 1.0) <= 5.0 * error + 1e-12)
    assert error.max() < 1e-3  # Russian roulette alone


def test_columns_of_gas_have_the_radiance_of_the_integral():
    gas, source, slant = np.array([2e-3, 1e-3, 5e-4]), np.array([3.0, 2.0, 1.0]), 1.0 / np.cos(np.radians(50.0))
    voxels = Voxels(np.zeros((1, 1, 3)), [0.0, 200.0, 500.0, 1500.0], (1e3, 1e3), 0.0, gas, source, 0.0, 5.0)
    depth = slant * gas * np.diff(voxels.edges_m)
    above = np.cumsum(depth[::-1])[::-1] - depth
    exact = 5.0 * np.exp(-depth.sum()) + np.sum(source * (1.0 - np.exp(-depth)) * np.exp(-above))
    mean, error = mean_of(radiance(voxels, ISOTROPIC, view_zenith_deg=50.0, photons=100_000))
    assert abs(mean - exact) < 4.0 * error


def chandrasekhar_h(mu, albedo):
    """H function of isotropic scattering (Radiative Transfer, 1960, sec. 39), by iteration."""
    node, weight = np.polynomial.legendre.leggauss(64)
    node, weight = 0.5 * (node + 1.0), 0.5 * weight
    values = np.ones_like(node)
    for _ in range(200):
        integral = np.sum(weight * node * values / (node[:, None] + node), axis=1)
        values = 1.0 / (np.sqrt(1.0 - albedo) + 0.5 * albedo * integral)
    return 1.0 / (np.sqrt(1.0 - albedo) + 0.5 * albedo * np.sum(weight * node * values / (mu + node)))


@pytest.mark.parametrize(("view", "sun"), [(0.0, 0.0), (60.0, 30.0)])
def test_thick_isotropic_clouds_reflect_as_chandrasekhar_found(view, sun):
    albedo, up, down = 0.9, np.cos(np.radians(view)), np.cos(np.radians(sun))
    exact = albedo / (4.0 * np.pi) * down / (up + down) * chandrasekhar_h(up, albedo) * chandrasekhar_h(down, albedo)
    thick = Voxels(np.full((2, 2, 1), 0.1), [0.0, 400.0], (100.0, 100.0), albedo, [0.0], [0.0])
    found = radiance(thick, ISOTROPIC, view_zenith_deg=view, sun=Sunlight(sun, 70.0, 1.0), photons=20_000)
    mean, error = mean_of(found)
    assert abs(mean - exact) < 4.0 * error
    assert error < 5e-3 * exact


def test_means_over_the_domain_are_reciprocal():
    clouds, table = broken(), henyey_greenstein(0.6)
    one = mean_of(radiance(clouds, table, view_zenith_deg=20.0, sun=Sunlight(65.0, 120.0, 1.0), photons=20_000))
    other = mean_of(
        radiance(
            clouds, table, view_zenith_deg=65.0, view_azimuth_deg=120.0, sun=Sunlight(20.0, 0.0, 1.0), photons=20_000
        )
    )
    down = np.cos(np.radians([65.0, 20.0]))
    assert abs(one[0] / down[0] - other[0] / down[1]) < 4.0 * np.hypot(one[1] / down[0], other[1] / down[1])


@pytest.mark.parametrize(("thickness", "sun", "view"), [(2.0, 0.0, 60.0), (18.0, 0.0, 0.0), (18.0, 60.0, 0.0)])
def test_uniform_clouds_reflect_as_adding_doubling_finds(thickness, sun, view):
    up, down = np.cos(np.radians([view, sun]))
    layer = np.array([[thickness]]), np.array([1.0]), np.array([[1.0], [0.85]])
    brdf, _ = solve_sun(*layer, np.array([up]), float(down), np.array([0.0]), 64, 64, kept_moments=64)
    uniform = Voxels(np.full((4, 4, 1), thickness / 250.0), [0.0, 250.0], (100.0, 100.0), 1.0, [0.0], [0.0])
    table = henyey_greenstein(0.85)
    found = radiance(uniform, table, view_zenith_deg=view, sun=Sunlight(sun, 0.0, 1.0), photons=5_000)
    mean, error = mean_of(found)
    assert abs(mean / down - brdf.item()) < 3.5 * error / down
    assert error / down < 0.02 * brdf.item()


# Means over the 32 cells of the consensus results of I3RC phase I (Cahalan et al., BAMS 86, 1275-1293, 2005), case 1.
@pytest.mark.parametrize(
    ("albedo", "sun", "view", "azimuth", "published"),
    [
        (1.0, 0.0, None, 0.0, 0.32760),
        (1.0, 0.0, 60.0, 0.0, 0.40425),
        (1.0, 60.0, None, 0.0, 0.58044),
        (0.99, 60.0, None, 0.0, 0.47654),
        (0.99, 60.0, 60.0, 0.0, 0.88616),
    ],
)
def test_a_step_cloud_reflects_as_published(albedo, sun, view, azimuth, published):
    found = radiance(
        step_cloud(albedo), henyey_greenstein(0.85), view_zenith_deg=view, view_azimuth_deg=azimuth,
        sun=Sunlight(sun, 180.0, 1.0), photons=4000, seed=3,
    )  # fmt: skip
    mean, error = (np.pi * estimate / np.cos(np.radians(sun)) for estimate in mean_of(found))
    assert abs(mean - published) < 3e-3 * published + 3.0 * error
    assert error < 0.015 * published


def test_a_step_cloud_seen_within_3_deg_of_nadir_has_the_published_nadir_radiance():
    """The consensus for nadir is that of a cone: single cells at the step say so, and the mean follows."""
    draws = []
    for number in range(40):
        zenith = np.degrees(np.arcsin(np.sqrt((number + 0.5) / 40.0) * np.sin(np.radians(3.0))))
        found = radiance(
            step_cloud(1.0), henyey_greenstein(0.85), view_zenith_deg=zenith, view_azimuth_deg=222.49 * number,
            sun=Sunlight(0.0, 180.0, 1.0), photons=150, seed=number,
        )  # fmt: skip
        draws.append(mean_of(found))
    mean, error = (
        np.pi * np.mean([estimate for estimate, _ in draws]),
        np.pi * np.sqrt(np.sum(np.square(draws), axis=0)[1]) / 40.0,
    )
    assert abs(mean - 0.25640) < 3e-3 * 0.25640 + 3.0 * error
    assert error < 0.01 * 0.25640


def test_angles_are_drawn_from_the_table():
    """The mean cosine of Henyey and Greenstein's function is its asymmetry: once scattered light in a thin layer."""
    for asymmetry in (-0.5, 0.0, 0.85, 0.98):
        table = henyey_greenstein(asymmetry)
        assert np.trapezoid(table.phase * table.cosine, table.cosine) / 2.0 == pytest.approx(asymmetry, abs=2e-4)
        assert np.all(np.diff(table.cumulative) > 0.0)


def test_the_same_seed_gives_the_same_bits_and_another_one_others():
    first, again, other = (
        radiance(broken(), ISOTROPIC, view_zenith_deg=0.0, sun=Sunlight(30.0, 0.0, 1.0), photons=50, seed=seed)[0]
        for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, again)
    assert np.any(first != other)


@pytest.mark.parametrize(
    ("clouds", "view", "sun"),
    [
        ({"albedo": 1.0, "gas": np.zeros(4)}, 89.0, 89.0),
        ({"albedo": 0.0}, 0.0, 0.0),
        ({"albedo": 1.0 - 1e-12, "surface_albedo": 1.0}, 45.0, 89.9),
        ({"gas": np.full(4, 1e6)}, 0.0, 45.0),
    ],
    ids=["grazing, conservative", "black", "nothing absorbs", "opaque gas"],
)
def test_extreme_clouds_have_finite_radiance(clouds, view, sun):
    mean, error = radiance(
        broken(**clouds), henyey_greenstein(0.99), view_zenith_deg=view, sun=Sunlight(sun, 0.0, 1.0), photons=20
    )
    assert np.all(np.isfinite(mean) & np.isfinite(error) & (mean >= 0.0))


def test_what_is_not_allowed_is_named():
    with pytest.raises(LightError, match=r"albedo: 1\.5; allowed: 0 to 1; closest is 1"):
        broken(albedo=1.5)
    with pytest.raises(LightError, match="view: zenith 90"):
        radiance(broken(), ISOTROPIC, view_zenith_deg=90.0)
    with pytest.raises(LightError, match="edges_m: 5 values; allowed: 4, ascending"):
        Voxels(np.zeros((1, 1, 3)), np.arange(5.0), (1.0, 1.0), 1.0, np.zeros(3), np.zeros(3))
