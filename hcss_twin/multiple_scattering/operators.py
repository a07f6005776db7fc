"""Products and inverses of operators on radiance, compiled.

Operators act on the radiance of the streams of one hemisphere. Kernels are scaled by
sqrt(2 pi mu weight) on both sides, so that they are symmetric and products are plain sums over
streams; extra directions have weight 0 and scale 1: light reaches them but does not come from
them. Rows are beams, streams, other extras; columns the first two only, for nobody asks what enters
along the other extras. Light that passes without scattering is a diagonal part of its own, "delta":
the kernel of an extra direction could not hold it, and thin layers keep their digits.

Whatever calls these compiles them once more, so calls are few and not nested, elements are written one by
one (an assignment to a slice compiles all of its checks), and no wrapper for the interpreter is made.
"""

from __future__ import annotations

from typing import Any

from numba import njit

# For functions that only compiled ones call.
inner = njit(cache=True, nogil=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)


@inner
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


@inner
def eliminate(matrix: Any, right: Any, first: int) -> None:
    """Solve ``matrix`` x = rows of ``right`` from ``first`` on, in place; both are overwritten.

    No pivoting: the matrices here are close to the identity, or symmetric and positive definite, and
    elimination of those is stable without (N. J. Higham, "Accuracy and Stability of Numerical
    Algorithms", 2nd ed., SIAM 2002, chapters 9 and 10).
    """
    n, columns = matrix.shape[0], right.shape[1]
    for k in range(n):
        pivot, known = matrix[k], right[first + k]
        inverse = 1.0 / pivot[k]
        for j in range(k + 1, n):
            pivot[j] *= inverse
        for j in range(columns):
            known[j] *= inverse
        for i in range(k + 1, n):
            row, other = matrix[i], right[first + i]
            factor = row[k]
            for j in range(k + 1, n):
                row[j] -= factor * pivot[j]
            for j in range(columns):
                other[j] -= factor * known[j]
    for k in range(n - 1, 0, -1):
        known = right[first + k]
        for i in range(k):
            factor = matrix[i, k]
            other = right[first + i]
            for j in range(columns):
                other[j] -= factor * known[j]
