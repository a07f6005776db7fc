"""Posterior density of the parameters of one image, or of those that a dimension tells of.

The likelihood of cloud parameters given nothing but a fractal dimension.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from hcss_twin.analysis.uncertainty.batch_variogram import BatchVariogram
from hcss_twin.analysis.uncertainty.space import KINDS, SHAPE, Space
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import PosteriorError

Likelihood = Callable[[Array], Array]
"""From H, gamma, Lx, Ly, coverage (N, 5) to ln of the likelihood (N,)."""


class Model(Protocol):
    """What chains need to know."""

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each dimension."""
        ...

    def log_probability(self, position: Array) -> Array:
        """Return ln of the posterior density (N,) of positions (N, D)."""
        ...

    def moves(self) -> list[tuple[Any, float]]:
        """Return emcee's moves and their weights."""
        ...

    def values(self, position: Array) -> dict[str, Array]:
        """Return the parameters (...) or (..., image) at positions (..., D)."""
        ...


@dataclass(frozen=True)
class SingleModel:
    """Parameters of one image."""

    space: Space
    likelihood: Likelihood

    @property
    def names(self) -> tuple[str, ...]:
        """Free parameters."""
        return self.space.names

    def log_probability(self, position: Array) -> Array:
        """Return ln of the posterior density (N,) of positions (N, D)."""
        total = self.space.log_prior(position)
        possible = np.isfinite(total)
        total[~possible] = -np.inf
        if possible.any():
            found = self.likelihood(self.space.complete(position[possible]))
            total[possible] += np.where(np.isnan(found), -np.inf, found)
        return total

    def moves(self) -> list[tuple[Any, float]]:
        """Return differential evolution, with whole jumps between modes now and then.

        Half the autocorrelation time of the stretch move here.
        """
        from emcee.moves import DEMove

        return [(DEMove(), 0.9), (DEMove(gamma0=1.0), 0.1)]

    def values(self, position: Array) -> dict[str, Array]:
        """Return the free parameters (...) at positions (..., D)."""
        return {name: KINDS[name].scale.back(position[..., i]) for i, name in enumerate(self.names)}


# Those of hcss_twin.analysis.measures.fractal_dimension.slopes.
_LAGS = np.array([1, 2], dtype=np.int64)


@dataclass(frozen=True)
class DimensionLikelihood:
    """Normal density of a dimension about that of the expected variogram.

    D = 3 - slope / 2, the slope that of ln of the field's semivariance, the mean of both axes, between lags of
    1 and 2 pixels: what ``variogram_dimension`` measures.

    Attributes
    ----------
    dimension, error : float
        Measured, and its standard deviation.
    rows, columns, pixel_size_m
        Of the image that it was measured in.
    variogram : BatchVariogram
        Of the field, expected.
    """

    dimension: float
    error: float
    rows: int
    columns: int
    pixel_size_m: float
    variogram: BatchVariogram

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises
        ------
        PosteriorError
            If the dimension is not between 2 and 3, or the error not positive.
        """
        if not 2.0 <= self.dimension <= 3.0:
            closest = 2 if self.dimension < 2.0 else 3
            raise PosteriorError(f"fractal dimension: {self.dimension:g} given, allowed: 2 to 3; closest is {closest}")
        if not 0.0 < self.error < math.inf:
            raise PosteriorError(f"error of the fractal dimension: {self.error:g} given, allowed: greater than 0")

    def expected(self, shapes: Array) -> Array:
        """Return the dimension (N,) of H, gamma, Lx, Ly (N, 4)."""
        semivariance, _ = self.variogram(shapes, _LAGS, self.pixel_size_m, self.rows, self.columns)
        near = semivariance[:, 0] + semivariance[:, 2]
        far = semivariance[:, 1] + semivariance[:, 3]
        return np.asarray(3.0 - 0.5 * np.log(far / near) / math.log(2.0))

    def __call__(self, values: Array) -> Array:
        """Return ln of the likelihood (N,), up to a constant, of H, gamma, Lx, Ly, coverage (N, 5)."""
        difference = (self.expected(values[:, : len(SHAPE)]) - self.dimension) / self.error
        return np.asarray(-0.5 * difference * difference)
