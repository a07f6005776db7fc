"""Thin layers from which doubling starts, compiled.

With I+, I- going down and up, t the optical depth and k+, k- the kernels of scattering into the same
and into the other hemisphere over mu, sum s = I+ + I- and difference d = I+ - I- obey

    ds/dt = -Y d,   dd/dt = -X s + 2 q t,   X = 1/mu - k+ - k-,   Y = 1/mu - k+ + k-,

where q = (1 - w) / mu times the gradient of the Planck radiance, taken as 0 in the middle. With
h half the thickness, s even and d odd give

    R + T = (1 + K)^-1 (1 - K),     K = tanh(h sqrt(X Y)) (X Y)^-1/2 X,

and s odd and d even the same for T - R with X and Y exchanged. tanh is replaced by its continued
fraction, tanh(z) / z = (1 + z^2 / 15) / (1 + 2 z^2 / 5) + O(z^6): a Cayley transform, so that energy
is conserved whatever h. The first member of that family, tanh(z) = z, is the "diamond" start of
W. J. Wiscombe, J. Quant. Spectrosc. Radiat. Transfer 16, 637-658 (1976).
"""

from __future__ import annotations

from typing import Any

from numba import njit

from hcss_twin.multiple_scattering.operators import apply, multiply, solve

# Largest tau' / mu of a starting layer. Its error, relative to the exponent of transmission, is the
# sixth power of this over 100800: 2e-13.
START = 0.05


@njit(cache=True, nogil=True)
def halvings(thickness: float, least_mu: float) -> int:
    """Return how often a layer is halved to be a starting layer for all directions."""
    count = 0
    while thickness > START * least_mu:
        thickness *= 0.5
        count += 1
    return count


@njit(cache=True, nogil=True)
def starting_layer(
    same: Any, other: Any, thickness: float, mu: Any, scale: Any, co_albedo: float, beams: int
) -> tuple[Any, Any, Any, Any]:
    """Return scaled kernels of reflection and transmission, scaled emissivity and far share.

    Parameters
    ----------
    same, other : ndarray (D, C)
        k+ and k-, scaled kernels.
    thickness : float
        Optical thickness, at most ``START`` times the least of ``mu``.
    mu, scale : ndarray (D,)
        Cosines, and sqrt(2 pi mu weight) or 1.
    co_albedo : float
        1 - w.
    beams : int
        How many extra directions stand before the streams.
    """
    x = -(same + other)
    y = other - same
    half = 0.5 * thickness
    inverse = 1.0 / mu
    source = half * co_albedo * inverse * scale
    y_source = apply(y, inverse, source, beams)
    load = source + (half * half / 15.0) * apply(x, inverse, y_source, beams)
    even, emitted = _cayley(x, y, half, inverse, load, beams)
    odd, slanted = _cayley(y, x, half, inverse, half * y_source, beams)
    emissivity = 2.0 * emitted
    # Of a source 1 at the base and -1 at the top the odd part leaves; halves of both make 0 to 1.
    far = emitted - (1.0 / 3.0) * slanted
    return odd - even, -(odd + even), emissivity, far


@njit(cache=True, nogil=True)
def _cayley(first: Any, second: Any, half: float, inverse: Any, load: Any, beams: int) -> Any:
    """Return the kernel of (1 + K)^-1 K, and (1 + K)^-1 of ``load`` over the denominator of K."""
    z2 = (half * inverse) ** 2
    square = half * half * multiply(first, inverse, second, inverse, beams)
    top_delta = (1.0 + z2 / 15.0) * (half * inverse)
    top = multiply(square / 15.0, 1.0 + z2 / 15.0, half * first, half * inverse, beams)
    return solve(0.4 * square + top, 1.0 + 0.4 * z2 + top_delta, top, top_delta, load, beams)
