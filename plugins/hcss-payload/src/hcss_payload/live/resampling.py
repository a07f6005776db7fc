"""Images between keyframes: both are sampled where the pixels of a frame look, and mixed by time."""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_twin.core.kernels import kernel

REACH = 2
"""Pixels around a place of whose values the cubic is made."""


@kernel(inner=True, fastmath={"contract"})
def _cubic(flat: Any, width: Any, y: Any, x: Any) -> Any:
    """Value at a place of an image: cubic convolution (R. Keys, 1981) with a = -1/2."""
    f = np.float32
    top, left = int(y), int(x)
    v, u = f(y - top), f(x - left)
    half, one = f(0.5), f(1.0)
    a0, a1 = ((-half * u + one) * u - half) * u, (f(1.5) * u - f(2.5)) * u * u + one
    a2, a3 = ((f(-1.5) * u + f(2.0)) * u + half) * u, (half * u - half) * u * u
    b0, b1 = ((-half * v + one) * v - half) * v, (f(1.5) * v - f(2.5)) * v * v + one
    b2, b3 = ((f(-1.5) * v + f(2.0)) * v + half) * v, (half * v - half) * v * v
    # Unsigned numbers: for signed ones every access would test whether it counts from the end.
    n, p, q, r = np.uint64(width), np.uint64(1), np.uint64(2), np.uint64(3)
    k = np.uint64((top - 1) * width + left - 1)
    first = a0 * flat[k] + a1 * flat[k + p] + a2 * flat[k + q] + a3 * flat[k + r]
    k += n
    second = a0 * flat[k] + a1 * flat[k + p] + a2 * flat[k + q] + a3 * flat[k + r]
    k += n
    third = a0 * flat[k] + a1 * flat[k + p] + a2 * flat[k + q] + a3 * flat[k + r]
    k += n
    fourth = a0 * flat[k] + a1 * flat[k + p] + a2 * flat[k + q] + a3 * flat[k + r]
    return (b0 * first + b1 * second) + (b2 * third + b3 * fourth)


@kernel(fastmath={"contract"})
def between_keyframes(places: Any, step: Any, before: Any, after: Any, later: Any, out: Any, lines: Any) -> None:
    """Write some rows of a frame.

    Parameters
    ----------
    places : ndarray (2, N, M, 2)
        Row and column in either keyframe that the nodes of a mesh look at, ``step`` pixels apart; between the nodes
        they are linear. All are at least ``REACH`` pixels within the keyframes.
    before, after : ndarray of float32 (B, rows, columns)
        Keyframes.
    later : float
        Weight of the second one.
    out : ndarray of float32 (B, Y, X)
    lines : (int, int)
        First row to be written, and the one after the last.
    """
    width, columns, down = before.shape[2], out.shape[2], 1.0 / step
    for which in range(2):
        share = np.float32(later) if which else np.float32(1.0) - np.float32(later)
        for band in range(out.shape[0]):
            flat = after[band].reshape(-1) if which else before[band].reshape(-1)
            for y in range(lines[0], min(lines[1], out.shape[1])):
                line = out[band, y]
                if not which:
                    for x in range(columns):
                        line[x] = 0.0
                if share == 0.0:
                    continue
                i = y // step
                fy = (y - i * step) * down
                upper, lower = places[which, i], places[which, i + 1]
                for j in range(places.shape[2] - 1):
                    row = (1.0 - fy) * upper[j, 0] + fy * lower[j, 0]
                    column = (1.0 - fy) * upper[j, 1] + fy * lower[j, 1]
                    more_rows = ((1.0 - fy) * upper[j + 1, 0] + fy * lower[j + 1, 0] - row) * down
                    more_columns = ((1.0 - fy) * upper[j + 1, 1] + fy * lower[j + 1, 1] - column) * down
                    for x in range(j * step, min((j + 1) * step, columns)):
                        along = x - j * step
                        line[x] += share * _cubic(flat, width, row + along * more_rows, column + along * more_columns)
