"""What a fit compares: expectations against the independent implementation, quadrature and brute force."""

import dataclasses

import numpy as np
import pytest
from hcss_evaluate.matching.structure import CloudImage, grey_inputs, image_structure
from hcss_evaluate.posterior.batch_variogram import BatchVariogram, DimensionLikelihood
from hcss_evaluate.posterior.doubts import doubts, main_modes, unlikeness
from hcss_evaluate.posterior.estimator_noise import EstimatorNoise
from hcss_evaluate.posterior.image_data import (
    ImageData,
    ScoreSemivariance,
    clipped_semivariance,
    field_scores,
    image_scores,
    rank_scores,
    still_field,
)
from hcss_evaluate.posterior.image_likelihood import ImageLikelihood
from hcss_evaluate.posterior.octaves import Octaves
from hcss_evaluate.posterior.parameter_space import Space
from scipy.integrate import dblquad
from scipy.special import ndtri
from scipy.stats import multivariate_normal, multivariate_t, rankdata

from hcss_twin.core.errors import ImageError
from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import Grid

KNOWN = Octaves(0, (8,))
PIXEL_M = 20.0
LAGS = np.array([1, 2, 4, 8, 16])


def shapes(count, side, seed=0):
    rng = np.random.default_rng(seed)
    cells = np.exp(rng.uniform(0, np.log(side / 2), (count, 2))) * 16_000 / (side * PIXEL_M)
    return np.column_stack([rng.uniform(0.05, 0.95, count), rng.uniform(1.2, 6, count), cells])


def field(shape, side, seed, coverage=0.5):
    parameters = FractalParameters(gamma=shape[1], H=shape[0], L=tuple(shape[2:]), k=(0, 8))
    inputs = grey_inputs(coverage, side, side, PIXEL_M, seed)
    return FractalClouds(inputs, parameters, threads=1).field(0.0, slice(0, side), slice(0, side))


@pytest.mark.parametrize("octaves", [Octaves(0, (3, 4, 8)), Octaves(2, (5,))])
def test_many_variograms_are_those_of_each(octaves):
    rows, columns = 90, 64
    given = shapes(12, 64)
    found, variance = BatchVariogram.of(octaves)(given, LAGS, PIXEL_M, rows, columns)
    kernel, nothing = KernelCorrelation.tabulate(), np.zeros_like(LAGS)
    dx, dy = np.concatenate([LAGS, nothing]), np.concatenate([nothing, LAGS])
    for row, column in np.ndindex(variance.shape):
        parameters_of_row, last = given[row], octaves.lasts[column]
        parameters = FractalParameters(
            gamma=parameters_of_row[1],
            H=parameters_of_row[0],
            L=(parameters_of_row[2], parameters_of_row[3]),
            k=(octaves.first, last),
        )
        expected = kernel.expected_variogram(parameters, PIXEL_M, dx, dy)
        np.testing.assert_allclose(found[row, column], expected, atol=1e-12)
        assert variance[row, column] == pytest.approx(kernel.frame_variance(parameters, PIXEL_M, rows, columns))


def test_a_still_field_is_that_of_the_generator_to_the_last_bit():
    shape = (0.4, 2.0, 40.0, 60.0)
    parameters = FractalParameters(gamma=shape[1], H=shape[0], L=shape[2:], k=(0, 8))
    np.testing.assert_array_equal(still_field(parameters, Grid(48, 48, PIXEL_M), 3), field(shape, 48, 3))


def test_last_octaves_are_drawn_as_often_as_their_likelihoods_say():
    rng, octaves = np.random.default_rng(0), Octaves(0, (3, 5, 9))
    density = np.log(np.tile([0.2, 0.0, 0.6], (40_000, 1)) + 1e-300)
    drawn = octaves.draw(density - 700.0, rng)
    assert np.mean(drawn == 3) == pytest.approx(0.25, abs=0.01)
    assert not np.any(drawn == 5)
    # Where all are impossible, all are equally likely.
    assert np.mean(octaves.draw(np.full((40_000, 3), -np.inf), rng) == 5) == pytest.approx(1 / 3, abs=0.01)


