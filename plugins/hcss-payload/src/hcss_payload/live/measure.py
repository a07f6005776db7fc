"""One band of a live frame behind the sensor, row by row: blur, noise and numbers in one pass.

The random numbers, the distribution of the noise and the converter are those of :mod:`hcss_twin.models.sensor.rows`,
without photon rates and flags. Products are added without rounding between where the processor can: live frames have
the same bits on one machine, not on all.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.kernels import kernel
from hcss_twin.models.sensor.noise import Noise

TOGETHER = 8
"""Weights of a kernel that are applied in one pass over a row."""

BLOCK = 64
"""Columns for which normal numbers are drawn at once."""

FEW, MAX_COUNTED = 100.0, 1e12
"""Fewest and most electrons to expect that noise is drawn for as a function of a normal number, as of cubes."""

_SQUARE_ROOT = np.int32(0x5F375A86)
"""Start of Newton's method for 1 / sqrt(x), from the bits of x (C. Lomont, Fast inverse square root, 2003)."""

# Known to compiled code, which reads no attributes of classes.
_fill_normals = Noise.fill_normals


class Weights(NamedTuple):
    """Weights of neighbouring pixels, as sensors of cubes have them.

    Attributes
    ----------
    down, across : ndarray (K, N) of float32
        Kernels along columns and rows, whose K products are summed; N is a multiple of 4, filled up with 0.
    reach : (int, int)
        Pixels before the middle of a kernel, along columns and rows.
    """

    down: NDArray[np.float32]
    across: NDArray[np.float32]
    reach: tuple[int, int]


class Kernels:
    """Weights of a blur that is a product of one kernel along columns and one along rows, or no blur.

    Attributes
    ----------
    down, across : ndarray of float32 (K,), (L,)
        Of neighbours from the lowest on, with zeros up to a multiple of ``TOGETHER``; empty without blur.
    reach : (int, int)
        Distance of the first weights from the pixel.
    """

    def __init__(self, weights: Weights) -> None:
        self.down, self.across = (
            np.append(axis_weights[0], np.zeros(-axis_weights.shape[1] % TOGETHER, np.float32))
            if len(axis_weights)
            else np.empty(0, np.float32)
            for axis_weights in (weights.down, weights.across)
        )
        self.reach = weights.reach

    @staticmethod
    def of(weights: Weights | None) -> Kernels | None:
        """Return the weights of a blur of the sensor; None if it is a sum of several products, or by transforms."""
        return None if weights is None or len(weights.down) > 1 else Kernels(weights)


