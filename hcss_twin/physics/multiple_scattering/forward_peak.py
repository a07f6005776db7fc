"""Single scattering of sunlight in closed form, and the forward peak removed by delta-M scaling.

Delta-M scaling treats the forward peak of the phase function as unscattered light, because a sharp peak would need
hundreds of streams. Fluxes remain accurate, but sunlight near its own direction and singly scattered light do not. Both
are corrected here.

Reflected light: the TMS method of T. Nakajima and M. Tanaka, J. Quant. Spectrosc. Radiat. Transfer 40, 51-69 (1988).
Light that the scaled problem scattered once by its truncated phase function is replaced by single scattering with the
full one, w / (1 - w f) P over the scaled thickness.

Transmitted light: that method counts the forward peak as scattered once whatever the thickness, far too much in thick
layers; its authors correct the second order (IMS). Here all orders of scattering through small angles are summed: over
a slant path y = tau / mu the moment of degree l of all light, direct and scattered, is exp(-y (1 - w chi_l)) (H. C. van
de Hulst, "Multiple Light Scattering", 1980, section 14.1.2). In the scaled problem, with the peak in the direct light,
it is the same for l < L, and exp(-y (1 - w f)) from L on. So the scattered light lacks, with y' = y (1 - w f),

    C_l = exp(-y') - exp(-y),  l < L;     C_l = exp(-y) (exp(w chi_l y) - 1),  l >= L,

which for thin layers is again exact single scattering.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics.geometry import scattering_cosine
from hcss_twin.physics.multiple_scattering.directions import Directions
from hcss_twin.physics.multiple_scattering.phase_function import (
    HENYEY_GREENSTEIN_MOMENTS,
    ScaledScattering,
    extended_moments,
    phase_function,
    polynomials,
)


def path_back(thickness: Array, mu: Array, mu_sun: Array | float) -> Array:
    """Integral of exp(-t (1/mu + 1/mu_sun)) over the layer; times the scattering kernel, it is the reflection.

    S. Chandrasekhar, "Radiative Transfer", Dover 1960, section 9, integrated.
    """
    rate = 1.0 / mu + 1.0 / mu_sun
    result: Array = -np.expm1(-thickness * rate) / rate
    return result


def path_through(thickness: Array, mu: Array | float, mu_sun: Array | float) -> Array:
    """Integral of exp(-t / mu_sun - (tau - t) / mu): as :func:`path_back`, for transmission.

    (exp(-tau / mu) - exp(-tau / mu_sun)) / (1 / mu_sun - 1 / mu), without 0 / 0 for equal cosines.
    """
    view, sun = 1.0 / mu, 1.0 / mu_sun
    x = thickness * np.abs(view - sun)
    # (1 - exp(-x)) / x
    safe = np.where(x > 0.0, x, 1.0)
    mean = np.where(x > 0.0, -np.expm1(-safe) / safe, 1.0)
    result: Array = thickness * np.exp(-thickness * np.minimum(view, sun)) * mean
    return result


_MIN_MOMENT = 1e-10
"""Smaller moments of a Henyey-Greenstein function are neglected."""

_MAX_ASYMMETRY = 0.998
"""Sharper peaks would need more than some ten thousand moments. Crystals have up to .9953."""


def once_back(scaled: ScaledScattering, albedo: Array, moments: Array, mu: Array, sun: float, azimuth: Array) -> Array:
    """Brdf (T, V, P) of light scattered once by the full phase function, over the scaled thickness."""
    kernel = once_back_kernel(scaled, albedo, moments, mu, sun, azimuth)
    return kernel * path_back(scaled.thickness[..., np.newaxis], mu, sun)


def once_back_kernel(
    scaled: ScaledScattering, albedo: Array, moments: Array, mu: Array, sun: float, azimuth: Array
) -> Array:
    """The kernel (V, P) of :func:`once_back`, which does not depend on thickness."""
    turned = np.array([scattering_cosine(m, sun, a) for m, a in zip(mu, azimuth, strict=True)])
    strength = (albedo / (1.0 - albedo * scaled.peak))[:, np.newaxis] / (4.0 * np.pi * mu * sun)
    result: Array = strength * phase_function(turned, moments)
    return result


_ANGLES, _MORE_AZIMUTHS = 1441, 16
"""Angles of the tabulated phase function, .125 deg apart; azimuths beyond the number of modes."""


def once_back_modes(scaled: ScaledScattering, albedo: Array, moments: Array, where: Directions, modes: int) -> Array:
    """Azimuth modes 0 to ``modes`` - 1 of the kernel of :func:`once_back` toward streams, (modes, V, N, C).

    Times :func:`path_back`, they are brdfs; azimuths count from the direction in which the light travels. A peak that
    the azimuths do not resolve, between grazing directions, is cut off.
    """
    count = modes + _MORE_AZIMUTHS
    azimuth = (np.arange(count) + 0.5) * np.pi / count
    upward, downward = where.mu[where.beams : where.columns, None], where.mu[: where.columns]
    product, sines = upward * downward, np.sqrt((1.0 - upward**2) * (1.0 - downward**2))
    cosine = sines[..., None] * np.cos(azimuth) - product[..., None]
    angle = np.maximum(np.arccos(np.clip(cosine, -1.0, 1.0)), 2.0 * np.pi / count)
    table = phase_function(np.cos(np.linspace(0.0, np.pi, _ANGLES)), moments)
    position = angle * ((_ANGLES - 1) / np.pi)
    below = np.minimum(position.astype(np.intp), _ANGLES - 2)
    value = table[:, below] + (position - below) * (table[:, below + 1] - table[:, below])
    series = np.cos(np.arange(modes)[:, None] * azimuth) / count
    strength = (albedo / (1.0 - albedo * scaled.peak))[:, None, None] / (4.0 * np.pi * product)
    result: Array = np.moveaxis(value @ series.T, -1, 0) * strength
    return result


def once_through(
    scaled: ScaledScattering, albedo: Array, moments: Array, mu: Array, sun: float, azimuth: Array
) -> Array:
    """Btdf (T, V, P) of light scattered once by the scaled phase function, and of the aureole.

    Raises
    ------
    ValueError
        If a Henyey-Greenstein function has |g| above 0.998.
    """
    onward = np.array([scattering_cosine(-m, sun, a) for m, a in zip(mu, azimuth, strict=True)])
    series = (2 * np.arange(scaled.moments.shape[0]) + 1)[:, np.newaxis] * scaled.moments
    truncated = np.asarray(np.polynomial.legendre.legval(onward, series), dtype=np.float64)
    strength = scaled.albedo[:, np.newaxis] / (4.0 * np.pi * mu * sun)
    once = strength * truncated * path_through(scaled.thickness[..., np.newaxis], mu, sun)
    return once + _aureole(scaled, albedo, moments, mu, sun, onward)


def _aureole(scaled: ScaledScattering, albedo: Array, moments: Array, mu: Array, sun: float, onward: Array) -> Array:
    """Btdf (T, V, P) of light that the scaled problem counts as direct or loses; ``onward`` (P,): scattering cosines.

    Where the cosines of view and sun differ, y is computed with the mean of their inverses, and the result is
    multiplied by the factor that makes single scattering exact.
    """
    count = scaled.moments.shape[0]
    if moments.shape[0] == HENYEY_GREENSTEIN_MOMENTS:
        largest = max(float(np.max(np.abs(moments[1]), initial=0.0)), 0.1)
        if largest > _MAX_ASYMMETRY:
            raise ValueError(f"|moments[1]| {largest:g}: allowed up to {_MAX_ASYMMETRY}; closest is {_MAX_ASYMMETRY}")
        known = extended_moments(moments, max(count + 1, int(np.log(_MIN_MOMENT) / np.log(largest)) + 1))
    else:
        known = extended_moments(moments, max(count + 1, moments.shape[0]))
    beyond = known[count:]
    series = 2.0 * np.arange(known.shape[0]) + 1.0
    rest = 1.0 - albedo * scaled.peak
    # All terms are relative to the slowest decay: under a low sun exp(-y) itself underflows.
    slowest = np.minimum(rest, 1.0 - albedo * np.max(beyond, axis=0, initial=0.0))
    missing, peak = (_scattered_onward(albedo * beyond, slowest), _scattered_onward(albedo * scaled.peak, slowest))
    tau = scaled.thickness / rest
    result = np.empty((*tau.shape, mu.size))
    values = series * polynomials(onward, known.shape[0])
    for p, (m, value) in enumerate(zip(mu, values, strict=True)):
        rate = 0.5 * (1.0 / m + 1.0 / sun)
        for t, y in enumerate(tau * rate):
            total = value[:count].sum() * peak(y) + value[count:] @ missing(y)
            slant = path_through(scaled.thickness[t], mu[p], sun)
            straight = scaled.thickness[t] * np.exp(-y * (rest - slowest))
            lit = straight > np.finfo(np.float64).tiny
            ratio = np.where(lit, slant / np.where(lit, straight, 1.0), 0.0)
            result[t, :, p] = total * ratio / (rate * 4.0 * np.pi * m * sun)
    return result


def _scattered_onward(strength: Array, slowest: Array) -> Callable[[Array], Array]:
    """exp(-y) (exp(strength y) - 1) / exp(-slowest y) as a function of y, without overflow, accurate for thin layers.

    ``slowest`` is at most 1 - strength, and at most 1.
    """
    decay, size, sign = 1.0 - np.maximum(strength, 0.0) - slowest, np.abs(strength), -np.sign(strength)

    def scattered(y: Array) -> Array:
        result: Array = np.exp(-y * np.maximum(decay, 0.0)) * np.expm1(-y * size) * sign
        return result

    return scattered
