"""Other readings of EV (eq 21): how grey levels are made, how many, what is counted, and in which unit.

The printed EV is about half of what eq 21 gives. Image1 of Table IX has the EV of the real image but another Den, so EV
may be the entropy of something else than neighbouring pairs. Every combination of the readings below is counted.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from hcss_paper.eq_5 import cloudy_pixels, fraction_value
from hcss_twin.providers import Array

GREYS: Mapping[str, Callable[[Array], Array]] = {
    "p of eq 5": lambda field: np.asarray(fraction_value(field), dtype=np.float64),
    "p squared": lambda field: np.asarray(fraction_value(field), dtype=np.float64) ** 2,
    "V of eq 2": lambda field: field,
    "exp V": np.exp,
}
LEVELS = (256, 128, 64, 32)
UNITS = {
    "bit": math.log(2.0),
    "half a bit": 2.0 * math.log(2.0),
    "nat": 1.0,
    "half a nat": 2.0,
    "digit": math.log(10.0),
}
COUNTED = (
    "pairs",
    "pixels",
    "pixel given its neighbour",
    "shared by neighbours",
    "pixel and mean of its neighbours",
    "cloudy pairs",
    "cloudy pixels",
    "unequal pairs",
)


@dataclass(frozen=True)
class Reading:
    """One reading of EV.

    Attributes
    ----------
    grey : str
        What grey levels are proportional to (:data:`GREYS`).
    stretch : {"clouds", "whole field"}
        Whose minimum and maximum are the first and last level of cloud.
    levels : int
        W.
    counted : str
        Events of the probability (:data:`COUNTED`).
    unit : str
        Of the entropy (:data:`UNITS`).
    """

    grey: str
    stretch: str
    levels: int
    counted: str
    unit: str


def readings(field: Array, coverage: float) -> tuple[dict[Reading, float], dict[Reading, float]]:
    """Return EV and Den of one cloud field by each reading; Den has the same grey levels and is ten times eq 22.

    Parameters
    ----------
    field : ndarray (rows, columns)
        V of eq 2.
    coverage : float
        0 to 1.
    """
    cloudy = cloudy_pixels(field, coverage)
    entropy, density = {}, {}
    for name, grey in GREYS.items():
        values = grey(field)
        for stretch, levels in itertools.product(("clouds", "whole field"), LEVELS):
            over = values[cloudy] if stretch == "clouds" else values
            low, high = float(over.min()), float(over.max())
            level = 1 + ((values - low) / (high - low) * (levels - 1)).astype(np.int64)
            level = np.where(cloudy, np.minimum(level, levels - 1), 0)
            pairs = _pairs(level, levels)
            apart = np.abs(np.subtract.outer(np.arange(levels), np.arange(levels)))
            den = 10.0 * float((pairs / (1.0 + apart)).sum() / pairs.sum())
            for counted, nats in zip(COUNTED, _entropies(level, pairs), strict=True):
                for unit, size in UNITS.items():
                    reading = Reading(name, stretch, levels, counted, unit)
                    entropy[reading], density[reading] = nats / size, den
    return entropy, density


def _pairs(level: NDArray[np.int64], levels: int) -> NDArray[np.int64]:
    cell = level[:, :-1] * levels + level[:, 1:]
    return np.bincount(cell.ravel(), minlength=levels * levels).reshape(levels, levels)


def _entropies(level: NDArray[np.int64], pairs: NDArray[np.int64]) -> tuple[float, ...]:
    """Return the entropies of :data:`COUNTED` in nats."""
    levels = len(pairs)
    of_pairs, of_pixels = _entropy(pairs), _entropy(np.bincount(level.ravel()))
    around = np.rint((9.0 * uniform_filter(level.astype(np.float64), 3) - level) / 8.0).astype(np.int64)
    return (
        of_pairs,
        of_pixels,
        of_pairs - of_pixels,
        2.0 * of_pixels - of_pairs,
        _entropy(np.bincount((level * levels + np.clip(around, 0, levels - 1)).ravel())),
        _entropy(pairs[1:, 1:]),
        _entropy(np.bincount(level[level > 0])),
        _entropy(pairs - np.diag(np.diag(pairs))),
    )


def _entropy(counts: NDArray[np.int64]) -> float:
    share = counts[counts > 0] / counts.sum()
    return -float(np.sum(share * np.log(share)))
