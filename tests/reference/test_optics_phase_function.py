"""Scattering amplitudes, phase functions and their moments against published tables and another library."""

import miepython
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import special

from hcss_twin.models.optics.spheres import (
    MomentSums,
    amplitudes,
    legendre_polynomials,
    mie_efficiencies,
    phase_function,
)

# C. F. Bohren and D. R. Huffman (1983), Appendix A, printed output of BHMIE: water drop of index 1.55, radius 0.525 um,
# wavelength 0.6328 um. Angle (deg), S11 / S11(0), POL = -S12 / S11, S33 / S11, S34 / S11.
BOHREN_HUFFMAN = [
    (0, 1.00000, 0.0, 1.00000, 0.0),
    (9, 0.785390, -0.459811e-2, 0.999400, 0.343261e-1),
    (18, 0.356897, -0.458541e-1, 0.986022, 0.160184),
    (27, 0.766119e-1, -0.364744, 0.843603, 0.394076),
    (36, 0.355355e-1, -0.534997, 0.686967, -0.491787),
    (45, 0.701845e-1, 0.959953e-2, 0.959825, -0.280434),
    (54, 0.574313e-1, 0.477927e-1, 0.985371, 0.163584),
    (63, 0.219660e-1, -0.440604, 0.648043, 0.621216),
    (72, 0.125959e-1, -0.831996, 0.203255, -0.516208),
    (81, 0.173750e-1, 0.341670e-1, 0.795354, -0.605182),
    (90, 0.124601e-1, 0.230462, 0.937497, 0.260742),
    (99, 0.679093e-2, -0.713472, -0.717397e-2, 0.700647),
    (108, 0.954239e-2, -0.756255, -0.394748e-1, -0.653085),
    (117, 0.863419e-2, -0.281215, 0.536251, -0.795835),
    (126, 0.227421e-2, -0.239612, 0.967602, 0.795798e-1),
    (135, 0.543998e-2, -0.850804, 0.187531, -0.490882),
    (144, 0.160243e-1, -0.706334, 0.495254, -0.505781),
    (153, 0.188852e-1, -0.891081, 0.453277, -0.226817e-1),
    (162, 0.195254e-1, -0.783319, -0.391613, 0.482752),
    (171, 0.301676e-1, -0.196194, -0.962069, 0.189556),
    (180, 0.383189e-1, 0.0, -1.00000, 0.0),
]

# W. J. Wiscombe, NCAR/TN-140+STR (1979, revised 1996), time factor exp(+i omega t): index, x, S1 forward and backward.
WISCOMBE = [
    (1.5 + 1j, 1.0, 5.84080e-1 + 1.90515e-1j, 3.48844e-1 + 1.46829e-1j),
    (1.33 + 1e-5j, 100.0, 5.25330e3 - 1.24319e2j, -5.65921e1 + 4.65097e1j),
    (1.5 + 1j, 100.0, 5.24375e3 - 2.93417e2j, -2.02936e1 + 4.38444e0j),
]


def test_matrix_elements_equal_the_printed_output_of_bohren_and_huffman() -> None:
    table = np.array(BOHREN_HUFFMAN)
    s1, s2 = amplitudes(1.55 + 0j, 2.0 * np.pi * 0.525 / 0.6328, np.cos(np.radians(table[:, 0])))
    s11 = 0.5 * (abs(s1) ** 2 + abs(s2) ** 2)
    found = [
        s11 / s11[0],
        0.5 * (abs(s1) ** 2 - abs(s2) ** 2) / s11,
        (s2 * s1.conjugate()).real / s11,
        (s2 * s1.conjugate()).imag / s11,
    ]
    for ours, printed in zip(found, table.T[1:], strict=True):
        np.testing.assert_allclose(ours, printed, rtol=2e-6, atol=1e-6)


