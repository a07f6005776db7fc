"""How a measured variogram scatters about the expected one: from simulated fields.

The analytic expectation is exact for the field; what is measured differs: normal scores are relative to
the frame, logarithms are taken, and clear pixels are at the threshold. No closed form of the covariance is
known for that, so it is estimated from simulations, drawn over the whole of where the posterior lies
and not at one point of it. Three things are learned from them as functions of the parameters: a small
correction of the mean, quadratic; standard deviations, log-linear beside their analytic size; and one
correlation matrix. Simulations do not enter otherwise: no seed is fixed in the likelihood.

Some hundred simulations leave the mean uncertain, and posteriors that did not know it would be too narrow:
the variance is that of a prediction, greater by the leverage of the position.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import PosteriorError

# Ridge of the regression, in simulations: directions that hardly vary are left alone.
_RIDGE = 1e-3

# Of ln of a standard deviation beside its analytic size, from the middle of the positions to their edge: the prior's
# standard deviation. Without a prior the noise of its estimate makes edges too likely, or too unlikely.
_SLOPE = 0.22

# Of the multivariate t; fewer simulations than that do not know better.
_FREEDOM = 30.0

# Of weighted regression and likeliest standard deviations in turn, and the farthest that one goes.
_TURNS, _FARTHEST = 8, 0.5


@dataclass(frozen=True)
class EstimatorNoise:
    """Distribution of residuals (statistics,) for any parameters.

    Attributes
    ----------
    centre, width : ndarray (P,)
        Of the parameters of the simulations, on their scales; a width of 0 is a fixed one.
    mean : ndarray (F, S)
        Coefficients of the mean residual, in units of the analytic size.
    log_deviation : ndarray (1 + P, S)
        Coefficients of ln of the standard deviation.
    lower : ndarray (S, S)
        Cholesky factor of the correlation matrix of residuals.
    inverse : ndarray (S, S)
        Of it.
    leverage : ndarray (F, F)
        Inverse of the Cholesky factor of the mean's regression: the square of its product with features is what the
        mean's uncertainty adds to a variance of 1.
    basis : ndarray (S, S)
        From residuals to the numbers of which all this is told: see :func:`contrasts`.
    freedom : float
        Degrees of freedom of the multivariate t: how heavy tails are.
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
        """Learn from residuals (N, S), in units of the analytic size, at positions (N, P).

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
        """Return independent residuals of unit variance, and ln of the standard deviation, both (N, S)."""
        mean, log_deviation = self._predict(positions)
        standard = (residuals @ self.basis.T - mean) * np.exp(-log_deviation)
        # Not a triangular solution: its threads cost more than they do for a dozen numbers.
        return standard @ self.inverse.T, log_deviation

    def _predict(self, positions: Array) -> tuple[Array, Array]:
        """Return the mean and ln of the standard deviation of a new residual on the basis, both (N, S)."""
        x = _scaled(positions, self.centre, self.width)
        features = _quadratic(x)
        leverage = np.sum((features @ self.leverage.T) ** 2, axis=1)
        return features @ self.mean, _linear(x) @ self.log_deviation + 0.5 * np.log1p(leverage)[:, None]

    def square_distance(self, positions: Array, residuals: Array) -> Array:
        """Return how far residuals (N, S) are from their mean (N,), squared Mahalanobis distance."""
        white, _ = self._white(positions, residuals)
        return np.asarray(np.sum(white * white, axis=1))

    def draw(self, rng: np.random.Generator, positions: Array) -> Array:
        """Draw one residual (N, S) for each position."""
        mean, log_deviation = self._predict(positions)
        noise = rng.standard_normal((positions.shape[0], self.lower.shape[0])) @ self.lower.T
        drawn = mean + noise * np.exp(log_deviation)
        return np.asarray(np.linalg.solve(self.basis, drawn.T).T)


def contrasts(lags: int, others: int) -> Array:
    """Return the basis (S, S) for so many lags along x, the same along y, and other statistics.

    A frame with more variance than others has it at all lags and along both axes, so that semivariances are nearly
    collinear, and how nearly depends on the parameters. Steps from one lag to the next, of the mean of both axes and of
    their difference, scatter each in its own way and are nearly uncorrelated.
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
    """Return the likeliest coefficients of the mean (F, S) and of ln of the standard deviation (1 + P, S).

    Weighted regression and scoring in turn. The mean of logarithms of squares would need no turns, but has 2.5 times
    the variance.

    Raises PosteriorError if a statistic never varies.
    """
    ridge = _RIDGE * np.eye(features.shape[1])
    mean = np.asarray(np.linalg.solve(features.T @ features + ridge, features.T @ residuals))
    deviation = (residuals - features @ mean).std(axis=0)
    if not np.all(deviation > 0.0):
        raise PosteriorError("simulations: a semivariance never varies; allowed: larger images, or other priors")
    slopes = np.zeros((linear.shape[1], residuals.shape[1]))
    slopes[0] = np.log(deviation)
    prior = np.full((linear.shape[1], 1), _SLOPE**-2)
    prior[0] = 0.0
    information = cho_factor(2.0 * linear.T @ linear + np.diag(prior[:, 0]))
    for _ in range(_TURNS):
        precision = np.exp(-2.0 * (linear @ slopes))
        precision /= precision.mean(axis=0)
        for each in range(residuals.shape[1]):
            weighted = features * precision[:, each, None]
            mean[:, each] = np.linalg.solve(weighted.T @ features + ridge, weighted.T @ residuals[:, each])
        square = (residuals - features @ mean) ** 2 * np.exp(-2.0 * (linear @ slopes))
        step = cho_solve(information, linear.T @ (square - 1.0) - prior * slopes)
        slopes += np.clip(step, -_FARTHEST, _FARTHEST)
    return mean, slopes


def _inverse(lower: Array) -> Array:
    return np.asarray(solve_triangular(lower, np.eye(lower.shape[0]), lower=True))
