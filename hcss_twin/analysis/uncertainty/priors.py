"""Prior distributions, written as ``uniform:0.02:0.98``."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import PosteriorOptionError, choose_from

# Kind, and what its two numbers are.
_KINDS = {
    "uniform": "low:high",
    "loguniform": "low:high",
    "normal": "mean:standard deviation",
    "lognormal": "median:standard deviation of the logarithm",
}


@dataclass(frozen=True)
class Prior:
    """A distribution of one parameter, cut off at the limits of what the parameter may be.

    Attributes
    ----------
    kind : {"uniform", "loguniform", "normal", "lognormal"}
        Shape.
    first, second : float
        Limits; mean and standard deviation; or median and standard deviation of the logarithm.
    low, high : float
        Where it ends.
    """

    kind: str
    first: float
    second: float
    low: float
    high: float

    @classmethod
    def parse(cls, name: str, text: str, low: float, high: float) -> Prior:
        """Read ``kind:number:number`` for a parameter that lies between ``low`` and ``high``.

        Raises
        ------
        PosteriorOptionError
            If it is not written so, has no width, or lies outside the limits.
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
        """As it is written."""
        return f"{self.kind}:{self.first:.6g}:{self.second:.6g}"

    def log_density(self, value: Array) -> Array:
        """Return ln of the density at values (any shape), up to a constant; -inf outside the limits."""
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
        """Return the density at values (any shape), with the integral one; 0 outside the limits."""
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
        """Parts of a normal or lognormal distribution below its two ends."""
        low, high, centre = self.low, self.high, self.first
        if self.kind == "lognormal":
            low, high = (math.log(each) if each > 0.0 else -math.inf for each in (low, high))
            centre = math.log(centre)
        return float(ndtr((low - centre) / self.second)), float(ndtr((high - centre) / self.second))

    def quantile(self, probability: Array) -> Array:
        """Return the values below which lie these parts of the distribution (any shape)."""
        if self.kind == "uniform":
            return np.asarray(self.low + (self.high - self.low) * probability)
        if self.kind == "loguniform":
            return np.asarray(self.low * (self.high / self.low) ** probability)
        takes_logarithm = self.kind == "lognormal"
        centre = math.log(self.first) if takes_logarithm else self.first
        below, above = self._parts
        # Rounding must not leave the open interval.
        position = np.clip(ndtri(below + (above - below) * probability), -8.0, 8.0)
        drawn = centre + self.second * position
        return np.asarray(np.exp(drawn) if takes_logarithm else drawn)
