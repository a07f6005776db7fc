"""Reflected sunlight scattered twice, in closed form: what few streams and moments miss of it.

Few streams suffice for light scattered many times. What remains of their error is nearly all in the second order, in
which a sharp phase function (glory, cloudbow, forward peak) acts twice on a beam. Its exact value over a homogeneous
layer takes two exponentials for each intermediate direction: light that enters along mu_0, is scattered at depth t
toward mu_i downward, and then at t' > t back toward mu, has the path

    int_0^tau exp(-t'/mu) int_0^t' exp(-t/mu_0 - (t' - t)/mu_i) dt dt'
      = [B(1/mu + 1/mu_0) - B(1/mu + 1/mu_i)] / (1/mu_i - 1/mu_0),     B(r) = (1 - exp(-tau r)) / r,

and light that is scattered back first has the same with mu and mu_0 exchanged. So twice-scattered light of the
truncated phase function is replaced by that of the full one, as forward_peak.py does for light scattered once.

The scaled problem (delta-M) counts a share f of scattering as none. Of the full phase function, what lies within an
angle of ``PEAK`` over the number of kept moments is weakened by a common factor, so that the whole has the weight
1 - f: the peak keeps its shape. What even the moments of this calculation do not resolve counts as not scattered.

Light that is scattered back once, and forward any number of times, keeps exp(-t r (1 - K_l)) of the moment of degree l
of the backward part of the phase function, with r = 1/mu + 1/mu_0 and the strength K_l of forward scattering, which is
negative from the degree on that scaling removed. Without these orders above the second a glory would shine through
scattering that scaling counts as none (H. C. van de Hulst, "Multiple Light Scattering", 1980, section 14.1.2).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, lru_cache

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics.geometry import scattering_cosine
from hcss_twin.physics.multiple_scattering.directions import gauss_streams
from hcss_twin.physics.multiple_scattering.phase_function import (
    ScaledScattering,
    extended_moments,
    phase_function,
    polynomials,
)

FEWEST_MOMENTS, TIMES_MOMENTS, MOST_MOMENTS = 96, 8, 576
"""Moments for twice-scattered light: so many times those of the solution, between these limits.

