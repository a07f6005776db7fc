"""The phase function is normalised, has asymmetry g, and its Legendre moments are powers of g."""

import numpy as np
import pytest
from numpy.polynomial import legendre

from hcss_twin.physics.multiple_scattering.phase_function import henyey_greenstein

MU, WEIGHT = legendre.leggauss(400)


@pytest.mark.parametrize("g", [-0.6, 0.0, 0.5, 0.85, 0.95])
def test_legendre_moments_are_powers_of_the_asymmetry(g) -> None:
    phase = henyey_greenstein(MU, g)
    for order in range(5):
        polynomial = legendre.legval(MU, np.eye(5)[order])
        assert 0.5 * np.sum(WEIGHT * phase * polynomial) == pytest.approx(g**order, abs=1e-10)


def test_forward_and_backward_values_are_the_closed_ones() -> None:
    g = 0.8
    assert henyey_greenstein(1.0, g) == pytest.approx((1 + g) / (1 - g) ** 2, rel=1e-13)
    assert henyey_greenstein(-1.0, g) == pytest.approx((1 - g) / (1 + g) ** 2, rel=1e-13)


def test_isotropic_scattering_is_one_everywhere() -> None:
    assert np.all(henyey_greenstein(MU, 0.0) == 1.0)


@pytest.mark.parametrize(("mu", "g"), [(0.0, 1.0), (0.0, -1.2), (1.1, 0.5), (np.array([0.0, -1.5]), 0.5)])
def test_values_outside_the_domain_are_refused(mu, g) -> None:
    with pytest.raises(ValueError, match="allowed"):
        henyey_greenstein(mu, g)
