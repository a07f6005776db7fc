"""Moments of the modified gamma distribution against closed forms, quadrature and published clouds."""

import math

import numpy as np
import pytest
from scipy import integrate

from hcss_twin.models.optics import size_distribution as size
from hcss_twin.providers import Microphysics

C1 = Microphysics("water", 6.0, 1.5, 1.0, 100e6, (0.0, math.inf))
STRATUS = Microphysics("water", 3.0, 0.193, 1.30, 80e6, (0.02, 50.0))
CUMULUS = Microphysics("water", 4.0, 0.00713, 2.34, 65e6, (0.02, 50.0))
TAIL = Microphysics("ice", 7.0, 1.0 / 3.0, 1.0, 1e5, (60.0, 70.0))


def test_gamma_distribution_has_factorial_moments() -> None:
    # nu = 1: <r^p> = (alpha + p)! / alpha! / b^p for whole numbers.
    for power in (1, 2, 3, 4):
        expected = math.factorial(6 + power) / math.factorial(6) / 1.5**power
        assert size.mean_power(C1, power) == pytest.approx(expected, rel=1e-12)


def test_cloud_c1_has_the_effective_radius_and_variance_of_hansen_and_travis() -> None:
    # n ~ r^((1 - 3v)/v) exp(-r / (R v)): alpha 6, b 1.5 is R = 6 um, v = 1/9.
    assert size.effective_radius_um(C1) == pytest.approx(6.0, rel=1e-12)
    assert size.effective_variance(C1) == pytest.approx(1.0 / 9.0, rel=1e-12)
    assert size.water_content_kg_m3(C1) == pytest.approx(0.063e-3, rel=0.01)


@pytest.mark.parametrize(("cloud", "radius", "content"), [(STRATUS, 11.30, 0.30), (CUMULUS, 12.68, 0.44)])
def test_opac_clouds_have_their_published_effective_radius_and_water(cloud, radius, content) -> None:
    # Hess et al. (1998), Table 1b; the coefficients are printed with three digits.
    assert size.effective_radius_um(cloud) == pytest.approx(radius, rel=0.003)
    assert size.water_content_kg_m3(cloud) * 1e3 == pytest.approx(content, rel=0.01)


@pytest.mark.parametrize("cloud", [STRATUS, CUMULUS, TAIL])
@pytest.mark.parametrize("power", [0.0, 2.0, 3.5])
def test_truncated_moments_equal_numerical_integrals(cloud, power) -> None:
    low, high = cloud.radius_range_um
    value, _ = integrate.quad(
        lambda r: float(size.density(cloud, np.array(r))) * r**power, low, high, epsrel=1e-11, limit=200
    )
    assert size.mean_power(cloud, power) * cloud.number_density_m3 == pytest.approx(value, rel=1e-8)


@pytest.mark.parametrize("cloud", [C1, STRATUS, CUMULUS, TAIL])
def test_quadrature_nodes_reproduce_area_and_volume(cloud) -> None:
    radius, number = size.quadrature(cloud, 100)
    for power in (2.0, 3.0, 6.0):
        expected = cloud.number_density_m3 * size.mean_power(cloud, power)
        assert np.sum(number * radius**power) == pytest.approx(expected, rel=3e-7)


def test_density_vanishes_outside_the_radius_range() -> None:
    assert np.all(size.density(STRATUS, np.array([0.01, 50.1])) == 0.0)


@pytest.mark.parametrize(
    ("field", "value"),
    [("alpha", -1.0), ("b", 0.0), ("nu", -1.0), ("number_density_m3", -1.0), ("radius_range_um", (5.0, 5.0))],
)
def test_impossible_distribution_is_refused_by_name(field, value) -> None:
    values = {**STRATUS.__dict__, field: value}
    with pytest.raises(ValueError, match=field):
        size.mean_power(Microphysics(**values), 2.0)
