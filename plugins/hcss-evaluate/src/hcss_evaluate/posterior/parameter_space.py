"""Free parameters of a fit with their priors, on the scales of chains, and its fixed parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hcss_evaluate.errors import PosteriorOptionError
from hcss_evaluate.posterior.priors import KINDS, Prior
from hcss_twin.providers import Array, choose_from

SHAPE = ("H", "gamma", "Lx", "Ly")
"""Parameters that determine the field's variogram."""

# Combinations of scale and prior with a constant density on the scale.
_FLAT = (("value", "uniform"), ("logarithm", "loguniform"))


@dataclass(frozen=True)
class Space:
    """Free parameters with their priors, and the values of the fixed ones.

    Attributes
    ----------
    priors : dict of str to Prior
        Priors of the free parameters, in the order of :data:`hcss_evaluate.posterior.priors.KINDS`.
    fixed : dict of str to float
        All others.
    """

    priors: dict[str, Prior]
    fixed: dict[str, float]

    @classmethod
    def of(cls, fixed: Mapping[str, float], priors: Mapping[str, str], usual: Mapping[str, str]) -> Space:
        """Check fixed values and priors; ``usual`` has the default priors.

        Raises PosteriorOptionError if a name is unknown or both fixed and given a prior, if a value is not allowed, or
        if nothing is free.
        """
        for name in (*fixed, *priors):
            if name not in KINDS:
                raise PosteriorOptionError(f"parameter: '{name}' given, {choose_from(name, KINDS)}")
        for name in fixed:
            if name in priors:
                raise PosteriorOptionError(f"{name}: fixed and given a prior, allowed: one of the two")
            kind = KINDS[name]
            if not kind.low < fixed[name] < kind.high:
                raise PosteriorOptionError(
                    f"{name}: fixed at {fixed[name]:g}, allowed: between {kind.low:g} and {kind.high:g}"
                )
        free = {
            name: Prior.parse(name, priors.get(name, usual[name]), kind.low, kind.high)
            for name, kind in KINDS.items()
            if name not in fixed
        }
        if not free:
            raise PosteriorOptionError("parameters: all are fixed, allowed: one or more free ones")
        return cls(free, {name: float(fixed[name]) for name in KINDS if name in fixed})

    @property
    def names(self) -> tuple[str, ...]:
        """Free parameters."""
        return tuple(self.priors)

    def complete(self, position: Array) -> Array:
        """Return all parameters (..., 5), in the order of ``KINDS``, at positions (..., free)."""
        values = np.empty((*position.shape[:-1], len(KINDS)))
        for column, name in enumerate(KINDS):
            if name in self.fixed:
                values[..., column] = self.fixed[name]
            else:
                values[..., column] = KINDS[name].scale.back(position[..., self.names.index(name)])
        return values

    def position(self, values: Array) -> Array:
        """Return positions (..., free) of all parameters (..., 5); the fixed ones are dropped."""
        columns = [list(KINDS).index(name) for name in self.names]
        return np.stack([KINDS[n].scale.of(values[..., c]) for n, c in zip(self.names, columns, strict=True)], axis=-1)

    def log_prior(self, position: Array) -> Array:
        """Return the log prior density (N,) of positions (N, free), up to a constant."""
        return np.asarray(self.log_priors(position).sum(axis=1))

    def log_priors(self, position: Array) -> Array:
        """Return the log prior density of each parameter at positions, both (N, free), up to a constant."""
        density = np.zeros_like(position)
        for column, (name, prior) in enumerate(self.priors.items()):
            scale, at = KINDS[name].scale, position[:, column]
            if (scale.kind, prior.kind) in _FLAT:
                # Most priors are constant; this avoids functions that take as long as the likelihood.
                low, high = self.limits[0][column], self.limits[1][column]
                density[(at <= low) | (at >= high), column] = -np.inf
            else:
                density[:, column] = prior.log_density(scale.back(at)) + scale.log_slope(at)
        return density

    def draw(self, rng: np.random.Generator, count: int) -> Array:
        """Draw positions (count, free) from the priors."""
        columns = []
        for name, prior in self.priors.items():
            # Stratified, so that a few hundred draws cover each prior evenly.
            probability = (rng.permutation(count) + rng.uniform(size=count)) / count
            columns.append(KINDS[name].scale.of(prior.quantile(np.clip(probability, 1e-9, 1.0 - 1e-9))))
        return np.stack(columns, axis=-1)

    @cached_property
    def limits(self) -> tuple[Array, Array]:
        """Minimum and maximum position (free,) that the priors allow."""
        ends = [KINDS[name].scale.of(np.array([prior.low, prior.high])) for name, prior in self.priors.items()]
        low, high = np.array(ends).T
        return low, high