@pytest.mark.parametrize(("one_minus", "threshold"), [(0.02, 0.3), (0.5, -1.0), (1.4, 1.2)])
def test_semivariance_above_a_threshold_is_the_double_integral(one_minus, threshold):
    pair = multivariate_normal([0, 0], [[1, 1 - one_minus], [1 - one_minus, 1]])

    def integrand(b, a):
        return 0.5 * (max(a, threshold) - max(b, threshold)) ** 2 * pair.pdf([a, b])

    # By symmetry twice the part a > b; nothing where both lie below.
    expected = 2 * dblquad(integrand, threshold, 7, -7, lambda a: a, epsabs=1e-6, epsrel=1e-4)[0]
    assert clipped_semivariance(one_minus, threshold) == pytest.approx(expected, rel=1e-3)


def test_without_clear_pixels_scores_are_the_field():
    for one_minus in (1e-6, 0.3, 1.5):
        assert clipped_semivariance(one_minus, -np.inf) == one_minus
        assert clipped_semivariance(one_minus, -9.0) == pytest.approx(one_minus, rel=1e-9)


def test_scores_do_not_depend_on_the_map_to_grey_levels():
    """Any brightness exponent, any calibration: ranks are the same."""
    level = np.maximum(field((0.4, 2.0, 40.0, 40.0), 48, 3), 0.0)
    other = np.where(level > 0, 1 + level.astype(np.float64) ** 3, 0)
    np.testing.assert_array_equal(image_scores(level), image_scores(other))


def test_cloudy_scores_are_normal_quantiles_of_ranks_and_clear_ones_the_threshold():
    level = np.maximum(field((0.4, 2.0, 40.0, 40.0), 48, 3), 0.0)
    scores, clear = image_scores(level), np.count_nonzero(level == 0)
    np.testing.assert_allclose(scores[level == 0], ndtri(clear / level.size), rtol=1e-6)
    expected = ndtri((rankdata(level.ravel(), "ordinal") - 0.5) / level.size).reshape(level.shape)
    np.testing.assert_allclose(scores[level > 0], expected[level > 0], atol=1e-6)


def test_scores_of_a_simulated_field_are_those_of_its_image():
    """Bins instead of ranks: the same to within a bin and the pixels in it."""
    given = field((0.4, 2.0, 40.0, 40.0), 96, 3)
    cloudy = given.size // 3
    lowest = np.sort(given, axis=None)[-cloudy]
    level = np.where(given >= lowest, given - lowest + 1.0, 0.0).astype(np.float32)
    scores = field_scores(given, rank_scores(cloudy, given.size))
    np.testing.assert_allclose(scores, image_scores(level), atol=2e-2)
    assert np.abs(scores - image_scores(level)).mean() < 1e-3


@pytest.mark.parametrize("coverage", [0.3, 0.7])
def test_expected_score_variogram_is_the_mean_of_simulations(coverage):
    side, shape = 64, np.array([0.4, 2.0, 8 * 12.5, 6 * 12.5])
    semivariance, variance = BatchVariogram.of(KNOWN)(shape[None], LAGS, PIXEL_M, side, side)
    expected = ScoreSemivariance(coverage).logarithm(semivariance / variance[..., None])[0, 0]
    data = ImageData(side, side, PIXEL_M, round(coverage * side**2), LAGS, np.ones(10))
    drawn = [data.simulate(shape, (0, 8), seed)[0] for seed in range(120)]
    simulated = np.array([image_structure(scores, LAGS.tolist()).logarithm for scores in drawn])
    error = simulated.std(axis=0) / np.sqrt(120)
    # .03: what frames' own mean, variance and logarithm change, which is learned.
    assert np.all(np.abs(simulated.mean(axis=0) - expected) < 0.03 + 3 * error)


@pytest.fixture(scope="module")
def image():
    side, shape = 64, np.array([0.4, 2.0, 75.0, 75.0])
    inputs = grey_inputs(0.4, side, side, PIXEL_M, 1)
    parameters = FractalParameters(gamma=shape[1], H=shape[0], L=tuple(shape[2:]), k=(0, 8))
    level = FractalClouds(inputs, parameters, threads=1).thickness_m(0.0, slice(0, side), slice(0, side))
    return CloudImage(level, PIXEL_M)


