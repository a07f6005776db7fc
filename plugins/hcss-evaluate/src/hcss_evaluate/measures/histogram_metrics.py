"""Metrics of the 2-D histogram of neighbouring grey levels: eqs 21 to 23 of the HCSS paper."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.measures.checks import checked_levels, checked_mask, range_within
from hcss_evaluate.measures.images import checked_image
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import ImageError


@dataclass(frozen=True)
class HistogramMetrics:
    """Three metrics of the counts G(g, g') of pairs f(x, y) = g, f(x + 1, y) = g'.

    Attributes
    ----------
    entropy : float
        EV, bits (eq 21): 0 to 2 log2 W.
    density : float
        Den (eq 22): mean of 1 / (1 + |g - g'|), greater than 0 and at most 1. The paper prints ten times this value.
    diagonal_peak : float
        DP (eq 23): pairs of equal levels over W - 1, as printed; the mean of the diagonal, which has W entries, would
        need W. It grows with the number of pixels.
    """

    entropy: float
    density: float
    diagonal_peak: float


def to_grey_levels(
    values: NDArray[Any], low: float, high: float, levels: int = 256, mask: NDArray[np.bool_] | None = None
) -> NDArray[np.uint8]:
    """Quantise an image (rows, columns) of any unit: cloudy pixels to 1 .. levels - 1, clear ones to 0.

    The range ``low`` to ``high`` is divided into levels - 1 equal steps; the value ``high`` belongs to the last. Pixels
    outside ``mask`` (default: none) are clear and may have any value, including NaN. ``levels`` is 3 to 256. Raises
    ImageError if a cloudy value is not finite or outside ``low`` to ``high``, or an argument is invalid.
    """
    pixels = checked_image("values", values, smallest=1)
    checked_levels(levels, 3)
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ImageError(f"low, high: {low} and {high} given, allowed: finite, low < high")
    cloudy = None if mask is None else checked_mask("mask", mask, pixels.shape)
    smallest, largest = range_within("values", pixels, cloudy)
    if smallest < low or largest > high:
        raise ImageError(
            f"values: {smallest:g} to {largest:g} given, allowed: {low:g} to {high:g}, the limits of the levels"
        )
    # Halved values, because the difference of two large numbers of opposite sign may overflow.
    per_half = (levels - 1) / (0.5 * high - 0.5 * low)
    everywhere = np.ones((1, 1), dtype=np.bool_)
    grey: NDArray[np.uint8] = _quantised(
        pixels, everywhere if cloudy is None else cloudy, cloudy is None, low, per_half, levels
    )
    return grey


@kernel()
def _quantised(pixels: Any, cloudy: Any, everywhere: bool, low: float, per_half: float, levels: int) -> Any:
    rows, columns = pixels.shape
    grey = np.zeros((rows, columns), np.uint8)
    top = np.int32(levels - 1)
    for i in range(rows):
        for j in range(columns):
            if everywhere or cloudy[i, j]:
                step = np.int32((0.5 * np.float64(pixels[i, j]) - 0.5 * low) * per_half)
                grey[i, j] = min(step + np.int32(1), top)
    return grey


def histogram_metrics(
    grey: NDArray[np.uint8], levels: int = 256, valid: NDArray[np.bool_] | None = None
) -> HistogramMetrics:
    """Compute the metrics of the 2-D histogram of horizontal neighbours in one pass.

    Arguments are those of ``joint_histogram``.

    Raises ImageError if the type, the shape, a level or ``levels`` is invalid, or no pair counts.
    """
    counts = joint_histogram(grey, levels, valid)
    pairs = int(counts.sum())
    if pairs == 0:
        raise ImageError("valid: no two neighbours along x are valid, allowed: one or more pairs")
    entropy, density, equal = _measures(counts, float(pairs))
    return HistogramMetrics(entropy, density, equal / (levels - 1))


def joint_histogram(
    grey: NDArray[np.uint8], levels: int = 256, valid: NDArray[np.bool_] | None = None
) -> NDArray[np.int64]:
    """Count the pairs f(x, y) = g, f(x + 1, y) = g' of neighbours along x: G(g, g') of eqs 21 to 23, (levels, levels).

    ``grey`` (rows, columns), at least two columns, has levels below ``levels``, 2 to 256; x runs along columns. A pair
    counts if both its pixels are ``valid`` (all, by default). Raises ImageError if an argument is invalid.
    """
    image = np.asarray(grey)
    if image.dtype != np.uint8:
        raise ImageError(f"grey: {image.dtype} given, allowed: uint8, see to_grey_levels")
    if image.ndim != 2 or image.shape[0] < 1 or image.shape[1] < 2:
        raise ImageError(f"grey: shape {image.shape} given, allowed: (rows, columns) with two columns or more")
    checked_levels(levels, 2, image)
    if valid is not None and not valid.all():
        both = checked_mask("valid", valid, image.shape)
        both = both[:, :-1] & both[:, 1:]
        cell = image[:, :-1][both].astype(np.int64) * levels + image[:, 1:][both]
        return np.bincount(cell, minlength=levels * levels).reshape(levels, levels)
    counts: NDArray[np.int64] = _pair_counts(np.ascontiguousarray(image), levels)
    return counts


@kernel()
def _pair_counts(grey: Any, levels: int) -> Any:
    """Return the counts of pairs as int64 (levels, levels)."""
    rows, columns = grey.shape
    # Two alternating histograms, because in flat regions each increment of one counter would wait for the previous one.
    even = np.zeros(levels * levels, dtype=np.uint32)
    odd = np.zeros(levels * levels, dtype=np.uint32)
    one = np.uint32(1)
    last = columns - 1
    for i in range(rows):
        left = np.int64(grey[i, 0])
        j = 1
        while j < last:
            middle = np.int64(grey[i, j])
            right = np.int64(grey[i, j + 1])
            even[left * levels + middle] += one
            odd[middle * levels + right] += one
            left = right
            j += 2
        if j == last:
            even[left * levels + np.int64(grey[i, j])] += one
    return (even.astype(np.int64) + odd.astype(np.int64)).reshape(levels, levels)


@kernel()
def _measures(counts: Any, pairs: float) -> tuple[float, float, float]:
    """Return entropy in bits, density, and the number of pairs of equal levels."""
    levels = counts.shape[0]
    entropy = 0.0
    density = 0.0
    equal = 0.0
    for g in range(levels):
        for h in range(levels):
            count = np.float64(counts[g, h])
            if count > 0.0:
                entropy -= count * math.log2(count / pairs)
                density += count / (1.0 + abs(g - h))
        equal += np.float64(counts[g, g])
    return entropy / pairs + 0.0, density / pairs, equal
