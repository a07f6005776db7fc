"""The sea against an independent integration, traced rays, and measured optical constants."""

import numpy as np
import pytest
from textbook_fresnel import real_fresnel

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.parameters import CoxMunkParameters, RoughSeaParameters
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.models.sea.cox_munk import CoxMunkSea
from hcss_twin.models.sea.rough_sea import RoughSea
from hcss_twin.providers import SeaInputs


def sea(wind: float) -> CoxMunkSea:
    return CoxMunkSea(SeaInputs(wind, 0.0, 290.0, Catalog()), CoxMunkParameters())


def emissivity_by_tilt_and_bearing(n: float, k: float, zenith_deg: float, wind: float) -> float:
    """Midpoint sums over the facet's tilt and bearing, with hidden facets left out one by one."""
    total = 0.003 + 0.00512 * wind
    theta = np.radians(zenith_deg)
    tan_tilt = (np.arange(1500) + 0.5) / 1500 * 6.0 * np.sqrt(total)
    tilt = np.arctan(tan_tilt)[:, None]
    bearing = ((np.arange(720) + 0.5) / 720 * np.pi)[None, :]
    cos_chi = np.sin(theta) * np.sin(tilt) * np.cos(bearing) + np.cos(theta) * np.cos(tilt)
    density = tan_tilt[:, None] * np.exp(-(np.tan(tilt) ** 2) / total)
    share = np.where(cos_chi > 0.0, density * cos_chi / np.cos(tilt), 0.0)
    reflectance = real_fresnel(n, k, np.maximum(cos_chi, 1e-12))
    return float(1.0 - (share * reflectance).sum() / share.sum())


@pytest.mark.parametrize("wind", [0.0, 5.0, 15.0, 40.0])
@pytest.mark.parametrize("zenith_deg", [0.0, 45.0, 70.0, 85.0])
def test_emissivity_agrees_with_a_sum_over_tilt_and_bearing(wind: float, zenith_deg: float) -> None:
    wavenumber = np.array([1e4 / 11.0])
    index = load_refractive_index(Catalog(), "water").at(wavenumber)[0]
    found = sea(wind).emissivity(wavenumber, np.array([np.cos(np.radians(zenith_deg))])).item()
    expected = emissivity_by_tilt_and_bearing(index.real, index.imag, zenith_deg, wind)
    assert found == pytest.approx(expected, abs=2e-6)


# n and k as printed by Hale and Querry (1973), Table I; the flat surface's nadir emissivity follows.
HALE_QUERRY = {3.8: (1.364, 0.0034), 10.0: (1.218, 0.0508), 11.0: (1.153, 0.0968), 12.0: (1.111, 0.199)}


@pytest.mark.parametrize("wavelength_um", sorted(HALE_QUERRY))
def test_nadir_emissivity_follows_from_the_measured_optical_constants(wavelength_um: float) -> None:
    n, k = HALE_QUERRY[wavelength_um]
    expected = 4.0 * n / ((n + 1.0) ** 2 + k**2)
    found = sea(0.0).emissivity(np.array([1e4 / wavelength_um]), np.ones(1)).item()
    assert found == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize(("zenith_deg", "wind"), [(0.0, 10.0), (40.0, 5.0), (65.0, 10.0)])
