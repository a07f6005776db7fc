"""Adaptive thresholds that separate cloud from sea in an image.

All functions take a *cloudiness level*: grey levels with the sign that makes cloud the larger
value. Missing pixels are NaN and count for nothing. A pixel is cloud where its level is greater
than the threshold.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

# Grey levels of the histogram: those of the 8-bit images for which Otsu's method was made.
_BINS = 256

# Grey levels among which the most frequent one of the sea is looked for: fewer, so that noise does not win.
_SEA_BINS = 64

# Standard deviation of a normal distribution over the median of its absolute deviations.
_MEDIAN_TO_SIGMA = 1.4826

# Of a normal background, one pixel in 700 exceeds its centre by this many standard deviations.
_FLOOR_SIGMAS = 3.0


def otsu_threshold(level: NDArray[np.float64]) -> float:
    """Return the level that best splits the histogram into two classes.

    Maximises the between-class variance [mu_T w(k) - mu(k)]^2 / (w(k) [1 - w(k)]) over the 255
    splits of a histogram with 256 equal bins (N. Otsu, "A threshold selection method from
    gray-level histograms", IEEE Trans. Syst. Man Cybern. 9, 62-66, 1979, eqs 18 and 19).

    Parameters
    ----------
    level : ndarray of float64, any shape
        Cloudiness level, NaN where missing; at least two different finite values.

    Returns
    -------
    float
        Upper edge of the last bin of the clear class. Where empty bins make several splits equal,
        the one in their middle, so that noise does not decide.

    Raises
    ------
    ValueError
        If the finite values are fewer than two or all equal.
    """
    finite = level[np.isfinite(level)]
    if finite.size < 2 or finite.min() == finite.max():
        raise ValueError("level: no two different values given, allowed: at least two")
    low = finite.min()
    span = finite.max() - low
    # Scaled first: the edges of a histogram of nearly equal large numbers would coincide.
    counts, _ = np.histogram((finite - low) / span, bins=_BINS, range=(0.0, 1.0))
    below = np.cumsum(counts)[:-1].astype(np.float64)
    first_moment = np.cumsum(counts * np.arange(_BINS, dtype=np.float64))
    total, total_moment = float(finite.size), first_moment[-1]
    # Neither class is empty: the extremes lie in the first and in the last bin.
    between = (total_moment * below / total - first_moment[:-1]) ** 2 / (below * (total - below))
    best = np.flatnonzero(between >= between.max() * (1.0 - 1e-12))
    return float(low + span * (0.5 * (best[0] + best[-1]) + 1.0) / _BINS)


def local_mean(level: NDArray[np.float64], window: int) -> NDArray[np.float64]:
    """Return the mean level of the ``window`` x ``window`` pixels around each pixel, without the missing.

    Parameters
    ----------
    level : ndarray of float64 (rows, columns)
        Cloudiness level, NaN where missing.
    window : int
        Side in pixels; at the border only what lies inside the image counts.

    Returns
    -------
    ndarray of float64 (rows, columns)
        NaN where the window holds no value.
    """
    valid = np.isfinite(level)
    if not valid.any():
        return np.full_like(level, np.nan)
    # Running sums lose digits where the values are large and alike, as temperatures are.
    centre = float(np.median(level[valid]))
    share = uniform_filter(valid.astype(np.float64), window, mode="constant")
    summed = uniform_filter(np.where(valid, level - centre, 0.0), window, mode="constant")
    mean = np.full_like(level, np.nan)
    np.divide(summed, share, out=mean, where=share > 0.5 / window**2)
    return mean + centre


def local_threshold(level: NDArray[np.float64], window: int) -> NDArray[np.float64]:
    """Return a threshold for each pixel: the mean of its surroundings, between a floor and a ceiling.

    The mean of a square window is the threshold of D. Bradley and G. Roth, "Adaptive thresholding
    using the integral image", J. Graphics Tools 12(2), 13-21, 2007, without their offset, which is
    a fraction of the grey level and has no meaning for a temperature. Alone it flags half of an
    open sea and clears half of a closed cloud deck. Therefore it is held between

    * the ceiling, Otsu's threshold of the whole image: what is brighter is cloud everywhere;
    * the floor, three standard deviations above the most frequent level below the ceiling, the
      sea. The standard deviation is that of the darker side, where there is no thin cloud.

    Over a background as varied as the clouds (land, or many degrees of latitude in the infrared)
    the floor reaches the ceiling, and the result is Otsu's.

    Parameters
    ----------
    level : ndarray of float64 (rows, columns)
        Cloudiness level, NaN where missing.
    window : int
        Side of the surroundings in pixels.

    Returns
    -------
    ndarray of float64 (rows, columns)
        Threshold; NaN where the window holds no value.

    Raises
    ------
    ValueError
        If the finite levels are all equal.
    """
    ceiling = otsu_threshold(level)
    floor = min(_sea_limit(level[level <= ceiling]), ceiling)
    bounded: NDArray[np.float64] = np.clip(local_mean(level, window), floor, ceiling)
    return bounded


def _sea_limit(clear: NDArray[np.float64]) -> float:
    """Return the level that a sea without cloud rarely exceeds, from the clear class (N,) of an image."""
    low = float(clear.min())
    span = float(clear.max()) - low
    if span == 0.0:
        return low
    counts, _ = np.histogram((clear - low) / span, bins=_SEA_BINS, range=(0.0, 1.0))
    peak = low + span * (int(np.argmax(counts)) + 0.5) / _SEA_BINS
    spread = _MEDIAN_TO_SIGMA * float(np.median(peak - clear[clear <= peak]))
    return peak + _FLOOR_SIGMAS * spread


def coverage_threshold(level: NDArray[np.float64], coverage: float) -> float:
    """Return the threshold above which the wanted fraction of the pixels lies.

    Parameters
    ----------
    level : ndarray of float64, any shape
        Cloudiness level, NaN where missing; missing pixels are clear but count as pixels.
    coverage : float
        Wanted fraction of cloudy pixels.

    Returns
    -------
    float
        The level of the cloudiest clear pixel; +inf for no cloud, -inf for all pixels. Exact to half
        a pixel where the levels differ. Equal levels stay together: of the two fractions on either
        side of their group, the closer one is taken.

    Raises
    ------
    ValueError
        If the coverage is outside [0, 1 - fraction of missing pixels].
    """
    finite = np.sort(level[np.isfinite(level)])
    wanted = round(coverage * level.size)
    if not 0 <= coverage <= 1 or wanted > finite.size:
        limit = finite.size / level.size
        raise ValueError(
            f"{coverage:g} given, allowed 0 to {limit:g} ({level.size - finite.size} of {level.size} pixels "
            f"are missing); closest is {min(max(coverage, 0.0), limit):g}"
        )
    if wanted == 0:
        return float("inf")
    if wanted == finite.size:
        return float("-inf")
    split = float(finite[finite.size - wanted - 1])
    fewer = finite.size - int(np.searchsorted(finite, split, side="right"))
    more = finite.size - int(np.searchsorted(finite, split, side="left"))
    if wanted - fewer <= more - wanted:
        return split
    below = finite[: finite.size - more]
    return float(below[-1]) if below.size else float("-inf")