def noise_density(noise, positions, residuals):
    """ln of the multivariate t of residuals (N, S), up to a constant; -inf outside the positions of the simulations."""
    x = np.clip((positions - noise.centre) / np.where(noise.width > 0.0, noise.width, 1.0), -1.0, 1.0)
    linear = np.concatenate([np.ones((x.shape[0], 1)), x], axis=1)
    first, second = np.triu_indices(x.shape[1])
    features = np.concatenate([linear, x[:, first] * x[:, second]], axis=1)
    leverage = np.sum((features @ noise.leverage.T) ** 2, axis=1)
    log_deviation = linear @ noise.log_deviation + 0.5 * np.log1p(leverage)[:, None]
    standard = (residuals @ noise.basis.T - features @ noise.mean) * np.exp(-log_deviation)
    white = np.linalg.solve(noise.lower, standard.T).T
    density = -0.5 * (noise.freedom + white.shape[1]) * np.log1p(np.sum(white**2, axis=1) / noise.freedom)
    inside = np.all(np.abs(positions - noise.centre) <= noise.width + 1e-9, axis=1)
    return np.where(inside, density, -np.inf) - np.sum(log_deviation, axis=1)


def image_density(likelihood, values, last):
    """The density of one last octave, step by step and not compiled."""
    positions, residuals, size = likelihood.residuals(values, np.full(values.shape[0], last))
    density = noise_density(likelihood.noise, positions, residuals) - residuals.shape[1] * np.log(size)
    return density + 0.5 * np.log1p(-size * size) if likelihood.uses_coverage else density


@pytest.mark.parametrize("uses_coverage", [True, False])
def test_the_compiled_density_is_the_one_of_its_parts(image, uses_coverage):
    octaves = Octaves(0, (5, 8))
    likelihood = ImageLikelihood.of(ImageData.of(image), octaves, uses_coverage)
    rng = np.random.default_rng(0)
    given = shapes(60, 64)
    lasts = likelihood.draw_lasts(np.column_stack([given, np.full(60, 0.5)]), rng)
    assert set(lasts) == {5, 8}
    likelihood = likelihood.learn(given, lasts, rng, lambda _: None)
    values = np.column_stack([shapes(200, 64, 1), rng.uniform(0.1, 0.9, 200)])
    found = likelihood(values)
    densities = np.stack([image_density(likelihood, values, last) for last in octaves.lasts], axis=1)
    np.testing.assert_allclose(likelihood.of_each_last(values), densities, rtol=1e-9)
    with np.errstate(divide="ignore"):
        expected = np.log(np.exp(densities).mean(axis=1))
    inside = np.isfinite(expected)
    assert inside.any()
    assert not inside.all()
    np.testing.assert_array_equal(np.isfinite(found), inside)
    np.testing.assert_allclose(found[inside], expected[inside], rtol=1e-9)


def test_doubts_name_the_parameters_that_they_concern(image):
    given = shapes(60, 64)
    likelihood = ImageLikelihood.of(ImageData.of(image), KNOWN, True)
    likelihood = likelihood.learn(given, np.full(60, 8), np.random.default_rng(0), lambda _: None)
    priors = {"H": "uniform:0.02:0.98", "Lx": "loguniform:6:400", "Ly": "loguniform:6:400", "coverage": "uniform:0:1"}
    space = Space.of({"gamma": 2.0}, {}, priors)
    # The image is 1280 m wide: 16 cells of 80 m, or 1.6 of 800 m.
    small, large = (np.tile([0.5, 2.0, cells, cells, 0.5], (50, 1)) for cells in (200.0, 20.0))
    sure = {"p_value": 0.5, "unlike": 1.0, "cloud_type": None}

    def doubted(values, **changes):
        return [doubt.parameters for doubt in doubts("i", likelihood, values, space, **(sure | changes))]

    assert doubted(small) == []
    assert doubted(large) == [("Lx", "Ly", "coverage")]
    assert doubted(large, cloud_type="stratus") == []
    variogram = ImageLikelihood.of(ImageData.of(image), Octaves.of(None), True).variogram
    unknown = dataclasses.replace(likelihood, variogram=variogram)
    assert [doubt.parameters[0] for doubt in doubts("i", unknown, large, space, **sure)] == ["H"]
    assert doubted(small, p_value=0.005) == doubted(small, unlike=1.3) == [("H", "Lx", "Ly", "coverage")]
    edge = small.copy()
    edge[:10, 0] = likelihood.noise.centre[0] + 0.999 * likelihood.noise.width[0]
    assert doubted(edge) == [("H",)]
    two = small.copy()
    two[:, 0] += np.linspace(-0.02, 0.02, 50)
    two[:20, 0] += 0.2
    assert doubted(two) == [("H",)]
    (doubt,) = doubts("i", likelihood, two, space, **sure)
    assert "two modes, at 0.49" in doubt.reason or "two modes, at 0.5" in doubt.reason
    assert "(60% of the draws) and 0.6" in doubt.reason or "(60% of the draws) and 0.7" in doubt.reason


