"""The octaves of the fractal sum in a fit: known, or unknown and marginalised.

An image shows octaves with cells from its size down to its pixel. Whether finer ones follow, which only roughen its
shortest lags, cannot be seen apart from H: stratus ends at cells of 20 m, the paper's simulated type at less than a
millimetre. So an unknown last octave is a parameter with a uniform prior, over which the likelihood is averaged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import Array

UNKNOWN = tuple(range(3, 11))
"""Possible last octaves where none is given; types of the catalogue have 4 to 10."""


@dataclass(frozen=True)
class Octaves:
    """First octave k, and the possible last ones (K,), ascending and equally likely."""

    first: int
    lasts: tuple[int, ...]

    @classmethod
    def of(cls, given: tuple[int, int] | None) -> Octaves:
        """Return the octaves of FIRST and LAST, or unknown ones."""
        return cls(0, UNKNOWN) if given is None else cls(given[0], given[1:])

    @property
    def known(self) -> tuple[int, int] | None:
        """First and last octave, if the last one is known."""
        return (self.first, self.lasts[0]) if len(self.lasts) == 1 else None

    @property
    def text(self) -> str:
        """Description for notes."""
        if self.known is not None:
            return f"Octaves {self.first} to {self.lasts[0]} are assumed."
        return (
            f"The last octave is unknown: {self.lasts[0]} to {self.lasts[-1]} are equally likely before the image is "
            "seen (--type or --octaves states it)."
        )

    def index(self, last: NDArray[np.int64]) -> NDArray[np.intp]:
        """Return the position in ``lasts`` of last octaves (any shape)."""
        return np.asarray(np.searchsorted(np.array(self.lasts), last))

    def draw(self, density: Array, rng: np.random.Generator) -> NDArray[np.int64]:
        """Draw a last octave (N,) for each row of log densities (N, K); any of them where all are 0."""
        largest = density.max(axis=1, keepdims=True)
        weight = np.where(np.isfinite(largest), np.exp(density - np.where(np.isfinite(largest), largest, 0.0)), 1.0)
        total = np.cumsum(weight, axis=1)
        below = total < (rng.uniform(size=density.shape[0]) * total[:, -1])[:, None]
        return np.asarray(np.array(self.lasts)[below.sum(axis=1)], dtype=np.int64)


def mean_density(density: Array) -> Array:
    """Return the logarithm (N,) of the mean over last octaves of densities given by logarithms (N, K)."""
    if density.shape[1] == 1:
        return np.asarray(density[:, 0])
    largest = density.max(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = largest + np.log(np.exp(density - largest[:, None]).sum(axis=1)) - math.log(density.shape[1])
    return np.where(np.isfinite(largest), mean, -np.inf)
