"""Features of patches against closed forms."""

import numpy as np
import pytest
from hcss_evaluate.realism.coherence import coherence, correlation_by_band, motion
from hcss_evaluate.realism.contours import components, euler_number, perimeter
from hcss_evaluate.realism.copies import Example, largest_correlations
from hcss_evaluate.realism.features import all_features
from hcss_evaluate.realism.gradients import gradient_features
from hcss_evaluate.realism.increments import LAGS, increment_features, structure_function
from hcss_evaluate.realism.moments import histogram_features, standard_moment
from hcss_evaluate.realism.patches import cut_patches, z_scored
from hcss_evaluate.realism.scales import autocorrelation_length, band_features
from hcss_evaluate.realism.spectrum import power_by_ring, spectral_features
from random_fields import power_law
from scipy.signal import lfilter

WHITE = np.random.default_rng(0).standard_normal((40, 64, 64))
COARSE = {"size": 64, "blur_pixels": 0.0, "noise_k": 0.0}


def test_white_noise_has_its_variance_in_every_ring_and_no_direction():
    _, density, anisotropy = power_by_ring(3.0 * np.random.default_rng(0).standard_normal((400, 64, 64)))
    np.testing.assert_allclose(density.mean(axis=0), 9.0, rtol=0.06)
    assert anisotropy.mean() < 0.25


@pytest.mark.parametrize("slope", [-2.0, -3.0])
def test_a_power_law_has_its_slope_and_no_curvature(slope):
    rng = np.random.default_rng(1)
    patches = np.stack([power_law(rng, slope)[:64, :64] for _ in range(40)])
    found = spectral_features(patches)
    assert found["spectral slope"].mean() == pytest.approx(slope, abs=0.1)
    assert found["spectral curvature"].mean() == pytest.approx(0.0, abs=0.1)
    shares = [values for name, values in found.items() if name.startswith("share")]
    np.testing.assert_allclose(np.sum(shares, axis=0), 1.0)


def test_waves_of_one_direction_are_anisotropic():
    rows = np.repeat(np.random.default_rng(2).standard_normal((4, 64, 1)), 64, axis=2)
    assert power_by_ring(rows)[2].min() > 1.5


def test_moments_of_gaussian_uniform_and_exponential_values():
    rng = np.random.default_rng(3)
    assert standard_moment(WHITE, 4).mean() == pytest.approx(3.0, abs=0.02)
    assert standard_moment(rng.random((1, 10**6)), 4)[0] == pytest.approx(1.8, abs=0.01)
    assert standard_moment(rng.exponential(size=(1, 10**6)), 3)[0] == pytest.approx(2.0, abs=0.05)
    assert standard_moment(np.ones((1, 9)), 4)[0] == 0.0


def test_increments_and_gradients_of_a_gaussian_field_have_kurtosis_three():
    for name, values in {**increment_features(WHITE), **gradient_features(WHITE)}.items():
        if name.startswith("kurtosis"):
            assert values.mean() == pytest.approx(3.0, abs=0.05), name


def test_a_plane_has_one_gradient_and_the_structure_function_of_its_slopes():
    plane = 3.0 * np.arange(64.0)[:, None] + 4.0 * np.arange(64.0) + np.zeros((1, 64, 64))
    found = gradient_features(plane)
    assert found["gradient, percentile 10"] == pytest.approx(5.0) == found["gradient, percentile 99"]
    np.testing.assert_allclose(structure_function(plane), [12.5 * lag**2 for lag in LAGS])


def test_the_share_of_flat_pixels_is_the_area_without_edges():
    step = np.zeros((1, 64, 64))
    step[:, :, 32:] = 1.0
    assert gradient_features(step)["share of flat pixels"] == pytest.approx(60.0 / 62.0)


def test_the_laplacian_of_narrow_peaks_is_skewed_downward():
    peaks = np.zeros((1, 64, 64))
    peaks[:, 8::16, 8::16] = 1.0
    assert histogram_features(peaks)["skewness of the Laplacian"][0] < -3.0
    assert histogram_features(-peaks)["skewness of the Laplacian"][0] > 3.0


def test_disc_ring_and_two_squares_have_their_parts_holes_and_outlines():
    masks = np.zeros((4, 32, 32), dtype=bool)
    y, x = np.ogrid[:32, :32]
    radius = np.hypot(y - 16, x - 16)
    masks[0] = radius < 10
    masks[1] = (radius < 10) & (radius > 5)
    masks[2, 2:6, 2:6] = masks[2, 10:14, 10:12] = True
    assert euler_number(masks).tolist() == [1, 0, 2, 0]
    assert components(masks).tolist() == [1, 1, 2, 0]
    assert perimeter(masks)[2:].tolist() == [16 + 12, 0]
    assert perimeter(masks)[0] == 4 * 19


