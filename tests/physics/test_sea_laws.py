"""Laws that the reflection and emission of any rough sea obey."""

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.parameters import CoxMunkParameters
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.models.sea.cox_munk import CoxMunkSea, mirror_facet
from hcss_twin.models.sea.facets import facet_weights, incidence_nodes
from hcss_twin.physics.fresnel import unpolarised_reflectance
from hcss_twin.providers import SeaInputs

# 14, 11, 8.5, 4, 3.1 and 2.75 um
WAVENUMBER = 1e4 / np.array([14.0, 11.0, 8.5, 4.0, 3.1, 2.75])


def sea(wind: float) -> CoxMunkSea:
    return CoxMunkSea(SeaInputs(wind, 0.0, 290.0, Catalog()), CoxMunkParameters())


def hemisphere(mu_count: int = 200, azimuth_count: int = 200) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cosines, relative azimuths and weights of cos(theta) dOmega, both halves of the azimuth."""
    x, w = np.polynomial.legendre.leggauss(mu_count)
    y, v = np.polynomial.legendre.leggauss(azimuth_count)
    mu, azimuth = np.meshgrid(0.5 * (x + 1.0), 0.5 * np.pi * (y + 1.0), indexing="ij")
    weight = mu * (0.5 * w)[:, None] * (np.pi * v)[None, :]
    return mu.ravel(), azimuth.ravel(), weight.ravel()


def test_a_nearly_flat_sea_emits_one_minus_fresnel() -> None:
    index = load_refractive_index(Catalog(), "water").at(WAVENUMBER)
    mu = np.array([0.2, 0.5, 0.8, 1.0])
    reflectance = unpolarised_reflectance(index, incidence_nodes(32)[:, None])
    found = 1.0 - facet_weights(mu, 1e-10) @ reflectance
    np.testing.assert_allclose(found, 1.0 - unpolarised_reflectance(index, mu[:, None]), rtol=0.0, atol=1e-7)


def test_emissivity_rises_steadily_to_its_nadir_value() -> None:
    mu = np.cos(np.radians(np.arange(89.0, -1.0, -1.0)))
    for wind in (0.0, 5.0):
        assert np.all(np.diff(sea(wind).emissivity(WAVENUMBER, mu), axis=0) > -1e-5)
    index = load_refractive_index(Catalog(), "water").at(WAVENUMBER)
    smooth = 1.0 - unpolarised_reflectance(index, 1.0)
    # At nadir reflectance is flat in the angle up to fourth order, so even wind hardly matters.
    np.testing.assert_allclose(sea(5.0).emissivity(WAVENUMBER, np.ones(1))[0], smooth, atol=1e-4)


@pytest.mark.parametrize(("wind", "zenith_deg", "tolerance"), [(0.0, 0.0, 1e-6), (5.0, 0.0, 1e-6), (5.0, 40.0, 1e-4)])
def test_what_is_not_emitted_is_reflected(wind: float, zenith_deg: float, tolerance: float) -> None:
    mu, azimuth, weight = hemisphere()
    view = np.cos(np.radians(zenith_deg))
    reflected = weight @ sea(wind).brdf(WAVENUMBER, np.full(mu.size, view), mu, azimuth)
    emitted = sea(wind).emissivity(WAVENUMBER, np.array([view]))[0]
    np.testing.assert_allclose(reflected + emitted, 1.0, rtol=0.0, atol=tolerance)


def test_oblique_defect_is_the_multiply_reflected_light_and_only_a_loss() -> None:
    # Light that a facet sends downward is in no direction of the BRDF: the sum falls short of 1.
    mu, azimuth, weight = hemisphere()
    view = np.cos(np.radians(60.0))
    reflected = weight @ sea(10.0).brdf(WAVENUMBER, np.full(mu.size, view), mu, azimuth)
    total = reflected + sea(10.0).emissivity(WAVENUMBER, np.array([view]))[0]
    assert np.all((total < 1.0) & (total > 0.99))


def test_glint_peaks_in_the_specular_direction() -> None:
    # A calm sea's lobe is narrow enough that the slowly varying factors hardly move its top.
    sun = np.cos(np.radians(30.0))
    zenith, azimuth = np.meshgrid(np.arange(0.0, 80.0, 0.5), np.arange(0.0, 181.0, 1.0), indexing="ij")
    mu = np.cos(np.radians(zenith.ravel()))
    field = sea(0.0).brdf(WAVENUMBER[1:2], mu, np.full(mu.size, sun), np.radians(azimuth.ravel()))[:, 0]
    top = int(np.argmax(field))
    assert azimuth.ravel()[top] == 180.0
    assert zenith.ravel()[top] == pytest.approx(30.0, abs=1.0)


@pytest.mark.parametrize("sun_deg", [0.0, 30.0, 75.0])
def test_specular_direction_needs_a_level_facet(sun_deg: float) -> None:
    mu = np.array([np.cos(np.radians(sun_deg))])
    slope_squared, cos_incidence = mirror_facet(mu, mu, np.array([np.pi]))
    assert slope_squared[0] == pytest.approx(0.0, abs=1e-30)
    assert cos_incidence[0] == pytest.approx(mu[0], rel=1e-14)


def test_mirror_facet_is_the_bisector_of_the_two_directions() -> None:
    random = np.random.default_rng(11)
    out, into = random.uniform(0.01, 1.0, (2, 300))
    azimuth = random.uniform(0.0, np.pi, 300)
    sin_out, sin_in = np.sqrt(1.0 - out**2), np.sqrt(1.0 - into**2)
    to_sensor = np.stack([sin_out, 0.0 * out, out])
    to_sun = np.stack([sin_in * np.cos(azimuth), sin_in * np.sin(azimuth), into])
    normal = (to_sensor + to_sun) / np.linalg.norm(to_sensor + to_sun, axis=0)
    slope_squared, cos_incidence = mirror_facet(out, into, azimuth)
    np.testing.assert_allclose(cos_incidence, np.sum(normal * to_sun, axis=0), rtol=1e-12)
    np.testing.assert_allclose(slope_squared, 1.0 / normal[2] ** 2 - 1.0, rtol=1e-10, atol=1e-13)
    # The scattering angle of the contract, cos = -mu mu0 - sin sin0 cos(dphi), is pi - 2 chi.
    scattering = -out * into - sin_out * sin_in * np.cos(azimuth)
    np.testing.assert_allclose(1.0 - 2.0 * cos_incidence**2, scattering, atol=1e-13)


def test_a_rougher_sea_spreads_the_glint() -> None:
    mu = np.array([0.8])
    peak = [sea(wind).brdf(WAVENUMBER, mu, mu, np.array([np.pi])) for wind in (0.0, 5.0, 10.0)]
    flank = [sea(wind).brdf(WAVENUMBER, mu, mu, np.array([np.pi / 2])) for wind in (0.0, 5.0, 10.0)]
    assert np.all(peak[0] > peak[1])
    assert np.all(peak[1] > peak[2])
    assert np.all(flank[0] < flank[1])
    assert np.all(flank[1] < flank[2])