def test_two_modes_are_found_and_one_mode_of_any_shape_is_one():
    rng = np.random.default_rng(0)
    one = {
        "normal": lambda: rng.standard_normal(400),
        "uniform": lambda: rng.uniform(size=400),
        "heavy tails": lambda: rng.standard_t(3, 400),
        "skewed": lambda: rng.lognormal(0.0, 0.8, 400),
        # equal normals two standard deviations apart have one maximum exactly (Robertson and Fryer, 1969)
        "nearly two": lambda: rng.standard_normal(400) + 2.0 * (rng.uniform(size=400) < 0.5),
    }
    for name, draw in one.items():
        assert sum(len(main_modes(draw())) == 2 for _ in range(200)) <= 4, name
    for share, fewest in ((0.1, 95), (0.5, 100)):
        found = [
            main_modes(rng.standard_normal(400) + np.where(rng.uniform(size=400) < share, 5.0, 0.0)) for _ in range(100)
        ]
        assert sum(len(modes) == 2 for modes in found) >= fewest
        places, shares = np.transpose([modes for modes in found if len(modes) == 2], (2, 1, 0))
        np.testing.assert_allclose(places.mean(axis=1), (0.0, 5.0), atol=0.15)
        np.testing.assert_allclose(shares.mean(axis=1), (1.0 - share, share), atol=0.02)
    assert main_modes(np.full(50, 3.0)) == [(3.0, 1.0)]


def test_an_image_without_the_field_is_unlike_those_of_its_posterior(image):
    """Shuffled in blocks it has the same grey levels, and edges that no Gaussian field has."""
    likelihood = ImageLikelihood.of(ImageData.of(image), KNOWN, True)
    values, lasts = np.tile([0.4, 2.0, 75.0, 75.0, 0.4], (50, 1)), np.full(50, 8)
    blocks = image.level.reshape(8, 8, 8, 8).swapaxes(1, 2).reshape(64, 8, 8)
    shuffled = blocks[np.random.default_rng(0).permutation(64)].reshape(8, 8, 8, 8).swapaxes(1, 2).reshape(64, 64)
    unlikeness_of_image, other = (
        unlikeness(CloudImage(level, PIXEL_M), likelihood, values, lasts, np.random.default_rng(1))
        for level in (image.level, shuffled)
    )
    assert unlikeness_of_image < 1.25 < other


def test_noise_is_learned_as_it_is():
    rng = np.random.default_rng(0)
    correlation = np.array([[1.0, 0.8], [0.8, 1.0]])
    position = np.column_stack([rng.uniform(-1, 1, 3000), np.full(3000, 2.0)])
    raw = rng.multivariate_normal([0, 0], correlation, 3000)
    deviation = np.exp(0.3 * position[:, :1]) * [0.5, 2.0]
    mean = 0.2 * position[:, :1] ** 2 - 0.4 * position[:, :1]
    noise = EstimatorNoise.learn(position, mean + deviation * raw)
    at = np.array([[0.8, 2.0]])
    drawn = noise.draw(rng, np.repeat(at, 40_000, axis=0))
    assert np.all(np.abs(drawn.mean(axis=0) + 0.192) < 0.1 * drawn.std(axis=0))
    np.testing.assert_allclose(drawn.std(axis=0), np.exp(0.24) * np.array([0.5, 2.0]), rtol=0.05)
    assert np.corrcoef(drawn.T)[0, 1] == pytest.approx(0.8, abs=0.03)
    distance = noise.square_distance(np.repeat(at, 40_000, axis=0), drawn)
    # Chi squared with two degrees of freedom.
    assert distance.mean() == pytest.approx(2.0, rel=0.03)
    outside = noise_density(noise, np.array([[1.5, 2.0], [0.0, 2.0]]), np.zeros((2, 2)))
    assert outside[0] == -np.inf
    assert np.isfinite(outside[1])


