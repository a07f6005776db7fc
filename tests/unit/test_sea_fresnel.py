"""Fresnel reflectance against closed forms that the implementation does not use."""

import numpy as np
import pytest

from hcss_twin.physics.fresnel import unpolarised_reflectance


def test_at_brewsters_angle_only_the_perpendicular_half_is_reflected() -> None:
    n = 1.5
    expected = 0.5 * ((n**2 - 1) / (n**2 + 1)) ** 2
    assert unpolarised_reflectance(n, np.cos(np.arctan(n))) == pytest.approx(expected, rel=1e-13)


def test_everything_is_reflected_toward_grazing_incidence() -> None:
    assert unpolarised_reflectance(1.3 + 0.1j, 1e-9) == pytest.approx(1.0, abs=1e-7)


def test_an_index_of_one_reflects_nothing() -> None:
    assert np.all(unpolarised_reflectance(1.0 + 0j, np.array([1e-3, 0.5, 1.0])) < 1e-18)


def test_transparent_medium_follows_the_sine_and_tangent_laws() -> None:
    incidence = np.radians([10.0, 35.0, 60.0, 85.0])
    refracted = np.arcsin(np.sin(incidence) / 1.333)
    perpendicular = (np.sin(incidence - refracted) / np.sin(incidence + refracted)) ** 2
    parallel = (np.tan(incidence - refracted) / np.tan(incidence + refracted)) ** 2
    found = unpolarised_reflectance(1.333, np.cos(incidence))
    np.testing.assert_allclose(found, 0.5 * (perpendicular + parallel), rtol=1e-12)


@pytest.mark.parametrize("mu", [0.0, -0.1, 1.0000001, np.nan])
def test_cosine_outside_its_range_is_refused(mu: float) -> None:
    with pytest.raises(ValueError, match="cos_incidence"):
        unpolarised_reflectance(1.33, mu)
