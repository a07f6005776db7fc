"""Thin layers from which doubling starts.

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
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array

# Largest tau' / mu of a starting layer, for the mean over azimuth and for other modes. Its error, relative to the
# exponent of transmission, is the sixth power of this over 100800: 2e-13, which keeps the sum of emission, reflection
# and transmission, and 6e-10 along the most slanted stream, ten thousand times less where mu is five times as large.
START, START_OF_MODES = 0.05, 0.2

ELEMENTS_AT_ONCE = 2**16
"""Maximum elements of the kernels of layers that are solved together: they stay in the cache of a processor."""


def halvings(thickness: Array, least_mu: float, start: float) -> NDArray[np.int64]:
    """Return how often layers are halved to become starting layers for all directions."""
    with np.errstate(divide="ignore"):
        octaves = np.log2(thickness / (start * least_mu))
    result: NDArray[np.int64] = np.ceil(np.maximum(octaves, 0.0)).astype(np.int64)
    return result


def starting_layers(
    same: Array, other: Array, thickness: Array, mu: Array, scale: Array, co_albedo: Array, beams: int
) -> Iterator[tuple[slice, Array, Array]]:
    """Yield scaled kernels of reflection and transmission of some layers, and beside them what the layers emit.

    Parameters
    ----------
    same, other : ndarray (n, D, C)
        k+ and k-, scaled kernels.
    thickness : ndarray (n,)
        Optical thickness, at most ``START`` or ``START_OF_MODES`` times the least of ``mu``.
    mu, scale : ndarray (D,)
        Cosines, and sqrt(2 pi mu weight) or 1.
    co_albedo : ndarray (n,)
        1 - w.
    beams : int
        Number of extra directions before the streams.

    Yields
    ------
    which : slice
        The layers (m of n).
    reflection, transmission : ndarray (m, D, C + 1)
        In the last column, scaled far share and emissivity.
    """
    columns = same.shape[2]
    streams = slice(beams, columns)
    step = max(1, ELEMENTS_AT_ONCE // (mu.size * columns))
    for begin in range(0, thickness.size, step):
        which = slice(begin, min(begin + step, thickness.size))
        # h X and h Y: their common delta part, and kernels.
        delta = 0.5 * thickness[which, None] / mu
        half = 0.5 * thickness[which, None, None]
        kernels = -half * (same[which] + other[which]), half * (other[which] - same[which])
        row, column = delta[:, :, None], delta[:, None, :columns]
        # Sources of the even and of the odd part.
        even = delta * co_albedo[which, None] * scale
        odd = delta * even + _over_streams(kernels[1], even, streams)
        even += (delta * odd + _over_streams(kernels[0], odd, streams)) / 15.0
        parts = []
        for first, second, load in ((*kernels, even), (*kernels[::-1], odd)):
            # K is ``top`` over 1 + 2 z^2 / 5, z^2 = h^2 X Y: kernels of z^2 and of both of these.
            square = row * second + first * column + first[:, :, streams] @ second[:, streams]
            top = ((15.0 + row**2) * first + square * column + square[:, :, streams] @ first[:, streams]) / 15.0
            # (1 + K)^-1 K and (1 + K)^-1 of the load: ``square`` becomes the kernel of the denominator.
            square = 0.4 * square + top
            numerator = (1.0 + delta**2 / 15.0) * delta
            diagonal = 1.0 + 0.4 * delta**2 + numerator
            right = np.concatenate((top - square * (numerator / diagonal)[:, None, :columns], load[:, :, None]), axis=2)
            matrix = square[:, streams, streams] + diagonal[:, streams, None] * np.eye(columns - beams)
            known = np.linalg.solve(matrix, right[:, streams])
            right = (right - square[:, :, streams] @ known) / diagonal[:, :, None]
            right[:, streams] = known
            parts.append(right)
        # Even, then odd: R + T and T - R. The odd part is the emission of a source from -1 at the top to 1 at the base;
        # half of each gives a source from 0 to 1.
        plus, minus = parts
        reflection, transmission = minus - plus, -plus - minus
        reflection[:, :, columns] = plus[:, :, columns] - minus[:, :, columns] / 3.0
        transmission[:, :, columns] = 2.0 * plus[:, :, columns]
        yield which, reflection, transmission


def _over_streams(kernel: Array, source: Array, streams: slice) -> Array:
    """Return the sum over streams of kernels (m, D, C) times sources (m, D)."""
    result: Array = (kernel[:, :, streams] @ source[:, streams, None])[:, :, 0]
    return result
