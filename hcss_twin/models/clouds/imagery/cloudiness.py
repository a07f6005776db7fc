"""Clouds in an image: the grey scale, the threshold above which a pixel is cloud, and the thickness (eq 7).

All functions take a *cloudiness level*: grey levels with the sign for which cloud has the larger values. Missing pixels
are NaN and are ignored. A pixel is cloudy if its level exceeds the threshold.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from hcss_twin.core.arrays import Array

Method = Literal["otsu", "local", "coverage"]

# Cloudy pixels above this percentile of grey levels get the maximum thickness: otherwise a few glinting or noisy pixels
# would make all other clouds thin.
TOP_PERCENTILE = 99.9

# Bins of the histogram: the levels of the 8-bit images for which Otsu devised his method.
_BINS = 256

# Bins for the most frequent sea level: fewer, to reduce the effect of noise.
_SEA_BINS = 64

# Ratio of the standard deviation to the median absolute deviation of a normal distribution.
_MEDIAN_TO_SIGMA = 1.4826

# One pixel in 700 of a normal background exceeds its mean by this many standard deviations.
_FLOOR_SIGMAS = 3.0


def otsu_threshold(level: Array) -> float:
    """Return the level that best splits the histogram of ``level`` (any shape) into two classes.

    The method maximises the between-class variance [mu_T w(k) - mu(k)]^2 / (w(k) [1 - w(k)]) over the 255 splits of a
    histogram with 256 equal bins (N. Otsu, "A threshold selection method from gray-level histograms", IEEE Trans. Syst.
    Man Cybern. 9, 62-66, 1979, eqs 18 and 19).

    Returns
    -------
    float
        Upper edge of the last bin of the clear class; the middle one if empty bins make several splits equal, which
        makes the threshold insensitive to noise.

    Raises
    ------
    ValueError
        If there are fewer than two finite values or all are equal.
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
    # Neither class is empty: the extremes are in the first and the last bin.
    between = (total_moment * below / total - first_moment[:-1]) ** 2 / (below * (total - below))
    best = np.flatnonzero(between >= between.max() * (1.0 - 1e-12))
    return float(low + span * (0.5 * (best[0] + best[-1]) + 1.0) / _BINS)


def local_mean(level: Array, window: int) -> Array:
    """Return the mean level (rows, columns) of the ``window`` x ``window`` pixels around each pixel.

    Missing pixels and pixels outside the image are ignored; NaN if the window contains no value.
    """
    valid = np.isfinite(level)
    if not valid.any():
        return np.full_like(level, np.nan)
    # Running sums lose precision if the values are large and nearly equal, such as temperatures.
    centre = float(np.median(level[valid]))
    share = uniform_filter(valid.astype(np.float64), window, mode="constant")
    summed = uniform_filter(np.where(valid, level - centre, 0.0), window, mode="constant")
    mean = np.full_like(level, np.nan)
    np.divide(summed, share, out=mean, where=share > 0.5 / window**2)
    return mean + centre


def local_threshold(level: Array, window: int) -> Array:
    """Return a threshold for each pixel: the mean of a square window around it, between a floor and a ceiling.

    The mean is the threshold of D. Bradley and G. Roth, "Adaptive thresholding using the integral image", J. Graphics
    Tools 12(2), 13-21, 2007, without their offset, which is a fraction of the grey level and has no meaning for
    temperatures. On its own, it flags half of an open sea as cloud and half of a closed cloud deck as clear. It is
    therefore limited by

    * a ceiling, Otsu's threshold of the whole image: brighter pixels are always cloud;
    * a floor, three standard deviations above the most frequent level below the ceiling, that of the sea. The standard
    deviation is that of the darker side, which contains no thin cloud.

    Over a background as variable as the clouds (land, or many degrees of latitude in the infrared), the floor reaches
    the ceiling, and the result is Otsu's threshold.

    Parameters
    ----------
    level : ndarray (rows, columns)
        Cloudiness level.
    window : int
        Side of the window in pixels.

    Returns
    -------
    ndarray (rows, columns)
        Threshold; NaN where the window contains no value.

    Raises
    ------
    ValueError
        If the finite levels are all equal.
    """
    ceiling = otsu_threshold(level)
    floor = min(_sea_limit(level[level <= ceiling]), ceiling)
    bounded: Array = np.clip(local_mean(level, window), floor, ceiling)
    return bounded


