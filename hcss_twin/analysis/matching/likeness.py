"""Whether an image can be one of the fractal fields that match it.

Semivariances and histogram are fitted, so they do not decide. A Gaussian field has no other organisation; cells,
streets and fibres show in the kurtosis of differences and in the skewness of the Laplacian.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcss_twin.analysis.matching.structure import CloudImage
from hcss_twin.core.arrays import Array

_LAGS = 1, 2, 4, 8
"""Pixels."""

MAX_RATIO = 1.25
"""Distances of images above this many times the largest one between realisations are beyond chance. Measured, after a
search: .2 to .6 for fractal fields; 3.4 to 6.6 for streets, open cells, fibres and anvils; .5 to 1.5 for altocumulus,
several layers, closed cells, stratus and trade cumulus, of which a fractal field can be like the first three."""


@dataclass(frozen=True)
class Likeness:
    """Distance of an image to the realisations of its match, and of each realisation to the others (N,)."""

    distance: float
    of_realisations: tuple[float, ...]

    @property
    def is_fractal(self) -> bool:
        """Whether the image may be one of the realisations."""
        return self.distance <= MAX_RATIO * max(self.of_realisations)


def likeness(image: CloudImage, realisations: Sequence[CloudImage]) -> Likeness:
    """Measure distances in standard deviations of the realisations (rms over kurtosis and skewness at each lag)."""
    numbers = np.stack([_organisation(each) for each in realisations])
    others = [np.delete(numbers, index, axis=0) for index in range(len(numbers))]
    each = tuple(_distance(own, rest) for own, rest in zip(numbers, others, strict=True))
    return Likeness(_distance(_organisation(image), numbers), each)


def _organisation(image: CloudImage) -> Array:
    """Return the logarithm of the kurtosis of differences and the skewness of the Laplacian at each lag (8,)."""
    level, numbers = image.level.astype(np.float64), []
    for lag in _LAGS:
        steps = np.concatenate([(level[lag:] - level[:-lag]).ravel(), (level[:, lag:] - level[:, :-lag]).ravel()])
        inside = slice(lag, -lag)
        around = level[2 * lag :, inside] + level[: -2 * lag, inside] + level[inside, 2 * lag :]
        laplacian = 4.0 * level[inside, inside] - around - level[inside, : -2 * lag]
        numbers.append(np.log(np.mean(steps**4) / np.mean(steps**2) ** 2))
        numbers.append(np.mean(laplacian**3) / np.mean(laplacian**2) ** 1.5)
    return np.array(numbers)


def _distance(numbers: Array, realisations: Array) -> float:
    spread = np.std(realisations, axis=0, ddof=1)
    return float(np.sqrt(np.mean(((numbers - np.mean(realisations, axis=0)) / spread) ** 2)))
