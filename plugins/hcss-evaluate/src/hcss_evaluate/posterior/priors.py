"""Prior distributions of the parameters of a fit, and the scales on which chains sample them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import ndtr, ndtri

from hcss_evaluate.errors import PosteriorOptionError
from hcss_twin.providers import Array, choose_from

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
            first, second = (float(number) for number in rest)
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
            low, high = (math.log(limit) if limit > 0.0 else -math.inf for limit in (low, high))
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