def _sea_limit(clear: Array) -> float:
    """Return the level that a clear sea rarely exceeds, from the levels (N,) of the clear class."""
    low = float(clear.min())
    span = float(clear.max()) - low
    if span == 0.0:
        return low
    counts, _ = np.histogram((clear - low) / span, bins=_SEA_BINS, range=(0.0, 1.0))
    peak = low + span * (int(np.argmax(counts)) + 0.5) / _SEA_BINS
    spread = _MEDIAN_TO_SIGMA * float(np.median(peak - clear[clear <= peak]))
    return peak + _FLOOR_SIGMAS * spread


def coverage_threshold(level: Array, coverage: float) -> float:
    """Return the threshold exceeded by the fraction ``coverage`` of the pixels.

    Parameters
    ----------
    level : ndarray, any shape
        Cloudiness level; NaN where missing.
    coverage : float
        Fraction of the visible pixels that are cloudy.

    Returns
    -------
    float
        The level of the cloudiest clear pixel; +inf for no cloud, -inf for all pixels. The coverage is exact to half a
        pixel if levels differ. Pixels with equal levels are treated alike, which gives the closer of the two possible
        fractions.

    Raises
    ------
    ValueError
        If the coverage is outside [0, 1].
    """
    if not 0 <= coverage <= 1:
        raise ValueError(f"{coverage:g} given, allowed 0 to 1; closest is {min(max(coverage, 0.0), 1.0):g}")
    finite = np.sort(level[np.isfinite(level)])
    wanted = round(coverage * finite.size)
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


class Cloudiness:
    """Threshold and thickness of the clouds in an image, from its cloudiness level."""

    @staticmethod
    def threshold(
        level: Array, method: Method, window: int | None, coverage: float, scene: Array
    ) -> tuple[float | Array, float]:
        """Return the threshold, for the whole image or by pixel, and its minimum, where thickness starts.

        Parameters
        ----------
        level : ndarray (rows, columns)
            Cloudiness level of the image.
        method : {"otsu", "local", "coverage"}
            :func:`otsu_threshold`, :func:`local_threshold` or :func:`coverage_threshold`.
        window : int or None
            Side in pixels of the averaging window of method ``local``; default: an eighth of the shorter side.
        coverage : float
            Fraction of cloudy pixels of ``scene``, for method ``coverage``.
        scene : ndarray
            The part of ``level`` that has this coverage.

        Raises
        ------
        ValueError
            If the levels have no contrast or the coverage is not possible.
        """
        if method == "otsu":
            otsu = otsu_threshold(level)
            return otsu, otsu
        if method == "local":
            local = local_threshold(level, window or max(3, min(level.shape) // 8))
            return local, float(np.nanmin(local))
        wanted = coverage_threshold(scene, coverage)
        return wanted, max(wanted, float(np.nanmin(level)))

    @staticmethod
    def relative_grey(level: Array, lowest: float) -> Array:
        """Return C' = (C - C_min) / (C_max - C_min) of cloudy pixels, clipped to 0 to 1 (eq 7 for images).

        Parameters
        ----------
        level : ndarray (N,)
            Cloudiness level C of the cloudy pixels.
        lowest : float
            C_min, the threshold. Pixels below it, which come from filled holes, get 0.

        Returns
        -------
        ndarray (N,)
            C_max is the 99.9th percentile of ``level``. All values are 1 if it does not exceed C_min.
        """
        if level.size == 0:
            return np.zeros(0)
        top = float(np.percentile(level, TOP_PERCENTILE))
        if top <= lowest:
            return np.ones_like(level)
        relative: Array = np.clip((level - lowest) / (top - lowest), 0.0, 1.0)
        return relative

    @staticmethod
    def thickness_of(relative: Array, thickness_min_m: float, thickness_max_m: float) -> NDArray[np.float32]:
        """Return Th = Th_min + (Th_max - Th_min) C' for relative grey levels C' (any shape) of cloudy pixels (eq 7).

        The single-precision result neither exceeds Th_max nor rounds to 0, which means clear sky.
        """
        values = (thickness_min_m + (thickness_max_m - thickness_min_m) * relative).astype(np.float32)
        highest = np.float32(thickness_max_m)
        if float(highest) > thickness_max_m:
            highest = np.nextafter(highest, np.float32(0.0))
        inside: NDArray[np.float32] = np.maximum(np.minimum(values, highest), np.finfo(np.float32).tiny)
        return inside
