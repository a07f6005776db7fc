"""How a measured variogram scatters about the expected one: from simulated fields.

The analytic expectation is exact for the field; what is measured differs: normal scores are relative to
the frame, logarithms are taken, and clear pixels are at the threshold. No closed form of the covariance is
known for that, so it is estimated from simulations, drawn over the whole of where the posterior lies
and not at one point of it. Three things are learned from them as functions of the parameters: a small
correction of the mean, quadratic; standard deviations, log-linear beside their analytic size; and one
correlation matrix. Simulations do not enter otherwise: no seed is fixed in the likelihood.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from hcss_twin.errors import PosteriorError

Array = NDArray[np.float64]

# E[ln chi^2] of one degree of freedom.
_MEAN_LOG_SQUARE = -1.2703628454614782

# Ridge of the regression, in simulations: directions that hardly vary are left alone.
_RIDGE = 1e-3


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
    basis : ndarray (S, S)
        From residuals to the numbers of which all this is told: see :func:`contrasts`.
    simulations : int
        How many taught it, less the coefficients of the mean.
    """

    centre: Array
    width: Array
    mean: Array
    log_deviation: Array
    lower: Array
    inverse: Array
    basis: Array
    simulations: int

    @classmethod
    def learn(cls, positions: Array, residuals: Array, basis: Array | None = None) -> EstimatorNoise:
        """Learn from residuals (N, S), in units of the analytic size, at positions (N, P).

        Raises
        ------
        PosteriorError
            If a statistic never varies.
        """
        basis = np.eye(residuals.shape[1]) if basis is None else basis
        residuals = residuals @ basis.T
        low, high = positions.min(axis=0), positions.max(axis=0)
        centre, width = 0.5 * (low + high), 0.5 * (high - low)
        x = _scaled(positions, centre, width)
        features, linear = _quadratic(x), _linear(x)
        mean = _regress(features, residuals)
        rest = residuals - features @ mean
        if not np.all(rest.std(axis=0) > 0.0):
            raise PosteriorError(
                "simulations: a semivariance never varies; allowed: larger images, or other priors"
            )
        squares = np.log(np.maximum(rest * rest, 1e-12 * np.mean(rest * rest, axis=0)))
        slopes = _regress(linear, 0.5 * (squares - _MEAN_LOG_SQUARE))
        # Of the level, the root mean square is the better estimate.
        standard = rest / np.exp(linear @ slopes)
        slopes[0] += 0.5 * np.log(np.mean(standard * standard, axis=0))
        standard = rest / np.exp(linear @ slopes)
        left = residuals.shape[0] - features.shape[1]
        lower = np.linalg.cholesky(standard.T @ standard / left)
        inverse = solve_triangular(lower, np.eye(lower.shape[0]), lower=True)
        return cls(centre, width, mean, slopes, lower, inverse, basis, left)

    def log_likelihood(self, positions: Array, residuals: Array) -> Array:
        """Return ln of the density (N,) of residuals (N, S) at positions (N, P), up to a constant.

        Multivariate t instead of normal, because the correlation matrix is an estimate (E. Sellentin
        and A. F. Heavens, Mon. Not. R. Astron. Soc. 456, L132 (2016), eq 11).
        """
        white, log_deviation = self._white(positions, residuals)
        square = np.sum(white * white, axis=1)
        count = self.simulations
        density = -0.5 * (count + 1.0) * np.log1p(square / count)
        density = np.where(self.has_learned(positions), density, -np.inf)
        return np.asarray(density - np.sum(log_deviation, axis=1))

    def has_learned(self, positions: Array) -> NDArray[np.bool_]:
        """Return whether positions (N, P) lie within those of the simulations (N,)."""
        return np.asarray(np.all(np.abs(positions - self.centre) <= self.width + 1e-9, axis=1))

    def _white(self, positions: Array, residuals: Array) -> tuple[Array, Array]:
        """Return independent residuals of unit variance, and ln of the standard deviation, both (N, S)."""
        x = _scaled(positions, self.centre, self.width)
        log_deviation = _linear(x) @ self.log_deviation
        standard = (residuals @ self.basis.T - _quadratic(x) @ self.mean) * np.exp(-log_deviation)
        # Not a triangular solution: its threads cost more than they do for a dozen numbers.
        return standard @ self.inverse.T, log_deviation

    def square_distance(self, positions: Array, residuals: Array) -> Array:
        """Return how far residuals (N, S) are from their mean (N,), squared Mahalanobis distance."""
        white, _ = self._white(positions, residuals)
        return np.asarray(np.sum(white * white, axis=1))

    def draw(self, rng: np.random.Generator, positions: Array) -> Array:
        """Draw one residual (N, S) for each position."""
        x = _scaled(positions, self.centre, self.width)
        noise = rng.standard_normal((positions.shape[0], self.lower.shape[0])) @ self.lower.T
        drawn = _quadratic(x) @ self.mean + noise * np.exp(_linear(x) @ self.log_deviation)
        return np.asarray(np.linalg.solve(self.basis, drawn.T).T)


def contrasts(lags: int, others: int) -> Array:
    """Return the basis (S, S) for so many lags along x, the same along y, and other statistics.

    A frame with more variance than others has it at all lags and along both axes, so that semivariances are
    nearly collinear, and how nearly depends on the parameters. Steps from one lag to the next, of the mean of both
    axes and of their difference, scatter each in its own way and are nearly uncorrelated.
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


def _regress(features: Array, values: Array) -> Array:
    square = features.T @ features + _RIDGE * np.eye(features.shape[1])
    return np.asarray(np.linalg.solve(square, features.T @ values))
