"""Posterior density of the parameters of one image, or of those that a dimension tells of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hcss_twin.uncertainty.scales import KINDS
from hcss_twin.uncertainty.space import Space

Array = NDArray[np.float64]

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
