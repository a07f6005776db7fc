"""Cloud fraction value and exact coverage: which pixels of a frame are cloudy (eq 5 of the HCSS paper).

The pixels with the highest field values are cloudy, exactly as many as the coverage requires. The paper sorts the
pixels; sorting the few near the threshold, or a histogram of their values, gives it faster. The quantile of the normal
distribution would give the coverage only on average over realisations: with large cells, the coverage of single frames
scatters by 0.04.

A window of a frame therefore depends on the rest of the frame. :func:`summarise` reduces this dependence to three
numbers in bounded memory, by counting the field values strip by strip.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel

_f4, _i4 = np.float32, np.int32

Field = NDArray[np.float32]

_LARGEST_VALUE = 9.0
"""For |V| above 9, the exceedance at 9, 1e-19, is used."""

_HALF_WORDS = 1 << 16
"""Number of values of the upper (or lower) 16 bits of a single-precision number."""


@kernel()
def exceedance(field: NDArray[np.float32], share: NDArray[np.float32]) -> None:
    """Write Q(V) = 1 - p = (1 - erf(V / sqrt 2)) / 2 of ``field`` (N,) into ``share`` (N,); p is that of eq 5.

    Q is used because clouds are the high values: in single precision p is exactly 1 above V = 5.4, where Q still has
    full precision. Q is exp(-V^2 / 2) times a rational function, our own minimax fit, with a relative error below 8e-6
    up to V = 9. It needs only additions, multiplications and divisions, so that results are bit-identical on all
    machines.
    """
    for i in range(field.size):
        v = min(abs(field[i]), _f4(_LARGEST_VALUE))
        whole = v * v * _f4(-0.7213475204444817)  # of exp(-v^2 / 2) as a power of 2
        k = _i4(whole - _f4(0.5))
        share[i] = _i4((k + _i4(127)) << _i4(23)).view(np.float32)
    for i in range(field.size):
        v = min(abs(field[i]), _f4(_LARGEST_VALUE))
        whole = v * v * _f4(-0.7213475204444817)
        k = _i4(whole - _f4(0.5))
        f = whole - _f4(k)
        power = _f4(1.0000000005541196) + f * (
            _f4(0.693147205731401)
            + f
            * (
                _f4(0.24022646890283433)
                + f * (_f4(0.05550328788681462) + f * (_f4(0.009618489058468727) + f * _f4(0.001339992679999926)))
            )
        )
        numerator = _f4(0.5000000009390256) + v * (
            _f4(0.4223514122126952)
            + v * (_f4(0.17164778855267124) + v * (_f4(0.03678277684890045) + v * _f4(0.003557918526464711)))
        )
        denominator = _f4(1.0) + v * (
            _f4(1.642587531176897)
            + v
            * (
                _f4(1.1538889879062961)
                + v * (_f4(0.4389124198358902) + v * (_f4(0.09221454018801588) + v * _f4(0.008918054551861829)))
            )
        )
        above = share[i] * power * numerator / denominator
        share[i] = above if field[i] > _f4(0.0) else _f4(1.0) - above


def cloud_fraction_value(field: Array) -> Array:
    """Map a standard normal field V to p = (1 + erf(V / sqrt 2)) / 2, uniform on [0, 1] (eq 5); any shape.

    p is exactly 1 above V = 8.3; order pixels by the field, not by p.
    """
    from scipy.special import erf  # takes 0.1 s to import

    p: Array = 0.5 * (1.0 + erf(field * np.sqrt(0.5)))
    return p


def cloudy_pixels(field: NDArray[np.floating[Any]], coverage: float) -> NDArray[np.bool_]:
    """Return the mask of the pixels with the highest field values, exactly as many as the coverage requires (eq 5).

    Sorting the field is equivalent to sorting p, because eq 5 is monotonic, and the field does not saturate.

    Parameters
    ----------
    field : ndarray of floating point (rows, columns)
        The field V.
    coverage : float
        Fraction of cloudy pixels, 0 to 1.

    Returns
    -------
    ndarray of bool (rows, columns)
        True in ``round(coverage * field.size)`` pixels (halves round to even). Pixels with equal values are ordered
        by flat index.

    Raises
    ------
    ValueError
        If the coverage is outside [0, 1].
    """
    lowest, surplus = highest_values(field, coverage)
    if lowest is None:
        return np.zeros(field.shape, dtype=np.bool_)
    mask: NDArray[np.bool_] = np.greater_equal(field, lowest)
    mask.ravel()[surplus] = False
    return mask


def highest_values(
    field: NDArray[np.floating[Any]], coverage: float
) -> tuple[np.floating[Any] | None, NDArray[np.intp]]:
    """Return the lowest cloudy value (None without cloud) and the flat indices of surplus pixels with this value.

    Parameters and errors are as for :func:`cloudy_pixels`.
    """
    if not 0.0 <= coverage <= 1.0:
        raise ValueError(f"coverage: {coverage} given, allowed 0 to 1; closest is {1.0 if coverage > 1.0 else 0.0}")
    count, flat, nothing = round(coverage * field.size), field.ravel(), np.empty(0, dtype=np.intp)
    if count == 0:
        return None, nothing
    if count == field.size:
        return flat.min(), nothing
    rank = flat.size - count
    lowest = _value_at(flat, rank)
    surplus = int(np.count_nonzero(flat >= lowest)) - count
    return lowest, np.flatnonzero(flat == lowest)[-surplus:] if surplus else nothing


_SAMPLE = 4096
"""Values of a sample that tells about where a rank lies."""


def _value_at(flat: NDArray[np.floating[Any]], rank: int) -> np.floating[Any]:
    """Return the value at a rank, from 0: only values near that of a sample are sorted, a tenth of the time."""
    sample = flat[:: max(1, flat.size // _SAMPLE) | 1].copy()  # an odd step, for rows have an even number of pixels
    share, spread = rank / flat.size * sample.size, 3.0 * math.sqrt(sample.size) + 2.0
    ends = max(0, int(share - spread)), min(sample.size - 1, int(share + spread))
    sample.partition(ends)
    near = np.empty(flat.size // 4 + 64, dtype=flat.dtype)
    below, count = _between(flat, sample[ends[0]], sample[ends[1]], near)
    if not below <= rank < below + count:  # many equal values, or a sample that is not like the whole
        near, below, count = flat, 0, flat.size
    value: np.floating[Any] = np.partition(near[:count], rank - below)[rank - below]
    return value


@kernel()
def _between(values: Any, low: Any, high: Any, near: Any) -> Any:
    """Collect values from low to high; return how many are lower, and how many are collected, 0 if they do not fit."""
    below, count = 0, 0
    for i in range(values.size):
        value = values[i]
        near[count] = value
        below += value < low
        count += (value >= low) & (value <= high)
        if count == near.size:
            return below, 0
    return below, count


@dataclass(frozen=True)
class FrameSummary:
    """Three numbers that determine which pixels of a frame are cloudy.

    Attributes
    ----------
    lowest : float or None
        Lowest field value of a cloudy pixel; None without cloud.
    highest : float
        Highest field value.
    last : int
        Flat index of the last cloudy pixel with the lowest value; pixels with equal values become cloudy in index
        order.
    """

    lowest: float | None
    highest: float
    last: int


def summarise(strips: Callable[[], Iterator[Field]], size: int, coverage: float) -> FrameSummary:
    """Determine which pixels of a frame are cloudy, in two or three passes over its field.

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
    extremes = np.array([np.inf, -np.inf], dtype=np.float32)

    def with_extremes() -> Iterator[Field]:
        for strip in strips():
            extremes[:] = min(extremes[0], strip.min()), max(extremes[1], strip.max())
            yield strip

    upper = _counted_upper(with_extremes())
    highest = float(extremes[1])
    if count == size:
        return FrameSummary(float(extremes[0]), highest, size - 1)
    half, rank = _bin_of_rank(upper, size - count)
    lowest, rank, equal = _order_statistic(strips(), half, rank)
    last = size - 1 if rank == 0 else _index_of(strips(), _f4(lowest), equal - rank)
    return FrameSummary(lowest, highest, last)


