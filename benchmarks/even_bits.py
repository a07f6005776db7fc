"""A look-up whose axis is even in the bits of the thickness: measured beside ``LookUp``, not used by the engine.

Tables are resampled to intervals that are even in the leading bits of a single-precision number, so that a pixel's
interval needs no search and no division. Resampling costs accuracy: a line between new nodes misses the corners of the
line between the old ones.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

SHIFT = 13
"""Bits within an interval: 1024 intervals from each power of 2 to the next."""

AT_ONCE = 64


class EvenBits:
    """Tables of one layer on an axis even in bits.

    Parameters
    ----------
    clear : ndarray (C,)
    nodes_m : ndarray (N,)
    alone : ndarray (N, C)
    """

    def __init__(self, clear: NDArray[Any], nodes_m: NDArray[Any], alone: NDArray[Any]) -> None:
        ends = nodes_m[[0, -1]].astype(np.float32).view(np.int32)
        self._first = int(ends[0]) >> SHIFT
        axis = (np.arange(self._first, (int(ends[1]) >> SHIFT) + 3, dtype=np.int64) << SHIFT).astype(np.int32)
        even = np.stack([np.interp(axis.view(np.float32), nodes_m, each) for each in alone.T])
        # clear sky is two entries before the first interval
        self._table = np.concatenate((clear[:, None], clear[:, None], even), axis=1).astype(np.float32)

    def fill(self, radiance: NDArray[np.float32], thickness_m: NDArray[np.float32]) -> None:
        """Write radiance (C, Y, X) for a thickness (Y, X), 0 without cloud."""
        _fill(radiance, self._table, thickness_m.view(np.int32), self._first)


@njit(nogil=True)
def _fill(radiance, table, bits, first):  # type: ignore[no-untyped-def]
    start, mask, step = np.int32(first << SHIFT), np.int32((1 << SHIFT) - 1), np.float32(2.0**-SHIFT)
    index, share = np.empty(AT_ONCE, np.uint32), np.empty(AT_ONCE, np.float32)
    width = bits.shape[1]
    for y in range(bits.shape[0]):
        for left in range(0, width, AT_ONCE):
            count = min(AT_ONCE, width - left)
            for x in range(count):
                place = np.int32(bits[y, left + x] - start)
                cloudy = place >= 0
                index[x] = np.uint32((place >> np.int32(SHIFT)) + np.int32(2)) if cloudy else np.uint32(0)
                share[x] = np.float32(place & mask) * step if cloudy else np.float32(0.0)
            for c in range(table.shape[0]):
                values, plane = table[c], radiance[c, y, left : left + count]
                for x in range(count):
                    low = values[index[x]]
                    plane[x] = low + share[x] * (values[index[x] + np.uint32(1)] - low)
