"""Sums of many plane waves at all pixels of a window, by fast Fourier transforms.

One sine for each wave and pixel takes most of the time of a scene with resolved waves. In tiles of a fixed size, the
wavenumbers along x are spread over a regular grid with a Kaiser-Bessel window, and one transform gives all columns of
a row (a non-uniform transform: J. A. Fessler and B. P. Sutton, IEEE Trans. Signal Process. 51 (2003) 560). Rows follow
from each other by turning the phases. Tiles start at fixed pixels, so that values do not depend on the window.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel

ROWS, COLUMNS, MARGIN = 32, 576, 32
"""Size of a tile in pixels, and columns of the first one before the image, for what a sensor needs around it: images
of 256 or 512 columns need one tile across."""

_LENGTH = 2 * COLUMNS
_WIDTH = 8
_SHAPE = 2.34 * _WIDTH
"""Length of the transform; width and shape parameter of the Kaiser-Bessel window for twice as many wavenumbers."""

ERROR = 3e-6
"""Largest error relative to the root-mean-square sum, half of it from single precision."""


class PlaneWaveSums:
    """Two sums of the sines of the same plane waves.

    Parameters
    ----------
    k_x, k_y : ndarray (N,)
        Wavenumbers, radians per pixel, along columns and rows; at most pi.
    amplitudes : ndarray (2, N)
        Amplitude of each wave in either sum.
    """

    def __init__(self, k_x: Array, k_y: Array, amplitudes: Array) -> None:
        from scipy.special import i0  # with scipy.fft, below

        self._k_x, self._k_y = k_x, k_y
        position = k_x * (_LENGTH / (2.0 * np.pi))
        self._first = np.ceil(position - 0.5 * _WIDTH).astype(np.int64)
        away = (self._first - position)[:, None] + np.arange(_WIDTH)
        self._weight = i0(_SHAPE * np.sqrt(np.maximum(1.0 - (2.0 * away / _WIDTH) ** 2, 0.0))).astype(np.float32)
        # The window's transform at each column, counted from the middle of a tile.
        column = np.arange(COLUMNS) - COLUMNS // 2
        root = np.sqrt(_SHAPE**2 - (np.pi * _WIDTH * column / _LENGTH) ** 2)
        self._scale = (root / (_WIDTH * np.sinh(root))).astype(np.float32)
        self._turns = np.exp(1j * k_y[:, None] * np.arange(ROWS)).astype(np.complex64).view(np.float32)
        # Both sums are one complex transform, first + i second; a sine is the difference of e^ip and e^-ip over 2i.
        self._amplitude = 0.5 * (amplitudes[1] - 1j * amplitudes[0])

    def at(self, phase: Array, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return both sums (2, y, x) of amplitude x sin(k_x x + k_y y + phase) over a window of pixels.

        Parameters
        ----------
        phase : ndarray (N,)
            Of each wave at pixel (0, 0).
        rows, columns : slice
            Window with a start and a stop; any integers.
        """
        from scipy.fft import ifft  # takes 0.1 s to import

        sums = np.empty((2, rows.stop - rows.start, columns.stop - columns.start), np.float32)
        grid = np.empty((_LENGTH, ROWS), np.complex64)
        lefts = range((columns.start + MARGIN) // COLUMNS * COLUMNS - MARGIN, columns.stop, COLUMNS)
        across = [np.exp(1j * (phase + self._k_x * (left + COLUMNS // 2))) for left in lefts]
        for top in range(rows.start // ROWS * ROWS, rows.stop, ROWS):
            down = np.exp(1j * self._k_y * top)
            for left, middle in zip(lefts, across, strict=True):
                _spread(grid.view(np.float32), self._first, self._weight, self._starts(down * middle), self._turns)
                tile = ifft(grid, axis=0, norm="forward", overwrite_x=True)
                _store(sums, tile, self._scale, top - rows.start, left - columns.start)
        return sums

    def _starts(self, phase: NDArray[np.complex128]) -> NDArray[np.float32]:
        """Return (N, 4) amplitudes, real and imaginary, of each wave and its mirror image at a phase, exp(ip)."""
        a, p = self._amplitude, phase
        up_down = a.real * p.real, a.imag * p.imag, a.real * p.imag, a.imag * p.real
        parts = up_down[0] - up_down[1], up_down[2] + up_down[3], -up_down[0] - up_down[1], up_down[2] - up_down[3]
        return np.stack(parts, axis=1).astype(np.float32)


@kernel()
def _spread(grid, first, weight, starts, turns):  # type: ignore[no-untyped-def]
    """Add each wave and its mirror image at the negative wavenumber to the grid (wavenumber, row).

    In pairs of real and imaginary part, for which less is compiled than for complex numbers.
    """
    length, lanes = grid.shape
    wave, mirrored = np.empty(lanes, np.float32), np.empty(lanes, np.float32)
    grid[:] = np.float32(0)
    for n in range(first.size):
        real, imaginary, mirror_real, mirror_imaginary = starts[n, 0], starts[n, 1], starts[n, 2], starts[n, 3]
        for lane in range(0, lanes, 2):
            turn_real, turn_imaginary = turns[n, lane], turns[n, lane + 1]
            wave[lane] = real * turn_real - imaginary * turn_imaginary
            wave[lane + 1] = real * turn_imaginary + imaginary * turn_real
            mirrored[lane] = mirror_real * turn_real + mirror_imaginary * turn_imaginary
            mirrored[lane + 1] = mirror_imaginary * turn_real - mirror_real * turn_imaginary
        for i in range(weight.shape[1]):
            one, other = grid[(first[n] + i) % length], grid[-(first[n] + i) % length]
            # Two loops over whole arrays: the compiler vectorises only these.
            for lane in range(wave.size):
                one[lane] += weight[n, i] * wave[lane]
            for lane in range(mirrored.size):
                other[lane] += weight[n, i] * mirrored[lane]


@kernel()
def _store(sums, tile, scale, top, left):  # type: ignore[no-untyped-def]
    """Store the part of a tile (column, row), which starts at ``top`` and ``left``, that lies in the window."""
    length, rows = tile.shape
    half = scale.size // 2
    for row in range(max(0, -top), min(rows, sums.shape[1] - top)):
        for column in range(max(0, -left), min(2 * half, sums.shape[2] - left)):
            value = tile[(column - half) % length, row]
            sums[0, top + row, left + column] = value.real * scale[column]
            sums[1, top + row, left + column] = value.imag * scale[column]
