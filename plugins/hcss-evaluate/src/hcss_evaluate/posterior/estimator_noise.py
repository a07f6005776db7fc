"""Scatter of measured variograms about the expected one, estimated from simulated fields.

The analytic expectation is exact for the field, but measurements differ: normal scores are relative to the frame,
logarithms are taken, and clear pixels are set to the threshold. No closed form of this covariance is known, so it is
estimated from simulations over the whole region of the posterior, not at a single point. The simulations provide three
results as functions of the parameters: a small quadratic correction of the mean, log-linear corrections of the analytic
standard deviations, and one correlation matrix. The likelihood itself uses no simulations and no fixed seed.

A few hundred simulations leave the mean uncertain, and ignoring this would make posteriors too narrow. The variance is
therefore the predictive variance, increased by the leverage of the position.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from hcss_evaluate.errors import PosteriorError
from hcss_twin.providers import Array

# Ridge of the regression, in simulations, which damps directions with hardly any variation.
_RIDGE = 1e-3

# Prior standard deviation of the change in ln(standard deviation / analytic size) from the centre of the positions to
# their edge. Without this prior, estimation noise would make the edges too likely or too unlikely.
_SLOPE = 0.22

# Limit on the degrees of freedom of the multivariate t.
_FREEDOM = 30.0

# Alternating iterations of weighted regression and maximum-likelihood standard deviations, and the largest step.
_TURNS, _FARTHEST = 8, 0.5


@dataclass(frozen=True)
class EstimatorNoise:
    """Distribution of residuals (statistics,) as a function of the parameters.

    Attributes
    ----------
    centre, width : ndarray (P,)
        Centre and width of the simulated parameters on their scales; a width of 0 denotes a fixed parameter.
    mean : ndarray (F, S)
        Coefficients of the mean residual, in units of the analytic size.
    log_deviation : ndarray (1 + P, S)
        Coefficients of ln of the standard deviation.
    lower : ndarray (S, S)
        Cholesky factor of the correlation matrix of residuals.
    inverse : ndarray (S, S)
        Inverse of ``lower``.
    leverage : ndarray (F, F)
        Inverse Cholesky factor of the regression of the mean; the square of its product with the features is the
        variance that the uncertainty of the mean adds to a variance of 1.
    basis : ndarray (S, S)
        Transformation of residuals to the described contrasts: see :func:`contrasts`.
    freedom : float
        Degrees of freedom of the multivariate t, which set the weight of its tails.
    """

    centre: Array
    width: Array
    mean: Array
    log_deviation: Array
    lower: Array
    inverse: Array
    leverage: Array
    basis: Array
    freedom: float

    @classmethod
    def learn(cls, positions: Array, residuals: Array, basis: Array | None = None) -> EstimatorNoise:
        """Fit the noise model to residuals (N, S), in units of the analytic size, at positions (N, P).

        Raises PosteriorError if a statistic never varies.
        """
        basis = np.eye(residuals.shape[1]) if basis is None else basis
        residuals = residuals @ basis.T
        low, high = positions.min(axis=0), positions.max(axis=0)
        centre, width = 0.5 * (low + high), 0.5 * (high - low)
        x = _scaled(positions, centre, width)
        features, linear = _quadratic(x), _linear(x)
        mean, slopes = _mean_and_deviation(features, linear, residuals)
        standard = (residuals - features @ mean) / np.exp(linear @ slopes)
        left = residuals.shape[0] - features.shape[1]
        lower = np.linalg.cholesky(standard.T @ standard / left)
        information = features.T @ features + _RIDGE * np.eye(features.shape[1])
        return cls(
            centre,
            width,
            mean,
            slopes,
            lower,
            _inverse(lower),
            _inverse(np.asarray(np.linalg.cholesky(information))),
            basis,
            min(_FREEDOM, left),
        )

    def _white(self, positions: Array, residuals: Array) -> tuple[Array, Array]:
        """Return whitened residuals and the log standard deviation, both (N, S)."""
        mean, log_deviation = self._predict(positions)
        standard = (residuals @ self.basis.T - mean) * np.exp(-log_deviation)
        # A triangular solver is slower here: its threading overhead dominates for a dozen numbers.
        return standard @ self.inverse.T, log_deviation

    def _predict(self, positions: Array) -> tuple[Array, Array]:
        """Return the mean and log standard deviation of a new residual in the basis, both (N, S)."""
        x = _scaled(positions, self.centre, self.width)
        features = _quadratic(x)
        leverage = np.sum((features @ self.leverage.T) ** 2, axis=1)
        return features @ self.mean, _linear(x) @ self.log_deviation + 0.5 * np.log1p(leverage)[:, None]

    def square_distance(self, positions: Array, residuals: Array) -> Array:
        """Return the squared Mahalanobis distance (N,) of residuals (N, S) from their mean."""
        white, _ = self._white(positions, residuals)
        return np.asarray(np.sum(white * white, axis=1))

    def draw(self, rng: np.random.Generator, positions: Array) -> Array:
        """Draw one residual (N, S) for each position."""
        mean, log_deviation = self._predict(positions)
        noise = rng.standard_normal((positions.shape[0], self.lower.shape[0])) @ self.lower.T
        drawn = mean + noise * np.exp(log_deviation)
        return np.asarray(np.linalg.solve(self.basis, drawn.T).T)


def contrasts(lags: int, others: int) -> Array:
    """Return the basis (S, S) for a number of lags along x, the same number along y, and other statistics.

    A frame with a large variance has it at all lags and along both axes, so the semivariances are nearly collinear, to
    a degree that depends on the parameters. Increments between successive lags, of the mean and of the difference of
    the axes, are nearly uncorrelated.
    """
    steps = np.eye(lags) - np.eye(lags, k=1)
    half = 0.5 * steps
    basis = np.eye(2 * lags + others)
    basis[: 2 * lags, : 2 * lags] = np.block([[half, half], [steps, -steps]])
    return basis


def _scaled(positions: Array, centre: Array, width: Array) -> Array:
    return np.asarray(np.clip((positions - centre) / np.where(width > 0.0, width, 1.0), -1.0, 1.0))


def _linear(x: Array) -> Array:
    return np.concatenate([np.ones((x.shape[0], 1)), x], axis=1)


def _quadratic(x: Array) -> Array:
    first, second = np.triu_indices(x.shape[1])
    return np.concatenate([_linear(x), x[:, first] * x[:, second]], axis=1)


def _mean_and_deviation(features: Array, linear: Array, residuals: Array) -> tuple[Array, Array]:
    """Return maximum-likelihood coefficients of the mean (F, S) and of the log standard deviation (1 + P, S).

    Weighted regression and scoring alternate. Averaging the logarithms of squares needs no iteration, but has 2.5 times
    the variance.

    Raises PosteriorError if a statistic never varies.
    """
    ridge = _RIDGE * np.eye(features.shape[1])
    mean = np.asarray(np.linalg.solve(features.T @ features + ridge, features.T @ residuals))
    deviation = (residuals - features @ mean).std(axis=0)
    if not np.all(deviation > 0.0):
        raise PosteriorError("simulations: a semivariance is constant; allowed: larger images, or other priors")
    slopes = np.zeros((linear.shape[1], residuals.shape[1]))
    slopes[0] = np.log(deviation)
    prior = np.full((linear.shape[1], 1), _SLOPE**-2)
    prior[0] = 0.0
    information = cho_factor(2.0 * linear.T @ linear + np.diag(prior[:, 0]))
    for _ in range(_TURNS):
        precision = np.exp(-2.0 * (linear @ slopes))
        precision /= precision.mean(axis=0)
        for measure in range(residuals.shape[1]):
            weighted = features * precision[:, measure, None]
            mean[:, measure] = np.linalg.solve(weighted.T @ features + ridge, weighted.T @ residuals[:, measure])
        square = (residuals - features @ mean) ** 2 * np.exp(-2.0 * (linear @ slopes))
        step = cho_solve(information, linear.T @ (square - 1.0) - prior * slopes)
        slopes += np.clip(step, -_FARTHEST, _FARTHEST)
    return mean, slopes


def _inverse(lower: Array) -> Array:
    return np.asarray(solve_triangular(lower, np.eye(lower.shape[0]), lower=True))
