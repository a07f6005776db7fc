"""Phase function of crystals from diffraction, reflection and rays: against Mie theory and closed forms.

Where ice absorbs all light that enters, every convex particle of random orientation reflects like a sphere (van de
Hulst 1957, section 8.42), so that spheres, for which Mie theory is exact, are the reference for crystals.
"""

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.optics.bulk import bulk_properties
from hcss_twin.models.optics.ice_crystals import DiffractionPeaks, crystal_moments
from hcss_twin.models.optics.mie import BulkOptics
from hcss_twin.models.optics.size_distribution import gamma_distribution, mean_power, projected_area_m1, quadrature
from hcss_twin.models.optics.spheres import amplitudes
from hcss_twin.models.parameters import BulkParameters
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.physics.multiple_scattering.phase_function import henyey_greenstein, phase_function
from hcss_twin.providers import OpticsInputs

ASIDE = np.cos(np.radians([40.0, 60.0, 90.0, 120.0, 150.0, 170.0]))
CLOUD = gamma_distribution("ice", 30.0, 0.1, 1e-5)


def mie(wavelength_um: float, index: complex) -> np.ndarray:
    """Scattering cross-section per volume and solid angle times 4 pi, m-1, at ``ASIDE``."""
    wave = 2.0 * np.pi / wavelength_um
    total = np.zeros(ASIDE.size)
    for radius, number in zip(*quadrature(CLOUD, 150), strict=True):
        s1, s2 = amplitudes(index, wave * radius, ASIDE)
        total += number * 0.5 * (np.abs(s1) ** 2 + np.abs(s2) ** 2)
    return 4.0 * np.pi * total * 1e-12 / wave**2


@pytest.mark.parametrize("wavelength_um", [2.95, 3.2])
def test_where_ice_is_black_light_beside_the_peak_is_that_of_mie_theory(wavelength_um: float) -> None:
    wavelength = np.array([wavelength_um])
    ice = load_refractive_index(Catalog(), "ice")
    bulk = bulk_properties(CLOUD, ice, wavelength, 200)
    index = ice.at(1e4 / wavelength)
    exact = mie(wavelength_um, complex(index[0])) / bulk.scattering_m1
    efficiency = bulk.scattering_m1 / projected_area_m1(CLOUD)
    moments = crystal_moments(DiffractionPeaks(CLOUD), efficiency, bulk.asymmetry, index, wavelength)
    np.testing.assert_allclose(phase_function(ASIDE, moments)[0], exact, rtol=0.1)
    # With the same asymmetry, half as much goes back.
    assert henyey_greenstein(ASIDE, bulk.asymmetry[0])[4] < 0.6 * exact[4]


def test_the_diffraction_peak_is_as_high_as_the_squared_size_and_falls_like_fraunhofers() -> None:
    narrow = gamma_distribution("ice", 30.0, 0.001, 1e-5)
    wavelength = np.array([3.7])
    peaks = DiffractionPeaks(narrow)
    moments = peaks.moments(wavelength, peaks.count(wavelength))
    wave = 2.0 * np.pi / wavelength[0]
    height = wave**2 * mean_power(narrow, 4.0) / mean_power(narrow, 2.0)
    # Without the tails that Kirchhoff's factor takes away, 1.4 % more of the light is in the peak.
    assert phase_function(np.ones(1), moments)[0, 0] == pytest.approx(height, rel=0.02)
    # |2 J1(z) / z|^2 is 1/2 at z = 1.616.
    half = np.cos(1.61634 / (wave * mean_power(narrow, 3.0) / mean_power(narrow, 2.0)))
    assert phase_function(np.array([half]), moments)[0, 0] == pytest.approx(0.5 * height, rel=0.02)


def test_crystals_keep_albedo_and_asymmetry_and_their_light_is_positive_everywhere() -> None:
    nu = 1e4 / np.array([2.2, 2.75, 2.85, 3.0, 3.35, 3.7, 4.5, 8.0, 10.8, 12.6])[::-1]
    everywhere = np.cos(np.linspace(0.0, np.pi, 400))
    for radius in (6.0, 90.0):
        cloud = gamma_distribution("ice", radius, 0.1, 1e-5)
        plain, rays = (
            BulkOptics(
                OpticsInputs(Catalog()), BulkParameters(radius_nodes=50, spectral_step=0.05, ice_phase_function=each)
            ).single_scattering(cloud, nu)
            for each in ("henyey-greenstein", "diffraction-and-rays")
        )
        np.testing.assert_array_equal(rays.albedo, plain.albedo)
        np.testing.assert_allclose(rays.moments[:2], plain.moments, rtol=0.0, atol=1e-10)
        assert np.all(phase_function(everywhere, rays.moments) > 0.0)


def test_a_wavelength_has_the_same_phase_function_whatever_others_are_asked_for() -> None:
    optics = BulkOptics(
        OpticsInputs(Catalog()),
        BulkParameters(radius_nodes=50, spectral_step=0.05, ice_phase_function="diffraction-and-rays"),
    )
    alone = optics.single_scattering(CLOUD, np.array([2700.0])).moments[:, 0]
    together = optics.single_scattering(CLOUD, np.array([2700.0, 3500.0])).moments[:, 0]
    np.testing.assert_allclose(together[: alone.size], alone, rtol=1e-12)
    assert np.max(np.abs(together[alone.size :])) < 1e-6
