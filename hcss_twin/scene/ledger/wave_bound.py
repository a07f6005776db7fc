"""How much resolved waves could change the radiance of clear pixels: a bound that costs no table."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcss_twin.physics.geometry import relative_azimuth_rad
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.planck import planck
from hcss_twin.providers import Sun
from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.sea.wave_contrast import thermal_contrast_bound, tilted_glint_bound

Array = NDArray[np.float64]

WAVENUMBERS = 24
"""Samples of each band."""


def wave_bound(
    assembly: Assembly, rms: tuple[float, float], wind_from_deg: float, suns: Sequence[Sun | None]
) -> float:
    """Return the greatest relative change of clear radiance in any band, for tilts of up to three standard deviations.

    Light from the sea counts with the change of its emissivity under a sky that sends nothing, and
    sunlight from the sea with that of the glint: as much as the sea sends toward the sensor through the air, and at
    most all the sunlight of clear sky. Both are upper limits.

    Parameters
    ----------
    assembly : Assembly
        Its sea has ``mean_square_slope``.
    rms : (float, float)
        Deviations of resolved slope, upwind and crosswind.
    wind_from_deg : float
        Bearing the wind comes from.
    suns : sequence of Sun or None
        Positions to consider.
    """
    grid = assembly.spectral_grid
    places = np.unique(np.concatenate([_sample(weights) for weights in grid.weights_cm1]))
    wavenumber, weights = grid.wavenumber_cm1[places], grid.weights_cm1[:, places]
    view = assembly.view
    mu = np.array([math.cos(math.radians(view.zenith_deg))])
    toward_view = _horizontal(view.zenith_deg, view.azimuth_deg - wind_from_deg)
    emissivity = assembly.sea.emissivity(wavenumber, mu)[0]
    thermal = emissivity * planck(wavenumber, assembly.sea_temperature_K)
    turn = math.radians(view.azimuth_deg - wind_from_deg)
    along = math.hypot(rms[0] * math.cos(turn), rms[1] * math.sin(turn))
    thermal *= thermal_contrast_bound(assembly.sea, wavenumber, mu, along)[0]
    path = to_space(0.0, view.zenith_deg)
    seen = assembly.transmittance.transmittance(wavenumber, [path])[0]
    greatest = 0.0
    for sun in suns:
        terms = assembly.model.clear(wavenumber, sun)
        change = weights @ (seen * thermal)
        if sun is not None:
            toward_sun = _horizontal(sun.zenith_deg, sun.azimuth_deg - wind_from_deg)
            vertical = float(mu[0]) + math.cos(math.radians(sun.zenith_deg))
            mirror = (
                -(toward_view[0] + toward_sun[0]) / vertical,
                -(toward_view[1] + toward_sun[1]) / vertical,
            )
            slope = float(assembly.sea.mean_square_slope)  # type: ignore[attr-defined]
            sunlight = np.sum([terms[name] for name in assembly.model.solar_terms], axis=0)
            sunlight = np.minimum(sunlight, seen * _glint(assembly, wavenumber, mu, sun))
            change = change + tilted_glint_bound(mirror, slope, rms, toward_view) * (weights @ sunlight)
        total = weights @ np.sum(list(terms.values()), axis=0)
        greatest = max(greatest, float(np.max(change[total > 0] / total[total > 0], initial=0.0)))
    return greatest


def _horizontal(zenith_deg: float, azimuth_deg: float) -> tuple[float, float]:
    """Horizontal components of a direction, along a bearing from which its azimuth is counted and clockwise from it."""
    sine, azimuth = math.sin(math.radians(zenith_deg)), math.radians(azimuth_deg)
    return sine * math.cos(azimuth), sine * math.sin(azimuth)


def _sample(weights: Array) -> NDArray[np.intp]:
    """Places, evenly taken, among those where a band has weight."""
    inside = np.flatnonzero(weights)
    return inside[np.unique(np.linspace(0, inside.size - 1, WAVENUMBERS).round().astype(np.intp))]


def _glint(assembly: Assembly, wavenumber_cm1: Array, mu: Array, sun: Sun) -> Array:
    """Sunlight reflected by the sea, (V,), at the sea, as if no air were above it."""
    mu_sun = np.array([math.cos(math.radians(sun.zenith_deg))])
    azimuth = np.array([relative_azimuth_rad(assembly.view.azimuth_deg, sun.azimuth_deg)])
    irradiance = assembly.solar_irradiance(wavenumber_cm1) / sun.distance_au**2
    brdf = assembly.sea.brdf(wavenumber_cm1, mu, mu_sun, azimuth)[0]
    return np.asarray(brdf * mu_sun[0] * irradiance, dtype=np.float64)
