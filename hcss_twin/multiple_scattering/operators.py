"""Products and inverses of operators on radiance, compiled.

Operators act on the radiance of the streams of one hemisphere. Kernels are scaled by
sqrt(2 pi mu weight) on both sides, so that they are symmetric and products are plain sums over
streams; extra directions have weight 0 and scale 1: light reaches them but does not come from
them. Rows are beams, streams, other extras; columns the first two only, for nobody asks what enters
along the other extras. Light that passes without scattering is a diagonal part of its own, "delta":
the kernel of an extra direction could not hold it, and thin layers keep their digits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def accumulate(out: Any, a: Any, b: Any, start: int, stop: int, beams: int, columns: int) -> None:
    """Add to rows ``start`` to ``stop`` of ``out`` the sum over streams of ``a`` [i, k] ``b`` [k, :]."""
    width = out.shape[1]
    # Four streams at once: a quarter of the loads and stores of ``out``.
    whole = columns - (columns - beams) % 4
    for i in range(start, stop):
        row = out[i]
        for k in range(beams, whole, 4):
            f0, f1, f2, f3 = a[i, k], a[i, k + 1], a[i, k + 2], a[i, k + 3]
            b0, b1, b2, b3 = b[k], b[k + 1], b[k + 2], b[k + 3]
            for j in range(width):
                row[j] += (f0 * b0[j] + f1 * b1[j]) + (f2 * b2[j] + f3 * b3[j])
        for k in range(whole, columns):
            f0 = a[i, k]
            b0 = b[k]
            for j in range(width):
                row[j] += f0 * b0[j]


@njit(cache=True, nogil=True)
def multiply(a: Any, a_delta: Any, b: Any, b_delta: Any, beams: int) -> Any:
    """Kernel (rows, columns) of the product of two operators; its delta part is the product of theirs."""
    rows, columns = a.shape
    out = np.empty((rows, columns))
    for i in range(rows):
        for j in range(columns):
            out[i, j] = a_delta[i] * b[i, j] + a[i, j] * b_delta[j]
    accumulate(out, a, b, 0, rows, beams, columns)
    return out


@njit(cache=True, nogil=True)
def apply(a: Any, a_delta: Any, vector: Any, beams: int) -> Any:
    """Operator on a vector over the rows."""
    rows, columns = a.shape
    out = a_delta * vector
    for i in range(rows):
        for k in range(beams, columns):
            out[i] += a[i, k] * vector[k]
    return out


@njit(cache=True, nogil=True)
def solve(a: Any, a_delta: Any, b: Any, b_delta: Any, vector: Any, beams: int) -> tuple[Any, Any]:
    """Kernel of a^-1 b, and a^-1 vector. The operator ``a`` must be close to the identity."""
    rows, columns = a.shape
    streams = columns - beams
    delta = b_delta / a_delta
    matrix = a[beams:columns, beams:columns].copy()
    known = np.empty((rows, columns + 1))
    for i in range(rows):
        for j in range(columns):
            known[i, j] = b[i, j] - a[i, j] * delta[j]
        known[i, columns] = vector[i]
    for k in range(streams):
        matrix[k, k] += a_delta[beams + k]
    eliminate(matrix, known[beams:columns])
    for i in range(rows):
        if i < beams or i >= columns:
            for k in range(beams, columns):
                factor = a[i, k]
                for j in range(columns + 1):
                    known[i, j] -= factor * known[k, j]
            known[i] /= a_delta[i]
    return known[:, :columns].copy(), known[:, columns].copy()


@njit(cache=True, nogil=True)
def eliminate(matrix: Any, right: Any) -> None:
    """Solve ``matrix`` x = ``right`` in place of ``right``; both are overwritten.

    No pivoting: the matrices here are close to the identity, or symmetric and positive definite, and
    elimination of those is stable without (N. J. Higham, "Accuracy and Stability of Numerical
    Algorithms", 2nd ed., SIAM 2002, chapters 9 and 10).
    """
    n, columns = right.shape
    for k in range(n):
        inverse = 1.0 / matrix[k, k]
        for j in range(k + 1, n):
            matrix[k, j] *= inverse
        for j in range(columns):
            right[k, j] *= inverse
        for i in range(k + 1, n):
            factor = matrix[i, k]
            for j in range(k + 1, n):
                matrix[i, j] -= factor * matrix[k, j]
            for j in range(columns):
                right[i, j] -= factor * right[k, j]
    for k in range(n - 1, 0, -1):
        for i in range(k):
            factor = matrix[i, k]
            for j in range(columns):
                right[i, j] -= factor * right[k, j]
