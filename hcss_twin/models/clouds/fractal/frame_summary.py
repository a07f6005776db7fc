"""What a window of a frame needs to know of the rest where coverage is that of the frame, found in bounded memory.

The pixels with the greatest field values are cloudy (see :mod:`hcss_twin.models.clouds.coverage`), so that a window
needs the
lowest of them, the greatest of all, and which of several pixels with the lowest value still count. They are found in
passes over strips of the field, which is made anew for each: the upper and then the lower half of the bits of the
order statistic by counting, and the place of the last pixel that counts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import ndtr

from hcss_twin.models.clouds.thickness import scaled_thickness
from hcss_twin.providers import CloudLayer

_HALF = 1 << 16

Field = NDArray[np.float32]


@dataclass(frozen=True)
class FrameSummary:
    """The cloudy pixels of a frame in three numbers.

    Attributes
    ----------
    lowest : float or None
        Lowest field value of a cloudy pixel; None without cloud.
    highest : float
        Greatest field value.
    last : int
        Place, in the order of rows, of the last cloudy pixel with the lowest value.
    """

    lowest: float | None
    highest: float
    last: int


def summarise(strips: Callable[[], Iterator[Field]], size: int, coverage: float) -> FrameSummary:
    """Find which pixels of a frame are cloudy.

    Parameters
    ----------
    strips : callable
        Yields the field in strips of whole rows, in order, each time it is called.
    size : int
        Pixels of the frame.
    coverage : float
        Fraction of cloudy pixels, 0 to 1.
    """
    count = round(coverage * size)
    if count == 0:
        return FrameSummary(None, 0.0, -1)
    upper, extremes = np.zeros(_HALF, dtype=np.int64), np.array([np.inf, -np.inf], dtype=np.float32)
    for strip in strips():
        _count_upper(strip.view(np.int32).reshape(-1), upper)
        extremes[:] = min(extremes[0], strip.min()), max(extremes[1], strip.max())
    highest = float(extremes[1])
    if count == size:
        return FrameSummary(float(extremes[0]), highest, size - 1)
    half, rank = _reached(upper, size - count)
    lower = np.zeros(_HALF, dtype=np.int64)
    for strip in strips():
        _count_lower(strip.view(np.int32).reshape(-1), half, lower)
    rest, rank = _reached(lower, rank)
    lowest = _number(half << 16 | rest)
    # Of the pixels with this value, those before the rank in the order of values are too many.
    wanted = int(lower[rest]) - rank
    return FrameSummary(lowest, highest, size - 1 if rank == 0 else _place(strips, np.float32(lowest), wanted))


def thickness_in_frame(
    field: Field, first: int, columns: int, summary: FrameSummary, layer: CloudLayer, exponent: float
) -> NDArray[np.float32]:
    """Return what :func:`hcss_twin.models.clouds.thickness.frame_thickness` has in a window of the frame.

    Parameters
    ----------
    field : ndarray of float32 (y, x)
        Of the window.
    first, columns : int
        Place of the window's first pixel, in the order of rows, and columns of the frame.
    """
    if summary.lowest is None:
        return np.zeros(field.shape, dtype=np.float32)
    shares = ndtr(-summary.lowest), ndtr(-summary.highest)
    thickness = scaled_thickness(field, layer, summary.lowest, *shares, exponent)
    if first + (field.shape[0] - 1) * columns + field.shape[1] - 1 > summary.last:
        y, x = np.nonzero(field == np.float32(summary.lowest))
        late = first + y * columns + x > summary.last
        thickness[y[late], x[late]] = 0.0
    return thickness


def _reached(counts: NDArray[np.int64], rank: int) -> tuple[int, int]:
    """Bin in which a rank, from 0, lies, and the rank within it."""
    ends = np.cumsum(counts)
    chosen = int(np.searchsorted(ends, rank, side="right"))
    return chosen, rank - int(ends[chosen] - counts[chosen])


def _place(strips: Callable[[], Iterator[Field]], value: np.float32, wanted: int) -> int:
    """Place of so manieth pixel, from 1, with a value."""
    before = 0
    for strip in strips():
        found = np.flatnonzero(strip == value)
        if found.size >= wanted:
            return before + int(found[wanted - 1])
        wanted -= found.size
        before += strip.size
    raise AssertionError("the field changed between two passes")


def _number(order: int) -> float:
    """Single-precision number of a place in the order of all."""
    bits = order ^ 0x8000_0000 if order & 0x8000_0000 else order ^ 0xFFFF_FFFF
    return float(np.array(bits, dtype=np.uint32).view(np.float32))


@njit(cache=True, nogil=True, inline="always")
def _order(word: Any) -> Any:
    """Place of a single-precision number, given by its bits, in the order of all; both zeros are one."""
    if word == -2147483648:
        return 2147483648
    return word + 2147483648 if word >= 0 else -1 - word


@njit(cache=True, nogil=True)
def _count_upper(words: Any, counts: Any) -> None:
    for i in range(words.size):
        counts[_order(np.int64(words[i])) >> 16] += 1


@njit(cache=True, nogil=True)
def _count_lower(words: Any, half: int, counts: Any) -> None:
    for i in range(words.size):
        order = _order(np.int64(words[i]))
        if order >> 16 == half:
            counts[order & 65535] += 1
