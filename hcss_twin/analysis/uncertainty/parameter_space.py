"""Free parameters of a fit: prior distributions, sampling scales, and the parameter space."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.special import ndtr, ndtri

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import PosteriorOptionError, choose_from

# Kinds of priors, and the meaning of their two numbers.
_KINDS = {
    "uniform": "low:high",
    "loguniform": "low:high",
    "normal": "mean:standard deviation",
    "lognormal": "median:standard deviation of the logarithm",
}


@dataclass(frozen=True)
class Prior:
    """Prior distribution of one parameter, truncated at the parameter's limits.

    Attributes
    ----------
    kind : {"uniform", "loguniform", "normal", "lognormal"}
        Shape.
    first, second : float
        Limits, mean and standard deviation, or median and standard deviation of the logarithm.
    low, high : float
        Truncation limits.
    """

    kind: str
    first: float
    second: float
    low: float
    high: float

    @classmethod
    def parse(cls, name: str, text: str, low: float, high: float) -> Prior:
        """Read ``kind:number:number`` for a parameter that lies between ``low`` and ``high``.

        Raises PosteriorOptionError if the format is wrong, the prior has no width, or it lies outside the limits.
        """
        kind, *rest = text.split(":")
        if kind not in _KINDS:
            raise PosteriorOptionError(f"prior of {name}: '{kind}' given, {choose_from(kind, _KINDS)}")
        try:
            first, second = (float(each) for each in rest)
        except ValueError:
            raise PosteriorOptionError(
                f"prior of {name}: '{text}' given, allowed: {kind}:{_KINDS[kind]}, two numbers"
            ) from None
        if not (math.isfinite(first) and math.isfinite(second)):
            raise PosteriorOptionError(f"prior of {name}: '{text}' given, allowed: finite numbers")
        if kind in ("uniform", "loguniform"):
            if kind == "loguniform" and first <= 0.0:
                raise PosteriorOptionError(f"prior of {name}: '{text}' given, allowed: limits greater than 0")
            if not first < second:
                raise PosteriorOptionError(f"prior of {name}: '{text}' given, allowed: low < high")
            if first < low or second > high:
                near = f"{kind}:{max(first, low):g}:{min(second, high):g}"
                raise PosteriorOptionError(
                    f"prior of {name}: '{text}' given, allowed: within {low:g} to {high:g}; closest is {near}"
                )
            return cls(kind, first, second, first, second)
        if second <= 0.0:
            raise PosteriorOptionError(f"prior of {name}: '{text}' given, allowed: a standard deviation greater than 0")
        if not low < first < high or (kind == "lognormal" and first <= 0.0):
            raise PosteriorOptionError(
                f"prior of {name}: '{text}' given, allowed: a centre between {low:g} and {high:g}"
            )
        return cls(kind, first, second, max(low, 0.0) if kind == "lognormal" else low, high)

    @property
    def text(self) -> str:
        """The text that :meth:`parse` reads."""
        return f"{self.kind}:{self.first:.6g}:{self.second:.6g}"

    def log_density(self, value: Array) -> Array:
        """Return the log density at values (any shape), up to a constant; -inf outside the limits."""
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.kind == "uniform":
                density = np.zeros_like(value)
            elif self.kind == "loguniform":
                density = -np.log(value)
            elif self.kind == "normal":
                density = -0.5 * ((value - self.first) / self.second) ** 2
            else:
                logarithm = np.log(value)
                density = -0.5 * ((logarithm - math.log(self.first)) / self.second) ** 2 - logarithm
        return np.where((value > self.low) & (value < self.high), density, -np.inf)

    def density(self, value: Array) -> Array:
        """Return the normalised density at values (any shape); 0 outside the limits."""
        if self.kind == "uniform":
            whole = self.high - self.low
        elif self.kind == "loguniform":
            whole = math.log(self.high / self.low)
        else:
            below, above = self._parts
            whole = self.second * math.sqrt(2.0 * math.pi) * (above - below)
        return np.asarray(np.exp(self.log_density(value)) / whole)

    @property
    def _parts(self) -> tuple[float, float]:
        """Cumulative probability of the untruncated normal or lognormal distribution at the two limits."""
        low, high, centre = self.low, self.high, self.first
        if self.kind == "lognormal":
            low, high = (math.log(each) if each > 0.0 else -math.inf for each in (low, high))
            centre = math.log(centre)
        return float(ndtr((low - centre) / self.second)), float(ndtr((high - centre) / self.second))

    def quantile(self, probability: Array) -> Array:
        """Return the quantiles of the distribution for given probabilities (any shape)."""
        if self.kind == "uniform":
            return np.asarray(self.low + (self.high - self.low) * probability)
        if self.kind == "loguniform":
            return np.asarray(self.low * (self.high / self.low) ** probability)
        takes_logarithm = self.kind == "lognormal"
        centre = math.log(self.first) if takes_logarithm else self.first
        below, above = self._parts
        # Rounding must not move values out of the open interval.
        position = np.clip(ndtri(below + (above - below) * probability), -8.0, 8.0)
        drawn = centre + self.second * position
        return np.asarray(np.exp(drawn) if takes_logarithm else drawn)


@dataclass(frozen=True)
class ParameterScale:
    """An increasing function of a parameter.

    Attributes
    ----------
    kind : {"value", "logarithm", "probit"}
        The parameter itself, its natural logarithm, or the normal quantile of a fraction.
    """

    kind: Literal["value", "logarithm", "probit"]

    def of(self, value: Array) -> Array:
        """Convert parameters (any shape) to the scale; limits of the range may be infinite."""
        with np.errstate(divide="ignore"):
            if self.kind == "logarithm":
                return np.asarray(np.log(value))
            return np.asarray(ndtri(value)) if self.kind == "probit" else np.asarray(value)

    def back(self, position: Array) -> Array:
        """Convert positions on the scale to parameters."""
        if self.kind == "logarithm":
            return np.asarray(np.exp(position))
        return np.asarray(ndtr(position)) if self.kind == "probit" else np.asarray(position)

    def log_slope(self, position: Array) -> Array:
        """Return ln(d parameter / d position), the Jacobian for converting densities."""
        if self.kind == "logarithm":
            return np.asarray(position)
        if self.kind == "probit":
            return np.asarray(-0.5 * position * position - 0.5 * math.log(2.0 * math.pi))
        return np.zeros_like(position)


@dataclass(frozen=True)
class ParameterKind:
    """A parameter with its limits, scale and default prior.

    ``low`` and ``high`` are the exclusive limits of the generator; chains sample on ``scale``, where ``widest`` is the
    largest default spread of a population.
    """

    long_name: str
    low: float
    high: float
    scale: ParameterScale
    widest: float


KINDS = {
    "H": ParameterKind("Hurst exponent", 0.0, 1.0, ParameterScale("value"), 0.5),
    "gamma": ParameterKind(
        "gap parameter, ratio of cells of one octave to the last", 1.01, 8.0, ParameterScale("logarithm"), 0.7
    ),
    "Lx": ParameterKind("lattice cells per 16 km along x at k = 0", 0.0, math.inf, ParameterScale("logarithm"), 2.0),
    "Ly": ParameterKind("lattice cells per 16 km along y at k = 0", 0.0, math.inf, ParameterScale("logarithm"), 2.0),
    "coverage": ParameterKind("cloudy fraction of the unbounded sky", 0.0, 1.0, ParameterScale("probit"), 2.0),
}
"""Parameters of one image, in the order of all arrays."""

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
        Priors of the free parameters, in the order of :data:`hcss_twin.analysis.uncertainty.parameter_space.KINDS`.
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