@pytest.fixture(scope="module")
def learned_from_few():
    """Thirty times noise learned from 150 standard normal residuals, with what it says of 2000 new ones."""
    rng = np.random.default_rng(1)
    found = []
    for _ in range(30):
        position, new = rng.uniform(-1, 1, (150, 4)), rng.uniform(-0.95, 0.95, (2000, 4))
        noise = EstimatorNoise.learn(position, rng.standard_normal((150, 2)))
        found.append((noise, noise.square_distance(new, rng.standard_normal((2000, 2)))))
    return found


def test_new_residuals_are_as_far_from_a_learned_mean_as_is_said(learned_from_few):
    """Fifteen coefficients from 150 simulations add a tenth to the variance, which is to be known."""
    distance = np.mean([square.mean() for _, square in learned_from_few])
    # Chi squared with two degrees of freedom. What standard deviations are uncertain by is not known: some 7 %.
    assert 2.0 < distance < 2.25


def test_standard_deviations_are_learned_as_well_as_numbers_allow(learned_from_few):
    slopes = np.array([noise.log_deviation[1:] for noise, _ in learned_from_few])
    # 1 / sqrt(2 N / 3) by the information of N normal numbers; the mean of ln of squares has 0.157.
    assert np.sqrt(np.mean(slopes**2)) < 0.12


def test_the_density_of_residuals_is_a_multivariate_t():
    rng = np.random.default_rng(2)
    noise = EstimatorNoise.learn(rng.uniform(-1, 1, (200, 1)), rng.standard_normal((200, 3)) * [1.0, 2.0, 0.5])
    # In the middle only the constant of each regression counts.
    centre = np.repeat(noise.centre[None], 5, axis=0)
    scale = np.exp(noise.log_deviation[0])
    shape = noise.lower @ noise.lower.T * scale[:, None] * scale * (1.0 + np.sum(noise.leverage[:, 0] ** 2))
    residuals = 2.0 * rng.standard_normal((5, 3))
    expected = multivariate_t(noise.mean[0], shape, df=noise.freedom).logpdf(residuals)
    found = noise_density(noise, centre, residuals)
    np.testing.assert_allclose(found - found[0], expected - expected[0], rtol=1e-9, atol=1e-9)


def test_the_dimension_of_a_field_is_three_less_its_hurst_exponent():
    """With octaves over all scales, far from the largest and the smallest."""
    variogram = BatchVariogram.of(Octaves(0, (16,)))
    likelihood = DimensionLikelihood(2.5, 0.1, 800, 800, 20.0, variogram)
    hurst = np.array([0.5, 0.6, 0.7])
    given = np.column_stack([hurst, np.full(3, 1.5), np.full((3, 2), 4.0)])
    np.testing.assert_allclose(likelihood.expected(given)[:, 0], 3.0 - hurst, atol=0.06)


def flat(value=0.0, rows=64, columns=64):
    return CloudImage(np.full((rows, columns), value, dtype=np.float32), PIXEL_M)


def holes(image):
    level = image.level.copy()
    level[3, 4] = np.nan
    return dataclasses.replace(image, level=level)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda _: flat(0.0), "0 of 4096 pixels are cloudy"),
        (lambda _: flat(9.0), "0 of 4096 pixels are clear"),
        (lambda image: dataclasses.replace(image, level=np.where(image.level > 0, 7, 0)), "all cloudy pixels are 7"),
        (holes, "not finite"),
        (lambda image: dataclasses.replace(image, level=image.level[:5, :5]), "5 x 5 pixels, allowed: 32"),
    ],
)
def test_an_image_that_tells_nothing_is_refused(image, change, message):
    with pytest.raises(ImageError, match=message):
        ImageData.of(change(image))
