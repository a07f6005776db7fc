"""Closed forms in place of adding-doubling: delta-Eddington fluxes and the source function technique.

The layer is scaled by delta-Eddington (J. H. Joseph, W. J. Wiscombe and J. A. Weinman, J. Atmos. Sci. 33, 2452-2459
(1976)). The sum s and difference d of both fluxes obey, with t from the middle,

    ds/dt = -b d,   dd/dt = -a s,   a = 2 (1 - w'),   b = 3/2 (1 - w' g').

The radiance that leaves toward mu is the integral of the source function made of these fluxes,
w' (s / 2 +- 3/4 g' mu d), as O. B. Toon, C. P. McKay, T. P. Ackerman and K. Santhanam, J. Geophys. Res.
94, 16287-16301 (1989), proposed. In isothermal surroundings s = 2, d = 0 solve the equations: rows sum to 1.

Isotropic light gives the amount that goes toward mu, not its origin. The kernels are that of single scattering, S, plus
the rest of each row, m_i, spread over all directions: K_ij = S_ij + (m_i + m_j - mean of m) / pi, symmetric, with the
right row sums.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hcss_twin.core.arrays import Array
from hcss_twin.physics.multiple_scattering.directions import gauss_streams
from hcss_twin.physics.multiple_scattering.forward_peak import once_back, once_through, path_back, path_through
from hcss_twin.physics.multiple_scattering.layer import LayerOperators, checked_cosines, checked_layers, checked_sun
from hcss_twin.physics.multiple_scattering.phase_function import ScaledScattering, extended_moments


@dataclass(frozen=True)
class _Rows:
    """Row sums of a layer at directions (D,): all (T, V, D)."""

    reflection: Array
    transmission: Array
    direct: Array
    emissivity: Array
    far_share: Array


def solve_layers_two_stream(
    optical_thickness: ArrayLike, albedo: ArrayLike, moments: ArrayLike, mu_extra: ArrayLike, streams: int
) -> LayerOperators:
    """Operators as :func:`hcss_twin.physics.multiple_scattering.layer.solve_layers`, approximate and in closed form.

    Parameters, result and errors are those of ``solve_layers``. ``streams`` is the number of directions only: results
    at a direction hardly depend on it. ``direct`` is scaled by delta-Eddington, thus larger than there.
    """
    thickness, w, chi = checked_layers(optical_thickness, albedo, moments)
    extra = checked_cosines("mu_extra", mu_extra)
    quadrature = gauss_streams(streams)
    mu = np.concatenate([extra, quadrature.mu])
    weight = np.concatenate([np.zeros_like(extra), quadrature.weight])
    scaled = _delta_eddington(thickness, w, chi)
    rows = _rows(scaled, mu)
    back, through = _once(scaled, mu)
    flux = 2.0 * np.pi * mu * weight
    return LayerOperators(
        mu,
        weight,
        back + _spread(rows.reflection - back @ flux, flux),
        through + _spread(rows.transmission - through @ flux, flux),
        rows.direct,
        rows.emissivity,
        rows.far_share,
    )


def solve_sun_two_stream(
    optical_thickness: ArrayLike,
    albedo: ArrayLike,
    moments: ArrayLike,
    mu_view: ArrayLike,
    mu_sun: float,
    relative_azimuth: ArrayLike,
    streams: int,
) -> tuple[Array, Array]:
    """Reflectance and transmittance (T, V, P) of sunlight, sr-1, in closed form.

    Single scattering and forward peak as in :func:`hcss_twin.physics.multiple_scattering.sunlight.solve_sun`, plus the
    part that :func:`solve_layers_two_stream` spreads over all directions, which does not depend on azimuth. Parameters,
    result and errors are those of ``solve_sun``.
    """
    thickness, w, chi = checked_layers(optical_thickness, albedo, moments)
    view, sun, azimuth = checked_sun(mu_view, mu_sun, relative_azimuth)
    quadrature = gauss_streams(streams)
    scaled = _delta_eddington(thickness, w, chi)
    mu = np.concatenate([[sun], quadrature.mu, view])
    weight = np.concatenate([[0.0], quadrature.weight, np.zeros_like(view)])
    flux = 2.0 * np.pi * mu * weight
    rows = _rows(scaled, mu)
    back, through = _once(scaled, mu)
    brdf = once_back(scaled, w, chi, view, sun, azimuth)
    btdf = once_through(scaled, w, chi, view, sun, azimuth)
    first = 1 + quadrature.mu.size
    brdf += _spread(rows.reflection - back @ flux, flux)[..., first:, 0]
    btdf += _spread(rows.transmission - through @ flux, flux)[..., first:, 0]
    return brdf, btdf


def _delta_eddington(thickness: Array, albedo: Array, moments: Array) -> ScaledScattering:
    """Scale to two moments; the peak is the second moment if the phase function has a forward peak.

    A phase function without one (Rayleigh's, or one that scatters backward) is not scaled.
    """
    g, second = extended_moments(moments, 3)[1:]
    peak = np.clip(second, 0.0, np.maximum(g, 0.0))
    rest = 1.0 - albedo * peak
    scaled = np.stack([np.ones_like(g), (g - peak) / (1.0 - peak)])
    return ScaledScattering(thickness * rest, albedo * (1.0 - peak) / rest, (1.0 - albedo) / rest, scaled, peak)


def _once(scaled: ScaledScattering, mu: Array) -> tuple[Array, Array]:
    """Kernels (T, V, D, D) of light scattered once by the scaled phase function 1 +- 3 g' mu mu'."""
    product = np.outer(mu, mu)
    slope = 3.0 * scaled.moments[1][:, np.newaxis, np.newaxis] * product
    strength = scaled.albedo[:, np.newaxis, np.newaxis] / (4.0 * np.pi * product)
    tau = scaled.thickness[..., np.newaxis, np.newaxis]
    view, sun = mu[:, np.newaxis], mu
    return strength * (1.0 - slope) * path_back(tau, view, sun), strength * (1.0 + slope) * path_through(tau, view, sun)


def _spread(row: Array, flux: Array) -> Array:
    """Symmetric kernel (T, V, D, D) with row sums ``row`` (T, V, D); ``flux`` (D,) sums to pi."""
    mean = (row @ flux / np.pi)[..., np.newaxis, np.newaxis]
    result: Array = (row[..., :, np.newaxis] + row[..., np.newaxis, :] - mean) / np.pi
    return result


def _rows(scaled: ScaledScattering, mu: Array) -> _Rows:
    """Light toward ``mu`` under isotropic light on both faces, and on both with opposite sign."""
    w, g = scaled.albedo[:, np.newaxis], scaled.moments[1][:, np.newaxis]
    a, b = 2.0 * scaled.co_albedo[:, np.newaxis], 1.5 * (1.0 - w * g)
    k = np.sqrt(a * b)
    tau = scaled.thickness[..., np.newaxis]
    half = 0.5 * tau
    slant = 0.75 * g * mu
    even, odd, linear = _weighted(k, tau, mu)
    direct = np.exp(-tau / mu)
    # tanh(k h) / k, h where k is 0
    tangent = np.where(k > 0.0, np.tanh(k * half) / np.where(k > 0.0, k, 1.0), half)
    # s = s0 cosh(k t), d = -a s0 sinh(k t) / k; s0 cosh(k h) = 2 / (1 + a tanh(k h) / k)
    both = w * (even - 2.0 * slant * a * odd) / (1.0 + a * tangent)
    # d = d0 cosh(k t), s = -b d0 sinh(k t) / k; d0 cosh(k h) = -2 / (1 + b tanh(k h) / k)
    opposite = w * (b * odd - 2.0 * slant * even) / (1.0 + b * tangent)
    emissivity = -np.expm1(-tau / mu) - both
    # The Planck radiance t adds s = 2 t, d = -2 / b to the second of these.
    d0 = (tau + 2.0 / b) / (1.0 + b * tangent)
    slanted = linear + w * (slant * (d0 * even + 2.0 / b * np.expm1(-tau / mu)) - 0.5 * b * d0 * odd)
    far = 0.5 * emissivity - np.where(tau > 0.0, slanted / np.where(tau > 0.0, tau, 1.0), 0.0)
    return _Rows(0.5 * (both + opposite), 0.5 * (both - opposite), direct, emissivity, far)


def _weighted(k: Array, tau: Array, mu: Array) -> tuple[Array, Array, Array]:
    """Means of cosh(k t), sinh(k t) / k, both over cosh(k tau / 2), and of t, weighted by exp(-u / mu) / mu.

    u = tau / 2 - t is the depth below the face that the light leaves, t the depth from the middle.
    """
    rate = 1.0 / mu
    x = tau * rate
    # x / 2 - 1 + exp(-x) (x / 2 + 1), by its series where that would cancel
    near = np.minimum(x, 0.1)
    series = near**3 * (1 / 12 - near * (1 / 24 - near * (1 / 80 - near * (1 / 360 - near / 2016))))
    linear = mu * np.where(x > 0.1, 0.5 * x - 1.0 + np.exp(-x) * (0.5 * x + 1.0), series)
    rising = -np.expm1(-(rate + k) * tau) / (rate + k)
    falling = path_through(tau, mu, 1.0 / np.maximum(k, np.finfo(np.float64).tiny))
    scale = rate / (1.0 + np.exp(-k * tau))
    # Below this both forms lose the same number of digits.
    thin = k * tau < 1e-5
    odd = np.where(thin, linear, scale * (rising - falling) / np.where(thin, 1.0, k))
    return scale * (rising + falling), odd, linear