@pytest.mark.parametrize(("index", "x", "forward", "backward"), WISCOMBE)
def test_amplitudes_equal_the_tables_of_wiscombe(index, x, forward, backward) -> None:
    s1, s2 = (each.conjugate() for each in amplitudes(index, x, np.array([1.0, -1.0])))
    for found, printed in ((s1[0], forward), (s1[1], backward)):
        assert found.real == pytest.approx(printed.real, rel=3e-6)
        assert found.imag == pytest.approx(printed.imag, rel=3e-6)
    assert s2[0] == pytest.approx(s1[0], rel=1e-12)
    assert s2[1] == pytest.approx(-s1[1], rel=1e-9)


def test_amplitudes_equal_another_library() -> None:
    generator = np.random.default_rng(3)
    mu = np.cos(np.linspace(0.0, np.pi, 61))
    for _ in range(12):
        x = float(10.0 ** generator.uniform(-1.0, 2.3))
        index = generator.uniform(1.1, 1.7) + 1j * 10.0 ** generator.uniform(-6.0, 0.0)
        theirs = miepython.S1_S2(index.conjugate(), x, mu, norm="wiscombe")
        for ours, other in zip(amplitudes(index, x, mu), theirs, strict=True):
            np.testing.assert_allclose(ours.conjugate(), other, rtol=1e-7, atol=1e-8 * abs(other[0]))


@settings(deadline=None, max_examples=25)
@given(x=st.floats(0.05, 120.0), n=st.floats(1.05, 1.8), log_k=st.floats(-8.0, 0.0))
def test_the_optical_theorem_holds(x, n, log_k) -> None:
    index = complex(n, 10.0**log_k)
    forward = amplitudes(index, x, np.array([1.0]))[0][0]
    q_ext = mie_efficiencies(np.array([index]), np.array([x]))[0][0]
    assert 4.0 / x**2 * forward.real == pytest.approx(q_ext, rel=1e-9)


@settings(deadline=None, max_examples=25)
@given(x=st.floats(0.05, 120.0), n=st.floats(1.05, 1.8), log_k=st.floats(-8.0, 0.0))
def test_moment_one_is_the_asymmetry_of_the_series(x, n, log_k) -> None:
    index = complex(n, 10.0**log_k)
    moments = MomentSums(16)(index, np.array([x]), np.ones(1))
    asymmetry = mie_efficiencies(np.array([index]), np.array([x]))[2][0]
    assert moments[0] == 1.0
    assert moments[1] == pytest.approx(asymmetry, abs=1e-8)
    assert np.all(np.abs(moments) <= 1.0)


def test_small_spheres_scatter_as_rayleigh_says() -> None:
    mu = np.linspace(-1.0, 1.0, 21)
    moments = MomentSums(8)(1.33 + 1e-6j, np.array([1e-3]), np.ones(1))
    np.testing.assert_allclose(moments, [1.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(phase_function(moments[:, np.newaxis], mu)[:, 0], 0.75 * (1 + mu**2), atol=1e-5)


def test_moments_rebuild_the_phase_function_of_spheres_of_many_sizes() -> None:
    size = np.linspace(3.0, 25.0, 300)
    number = size**4 * np.exp(-0.4 * size)
    index = 1.33 + 0.01j
    moments = MomentSums(128)(index, size, number)
    mu = np.cos(np.linspace(0.0, np.pi, 91))
    intensity = np.zeros_like(mu)
    for x, weight in zip(size, number, strict=True):
        s1, s2 = amplitudes(index, float(x), mu)
        intensity += weight * 0.5 * (abs(s1) ** 2 + abs(s2) ** 2)
    q_sca = mie_efficiencies(np.full(size.size, index), size)[1]
    direct = 4.0 * intensity / np.sum(number * q_sca * size**2)
    rebuilt = phase_function(moments[:, np.newaxis], mu)[:, 0]
    np.testing.assert_allclose(rebuilt, direct, rtol=1e-8)
    assert np.all(rebuilt > 0.0)


def test_legendre_polynomials_equal_those_of_scipy() -> None:
    mu = np.linspace(-1.0, 1.0, 33)
    for degree, values in enumerate(legendre_polynomials(mu, 40)):
        np.testing.assert_allclose(values, special.eval_legendre(degree, mu), atol=1e-12)