@kernel()
def measure_rows(
    image: Any,
    down: Any,
    across: Any,
    reach: Any,
    added: Any,
    gain: Any,
    offset: Any,
    detector: Any,
    key: Any,
    lines: Any,
    radiance: Any,
    number: Any,
) -> Any:
    """Write the measurement of some rows of a frame (Y, X) of one band.

    False if pixels have so few or so many electrons that :func:`hcss_twin.models.sensor.rows.measure` must draw them.

    Parameters
    ----------
    image : ndarray of float32 (Y, X)
        Radiance, mirrored at the edges.
    down, across, reach
        As in :class:`Kernels`.
    added, gain, offset, detector
        As :func:`hcss_twin.models.sensor.rows.measure` takes them; with shot noise there must be read noise.
    key : uint64
        Of normal numbers.
    lines : (int, int)
        First row to be written, and the one after the last.
    radiance, number : ndarray (Y, X) of float32, int32
        Results; ``number`` may be of shape (0, 0).
    """
    rows, columns = image.shape
    flat, left = image.reshape(-1), reach[1]
    wide = np.zeros(columns + across.size, np.float32)
    middle, signal = wide[left : left + columns], np.empty(columns, np.float32)
    own_gain, own_offset = np.zeros(columns, np.float32), np.zeros(columns, np.float32)
    normals = np.zeros((columns + BLOCK - 1) // BLOCK * BLOCK, np.float32)
    apart = np.int32(0)
    for y in range(lines[0], min(lines[1], rows)):
        if down.size:
            first = y - reach[0]
            _fill(middle, np.float32(0.0))
            if first >= 0 and first + down.size <= rows:
                for k in range(0, down.size, TOGETHER):
                    _add_neighbours(flat, (first + k) * columns, columns, down, k, middle)
            else:
                for k in range(down.size):
                    _add_row(image[_mirrored(first + k, rows)], down[k], middle)
            for x in range(left):
                wide[x] = middle[_mirrored(x - left, columns)]
            for x in range(left + columns, wide.size):
                wide[x] = middle[_mirrored(x - left, columns)]
            _fill(signal, np.float32(0.0))
            for k in range(0, across.size, TOGETHER):
                _add_neighbours(wide, k, 1, across, k, signal)
        else:
            for x in range(columns):
                signal[x] = image[y, x]
        if added.size:
            _add_row(added[y], np.float32(1.0), signal)
        _pattern_row(gain, y, own_gain)
        _pattern_row(offset, y, own_offset)
        if detector.shot or detector.deviation:
            _fill_normals(normals, y, 0, key)
        apart |= _add_noise(signal, own_gain, own_offset, normals, detector)
        if number.size:
            _write_numbers(signal, detector, radiance[y], number[y])
        else:
            full, back = np.float32(detector.full - detector.dark), np.float32(1.0 / detector.per_radiance)
            for x in range(columns):
                radiance[y, x] = min(signal[x], full) * back
    return apart == 0


@kernel(inner=True)
def _mirrored(index: Any, size: Any) -> Any:
    while index < 0 or index >= size:
        index = -1 - index if index < 0 else 2 * size - 1 - index
    return index


@kernel(inner=True)
def _pattern_row(pattern: Any, y: Any, pattern_row: Any) -> None:
    # Loops over pixels compile in a tenth of the time of assignments to slices.
    if pattern.size and pattern.shape[1] == pattern_row.size:
        for x in range(pattern_row.size):
            pattern_row[x] = pattern[y, x]
    elif pattern.size:
        _fill(pattern_row, pattern[y, 0])


@kernel(inner=True)
def _fill(row: Any, value: Any) -> None:
    for x in range(row.size):
        row[x] = value


@kernel(inner=True, fastmath={"contract"})
def _add_row(row: Any, weight: Any, total: Any) -> None:
    for x in range(total.size):
        total[x] += weight * row[x]


@kernel(inner=True, fastmath={"contract"})
def _add_neighbours(flat: Any, first: Any, step: Any, weights: Any, k: Any, total: Any) -> None:
    """Add weighted neighbours, ``step`` apart in ``flat`` from ``first`` on, to a row; weights from the k-th on."""
    a, b, c, d = weights[k], weights[k + 1], weights[k + 2], weights[k + 3]
    e, f, g, h = weights[k + 4], weights[k + 5], weights[k + 6], weights[k + 7]
    # Unsigned numbers: for signed ones every access would test whether it counts from the end.
    n = np.uint64(step)
    n2, n3, n4 = np.uint64(2) * n, np.uint64(3) * n, np.uint64(4) * n
    n5, n6, n7 = np.uint64(5) * n, np.uint64(6) * n, np.uint64(7) * n
    for i in range(total.size):
        x = np.uint64(first) + np.uint64(i)
        total[i] += ((a * flat[x] + b * flat[x + n]) + (c * flat[x + n2] + d * flat[x + n3])) + (
            (e * flat[x + n4] + f * flat[x + n5]) + (g * flat[x + n6] + h * flat[x + n7])
        )


@kernel(inner=True, fastmath={"contract"})
def _add_noise(signal: Any, gain: Any, offset: Any, normals: Any, detector: Any) -> Any:
    """Turn a row of radiance into signals with noise; not 0 if some pixels have few or too many electrons.

    The noise is that of :func:`hcss_twin.models.sensor.rows.measure`.
    """
    f = np.float32
    scale, dark, shot, added_variance = (
        f(detector.per_radiance),
        f(detector.dark),
        f(detector.shot),
        f(detector.deviation**2),
    )
    least, most = f(FEW if detector.shot else -np.inf), f(MAX_COUNTED)
    sixth, half, once, one, apart = f(1.0 / 6.0), f(0.5), f(1.5), f(1.0), np.int32(0)
    for x in range(signal.size):
        excess = signal[x] * scale * (one + gain[x]) + offset[x]
        mean = shot * (excess + dark)
        variance = mean + added_variance
        # 1 / sqrt(variance) within 5e-6
        root = np.int32(_SQUARE_ROOT - (np.float32(variance).view(np.int32) >> np.int32(1))).view(np.float32)
        root *= once - half * variance * root * root
        root *= once - half * variance * root * root
        b = mean * sixth * root * root
        z = normals[x]
        signal[x] = excess + ((variance - b * b) * root * z + b * (z * z - one))
        apart = np.int32(apart | np.int32(mean < least) | np.int32(mean > most))
    return apart


@kernel(inner=True)
def _write_numbers(signal: Any, detector: Any, radiance: Any, number: Any) -> None:
    f = np.float32
    full, per_step, most = f(detector.full - detector.dark), f(1.0 / detector.step), f(detector.most)
    zero = detector.dark / detector.step + detector.offset
    rounded, start, back = f(zero + 0.5), f(zero), f(detector.step / detector.per_radiance)
    for x in range(signal.size):
        within = min(max(np.floor(min(signal[x], full) * per_step + rounded), f(0.0)), most)
        radiance[x] = (within - start) * back
        number[x] = np.int32(within)
