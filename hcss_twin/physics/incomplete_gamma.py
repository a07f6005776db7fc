"""Regularised incomplete gamma functions of single numbers without scipy.special, which takes 0.1 s to import.

Below t = s + 1 the power series, above it the continued fraction (DLMF 8.11.4 and 8.9.2; W. J. Lentz, Appl. Opt. 15,
668 (1976)).
"""

from __future__ import annotations

import math

_SMALLEST = 1e-300
"""Replaces zero denominators of the continued fraction."""

_LARGEST = 200.0
"""The expansions need about sqrt(s) terms and lose digits as s grows; above this, scipy.special is used."""


def lower_and_upper(s: float, t: float) -> tuple[float, float]:
    """Return P(s, t) = gamma(s, t) / Gamma(s) and Q = 1 - P for s > 0 and t >= 0.

    The smaller of the two has a relative error below 1e-12.
    """
    if s > _LARGEST:
        from scipy.special import gammainc, gammaincc

        return float(gammainc(s, t)), float(gammaincc(s, t))
    if t == 0.0:
        return 0.0, 1.0
    if math.isinf(t):
        return 1.0, 0.0
    front = math.exp(s * math.log(t) - t - math.lgamma(s))
    if t < s + 1.0:
        term = total = 1.0 / s
        number = s
        while term > total * 1e-17:
            number += 1.0
            term *= t / number
            total += term
        lower = min(front * total, 1.0)
        return lower, 1.0 - lower
    odd = t + 1.0 - s
    c, d = 1.0 / _SMALLEST, 1.0 / odd
    fraction, change, number = d, 0.0, 0.0
    while abs(change - 1.0) > 4e-16:
        number += 1.0
        even = number * (s - number)
        odd += 2.0
        d = 1.0 / (even * d + odd or _SMALLEST)
        c = even / c + odd or _SMALLEST
        change = c * d
        fraction *= change
    upper = min(front * fraction, 1.0)
    return 1.0 - upper, upper
