"""Laws that the optical properties of a cloud obey whatever the particles."""

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.optics.bulk import bulk_properties
from hcss_twin.models.optics.mie import MieOptics
from hcss_twin.models.optics.size_distribution import gamma_distribution
from hcss_twin.models.optics.spheres import mie_efficiencies
from hcss_twin.models.parameters import MieParameters
from hcss_twin.models.refractive_index import RefractiveIndex, load_refractive_index
from hcss_twin.providers import Microphysics, Optics, OpticsInputs

STRATUS = Microphysics("water", 3.0, 0.193, 1.30, 80e6, (0.02, 50.0))
CUMULUS = Microphysics("water", 4.0, 0.00713, 2.34, 65e6, (0.02, 50.0))
CIRRUS = Microphysics("ice", 7.0, 1.0 / 3.0, 1.0, 0.13e6, (1.0, 150.0))
BANDS_UM = ((2.7, 3.0), (3.0, 5.0), (8.0, 14.0))


@pytest.fixture(scope="module")
def optics() -> MieOptics:
    return MieOptics(OpticsInputs(Catalog()), MieParameters())


def test_large_spheres_remove_twice_their_shadow() -> None:
    # Q_ext -> 2 as 2 + c x^(-2/3) (edge term; Nussenzveig and Wiscombe, Phys. Rev. Lett. 45, 1490 (1980)).
    x = np.array([1000.0, 8000.0])
    q_ext = mie_efficiencies(np.full(2, 1.33 + 0.1j), x)[0]
    assert q_ext[0] == pytest.approx(2.0 + 1.9924 * x[0] ** (-2 / 3), abs=5e-4)
    assert (q_ext[0] - 2.0) / (q_ext[1] - 2.0) == pytest.approx(4.0, rel=0.02)


def test_window_properties_of_a_10_um_cloud_are_those_of_hu_and_stamnes() -> None:
    # Y. X. Hu and K. Stamnes, J. Climate 6, 728 (1993), at 10.8 um: 129.8 m2/kg, albedo .522, asymmetry .923,
    # fitted over size distributions. Effective variance 0.172 is the closest of the usual ones.
    cloud = gamma_distribution("water", 10.0, 0.172, 1e-3)
    bulk = bulk_properties(cloud, load_refractive_index(Catalog(), "water"), np.array([10.8]), 200)
    assert bulk.extinction_m1[0] / 1e-3 == pytest.approx(129.8, rel=0.004)
    assert bulk.albedo[0] == pytest.approx(0.522, rel=0.012)
    assert bulk.asymmetry[0] == pytest.approx(0.923, rel=0.001)


def test_narrower_distributions_extinguish_little_more_at_equal_effective_radius() -> None:
    index = load_refractive_index(Catalog(), "water")
    narrow = bulk_properties(gamma_distribution("water", 10.0, 0.1, 1e-3), index, np.array([10.8]), 200)
    assert narrow.extinction_m1[0] / 1e-3 == pytest.approx(129.8, rel=0.031)


def test_coefficients_are_proportional_to_the_number_of_particles(optics) -> None:
    nu = np.array([900.0, 2600.0])
    double = Microphysics(**{**STRATUS.__dict__, "number_density_m3": 2 * STRATUS.number_density_m3})
    once, twice = optics.single_scattering(STRATUS, nu), optics.single_scattering(double, nu)
    np.testing.assert_allclose(twice.extinction_m1, 2 * once.extinction_m1, rtol=1e-11)
    np.testing.assert_allclose(twice.albedo, once.albedo, rtol=1e-11)
    np.testing.assert_allclose(twice.moments, once.moments, rtol=1e-11)


@pytest.mark.parametrize("cloud", [STRATUS, CUMULUS, CIRRUS])
def test_interpolation_and_quadrature_stay_below_two_parts_in_ten_thousand(optics, cloud) -> None:
    generator = np.random.default_rng(3)
    wavelength = np.concatenate([generator.uniform(*band, 2) for band in BANDS_UM])
    index = load_refractive_index(Catalog(), cloud.material)
    exact = bulk_properties(cloud, index, wavelength, 600)
    result = optics.single_scattering(cloud, 1e4 / wavelength)
    np.testing.assert_allclose(result.extinction_m1, exact.extinction_m1, rtol=2e-4)
    np.testing.assert_allclose(result.extinction_m1 * (1 - result.albedo), exact.absorption_m1, rtol=2e-4)
    np.testing.assert_allclose(result.moments[1], exact.asymmetry, rtol=2e-4)


def test_provider_fits_the_contract_and_refuses_what_it_does_not_cover(optics) -> None:
    assert isinstance(optics, Optics)
    with pytest.raises(ValueError, match=r"closest is 33333\.3"):
        optics.single_scattering(STRATUS, np.array([1000.0, 34000.0]))
    with pytest.raises(ValueError, match="number_density_m3"):
        optics.single_scattering(Microphysics(**{**STRATUS.__dict__, "number_density_m3": 0.0}), np.array([900.0]))


def test_refractive_index_is_linear_in_the_logarithm_of_wavelength() -> None:
    index = RefractiveIndex("two", np.array([1.0, 4.0]), np.array([1.2, 1.4]), np.array([1e-4, 1e-2]))
    assert index.at(np.array([5000.0]))[0] == pytest.approx(1.3 + 1e-3j, rel=1e-12)
    with pytest.raises(ValueError, match=r"covers 2500 to 10000 cm-1"):
        index.at(np.array([2000.0]))


def test_only_the_table_of_the_cloud_at_hand_is_read() -> None:
    catalog = Catalog()
    MieOptics(OpticsInputs(catalog), MieParameters()).single_scattering(STRATUS, np.array([1000.0]))
    assert list(catalog.used) == ["optical_constants/water.csv", "optics/mie-stratus.nc"]
