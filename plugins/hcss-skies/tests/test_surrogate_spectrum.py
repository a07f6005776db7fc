"""Spectra of images that are not periodic, for planes of other sizes, and under other amplitudes."""

import numpy as np
import pytest
from conftest import power_law
from hcss_skies.surrogate.template import periodic_component, plane_magnitude, underlying_magnitude
from scipy.sparse import lil_array
from scipy.sparse.linalg import spsolve
from scipy.stats import gamma, norm


def cross_excess(field):
    """Power of the modes on the axes over that of the others at the same wavenumbers, from 16 cycles up."""
    n = field.shape[0]
    power = np.abs(np.fft.fft2(field - field.mean())) ** 2
    ky, kx = np.meshgrid(np.fft.fftfreq(n) * n, np.fft.fftfreq(n) * n, indexing="ij")
    ring = np.rint(np.hypot(ky, kx)).astype(int)
    on_axis = (kx == 0) | (ky == 0)
    ratio = [power[on_axis & (ring == k)].mean() / power[~on_axis & (ring == k)].mean() for k in range(16, n // 2)]
    return float(np.mean(ratio))


def test_smooth_component_solves_its_poisson_equation():
    image = np.random.default_rng(1).normal(size=(7, 9))
    rows, columns = image.shape
    laplacian = lil_array((image.size, image.size))
    jumps = np.zeros(image.shape)
    for i in range(rows):
        for j in range(columns):
            for di, dj in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                y, x = (i + di) % rows, (j + dj) % columns
                laplacian[i * columns + j, y * columns + x] += 1.0
                laplacian[i * columns + j, i * columns + j] -= 1.0
                # A neighbour across the border: what it is more than the pixel itself is a jump.
                if not (0 <= i + di < rows and 0 <= j + dj < columns):
                    jumps[i, j] += image[y, x] - image[i, j]
    # Fix the free constant: the first equation becomes "the sum is 0".
    laplacian[0, :] = 1.0
    right = jumps.ravel().copy()
    right[0] = 0.0
    smooth = spsolve(laplacian.tocsr(), right).reshape(image.shape)
    np.testing.assert_allclose(image - periodic_component(image), smooth, atol=1e-12)


@pytest.mark.parametrize(("beta", "plain_at_least"), [(3.0, 3.0), (4.0, 20.0)])
def test_leakage_of_the_borders_is_gone(beta, plain_at_least):
    crops = [power_law((512, 512), beta, seed, cutoff=1.0)[100:356, 60:316] for seed in range(4)]
    assert np.mean([cross_excess(crop) for crop in crops]) > plain_at_least
    assert np.mean([cross_excess(periodic_component(crop)) for crop in crops]) == pytest.approx(1, abs=0.3)


def test_mirroring_would_make_lattices_of_oblique_streaks():
    y, x = np.mgrid[:128, :128]
    streaks = np.cos(2 * np.pi * (9 * x + 7 * y) / 128)
    mirrored = np.block([[streaks, streaks[:, ::-1]], [streaks[::-1], streaks[::-1, ::-1]]])
    for field, both in ((mirrored, True), (periodic_component(streaks), False)):
        power = np.abs(np.fft.fft2(field)) ** 2
        scale = field.shape[0] // 128
        along, across = power[7 * scale, 9 * scale], power[-7 * scale, 9 * scale]
        assert (across > 0.5 * along) == both


def test_magnitudes_are_those_of_the_image_with_unit_variance():
    image = 5.0 + 3.0 * np.random.default_rng(3).normal(size=(31, 40))
    magnitude = plane_magnitude(image, image.shape)
    expected = np.abs(np.fft.rfft2(image)) / image.std()
    expected[0, 0] = 0.0
    np.testing.assert_allclose(magnitude, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("shape", [(96, 130), (200, 96), (97, 131)])
def test_a_larger_plane_has_the_same_structures(shape):
    image = power_law((96, 96), 2.5, seed=4, cutoff=1.0)
    magnitude = plane_magnitude(image, shape)
    white = np.fft.rfft2(np.random.default_rng(5).normal(size=shape))
    field = np.fft.irfft2(white * magnitude / np.sqrt(shape[0] * shape[1]), s=shape)
    assert np.mean(np.fft.irfft2(magnitude**2, s=shape)[0, 0]) / (shape[0] * shape[1]) == pytest.approx(1.0)
    # Structure functions at lags that both hold many times.
    for lag in (1, 2, 4):
        for axis in (0, 1):
            ours = np.mean((field - np.roll(field, lag, axis)) ** 2)
            theirs = np.mean((image - np.roll(image, lag, axis)) ** 2)
            assert ours == pytest.approx(theirs, rel=0.2)


def test_normal_amplitudes_leave_the_magnitudes_as_they_are():
    shape = (64, 80)
    magnitude = plane_magnitude(power_law(shape, 2.0, seed=6, cutoff=1.0), shape)
    normal = np.sort(np.random.default_rng(7).normal(size=200_000))
    underlying = underlying_magnitude(magnitude, shape, normal)
    strong = magnitude > 0.05 * magnitude.max()
    np.testing.assert_allclose(underlying[strong], magnitude[strong], rtol=0.03)


def test_underlying_field_gets_the_wanted_correlation_with_lognormal_amplitudes():
    """Closed form: exp(s X) has the correlation (exp(s^2 r) - 1) / (exp(s^2) - 1)."""
    shape, s = (128, 128), 1.0
    lag = np.hypot(*np.meshgrid(np.fft.fftfreq(128) * 128, np.fft.fftfreq(128) * 128, indexing="ij"))
    normal_correlation = np.exp(-((lag / 6.0) ** 2))
    wanted = (np.exp(s**2 * normal_correlation) - 1) / (np.exp(s**2) - 1)
    magnitude = np.sqrt(np.maximum(np.fft.rfft2(wanted).real, 0.0) * wanted.size)
    magnitude[0, 0] = 0.0
    level = (np.arange(1 << 16) + 0.5) / (1 << 16)
    amplitudes = np.exp(s * norm.ppf(level))
    underlying = underlying_magnitude(magnitude, shape, amplitudes)
    found = np.fft.irfft2(underlying**2, s=shape)
    found /= found[0, 0]
    # The mean of a torus is 0, which lowers all correlations alike.
    expected = normal_correlation - normal_correlation.mean()
    expected /= expected[0, 0]
    np.testing.assert_allclose(found, expected, atol=0.01)


def test_underlying_spectrum_is_a_spectrum_where_the_wanted_pair_does_not_exist():
    shape = (64, 64)
    image = np.zeros(shape)
    image[20:24, 10:50] = 1.0
    magnitude = plane_magnitude(image, shape)
    underlying = underlying_magnitude(magnitude, shape, np.sort(image, axis=None))
    assert np.all(np.isfinite(underlying))
    assert np.all(underlying >= 0.0)
    assert np.fft.irfft2(underlying**2, s=shape)[0, 0] / image.size == pytest.approx(1.0)


def test_skewed_amplitudes_get_their_spectrum_in_the_mean():
    """Monte Carlo: without the correction the finest octave of a skewed field has a quarter too much power."""
    shape = (128, 128)
    cycles = 128 * np.hypot(np.fft.fftfreq(128)[:, None], np.fft.rfftfreq(128)[None, :])
    magnitude = (10.0**2 + cycles**2) ** -1.0
    magnitude[0, 0] = 0.0
    magnitude /= np.sqrt(np.fft.irfft2(magnitude**2, s=shape)[0, 0] / 128**2)
    amplitudes = gamma(1.0).ppf((np.arange(128**2) + 0.5) / 128**2)
    fine = (cycles >= 32) & (cycles < 64)
    rng = np.random.default_rng(9)
    found = []
    for start in (magnitude, underlying_magnitude(magnitude, shape, amplitudes)):
        total = 0.0
        for _ in range(20):
            field = np.fft.irfft2(start * np.fft.rfft2(rng.normal(size=shape)), s=shape)
            matched = np.empty(field.size)
            matched[np.argsort(field, axis=None)] = amplitudes
            total += np.sum(np.abs(np.fft.rfft2(matched.reshape(shape)))[fine] ** 2)
        found.append(total / 20 / np.sum(magnitude[fine] ** 2 * amplitudes.var()))
    plain, corrected = found
    assert plain > 1.2
    assert corrected == pytest.approx(1.0, abs=0.06)
