"""The likelihood of cloud parameters given one image: analytic, compiled, and vectorised over walkers."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.matching.structure import image_structure
from hcss_evaluate.posterior.batch_variogram import BatchVariogram
from hcss_evaluate.posterior.estimator_noise import EstimatorNoise, contrasts
from hcss_evaluate.posterior.image_data import ImageData, ScoreSemivariance
from hcss_evaluate.posterior.octaves import Octaves, mean_density
from hcss_evaluate.posterior.parameter_space import SHAPE
from hcss_evaluate.posterior.priors import KINDS
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array, ImageError


@kernel()
def log_densities(
    positions: Any,
    semivariance: Any,
    variance: Any,
    observed: Any,
    sky: Any,
    threshold: float,
    uses_coverage: bool,
    first: float,
    step: float,
    table: Any,
    centre: Any,
    width: Any,
    mean: Any,
    log_deviation: Any,
    inverse: Any,
    leverage: Any,
    basis: Any,
    freedom: float,
    density: Any,
) -> None:
    """Fill ``density`` (N,): log density of the statistics, up to a constant; -inf outside the simulated region.

    The density is a multivariate t instead of a normal, because simulated residuals have heavier tails (kurtosis 3.5 to
    5) and the correlation matrix is an estimate. One loop without arrays takes a tenth of the time of array operations;
    a test compares both.

    Parameters
    ----------
    positions : ndarray (N, 4)
        H, gamma, Lx, Ly on their scales.
    semivariance, variance : ndarray (N, M) and (N,)
        Expected variogram of the field.
    observed : ndarray (M,)
        ln of semivariances of normal scores.
    sky, threshold : ndarray (N,), float
        Thresholds of the sky, and the normal score above which the frame's pixels are cloudy, if ``uses_coverage``.
    first, step, table
        Of :attr:`hcss_evaluate.posterior.image_data.ScoreSemivariance.table`.
    centre, width, mean, log_deviation, inverse, leverage, basis, freedom
        Of :class:`hcss_evaluate.posterior.estimator_noise.EstimatorNoise`.
    """
    number, lags = positions.shape[1], semivariance.shape[1]
    count = inverse.shape[0]
    x = np.empty(number)
    feature = np.empty(mean.shape[0])
    residual, raw = np.empty(count), np.empty(count)
    for n in range(positions.shape[0]):
        inside = True
        for i in range(number):
            away = positions[n, i] - centre[i]
            inside &= abs(away) <= width[i] + 1e-9
            x[i] = min(max(away / width[i], -1.0), 1.0) if width[i] > 0.0 else 0.0
        if not inside:
            density[n] = -np.inf
            continue
        feature[0] = 1.0
        k = 1 + number
        for i in range(number):
            feature[1 + i] = x[i]
            for j in range(i, number):
                feature[k] = x[i] * x[j]
                k += 1
        size = np.sqrt(1.0 - variance[n])
        # Variance that the uncertainty of the mean adds to a variance of 1.
        added = 0.0
        for i in range(feature.size):
            found = 0.0
            for k in range(i + 1):
                found += leverage[i, k] * feature[k]
            added += found * found
        widening = 0.5 * np.log1p(added)
        total = 0.0
        for s in range(count):
            if s < lags:
                at = (np.log(semivariance[n, s] / variance[n]) - first) / step
                at = min(max(at, 0.0), table.size - 1.0)
                low = min(int(at), table.size - 2)
                expected = table[low] + (at - low) * (table[low + 1] - table[low])
                raw[s] = (observed[s] - expected) / size
            else:
                raw[s] = (sky[n] - np.sqrt(variance[n]) * threshold) / size
        for s in range(count):
            found = 0.0
            for k in range(count):
                found += basis[s, k] * raw[k]
            for k in range(feature.size):
                found -= feature[k] * mean[k, s]
            spread = widening + log_deviation[0, s]
            for i in range(number):
                spread += x[i] * log_deviation[1 + i, s]
            residual[s] = found * np.exp(-spread)
            total -= spread
        square = 0.0
        for s in range(count):
            white = 0.0
            for k in range(s + 1):
                white += inverse[s, k] * residual[k]
            square += white * white
        total -= 0.5 * (freedom + count) * np.log1p(square / freedom) + count * np.log(size)
        if uses_coverage:
            total += 0.5 * np.log(variance[n])
        density[n] = total


# Limits of a frame's variance, which rounding could make 0 or less, or 1.
MIN_VARIANCE = 1e-9

# Smaller images are simulated by code that holds Python's global lock.
_PIXELS_WITH_THREADS, _MAX_THREADS = 2**16, 8


@dataclass(frozen=True)
class ImageLikelihood:
    """Likelihood of an image's statistics given its cloud parameters.

    Statistics are the logarithms of the semivariances of normal scores along x and y, and the threshold of the sky
    above which the frame's pixels are cloudy. The threshold is not measured but follows from the coverage parameter, t
    = -probit(coverage). In a frame it is m + s q, with the frame's mean m and standard deviation s and the quantile q
    of its known coverage, so the density of the coverage is that of the threshold times s.

    Attributes
    ----------
    noise : EstimatorNoise or None
        Scatter of the statistics; None until it has been estimated.
    uses_coverage : bool
        Whether coverage refers to the unbounded sky. Otherwise it is the frame's by construction and carries no
        information.
    misfit : float
        Model error: standard deviation of ln semivariance, independent at each lag.
    """

    data: ImageData
    variogram: BatchVariogram
    score: ScoreSemivariance
    uses_coverage: bool
    misfit: float = 0.0
    noise: EstimatorNoise | None = None

    @classmethod
    def of(cls, data: ImageData, octaves: Octaves, uses_coverage: bool, misfit: float = 0.0) -> ImageLikelihood:
        """Prepare everything that needs no simulation."""
        return cls(data, BatchVariogram.of(octaves), ScoreSemivariance(data.coverage), uses_coverage, misfit)

    def expected(self, shapes: Array, lasts: NDArray[np.int64]) -> tuple[Array, Array]:
        """Return the expected statistics without correction, and the analytic size of their scatter.

        For H, gamma, Lx, Ly (N, 4) and last octaves (N,), these are ln of semivariances, with the threshold if coverage
        is used, (N, S), and the standard deviation of a frame's mean (N,).
        """
        data = self.data
        semivariances, variances = self.variogram(shapes, data.lags, data.pixel_size_m, data.rows, data.columns)
        chosen = np.arange(shapes.shape[0]), self.variogram.octaves.index(lasts)
        semivariance, variance = semivariances[chosen], variances[chosen]
        variance = np.clip(variance, MIN_VARIANCE, 1.0 - MIN_VARIANCE)
        mean = self.score.logarithm(semivariance / variance[:, None])
        if self.uses_coverage:
            mean = np.concatenate([mean, (np.sqrt(variance) * data.threshold)[:, None]], axis=1)
        return mean, np.sqrt(1.0 - variance)

    def __call__(self, values: Array) -> Array:
        """Return the log-likelihood (N,), up to a constant, of H, gamma, Lx, Ly, coverage (N, 5).

        It is averaged over the possible last octaves.
        """
        return mean_density(self.of_each_last(values))

    def draw_lasts(self, values: Array, rng: np.random.Generator) -> NDArray[np.int64]:
        """Draw a last octave (N,) for each of H, gamma, Lx, Ly, coverage (N, 5), given the image if noise is known."""
        octaves = self.variogram.octaves
        equal = np.zeros((values.shape[0], len(octaves.lasts)))
        return octaves.draw(equal if self.noise is None else self.of_each_last(values), rng)

    def of_each_last(self, values: Array) -> Array:
        """Return the log-likelihood (N, K), up to a constant, of each last octave."""
        assert self.noise is not None
        data, noise = self.data, self.noise
        semivariance, variance = self.variogram(
            values[:, : len(SHAPE)], data.lags, data.pixel_size_m, data.rows, data.columns
        )
        count = variance.shape[1]
        sky = -ndtri(values[:, -1]) if self.uses_coverage else np.zeros(values.shape[0])
        density = np.empty(variance.size)
        log_densities(
            np.repeat(on_scales(values[:, : len(SHAPE)]), count, axis=0),
            semivariance.reshape(variance.size, -1),
            np.clip(variance.ravel(), MIN_VARIANCE, 1.0 - MIN_VARIANCE),
            np.log(data.variogram),
            np.repeat(sky, count),
            data.threshold,
            self.uses_coverage,
            *self.score.table,
            noise.centre,
            noise.width,
            noise.mean,
            noise.log_deviation,
            noise.inverse,
            noise.leverage,
            noise.basis,
            noise.freedom,
            density,
        )
        return density.reshape(-1, count)

    def residuals(self, values: Array, lasts: NDArray[np.int64]) -> tuple[Array, Array, Array]:
        """Return the residuals of the image relative to its expectation for H, gamma, Lx, Ly, coverage (N, 5).

        Returns the positions of H, gamma, Lx, Ly on their scales (N, 4), the residuals in units of the size (N, S), and
        the size (N,) from :meth:`expected`.
        """
        shapes = values[:, : len(SHAPE)]
        mean, size = self.expected(shapes, lasts)
        statistics = np.broadcast_to(np.log(self.data.variogram), (values.shape[0], self.data.variogram.size))
        if self.uses_coverage:
            threshold = -ndtri(values[:, -1:])
            statistics = np.concatenate([statistics, threshold], axis=1)
        return on_scales(shapes), (statistics - mean) / size[:, None], size

    def learn(
        self, shapes: Array, lasts: NDArray[np.int64], rng: np.random.Generator, progress: Callable[[int], None]
    ) -> ImageLikelihood:
        """Simulate one image for each of ``shapes`` (N, 4) and ``lasts`` (N,), and return the likelihood with scatter.

        Raises PosteriorError if simulated images do not vary.
        """
        seeds = [int(rng.integers(0, 2**31)) for _ in range(shapes.shape[0])]
        first = self.variogram.octaves.first
        large = self.data.rows * self.data.columns >= _PIXELS_WITH_THREADS
        workers = min(_MAX_THREADS, os.cpu_count() or 1) if large else 1
        statistics: Array = np.empty((shapes.shape[0], 2 * self.data.lags.size + 1))

        def one(index: int) -> None:
            try:
                scores, threshold = self.data.simulate(shapes[index], (first, int(lasts[index])), seeds[index])
                structure = image_structure(scores, self.data.lags.tolist())
            except ImageError as error:
                named = ", ".join(f"{n} = {v:.4g}" for n, v in zip(SHAPE, shapes[index], strict=True))
                raise PosteriorError(f"simulation: {error}, with {named}; allowed: priors that exclude them") from error
            statistics[index, :-1] = structure.logarithm
            statistics[index, -1] = threshold

        with ThreadPoolExecutor(workers) as pool:
            try:
                for _ in pool.map(one, range(shapes.shape[0])):
                    progress(1)
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
        mean, size = self.expected(shapes, lasts)
        if not self.uses_coverage:
            statistics = statistics[:, :-1]
        residuals = (statistics - mean) / size[:, None]
        if self.misfit > 0.0:
            # The model error is part of the scatter and is estimated with it.
            extra = rng.standard_normal((shapes.shape[0], 2 * self.data.lags.size)) * self.misfit
            residuals[:, : extra.shape[1]] += extra / size[:, None]
        basis = contrasts(self.data.lags.size, int(self.uses_coverage))
        return replace(self, noise=EstimatorNoise.learn(on_scales(shapes), residuals, basis))

    def replicate(self, shapes: Array, lasts: NDArray[np.int64], rng: np.random.Generator) -> Array:
        """Draw ln semivariances (N, 2 M), one image for each of ``shapes`` (N, 4) and ``lasts`` (N,)."""
        assert self.noise is not None
        mean, size = self.expected(shapes, lasts)
        drawn = mean + size[:, None] * self.noise.draw(rng, on_scales(shapes))
        return np.asarray(drawn[:, : self.data.variogram.size])


def on_scales(shapes: Array) -> Array:
    """Convert H, gamma, Lx, Ly (N, 4) to their scales."""
    columns = [KINDS[name].scale.of(shapes[:, column]) for column, name in enumerate(SHAPE)]
    return np.stack(columns, axis=1)