def _counted_upper(strips: Iterable[Field]) -> NDArray[np.int64]:
    counts = np.zeros(_HALF_WORDS, dtype=np.int64)
    for strip in strips:
        _count_upper(strip.view(np.int32).reshape(-1), counts)
    return counts


def _order_statistic(strips: Iterable[Field], half: int, rank: int) -> tuple[float, int, int]:
    """Return the value at a rank among values with upper bits ``half``, its rank among equal ones, and their number."""
    counts = np.zeros(_HALF_WORDS, dtype=np.int64)
    for strip in strips:
        _count_lower(strip.view(np.int32).reshape(-1), half, counts)
    rest, rank = _bin_of_rank(counts, rank)
    order = half << 16 | rest
    bits = order ^ 0x8000_0000 if order & 0x8000_0000 else order ^ 0xFFFF_FFFF  # the inverse of _order
    return float(np.array(bits, dtype=np.uint32).view(np.float32)), rank, int(counts[rest])


def _bin_of_rank(counts: NDArray[np.int64], rank: int) -> tuple[int, int]:
    """Return the bin that holds a rank, from 0, and the rank within the bin."""
    ends = np.cumsum(counts)
    chosen = int(np.searchsorted(ends, rank, side="right"))
    return chosen, rank - int(ends[chosen] - counts[chosen])


def _index_of(strips: Iterable[Field], value: np.float32, number: int) -> int:
    """Return the flat index of the ``number``-th pixel, from 1, with this value."""
    before = 0
    for strip in strips:
        indices = np.flatnonzero(strip == value)
        if indices.size >= number:
            return before + int(indices[number - 1])
        number -= indices.size
        before += strip.size
    raise AssertionError("the field changed between two passes")


@kernel(inner=True)
def _order(word: Any) -> Any:
    """Map the bits of a single-precision number to an ordered 32-bit integer; both zeros map to the same one."""
    if word == -2147483648:
        return 2147483648
    return word + 2147483648 if word >= 0 else -1 - word


@kernel()
def _count_upper(words: Any, counts: Any) -> None:
    for i in range(words.size):
        counts[_order(np.int64(words[i])) >> 16] += 1


@kernel()
def _count_lower(words: Any, half: int, counts: Any) -> None:
    for i in range(words.size):
        order = _order(np.int64(words[i]))
        if order >> 16 == half:
            counts[order & 65535] += 1
