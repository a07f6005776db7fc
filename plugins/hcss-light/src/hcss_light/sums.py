"""Sunlight in sliced clouds by sums of exponentials of the optical thickness toward view and sun.

The radiance of uniform columns as a function of their thickness is fitted by integrals of exp(-c (tau_view + tau_sun))
over tau_view with non-negative weights. The same integrals along the rays of broken cloud then give its radiance: light
that is scattered many times counts as light that is weakened less, on the same two straight paths.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from hcss_light.slices import Field, Slices, direct_sunlight, march
from hcss_light.source import Direction, Particles
from hcss_twin.providers import Array

RATES = np.array([1.0, 0.4, 0.15, 0.05, 0.015])
"""Extinction of the terms over that without the forward peak."""


def sun_integrals(
    slices: Slices, density: Field, particles: Particles, sunlight: Array, view: Direction, sun: Direction,
    reference_m: float,
) -> Array:  # fmt: skip
    """Return the integral (C, y, x) of each term for rays through points at an altitude.

    For each rate c the integral of sunlight exp(-c (tau_view + tau_sun)) over c tau_view.
    """
    extinction = particles.scaled[0]
    depth = np.empty(density.shape, dtype=np.float32)
    shifts = slices.shifts(sun.zenith_deg, sun.azimuth_deg, slices.base_m)
    direct_sunlight(density, extinction, slices.height_m, float(sun.vector[2]), shifts, True, depth)
    result = np.empty((RATES.size, *density.shape[1:]), dtype=np.float32)
    shifts, none = slices.shifts(view.zenith_deg, view.azimuth_deg, reference_m), np.zeros(slices.count)
    for rate, integral in zip(RATES.tolist(), result, strict=True):
        reached = np.exp(-rate * depth) * sunlight.astype(np.float32)[:, None, None]
        march(density, reached, none, rate * extinction, slices.height_m, float(view.vector[2]), shifts, 0.0, integral)
    return result.astype(np.float64)


def fitted_weights(integrals: Array, radiance: Array) -> Array:
    """Return non-negative weights (C,) with which integrals (C, N) of uniform columns give their radiance (N,).

    All thicknesses count by their relative error.
    """
    scale = 1.0 / np.maximum(radiance, 1e-3 * np.max(radiance, initial=np.finfo(float).tiny))
    weights: Array = nnls((integrals * scale).T, radiance * scale)[0]
    return weights
