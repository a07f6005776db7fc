"""Thin layers from which doubling starts, and products and inverses of operators, compiled.

Operators act on the radiance of the streams of one hemisphere. Kernels are scaled by sqrt(2 pi mu weight) on both
sides, so that they are symmetric and products are plain sums over streams; extra directions have weight 0 and scale 1:
light reaches them but does not come from them. Rows are beams, streams, other extras; columns the first two only,
because no light enters along the other extras. Light that passes without scattering is a separate diagonal part,
"delta": the kernel of an extra direction could not represent it, and thin layers keep their precision.

With the radiances I+ down and I- up, t the optical depth and k+, k- the kernels of scattering into the same and into
the other hemisphere over mu, sum s = I+ + I- and difference d = I+ - I- obey

    ds/dt = -Y d,   dd/dt = -X s + 2 q t,   X = 1/mu - k+ - k-,   Y = 1/mu - k+ + k-,

where q = (1 - w) / mu times the gradient of the Planck radiance, taken as 0 in the middle. With h half the thickness, s
even and d odd give

    R + T = (1 + K)^-1 (1 - K),     K = tanh(h sqrt(X Y)) (X Y)^-1/2 X,

s odd and d even give T - R in the same way, with X and Y exchanged. tanh is replaced by its continued fraction, tanh(z)
/ z = (1 + z^2 / 15) / (1 + 2 z^2 / 5) + O(z^6): a Cayley transform, which conserves energy for any h. The first member
of that family, tanh(z) = z, is the "diamond" start of W. J. Wiscombe, J. Quant. Spectrosc. Radiat. Transfer 16, 637-658
(1976).

Numba compiles these functions again in every caller. So calls are few and not nested, elements are written one by one
(an assignment to a slice compiles all of its checks), and functions have no wrapper for the interpreter.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_twin.core.kernels import inner, kernel


@inner(error_model="numpy")
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


@inner(error_model="numpy")
def eliminate(matrix: Any, right: Any, first: int) -> None:
    """Solve ``matrix`` x = rows of ``right`` from ``first`` on, in place; both are overwritten.

    No pivoting: the matrices here are close to the identity, or symmetric and positive definite, for which elimination
    is stable without it (N. J. Higham, "Accuracy and Stability of Numerical Algorithms", 2nd ed., SIAM 2002, chapters 9
    and 10).
    """
    n, columns = matrix.shape[0], right.shape[1]
    for k in range(n):
        inverse = 1.0 / matrix[k, k]
        matrix[k, k] = inverse
        # Loops over slices start at 0 and become vector instructions: others would allow for negative indices.
        pivot = matrix[k, k + 1 :]
        for j in range(pivot.size):
            pivot[j] *= inverse
        for i in range(k + 1, n):
            factor, row = matrix[i, k], matrix[i, k + 1 :]
            for j in range(pivot.size):
                row[j] -= factor * pivot[j]
    # Rows from the first to the last, then back: each loses multiples of those before it, four at once.
    for back in range(2):
        for number in range(n):
            i = n - 1 - number if back else number
            start, stop = (i + 1, n) if back else (0, i)
            whole = stop - (stop - start) % 4
            row = right[first + i]
            for k in range(start, whole, 4):
                f0, f1, f2, f3 = matrix[i, k], matrix[i, k + 1], matrix[i, k + 2], matrix[i, k + 3]
                b0, b1, b2, b3 = right[first + k], right[first + k + 1], right[first + k + 2], right[first + k + 3]
                for j in range(columns):
                    row[j] -= (f0 * b0[j] + f1 * b1[j]) + (f2 * b2[j] + f3 * b3[j])
            for k in range(whole, stop):
                f0 = matrix[i, k]
                b0 = right[first + k]
                for j in range(columns):
                    row[j] -= f0 * b0[j]
            if not back:
                inverse = matrix[i, i]
                for j in range(columns):
                    row[j] *= inverse


# Largest tau' / mu of a starting layer, for the mean over azimuth and for other modes. Its error, relative to the
# exponent of transmission, is the sixth power of this over 100800: 2e-13, which keeps the sum of emission, reflection
# and transmission, and 6e-10 along the most slanted stream, ten thousand times less where mu is five times as large.
START, START_OF_MODES = 0.05, 0.2


@kernel()
def halvings(thickness: float, least_mu: float, start: float) -> int:
    """Return how often a layer is halved to become a starting layer for all directions."""
    count = 0
    while thickness > start * least_mu:
        thickness *= 0.5
        count += 1
    return count


@inner(error_model="numpy")
def starting_layer(
    same: Any,
    other: Any,
    thickness: float,
    mu: Any,
    scale: Any,
    co_albedo: float,
    beams: int,
    skipped: int,
    reflection: Any,
    transmission: Any,
) -> None:
    """Write scaled kernels of reflection and transmission, and beside the latter what the layer emits.

    Parameters
    ----------
    same, other : ndarray (D, C)
        k+ and k-, scaled kernels.
    thickness : float
        Optical thickness, at most ``START`` or ``START_OF_MODES`` times the least of ``mu``.
    mu, scale : ndarray (D,)
        Cosines, and sqrt(2 pi mu weight) or 1.
    co_albedo : float
        1 - w.
    beams : int
        Number of extra directions before the streams.
    skipped : int
        Number of first rows that are not needed.
    reflection, transmission : ndarray (D, C + 2) or (D, C)
        Written to; the last two of C + 2 columns of ``transmission`` become scaled emissivity and far share.
    """
    rows, columns = same.shape
    streams = columns - beams
    emits = reflection.shape[1] > columns
    half = 0.5 * thickness
    # h X and h Y, kernels and their common delta part.
    kernels = np.empty((2, rows, columns))
    delta = np.empty(rows)
    # Sources of the even and of the odd part.
    load = np.empty((2, rows))
    for i in range(rows):
        delta[i] = half / mu[i]
        load[0, i] = delta[i] * co_albedo * scale[i]
        for j in range(columns):
            kernels[0, i, j] = -half * (same[i, j] + other[i, j])
            kernels[1, i, j] = half * (other[i, j] - same[i, j])
    for i in range(skipped, rows):
        total = delta[i] * load[0, i]
        for k in range(beams, columns):
            total += kernels[1, i, k] * load[0, k]
        load[1, i] = total
    for i in range(skipped, rows):
        total = delta[i] * load[1, i]
        for k in range(beams, columns):
            total += kernels[0, i, k] * load[1, k]
        load[0, i] += total / 15.0
    square = np.empty((rows, columns))
    known = np.empty((rows, columns + 1))
    top = np.empty((rows, columns))
    matrix = np.empty((streams, streams))
    for part in range(2):
        first, second = kernels[part], kernels[1 - part]
        # K is ``top`` over 1 + 2 z^2 / 5, z^2 = h^2 X Y: kernels of z^2 and of both of these.
        for i in range(skipped, rows):
            for j in range(columns):
                square[i, j] = delta[i] * second[i, j] + first[i, j] * delta[j]
        accumulate(square, first, second, skipped, rows, beams, columns)
        for i in range(skipped, rows):
            widened = 15.0 + delta[i] * delta[i]
            for j in range(columns):
                top[i, j] = widened * first[i, j] + square[i, j] * delta[j]
        accumulate(top, square, first, skipped, rows, beams, columns)
        # (1 + K)^-1 K and (1 + K)^-1 of the load: ``square`` becomes the kernel of the denominator.
        for i in range(skipped, rows):
            for j in range(columns):
                top[i, j] /= 15.0
                square[i, j] = 0.4 * square[i, j] + top[i, j]
        for i in range(skipped, rows):
            known[i, columns] = load[part, i]
            for j in range(columns):
                z2 = delta[j] * delta[j]
                numerator = (1.0 + z2 / 15.0) * delta[j]
                known[i, j] = top[i, j] - square[i, j] * (numerator / (1.0 + 0.4 * z2 + numerator))
        for k in range(streams):
            i = beams + k
            for j in range(streams):
                matrix[k, j] = square[i, beams + j]
            z2 = delta[i] * delta[i]
            matrix[k, k] += 1.0 + 0.4 * z2 + (1.0 + z2 / 15.0) * delta[i]
        eliminate(matrix, known, beams)
        for i in range(skipped, rows):
            if i < beams or i >= columns:
                z2 = delta[i] * delta[i]
                diagonal = 1.0 + 0.4 * z2 + (1.0 + z2 / 15.0) * delta[i]
                for j in range(columns + 1):
                    total = known[i, j]
                    for k in range(beams, columns):
                        total -= square[i, k] * known[k, j]
                    known[i, j] = total / diagonal
        # Even, then odd: R + T and T - R. The odd part is the emission of a source from -1 at the top to 1 at the base;
        # half of each gives a source from 0 to 1.
        for i in range(skipped, rows):
            if part == 0:
                for j in range(columns):
                    reflection[i, j] = -known[i, j]
                    transmission[i, j] = -known[i, j]
                if emits:
                    transmission[i, columns] = 2.0 * known[i, columns]
                    transmission[i, columns + 1] = known[i, columns]
            else:
                for j in range(columns):
                    reflection[i, j] += known[i, j]
                    transmission[i, j] -= known[i, j]
                if emits:
                    transmission[i, columns + 1] -= known[i, columns] / 3.0
