"""Sunlight scattered once by a homogeneous layer, in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.multiple_scattering.phase_function import ScaledScattering, phase_function
from hcss_twin.physics.geometry import scattering_cosine

Array = NDArray[np.float64]


def path_back(thickness: Array, mu: Array, mu_sun: Array | float) -> Array:
    """Integral of exp(-t (1/mu + 1/mu_sun)) over the layer: times the kernel of scattering, reflection.

    S. Chandrasekhar, "Radiative Transfer", Dover 1960, section 9, integrated.
    """
    rate = 1.0 / mu + 1.0 / mu_sun
    result: Array = -np.expm1(-thickness * rate) / rate
    return result


def path_through(thickness: Array, mu: Array, mu_sun: Array | float) -> Array:
    """Integral of exp(-t / mu_sun - (tau - t) / mu): as :func:`path_back`, transmission.

    (exp(-tau / mu) - exp(-tau / mu_sun)) / (1 / mu_sun - 1 / mu), without 0 / 0 where both are alike.
    """
    view, sun = 1.0 / mu, 1.0 / mu_sun
    x = thickness * np.abs(view - sun)
    # (1 - exp(-x)) / x
    safe = np.where(x > 0.0, x, 1.0)
    mean = np.where(x > 0.0, -np.expm1(-safe) / safe, 1.0)
    result: Array = thickness * np.exp(-thickness * np.minimum(view, sun)) * mean
    return result


def single_scattering(
    scaled: ScaledScattering, albedo: Array, moments: Array, mu: Array, sun: float, azimuth: Array
) -> tuple[Array, Array]:
    """Light scattered once, by the full phase function over the scaled optical thickness; (T, V, P) each."""
    tau = scaled.thickness[..., np.newaxis]
    strength = (albedo / (1.0 - albedo * scaled.peak))[:, np.newaxis] / (4.0 * np.pi * mu * sun)
    turned = [scattering_cosine(m, sun, a) for m, a in zip(mu, azimuth, strict=True)]
    onward = [scattering_cosine(-m, sun, a) for m, a in zip(mu, azimuth, strict=True)]
    brdf = strength * phase_function(np.array(turned), moments) * path_back(tau, mu, sun)
    btdf = strength * phase_function(np.array(onward), moments) * path_through(tau, mu, sun)
    return brdf, btdf
