"""How far the values of two images lie apart, whatever their places."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import ImageError


@dataclass(frozen=True)
class DistributionDistance:
    """Differences of two distributions of values.

    Attributes
    ----------
    mean_difference : float
        Second less first, in the unit of the values.
    deviation_ratio : float
        Standard deviation of the second over that of the first.
    wasserstein : float
        W1: the mean amount by which values must change to turn one distribution into the other, in the unit of the
        values.
    wasserstein_centred : float
        The same after both means were subtracted: what is left is shape.
    kolmogorov_smirnov : float
        Greatest difference of the cumulative distributions, 0 to 1.
    """

    mean_difference: float
    deviation_ratio: float
    wasserstein: float
    wasserstein_centred: float
    kolmogorov_smirnov: float


def distribution_distance(first: NDArray[Any], second: NDArray[Any]) -> DistributionDistance:
    """Compare the values of two images.

    Parameters
    ----------
    first, second : ndarray of real numbers, any shapes
        In the same unit; NaN is missing.

    Raises
    ------
    ImageError
        If one has no value.
    """
    one, other = _sorted("first", first), _sorted("second", second)
    mean_one, mean_other = float(np.mean(one)), float(np.mean(other))
    spread_one, spread_other = float(np.std(one)), float(np.std(other))
    width, difference = _cumulative_difference(one, other)
    centred_width, centred = _cumulative_difference(one - mean_one, other - mean_other)
    ratio = spread_other / spread_one if spread_one else (1.0 if spread_other == 0.0 else math.inf)
    return DistributionDistance(
        mean_difference=mean_other - mean_one,
        deviation_ratio=ratio,
        wasserstein=float(width @ difference),
        wasserstein_centred=float(centred_width @ centred),
        kolmogorov_smirnov=float(difference.max()) if difference.size else 0.0,
    )


def _sorted(name: str, values: NDArray[Any]) -> NDArray[np.float64]:
    flat = np.asarray(values, dtype=np.float64).ravel()
    flat = np.sort(flat[~np.isnan(flat)])
    if flat.size == 0:
        raise ImageError(f"{name}: no value given, allowed: one or more that are not missing")
    return flat


def _cumulative_difference(
    one: NDArray[np.float64], other: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the steps between all values, and |F1 - F2| on each; one sort serves both distances."""
    every = np.concatenate([one, other])
    every.sort(kind="stable")
    places = every[:-1]
    difference: NDArray[np.float64] = np.abs(
        np.searchsorted(one, places, side="right") / one.size
        - np.searchsorted(other, places, side="right") / other.size
    )
    return np.diff(every), difference
