"""Measurement of one band, row by row: separable blur, electrons and their noise, range and digital numbers.

Nothing but the frame and its results is as large as the image. Single precision: errors are those of rounding of the
radiance in the cube. Signals are in excess of the dark current, so that its subtraction costs no digits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hcss_twin.core.kernels import kernel
from hcss_twin.models.sensor.noise import MAX_COUNTED, draw_poisson, pixel_key, row_key
from hcss_twin.models.sensor.philox import BLOCK, fill_normals

FEW = 100.0
"""Expected electrons below which Poisson's distribution is drawn from exactly.

From there on, a quadratic function of a normal number has its mean, variance and skewness; rounded to whole
electrons, its distribution function is within 1e-4. The difference falls inversely with the mean.
"""

TAPS_AT_ONCE = 4
"""Weights of a kernel that are applied in one pass over a row."""

_SQUARE_ROOT = np.int32(0x5F375A86)
"""Start of Newton's method for 1 / sqrt(x), from the bits of x (C. Lomont, Fast inverse square root, 2003)."""


class Detector(NamedTuple):
    """Numbers of one band, in units of the signal: electrons, or W m-2 sr-1 where these are not counted.

    Attributes
    ----------
    per_radiance : float
        Signal of 1 W m-2 sr-1.
    dark : float
        Signal of the dark current.
    photons : float
        Photons per second of 1 W m-2 sr-1.
    shot : float
        1 with shot noise, otherwise 0.
    deviation : float
        Standard deviation of read noise or Gaussian noise.
    full : float
        Largest signal, dark current included; infinity if there is none.
    step, offset, most : float
        Signal of one digital number, number at zero signal, largest number; ``step`` is 0 without a converter.
    """

    per_radiance: float
    dark: float
    photons: float
    shot: float
    deviation: float
    full: float
    step: float
    offset: float
    most: float