With 5 times as many, and 360, 64 streams are up to 3.3e-3 off over thick ice near the glory, more than 24 to 48.
"""

MOMENTS_PER_STREAM = 1.5
"""With twice as many moments as streams, products of two phase functions would be integrated wrongly."""

PEAK = 1.5
"""Angle within which the phase function is weakened, times the kept moments."""

BACKWARD_DEG = 70.0, 110.0
"""Between these angles the backward part of the phase function begins."""

ANGLES = 1440
"""Angles at which the phase function is integrated."""

LEAST_SHARE = 1e-7
"""Azimuth modes end after two in succession below this share of the largest one."""

MODES_TOGETHER = 32
"""Modes whose Legendre functions are in memory."""

MOST_KEPT = 2**14
"""Degrees times directions up to which they are kept for the next solution toward the same view: 4 MB each."""

_CLOSEST = 1e-6
"""Least difference of inverse cosines that is divided by; it changes the path by as much."""


def missing_second_order(
    scaled: ScaledScattering,
    albedo: Array,
    moments: Array,
    streams: int,
    modes: int,
    mu: Array,
    sun: float,
    azimuth: Array,
) -> Array:
    """Brdf (T, V, P) that a solution with few streams lacks.

    Parameters
    ----------
    scaled : ScaledScattering
        The layer as it is solved.
    albedo, moments : ndarray (V,), (K, V)
        Those of the layer, unscaled, as for :func:`extended_moments`.
    streams, modes : int
        Of the solution.
    mu, azimuth : ndarray (P,)
        Cosines of the views' zenith angles, and azimuths relative to the sun, radians; pi is glint.
    sun : float
        Cosine of the sun's zenith angle.
    """
    kept = scaled.moments.shape[0]
    count = max(FEWEST_MOMENTS, min(TIMES_MOMENTS * kept, MOST_MOMENTS), kept)
    known = extended_moments(moments, count + 1)
    full, sharpest = known[:-1], known[-1]
    angle, weight = _quadrature(ANGLES)
    cosines = np.cos(angle)
    values = phase_function(cosines, moments) * (0.5 * weight)
    legendre = polynomials(cosines, count)
    outside = legendre.T @ (values * -(np.expm1(-((angle * (kept / PEAK)) ** 2)) ** 3)).T
    backward = legendre.T @ (values * _rising(angle, *np.radians(BACKWARD_DEG))).T
    inside = 1.0 - outside[0] - sharpest
    there = np.abs(inside) > LEAST_SHARE
    weakened = np.divide(1.0 - scaled.peak - outside[0], inside, out=np.ones_like(inside), where=there)
    exact, strength = outside + weakened * (full - sharpest - outside), albedo / (1.0 - albedo * scaled.peak)
    more = round(count / MOMENTS_PER_STREAM)
    result = twice_back(scaled.thickness, strength, exact, more, count, mu, sun, azimuth)
    result -= twice_back(scaled.thickness, scaled.albedo, scaled.moments, streams, modes, mu, sun, azimuth)
    onward, once_more = strength * (full - backward - scaled.peak), strength * (exact - backward)
    cosine = np.array([scattering_cosine(m, sun, a) for m, a in zip(mu, azimuth, strict=True)])
    series = polynomials(cosine, count) * (2.0 * np.arange(count) + 1.0)
    for m in np.unique(mu):
        above = _above_second(scaled.thickness, 1.0 / m + 1.0 / sun, onward[kept:], once_more[kept:])
        for p in np.flatnonzero(mu == m):
            strengths = (series[p, :, None] * backward)[kept:] * (strength / (4.0 * np.pi * m * sun))
            result[..., p] += np.einsum("ltv,lv->tv", above, strengths)
    return result


def _above_second(thickness: Array, rate: float, onward: Array, once_more: Array) -> Array:
    """Path (L, T, V) of light scattered back once and forward at least twice.

    Parameters
    ----------
    onward, once_more : ndarray (L, V)
        Strength of forward scattering, and the one with which light scattered twice is known already.
    """
    straight = _integral(rate, thickness)
    twice = straight - thickness * np.exp(-rate * thickness)
    result: Array = _integral((1.0 - onward[:, None]) * rate, thickness) - straight - once_more[:, None] * twice
    return result


def twice_back(
    thickness: Array, strength: Array, moments: Array, streams: int, modes: int, mu: Array, sun: float, azimuth: Array
) -> Array:
    """Brdf (T, V, P) of light that a layer scatters twice, over Gauss streams as intermediate directions.

    Parameters
    ----------
    thickness : ndarray (T, V)
    strength : ndarray (V,)
        Single-scattering albedo.
    moments : ndarray (L, V)
        Of the phase function.
    modes : int
        Most azimuth modes.
    """
    between = gauss_streams(streams)
    distinct, of_view = np.unique(mu, return_inverse=True)  # kernels do not depend on the azimuth
    series = (2 * np.arange(moments.shape[0]) + 1)[:, np.newaxis] * moments
    every = np.concatenate((between.mu, [sun], distinct))
    # Light that is scattered down first, and back first.
    down, back = np.zeros((2, streams, mu.size, strength.size))
    largest, small = 0.0, False
    for mode, value in enumerate(_legendre_of_modes(every, moments.shape[0], modes)):
        along, ends = value[:, :streams, None], value[:, None, streams:]
        both = _kernels((along * ends).reshape(moments.shape[0], -1), series, mode)
        same, other = (kernel.reshape(streams, 1 + distinct.size, -1) for kernel in both)
        # The sunbeam travels away from the sun: its relative azimuth is the supplement.
        term = ((1.0 if mode == 0 else 2.0) * np.cos(mode * (np.pi - azimuth)))[:, None]
        parts = other[:, 1:] * same[:, :1], same[:, 1:] * other[:, :1]
        down += parts[0][:, of_view] * term
        back += parts[1][:, of_view] * term
        size = max(float(np.max(np.abs(part))) for part in parts)
        largest = max(largest, size)
        if small and size <= LEAST_SHARE * largest:
            break
        small = size <= LEAST_SHARE * largest
    factor = 2.0 * np.pi * (between.weight / between.mu)[:, None, None] * (strength / (4.0 * np.pi)) ** 2
    inverse, to_sun = 1.0 / between.mu, 1.0 / sun
    beside_sun = _apart(inverse, to_sun)
    down *= factor / (beside_sun - to_sun)[:, None, None]
    from_streams = [_integral(to_sun + rate, thickness) for rate in inverse]
    result = np.empty((*thickness.shape, mu.size))
    for view, to_view in enumerate(1.0 / distinct):
        these = np.flatnonzero(of_view == view)
        beside_view = _apart(inverse, to_view)
        downward = down[:, these, None]
        backward = back[:, these, None] * factor[:, None] / (beside_view - to_view)[:, None, None, None]
        total = _integral(to_view + to_sun, thickness) * np.sum(downward + backward, axis=0)
        for stream, known in enumerate(from_streams):
            moved = beside_view[stream] != inverse[stream]
            total -= downward[stream] * _integral(to_view + beside_sun[stream], thickness)
            total -= backward[stream] * (_integral(to_sun + beside_view[stream], thickness) if moved else known)
        result[..., these] = np.moveaxis(total * (to_view * to_sun), 0, -1)
    return result


def _legendre_of_modes(mu: Array, degrees: int, modes: int) -> Iterator[Array]:
    """Yield :func:`normalised_legendre` of each mode, (degrees, D), from one recurrence for several modes."""
    block = _known_block if degrees * mu.size <= MOST_KEPT else _legendre_block
    for begin in range(0, min(modes, degrees), MODES_TOGETHER):
        yield from block(mu.tobytes(), degrees, begin, min(begin + MODES_TOGETHER, modes, degrees))


def _legendre_block(cosines: bytes, degrees: int, begin: int, end: int) -> Array:
    """Return the functions (end - begin, degrees, D) of some modes."""
    mu = np.frombuffer(cosines, dtype=np.float64)
    sine, first, sectoral = np.sqrt((1.0 - mu) * (1.0 + mu)), np.ones_like(mu), 0
    order = np.arange(begin, end)[:, None]
    result = np.zeros((order.size, degrees, mu.size))
    for degree in range(begin, degrees):
        if degree < end:
            while sectoral < degree:
                sectoral += 1
                first = first * (sine * np.sqrt((2 * sectoral - 1) / (2 * sectoral)))
            result[degree - begin, degree] = first
        if degree + 1 == degrees:
            break
        lower = order[: min(degree - begin + 1, order.size)]
        before = np.sqrt(degree * degree - lower * lower) * result[: lower.size, degree - 1]
        after = (2 * degree + 1) * mu * result[: lower.size, degree] - before
        result[: lower.size, degree + 1] = after / np.sqrt((degree + 1) ** 2 - lower**2)
    result.flags.writeable = False
    return result


_known_block = lru_cache(maxsize=8)(_legendre_block)


def _kernels(product: Array, series: Array, mode: int) -> tuple[Array, Array]:
    """Return scattering into the same and into the other hemisphere (N, V) from products (L, N)."""
    even = product[mode::2].T @ series[mode::2]
    odd = product[mode + 1 :: 2].T @ series[mode + 1 :: 2]
    return even + odd, even - odd


def _integral(rate: Array | float, thickness: Array) -> Array:
    """Integral of exp(-rate t) over the layer."""
    result: Array = -np.expm1(-rate * thickness) / rate
    return result


def _apart(inverse: Array, other: float) -> Array:
    """Move inverse cosines of streams that equal another one a little: the path is a difference quotient there."""
    return np.where(np.abs(inverse - other) < _CLOSEST, other + _CLOSEST, inverse)


def _rising(angle: Array, low: float, high: float) -> Array:
    """Return 0 below an angle and 1 above another one, with a smooth step between."""
    position = np.clip((angle - low) / (high - low), 0.0, 1.0)
    result: Array = position * position * (3.0 - 2.0 * position)
    return result


@cache
def _quadrature(count: int) -> tuple[Array, Array]:
    """Return angles and weights (count,) of Fejer's first rule for integrals over the cosine."""
    angle = (np.arange(count) + 0.5) * np.pi / count
    degree = np.arange(1, count // 2 + 1)
    weight = (2.0 - 4.0 * np.cos(2.0 * angle[:, None] * degree) @ (1.0 / (4.0 * degree**2 - 1.0))) / count
    angle.flags.writeable = weight.flags.writeable = False
    return angle, weight
