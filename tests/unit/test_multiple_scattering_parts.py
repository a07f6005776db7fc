"""Streams, moments and refusals."""

import numpy as np
import pytest
from scipy.special import lpmv

from hcss_twin.physics.multiple_scattering.beams import solve_coupled_layers
from hcss_twin.physics.multiple_scattering.directions import gauss_streams, normalised_legendre
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.phase_function import delta_m, phase_function, polynomials
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun

HG = np.array([[1.0], [0.8]])


@pytest.mark.parametrize("count", [1, 2, 8, 32])
def test_streams_integrate_polynomials_over_the_hemisphere(count) -> None:
    streams = gauss_streams(count)
    for power in range(2 * count):
        assert np.sum(streams.weight * streams.mu**power) == pytest.approx(1 / (power + 1), rel=1e-12)


def test_the_flux_of_constant_radiance_is_pi() -> None:
    streams = gauss_streams(4)
    assert 2 * np.pi * np.sum(streams.mu * streams.weight) == pytest.approx(np.pi)


def test_legendre_functions_equal_the_library_s() -> None:
    mu = np.linspace(-1, 1, 9)
    for order in range(5):
        found = normalised_legendre(mu, order, 8)
        for degree in range(order, 8):
            ratio = np.prod(np.arange(degree - order + 1, degree + order + 1, dtype=float))
            expected = (-1) ** order * lpmv(order, degree, mu) / np.sqrt(ratio)
            np.testing.assert_allclose(found[degree], expected, rtol=1e-12, atol=1e-14)


def test_two_moments_stand_for_henyey_and_greenstein() -> None:
    cosine = np.linspace(-1, 1, 7)
    many = 0.6 ** np.arange(200)[:, np.newaxis]
    np.testing.assert_allclose(
        phase_function(cosine, np.array([[1.0], [0.6]])), phase_function(cosine, many), rtol=1e-10
    )


def test_scaling_keeps_absorption_and_the_moments_of_extinction() -> None:
    scaled = delta_m(np.array([[3.0]]), np.array([0.9]), HG, 16)
    assert scaled.thickness * scaled.co_albedo == pytest.approx(3.0 * 0.1)
    for degree in range(16):
        scattered = scaled.thickness * (1 - scaled.albedo * scaled.moments[degree])
        assert scattered == pytest.approx(3.0 * (1 - 0.9 * 0.8**degree))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"optical_thickness": [[-1.0]]}, r"optical_thickness -1: allowed finite, from 0; closest is 0"),
        ({"optical_thickness": [[np.inf]]}, r"optical_thickness inf: allowed finite"),
        ({"optical_thickness": [1.0]}, r"optical_thickness: shape \(1,\) given, allowed: \(T, 1\)"),
        ({"albedo": [1.2]}, r"albedo 1.2: allowed 0 to 1; closest is 1"),
        ({"albedo": [np.nan]}, r"albedo nan: allowed 0 to 1"),
        ({"moments": [[1.0], [1.0]]}, r"moments 1: allowed above -1 and below 1"),
        ({"moments": [[0.9], [0.5]]}, r"moments\[0\] 0.9: allowed 1"),
        ({"moments": [[1.0]]}, r"moments: shape \(1, 1\) given, allowed: \(K, 1\) with K from 2"),
        ({"mu_extra": [0.0]}, r"mu_extra 0: allowed above 0, to 1"),
        ({"streams": 0}, r"streams 0: allowed whole numbers from 1; closest is 1"),
        ({"streams": 7.6}, r"streams 7.6: allowed whole numbers from 1; closest is 8"),
        ({"threads": 0}, r"threads 0: allowed from 1"),
    ],
)
def test_layers_without_meaning_are_refused(change, message) -> None:
    layer = {"optical_thickness": [[1.0]], "albedo": [0.9], "moments": HG, "mu_extra": [1.0], "streams": 4}
    with pytest.raises(ValueError, match=message):
        solve_layers(**(layer | change))


def test_a_zeroth_moment_that_differs_from_1_by_rounding_counts_as_1() -> None:
    layer = {"optical_thickness": [[1.0]], "albedo": [0.9], "mu_extra": [1.0], "streams": 4}
    exact, rounded = (solve_layers(moments=np.array([[first], [0.8]]), **layer) for first in (1.0, 1.0 - 2**-52))
    np.testing.assert_array_equal(rounded.reflection, exact.reflection)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mu_sun": 0.0}, r"mu_sun 0: allowed above 0, to 1"),
        ({"mu_view": [1.1]}, r"mu_view 1.1: allowed above 0, to 1"),
        ({"relative_azimuth": [4.0]}, r"relative_azimuth 4: allowed 0 to pi; closest is 3.14159"),
        ({"relative_azimuth": [1.0, 2.0]}, r"relative_azimuth: shape \(2,\) given, allowed: \(1,\)"),
        ({"modes": 9}, r"modes 9: allowed 1 to 8, twice the streams; closest is 8"),
        ({"moments": [[1.0], [0.999]]}, r"\|moments\[1\]\| 0.999: allowed up to 0.998"),
        ({"modes": 0}, r"modes 0: allowed 1 to 8, twice the streams; closest is 1"),
        ({"mode_tolerance": -1.0}, r"mode_tolerance -1: allowed from 0, below 1; closest is 0"),
        ({"mode_tolerance": 1.0}, r"mode_tolerance 1: allowed from 0, below 1$"),
        ({"mode_tolerance": np.nan}, r"mode_tolerance nan: allowed from 0, below 1$"),
    ],
)
def test_sunlight_without_meaning_is_refused(change, message) -> None:
    case = {"optical_thickness": [[1.0]], "albedo": [0.9], "moments": HG, "mu_view": [1.0], "mu_sun": 0.5}
    case |= {"relative_azimuth": [0.0], "streams": 4, "modes": 8}
    with pytest.raises(ValueError, match=message):
        solve_sun(**(case | change))


@pytest.mark.parametrize(("cosines", "count"), [(1, 1602), (1, 3), (40, 130), (600, 130), (600, 5), (1441, 4000)])
def test_kept_polynomials_are_those_of_legendre(cosines, count) -> None:
    cosine = np.cos(np.linspace(0.1, 3.0, cosines))
    exact = np.polynomial.legendre.legvander(cosine, count - 1)
    for some in (slice(None), slice(0, 512), slice(512, 1024)):
        np.testing.assert_array_equal(polynomials(cosine, count, some), exact[some])


def test_modes_above_the_mean_over_azimuth_do_not_depend_on_it() -> None:
    whole, without = (
        solve_coupled_layers([[0.5], [2.0]], [0.9], HG, [0.7, 0.4], 4, 6, least_mode=least) for least in (0, 1)
    )
    for of_whole, of_modes in ((whole.beams, without.beams), (whole.streams, without.streams)):
        np.testing.assert_array_equal(of_modes[1:], of_whole[1:])
        assert not np.any(of_modes[0])
        assert np.any(of_whole[0])