def test_brdf_agrees_with_rays_traced_on_random_facets(zenith_deg: float, wind: float) -> None:
    """Reflect many sight lines and compare the energy per bin of direction with the integrated BRDF."""
    wavenumber = np.array([1e4 / 3.8])
    index = load_refractive_index(Catalog(), "water").at(wavenumber)[0]
    theta, count = np.radians(zenith_deg), 500_000
    sight = np.array([np.sin(theta), 0.0, np.cos(theta)])
    slopes = np.random.default_rng(5).normal(0.0, np.sqrt(0.5 * (0.003 + 0.00512 * wind)), (2, count))
    normal = np.stack([-slopes[0], -slopes[1], np.ones(count)])
    area = np.sqrt(np.sum(normal**2, axis=0))
    normal /= area
    cosine = sight @ normal
    away = 2.0 * cosine * normal - sight[:, None]
    # Projected facet area per unit of horizontal area, divided by the projection of the latter.
    share = np.maximum(cosine, 0.0) * area / np.cos(theta)
    energy = share * real_fresnel(index.real, index.imag, np.maximum(cosine, 1e-12)) / count
    azimuth = np.abs(np.arctan2(away[1], away[0]))
    edges = (np.linspace(0.1, 1.0, 7), np.linspace(0.0, np.pi, 5))
    traced = np.histogram2d(away[2], azimuth, edges, weights=energy)[0]
    squared = np.histogram2d(away[2], azimuth, edges, weights=energy**2)[0]
    rays = np.histogram2d(away[2], azimuth, edges)[0]

    x, w = np.polynomial.legendre.leggauss(32)
    model = sea(wind)
    expected = np.empty_like(traced)
    for i, j in np.ndindex(*expected.shape):
        half_mu, half_azimuth = 0.5 * np.diff(edges[0])[i], 0.5 * np.diff(edges[1])[j]
        mu, phi = np.meshgrid(edges[0][i] + half_mu * (x + 1.0), edges[1][j] + half_azimuth * (x + 1.0))
        brdf = model.brdf(wavenumber, np.full(mu.size, sight[2]), mu.ravel(), phi.ravel()).reshape(mu.shape)
        # Both signs of the azimuth fall into one bin.
        expected[i, j] = 2.0 * half_mu * half_azimuth * np.sum(brdf * mu * w[None, :] * w[:, None])
    filled = rays > 100
    deviation = (traced[filled] - expected[filled]) / np.sqrt(squared[filled])
    assert np.count_nonzero(filled) >= 7
    assert np.abs(deviation).max() < 4.0
    assert traced.sum() == pytest.approx(expected.sum(), rel=3e-3)


def test_wind_lowers_emissivity_at_moderate_views_and_raises_it_toward_the_horizon() -> None:
    """As in the model of Masuda et al. (1988), where the curves for different winds cross near 70 degrees."""
    wavenumber, mu = np.array([1e4 / 11.0]), np.cos(np.radians([40.0, 60.0, 80.0]))
    calm, windy = (sea(wind).emissivity(wavenumber, mu)[:, 0] for wind in (0.0, 15.0))
    assert windy[0] < calm[0]
    assert windy[1] < calm[1]
    assert windy[2] > calm[2]


@pytest.mark.parametrize("law", ["upwind-crosswind", "gram-charlier"])
@pytest.mark.parametrize("bearing_deg", [0.0, 40.0, 90.0, 160.0, 250.0])
def test_emissivity_at_a_bearing_agrees_with_a_sum_over_slopes_in_the_winds_frame(law: str, bearing_deg: float) -> None:
    wavenumber, wind, zenith, bearing = (np.array([1e4 / 11.0]), 12.0, np.radians(70.0), np.radians(bearing_deg))
    index = load_refractive_index(Catalog(), "water").at(wavenumber)[0]
    sigma_up, sigma_cross = np.sqrt(0.00316 * wind), np.sqrt(0.003 + 0.00192 * wind)
    axis = np.linspace(-6.0, 6.0, 1201)
    eta, xi = axis[:, None], axis[None, :]
    density = np.exp(-0.5 * (eta**2 + xi**2))
    if law == "gram-charlier":
        series = 1 - (0.01 - 0.0086 * wind) / 2 * (xi**2 - 1) * eta - (0.04 - 0.033 * wind) / 6 * (eta**3 - 3 * eta)
        series = series + 0.4 / 24 * (xi**4 - 6 * xi**2 + 3) + 0.12 / 4 * (xi**2 - 1) * (eta**2 - 1)
        density = density * np.maximum(series + 0.23 / 24 * (eta**4 - 6 * eta**2 + 3), 0.0)
    toward = eta * sigma_up * np.cos(bearing) + xi * sigma_cross * np.sin(bearing)
    seen = np.maximum(np.cos(zenith) - toward * np.sin(zenith), 0.0)
    cosine = np.maximum(seen / np.sqrt(1.0 + (eta * sigma_up) ** 2 + (xi * sigma_cross) ** 2), 1e-9)
    share = density * seen
    expected = 1.0 - (share * real_fresnel(index.real, index.imag, cosine)).sum() / share.sum()
    parameters = RoughSeaParameters.model_validate(
        {"slopes": law, "foam": False, "re_reflection": False, "water_temperature": False, "salinity_psu": 0.0}
    )
    model = RoughSea(SeaInputs(wind, 0.0, 290.0, Catalog()), parameters)
    found = model.emissivity(wavenumber, np.array([np.cos(zenith)]), np.array([bearing])).item()
    assert found == pytest.approx(expected, abs=2e-5)