@kernel()
def measure(  # type: ignore[no-untyped-def]
    image, down, across, reach, added, gain, offset, detector, keys, corner, lines, radiance, rate, number, saturated
):
    """Write the measurement of a frame (Y, X) of one band; False if more electrons are expected than can be drawn.

    Parameters
    ----------
    image : ndarray of float32 (Y, X)
        Radiance, mirrored at the edges.
    down, across : ndarray of float32 (T, K), (T, L)
        The blur is the sum of T products of weights of neighbouring rows and columns, from the lowest on; T = 0: none.
        K and L are multiples of ``TAPS_AT_ONCE``, with zeros at the end.
    reach : (int, int)
        Distance of the first weights from the pixel, in rows and columns.
    added : ndarray of float32 (Y, X) or (0, 0)
        Radiance that is not blurred.
    gain, offset : ndarray of float32 (Y, X), (Y, 1) or (0, 0)
        Relative difference of the detectors' gain, and their offset in units of the signal.
    keys : (uint64, uint64)
        Of normal and of Poisson numbers.
    corner : (int, int)
        Row and column of the first pixel in the image.
    lines : (int, int)
        First row to be written, and the one after the last.
    radiance, rate, number, saturated : ndarray (Y, X) of float32, float32, int32, uint8
        Results; all but the first may be of shape (0, 0).
    """
    rows, columns = image.shape
    block, skipped = corner[1] // BLOCK, corner[1] % BLOCK
    wide = np.zeros(columns + across.shape[1], np.float32)
    blurred, signal = np.empty(columns, np.float32), np.empty(columns, np.float32)
    own_gain, own_offset = np.zeros(columns, np.float32), np.zeros(columns, np.float32)
    numbers = np.zeros((columns + skipped + BLOCK - 1) // BLOCK * BLOCK, np.float32)
    normals = numbers[skipped : skipped + columns]
    for y in range(lines[0], min(lines[1], rows)):
        if down.shape[0]:
            _blur_row(image, y, down, across, reach, wide, blurred)
        else:
            blurred[:] = image[y]
        if added.size:
            _add_row(blurred, added[y])
        if rate.size:
            _scale_row(blurred, detector.photons, rate[y])
        _pattern_row(gain, y, own_gain)
        _pattern_row(offset, y, own_offset)
        if detector.shot or detector.deviation:
            fill_normals(numbers, corner[0] + y, block, keys[0])
        few, many = _noise_row(blurred, own_gain, own_offset, normals, detector, signal)
        if many:
            return False
        if few:
            own_key = row_key(keys[1], np.int64(corner[0] + y))
            _few_row(blurred, own_gain, own_offset, normals, detector, own_key, corner[1], signal)
        if number.size:
            _number_row(signal, detector, radiance[y], number[y], saturated[y])
        else:
            if saturated.size:
                _clip_row(signal, detector, saturated[y])
            _scale_row(signal, 1.0 / detector.per_radiance, radiance[y])
    return True


@kernel()
def _mirrored(index, size):  # type: ignore[no-untyped-def]
    while index < 0 or index >= size:
        index = -1 - index if index < 0 else 2 * size - 1 - index
    return index


@kernel()
def _add_four(total, a, b, c, d, weights):  # type: ignore[no-untyped-def]
    p, q, r, s = weights[0], weights[1], weights[2], weights[3]
    for x in range(total.size):
        total[x] += (p * a[x] + q * b[x]) + (r * c[x] + s * d[x])


@kernel()
def _blur_row(image, y, down, across, reach, wide, blurred):  # type: ignore[no-untyped-def]
    """Write one row of the blurred image; the order of operations is the same for each pixel of any window."""
    rows, columns = image.shape
    left = reach[1]
    blurred[:] = np.float32(0.0)
    middle = wide[left : left + columns]
    for term in range(down.shape[0]):
        middle[:] = np.float32(0.0)
        for k in range(0, down.shape[1], TAPS_AT_ONCE):
            row = y - reach[0] + k
            a, b = image[_mirrored(row, rows)], image[_mirrored(row + 1, rows)]
            c, d = image[_mirrored(row + 2, rows)], image[_mirrored(row + 3, rows)]
            _add_four(middle, a, b, c, d, down[term, k:])
        for x in range(left):
            wide[x] = middle[_mirrored(x - left, columns)]
        for x in range(left + columns, wide.size):
            wide[x] = middle[_mirrored(x - left, columns)]
        for k in range(0, across.shape[1], TAPS_AT_ONCE):
            a, b = wide[k : k + columns], wide[k + 1 : k + 1 + columns]
            c, d = wide[k + 2 : k + 2 + columns], wide[k + 3 : k + 3 + columns]
            _add_four(blurred, a, b, c, d, across[term, k:])


@kernel()
def _add_row(values, more):  # type: ignore[no-untyped-def]
    for x in range(values.size):
        values[x] += more[x]


@kernel()
def _pattern_row(pattern, y, pattern_row):  # type: ignore[no-untyped-def]
    if pattern.size:  # a loop compiles in a tenth of the time of assignments to slices
        beside = np.int64(pattern.shape[1] == pattern_row.size)
        for x in range(pattern_row.size):
            pattern_row[x] = pattern[y, beside * x]


@kernel()
def _scale_row(values, factor, scaled):  # type: ignore[no-untyped-def]
    by = np.float32(factor)
    for x in range(values.size):
        scaled[x] = values[x] * by


@kernel()
def _noise_row(blurred, gain, offset, normals, detector, signal):  # type: ignore[no-untyped-def]
    """Write a row of signals with noise; return whether pixels have fewer and more electrons than it is for.

    The noise a z + b (z^2 - 1) of a normal number z has the variance a^2 + 2 b^2 and the third moment
    6 a^2 b + 8 b^3: with b = m / (6 v) and a^2 = v - 2 b^2 the variance v and, within 2e-4, the third moment m.
    """
    f = np.float32
    scale, dark, shot = f(detector.per_radiance), f(detector.dark), f(detector.shot)
    counted = detector.shot > 0.0 and detector.deviation == 0.0  # and rounding adds 1 / 12 to the variance
    further_variance = f(-1.0 / 12.0) if counted else f(detector.deviation**2)
    few, many, most, sixth, half, once = np.int32(0), np.int32(0), f(MAX_COUNTED), f(1.0 / 6.0), f(0.5), f(1.5)
    for x in range(signal.size):
        excess = blurred[x] * scale * (f(1.0) + gain[x]) + offset[x]
        mean = shot * (excess + dark)
        variance = mean + further_variance
        # 1 / sqrt(variance) within 5e-6
        root = np.int32(_SQUARE_ROOT - (np.float32(variance).view(np.int32) >> np.int32(1))).view(np.float32)
        root *= once - half * variance * root * root
        root *= once - half * variance * root * root
        b = mean * sixth * root * root
        a = (variance - b * b) * root
        z = normals[x]
        signal[x] = excess + (a * z + b * (z * z - f(1.0)))
        few = np.int32(few | np.int32(mean < f(FEW)))
        many = np.int32(many | np.int32(mean > most))
    if counted:
        for x in range(signal.size):
            signal[x] = np.floor(signal[x] + dark + half) - dark
    return (few if detector.shot else np.int32(0)), many


@kernel()
def _few_row(blurred, gain, offset, normals, detector, key, column, signal):  # type: ignore[no-untyped-def]
    """Draw few electrons from Poisson's distribution; negative means, which blur can cause, are kept."""
    for x in range(signal.size):
        mean = blurred[x] * detector.per_radiance * (1.0 + gain[x]) + offset[x] + detector.dark
        if mean < FEW:
            drawn = draw_poisson(max(mean, 0.0), pixel_key(key, np.int64(column + x))) + min(mean, 0.0)
            signal[x] = drawn - detector.dark + detector.deviation * normals[x]


@kernel()
def _clip_row(signal, detector, saturated):  # type: ignore[no-untyped-def]
    full = np.float32(detector.full - detector.dark)
    for x in range(signal.size):
        saturated[x] = np.uint8(signal[x] > full)
        signal[x] = min(signal[x], full)


@kernel()
def _number_row(signal, detector, radiance, number, saturated):  # type: ignore[no-untyped-def]
    f = np.float32
    full, per_step, most = f(detector.full - detector.dark), f(1.0 / detector.step), f(detector.most)
    zero = detector.dark / detector.step + detector.offset
    rounded, start, back = f(zero + 0.5), f(zero), f(detector.step / detector.per_radiance)
    for x in range(signal.size):
        value = np.floor(min(signal[x], full) * per_step + rounded)
        within = min(max(value, f(0.0)), most)
        radiance[x] = (within - start) * back
        number[x] = np.int32(within)
        above = np.uint8((signal[x] > full) | (value > most))
        saturated[x] = above | (np.uint8(value < f(0.0)) << np.uint8(1))
