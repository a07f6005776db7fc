"""Which pixels are cloudy: eq 5 of the HCSS paper and its coverage by sorting."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import erf


def cloud_fraction_value(field: NDArray[np.float64]) -> NDArray[np.float64]:
    """Map a standard normal field to p, uniform on [0, 1] (eq 5); any shape.

    p is exactly 1 above 8.3; order pixels by the field, not by p.
    """
    p: NDArray[np.float64] = 0.5 * (1.0 + erf(field * np.sqrt(0.5)))
    return p


def cloudy_pixels(field: NDArray[np.floating[Any]], coverage: float) -> NDArray[np.bool_]:
    """Return the mask of the pixels with the greatest field values, exactly as many as asked for.

    Sorting p and sorting the field are the same, because eq 5 is monotonic; the field does not
    saturate. A threshold from the normal quantile would hold the coverage only on average over
    realisations, with a scatter of about .04 from frame to frame for large cells.

    Parameters
    ----------
    field : ndarray of floating point (rows, columns)
        The field V.
    coverage : float
        Wanted fraction of cloudy pixels, 0 to 1.

    Returns
    -------
    ndarray of bool (rows, columns)
        True in ``round(coverage * field.size)`` pixels (halves go to the even number). Of pixels
        with equal values those with the smaller flat index are taken first.

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


_BINS = 1 << 16


def _order_statistic(flat: NDArray[np.floating[Any]], rank: int) -> np.floating[Any]:
    """Return the value with exactly ``rank`` values (counting equals) before it.

    Single precision, of which every frame is made, is sorted into bins by the upper half of its bits; only
    one bin need be sorted within. Four times faster than a partition of the whole.
    """
    if flat.dtype != np.float32:
        by_partition: np.floating[Any] = np.partition(flat, rank)[rank]
        return by_partition
    counts = np.zeros(_BINS, dtype=np.int64)
    _count(flat.view(np.int32), counts)
    before = np.cumsum(counts)
    chosen = int(np.searchsorted(before, rank, side="right"))
    members = np.empty(counts[chosen], dtype=np.float32)
    _collect(flat, flat.view(np.int32), chosen, members)
    members.sort()
    value: np.float32 = members[rank - int(before[chosen]) + members.size]
    return value


@njit(cache=True, nogil=True, inline="always")
def _bin(word: Any) -> Any:
    """Order of a number among the bins: of negative numbers, the bits descend."""
    high = word >> 16
    return high + 32768 if high >= 0 else -1 - high


@njit(cache=True, nogil=True)
def _count(words: Any, counts: Any) -> None:
    for i in range(words.size):
        counts[_bin(np.int64(words[i]))] += 1


@njit(cache=True, nogil=True)
def _collect(values: Any, words: Any, chosen: Any, members: Any) -> None:
    found = 0
    for i in range(words.size):
        if _bin(np.int64(words[i])) == chosen:
            members[found] = values[i]
            found += 1


def highest_values(
    field: NDArray[np.floating[Any]], coverage: float
) -> tuple[np.floating[Any] | None, NDArray[np.intp]]:
    """Return the lowest cloudy value, None without cloud, and the pixels of that value that are too many.

    Parameters and errors are those of :func:`cloudy_pixels`.
    """
    if not 0.0 <= coverage <= 1.0:
        raise ValueError(
            f"coverage: {coverage} given, allowed 0 to 1; closest is {1.0 if coverage > 1.0 else 0.0}"
        )
    count, flat, nothing = round(coverage * field.size), field.ravel(), np.empty(0, dtype=np.intp)
    if count == 0:
        return None, nothing
    if count == field.size:
        return flat.min(), nothing
    lowest = _order_statistic(flat, flat.size - count)
    surplus = int(np.count_nonzero(flat >= lowest)) - count
    return lowest, np.flatnonzero(flat == lowest)[-surplus:] if surplus else nothing