def test_the_autocorrelation_of_a_first_order_process_falls_to_one_e_at_its_length():
    noise = np.random.default_rng(4).standard_normal((30, 64, 1064))
    rows = lfilter([1.0], [1.0, -0.8], noise)[:, :, -64:]
    assert autocorrelation_length(rows, 2, float(np.exp(-1.0))).mean() == pytest.approx(-1.0 / np.log(0.8), rel=0.1)
    assert autocorrelation_length(rows, 1, 0.5).mean() == pytest.approx(0.5, abs=0.02)


def test_amplitudes_of_bands_are_independent_in_noise_and_not_where_noise_is_patchy():
    y, x = np.mgrid[:64, :64]
    patchy = WHITE * (1.0 + np.sin(y / 10.0) * np.sin(x / 10.0))
    name = "correlation of bands 0-1 px, 1-2 px"
    assert band_features(patchy)[name].mean() > band_features(WHITE)[name].mean() + 0.2
    assert band_features(WHITE)["kurtosis of band 0-1 px"].mean() == pytest.approx(3.0, abs=0.05)


def test_features_of_patches_do_not_depend_on_their_neighbours():
    names, values = all_features(WHITE[:3])
    assert len(names) == values.shape[1] > 40
    np.testing.assert_allclose(all_features(WHITE[1:2])[1], values[1:2], rtol=1e-9, atol=1e-12)


def test_clear_flat_and_incomplete_patches_are_left_out():
    rng = np.random.default_rng(5)
    field = np.full((128, 192), 290.0)
    field[:64, :64] -= 10.0 * rng.random((64, 64))
    field[:64, 64:128] -= 10.0 * rng.random((64, 64))
    field[3, 70] = np.nan
    field[64:, :64] = 280.0
    found = cut_patches("real", [field], [7], rng=rng, **COARSE)
    assert found.cut == 6
    assert found.scene.tolist() == [7]
    np.testing.assert_array_equal(found.kelvin[0], field[:64, :64])
    z = z_scored(found.kelvin)
    assert z.mean() == pytest.approx(0.0, abs=1e-9)
    assert z.std() == pytest.approx(1.0)


def test_a_moved_or_mirrored_piece_is_a_copy_and_another_field_is_none():
    rng = np.random.default_rng(6)
    example, other = power_law(rng, -3.0, 128), power_law(rng, -3.0, 128)
    piece = example[17:49, 60:92]
    given = np.stack([piece, piece[::-1], 250.0 + 0.1 * piece[:, ::-1], other[:32, :32]])
    found = largest_correlations(given, [Example(example, 32)])
    np.testing.assert_allclose(found[:3], 1.0, atol=1e-4)
    assert found[3] < 0.98
    assert largest_correlations(given[3:], [Example(example, 32), Example(other, 32)]) == pytest.approx(1.0, abs=1e-4)


def test_the_largest_correlation_is_that_of_all_places_tried_one_by_one():
    rng = np.random.default_rng(7)
    example, patch = power_law(rng, -2.0, 24), power_law(rng, -2.0, 24)[:16, :16]
    tried = [
        np.corrcoef(flipped.ravel(), example[row : row + 16, column : column + 16].ravel())[0, 1]
        for flipped in (patch, patch[::-1], patch[:, ::-1], patch[::-1, ::-1])
        for row in range(9)
        for column in range(9)
    ]
    assert largest_correlations(patch[None], [Example(example, 16)])[0] == pytest.approx(max(tried), abs=1e-4)


def test_frozen_clouds_in_wind_are_coherent_and_a_known_mixture_correlates_as_mixed():
    rng = np.random.default_rng(8)
    wide = power_law(rng, -2.5)
    first, second = wide[20:148, 20:148], wide[17:145, 25:153]
    assert motion(first, second) == (3, -5)
    np.testing.assert_allclose(correlation_by_band(first, second), 1.0, atol=1e-9)
    pairs = [(power_law(rng, -2.5), power_law(rng, -2.5)) for _ in range(8)]
    found = coherence(([0.6 * one + 0.8 * other, one], [900.0, 0.0]) for one, other in pairs)
    assert list(found) == [900.0]
    np.testing.assert_allclose(found[900.0], 0.6, atol=0.08)
