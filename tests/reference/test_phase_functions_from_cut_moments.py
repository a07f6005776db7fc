"""Phase functions whose moments end before the forward peak's do, against all moments and a closed form."""

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.optics.bulk import bulk_moments
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.physics.multiple_scattering.phase_function import phase_function
from hcss_twin.scenario.cloud_types import load_cloud_type

DEGREES = np.linspace(15.0, 170.0, 311)
EVERYWHERE = np.linspace(0.0, 180.0, 1441)


def summed(moments, degrees):
    """The series (P,) as it is, of moments (K,)."""
    terms = (2 * np.arange(moments.size) + 1) * moments
    return np.polynomial.legendre.legval(np.cos(np.radians(degrees)), terms)


@pytest.mark.parametrize(
    ("name", "wavelength_um"),
    [("cirrus", 3.094), ("stratus", 2.2), ("stratus", 1.7), ("stratus", 1.2), ("cumulus", 1.0), ("stratus", 0.75)],
)
def test_128_moments_give_the_phase_function_of_spheres_beside_its_forward_peak(name, wavelength_um) -> None:
    cloud_type = load_cloud_type(name, Catalog())
    phase = cloud_type.layer.material
    cloud, index = cloud_type.microphysics.particles(phase), load_refractive_index(Catalog(), phase)
    moments = bulk_moments(cloud, index, np.array([wavelength_um]), 400, 640)
    assert abs(moments[-1, 0]) < 1e-5  # all there are
    exact = summed(moments[:, 0], DEGREES)
    cut = moments[:128]
    found = phase_function(np.cos(np.radians(DEGREES)), cut)[0]
    np.testing.assert_allclose(found, exact, rtol=0.045)
    # The sum itself is worth less.
    assert np.max(np.abs(summed(cut[:, 0], DEGREES) / exact - 1.0)) > 5.0 * np.max(np.abs(found / exact - 1.0))
    away = EVERYWHERE > 2.0
    assert np.all(phase_function(np.cos(np.radians(EVERYWHERE[away])), cut) > 0.0)


@pytest.mark.parametrize("g", [0.9, 0.95, 0.98])
def test_few_moments_of_henyey_and_greenstein_give_their_closed_form(g) -> None:
    moments = g ** np.arange(64.0)[:, np.newaxis]
    cosine = np.cos(np.radians(DEGREES))
    closed = phase_function(cosine, moments[:2])
    assert np.max(np.abs(summed(moments[:, 0], DEGREES) / closed[0] - 1.0)) > 0.5
    np.testing.assert_allclose(phase_function(cosine, moments), closed, rtol=0.02)


def test_a_sum_that_is_negative_is_mended_whatever_its_last_moment_is() -> None:
    moments = 0.9 ** np.arange(64.0)[:, np.newaxis]
    moments[-1] = 1.05 * moments[-2]  # not fading
    cosine = np.cos(np.radians(DEGREES))
    assert np.min(summed(moments[:, 0], EVERYWHERE)) < 0.0
    np.testing.assert_allclose(phase_function(cosine, moments), phase_function(cosine, moments[:2]), rtol=0.06)


@pytest.mark.parametrize(
    "moments",
    [np.array([1.0, 0.0, 0.1]), 0.6 ** np.arange(60.0), 0.9 ** np.arange(400.0), np.array([1.0, 0.2, 0.15])],
    ids=["Rayleigh", "smooth", "peaked", "few"],
)
def test_moments_that_are_all_there_are_summed_as_they_are(moments) -> None:
    found = phase_function(np.cos(np.radians(EVERYWHERE)), moments[:, np.newaxis])[0]
    np.testing.assert_allclose(found, summed(moments, EVERYWHERE), rtol=1e-12)


def test_straight_on_it_stays_finite_and_continuous() -> None:
    moments = 0.99 ** np.arange(64.0)[:, np.newaxis]
    cosine = 1.0 - np.concatenate(([0.0], np.geomspace(1e-12, 1e-2, 4001)))
    found = phase_function(cosine, moments)[0]
    assert found[0] > 0.9 * summed(moments[:, 0], 0.0)
    assert np.max(np.abs(np.diff(found))) < 5e-3 * found[0]


def test_a_phase_function_does_not_depend_on_which_others_are_asked_for() -> None:
    cut, whole = 0.97 ** np.arange(64.0), 0.5 ** np.arange(64.0)
    cosine = np.cos(np.radians(DEGREES))
    both = phase_function(cosine, np.stack((cut, whole), axis=1))
    for row, each in zip(both, (cut, whole), strict=True):
        np.testing.assert_allclose(row, phase_function(cosine, each[:, np.newaxis])[0], rtol=1e-13)
