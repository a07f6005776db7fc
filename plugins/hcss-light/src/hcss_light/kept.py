"""Source functions that are kept while clouds drift: frames between two instants march the view alone.

Light within clouds changes little in seconds, and moves with them. Kept is its ratio to the mean of its height, so that
the warmth of heights stays: columns do change, from point to point and with time. Where one is higher than it was, its
top gets the ratio of the old top, and where there was none, 1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_light.slices import Field
from hcss_twin.core.kernels import kernel


@dataclass(frozen=True)
class KeptSource:
    """Source functions of some groups of wavenumbers in the cloudy part of each column.

    Attributes
    ----------
    low, start : ndarray (y, x), (y x + 1,)
        Lowest cloudy slice of each column, and where its values begin; they end where the next ones begin.
    values : ndarray of float32 (G, N)
        Over the means.
    means : ndarray of float32 (G, Z)
        Over the cloud of each slice.
    """

    low: NDArray[np.int64]
    start: NDArray[np.int64]
    values: NDArray[np.float32]
    means: NDArray[np.float32]

    @classmethod
    def of(cls, density: Field, sources: Sequence[Field]) -> KeptSource:
        """Return sources (Z, y, x) without the clear parts of their columns."""
        cloudy = density > 0.0
        some = np.any(cloudy, axis=0)
        low = np.where(some, np.argmax(cloudy, axis=0), 0)
        high = np.where(some, density.shape[0] - np.argmax(cloudy[::-1], axis=0), 0)
        start = np.concatenate(([0], np.cumsum(high - low)))
        values = np.empty((len(sources), int(start[-1])), dtype=np.float32)
        means = np.empty((len(sources), density.shape[0]), dtype=np.float32)
        number = np.count_nonzero(cloudy, axis=(1, 2))
        slices = np.arange(density.shape[0])
        for value, mean, source in zip(values, means, sources, strict=True):
            # Slices without cloud have the mean of the nearest one with it.
            mean[:] = 1.0
            if np.any(number):
                sums = np.asarray(np.sum(source, axis=(1, 2), where=cloudy, dtype=np.float64))
                mean[:] = np.interp(slices, slices[number > 0], (sums / np.maximum(number, 1))[number > 0])
            _pack(source, np.maximum(mean, np.finfo(np.float32).tiny), low, start, value)
        return cls(low, start, values, means)

    def at(self, density: Field, moved: Sequence[float]) -> Iterator[Field]:
        """Yield the source (Z, y, x) of each group in clouds that have moved by so many rows and columns, 0 or more."""
        whole = np.floor(moved).astype(np.int64)
        part = np.asarray(moved, dtype=np.float64) - whole
        result = np.empty((self.values.shape[0], *density.shape), dtype=np.float32)
        _unpack(density, self.low, self.start, self.values, self.means, whole, part, result)
        yield from result


@kernel()
def _pack(source: Any, mean: Any, low: Any, start: Any, values: Any) -> None:
    rows, columns = low.shape
    for y in range(rows):
        for x in range(columns):
            first = start[y * columns + x]
            for n in range(start[y * columns + x + 1] - first):
                values[first + n] = source[low[y, x] + n, y, x] / mean[low[y, x] + n]


@kernel()
def _unpack(density: Any, low: Any, start: Any, values: Any, means: Any, whole: Any, part: Any, result: Any) -> None:
    count, rows, columns = density.shape
    first, size, bottom = np.empty(4, dtype=np.int64), np.empty(4, dtype=np.int64), np.empty(4, dtype=np.int64)
    weight = np.empty(4, dtype=np.float32)
    result[:] = 0.0
    for y in range(rows):
        for x in range(columns):
            near = 0
            for corner in range(4):
                down, right = corner // 2, corner % 2
                share = (part[0] if down else 1.0 - part[0]) * (part[1] if right else 1.0 - part[1])
                i = min(max(y - whole[0] - down, 0), low.shape[0] - 1)
                j = min(max(x - whole[1] - right, 0), low.shape[1] - 1)
                start_of_column = start[i * low.shape[1] + j]
                length = start[i * low.shape[1] + j + 1] - start_of_column
                if share > 0.0 and length > 0:
                    first[near], size[near], weight[near], bottom[near] = start_of_column, length, share, low[i, j]
                    near += 1
            for s in range(count):
                if density[s, y, x] <= 0.0:
                    continue
                for group in range(values.shape[0]):
                    total, weights = np.float32(0.0), np.float32(0.0)
                    for n in range(near):
                        value = values[group, first[n] + min(max(s - bottom[n], 0), size[n] - 1)]
                        # Columns may have gaps.
                        if value > 0.0:
                            total += weight[n] * value
                            weights += weight[n]
                    result[group, s, y, x] = means[group, s] * (total / weights if weights > 0.0 else np.float32(1.0))
