"""Thermal radiance of clear air at the limb, in tables over the tangent height.

A line of sight that misses the ground passes the air twice, down to its tangent height and up again, in spherical
shells. The amounts of absorbers of a shell are those of its vertical thickness times the length of the line in it, and
add along the line; the transmittance is that of their sum, as for paths to the ground. With the transmittance t from
the camera to the ends of a segment of temperature T the radiance is

    L = sum B(T) [t(near end) - t(far end)],

so that isothermal air gives (1 - t) B exactly. Lines of sight are straight, as those of all pixels; clouds and
scattered sunlight are left out.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_payload.rays import geographic
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.physics.geodesy import SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M
from hcss_twin.physics.paths import Path, to_space
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import EARTH_RADIUS_M, Profile
from hcss_twin.plan.plan import Plan

TOP_M = 100e3
"""Altitude above which there is no air."""

_FINE, _COARSE, _FINE_TO_M = 50.0, 200.0, 20e3
"""Thickness of shells, in whose lowest one amounts err by a sixth of it over their scale height, m."""

_NODES_M = np.concatenate((np.arange(0.0, 25e3, 500.0), np.arange(25e3, 60e3, 1e3), np.arange(60e3, TOP_M, 2e3)))
"""Tangent heights of the table."""

_SEGMENT_M = 1e3
"""Thickness of segments of one temperature."""

_OFFSET_M = 50e3
"""Distance along a line at which its altitude is compared with that of its lowest point."""


class Limb:
    """Radiance of the limb above the ground of a plan's scene.

    Raises
    ------
    ScenarioError
        If the atmosphere has no amounts of absorbers, which add along a line.
    """

    def __init__(self, plan: Plan) -> None:
        grid, assembly = plan.spectral_grid, plan.assembly
        if not hasattr(assembly.transmittance, "absorber_amounts"):
            message = (
                "'limb' needs an atmosphere with amounts of absorbers, which add along a line of sight, as "
                "'band-model'; allowed: that one, or 'missing'; closest is 'missing'"
            )
            raise ScenarioError([Problem("camera.beyond", message)])
        self._radiance = limb_radiance(
            assembly.transmittance, assembly.profile, grid.wavenumber_cm1, grid.weights_cm1, _NODES_M
        )

    def __call__(self, tangent_m: Array) -> Array:
        """Return the radiance (B, ...) at tangent heights (...); its logarithm is linear between those of the table."""
        # Above the last height the air ends within the pixel of a camera.
        logarithm = np.log(np.maximum(self._radiance, 1e-30))
        each = [np.exp(np.interp(tangent_m, _NODES_M, own)) for own in logarithm.T]
        return np.where(tangent_m < TOP_M, np.stack(each), 0.0)


def limb_radiance(
    provider: Any, profile: Profile, wavenumber_cm1: Array, weights_cm1: Array, tangent_m: Array
) -> Array:
    """Return the radiance (N, B) of clear air along lines of sight with tangent heights (N,), multiples of 200 m.

    Parameters
    ----------
    provider : TransmittanceProvider
        With ``absorber_amounts``.
    weights_cm1 : ndarray (B, V)
        Of the bands at the wavenumbers (V,).
    """
    levels = np.concatenate((np.arange(0.0, _FINE_TO_M, _FINE), np.arange(_FINE_TO_M, TOP_M + 1.0, _COARSE)))
    # Outside its levels the profile has no air.
    top = float(profile.altitude_m[-1])
    above = [to_space(float(min(level, top)), 0.0) if level < top else Path() for level in levels]
    vertical = -np.diff(provider.absorber_amounts(above), axis=0)
    radius = EARTH_RADIUS_M + levels
    result = []
    for height in tangent_m:
        first = int(np.searchsorted(levels, height - 1e-6))
        away = np.sqrt((radius[first:] - radius[first]) * (radius[first:] + radius[first]))
        along = np.diff(away) / np.diff(levels[first:])
        # Amounts from the tangent point to each level.
        upward = np.concatenate(
            (np.zeros((1, vertical.shape[1])), np.cumsum(along[:, None] * vertical[first:], axis=0))
        )
        ends = _segments(levels[first:])
        each = upward[ends]
        near = provider.transmittance_of_amounts(wavenumber_cm1, upward[-1] - each)
        far = provider.transmittance_of_amounts(wavenumber_cm1, upward[-1] + each)
        altitude = np.minimum(levels[first:][ends], top)
        temperature = profile.temperature_at(0.5 * (altitude[1:] + altitude[:-1]))
        source = planck(wavenumber_cm1[None, :], temperature[:, None])
        spectrum = np.sum(source * (np.diff(near, axis=0) - np.diff(far, axis=0)), axis=0)
        result.append(np.sum(weights_cm1 * spectrum, axis=1))
    return np.stack(result)


def _segments(levels_m: Array) -> Any:
    """Return the levels at the ends of segments: close together near the tangent point, where lines are long."""
    wanted = levels_m[0] + np.concatenate((_SEGMENT_M * np.array([0.0, 0.05, 0.2, 0.5]), np.arange(1e3, 101e3, 1e3)))
    return np.unique(np.searchsorted(levels_m, np.minimum(wanted, levels_m[-1]) - 1e-6))


def tangent_heights_m(origin_m: Array, direction: Array) -> Array:
    """Return the least altitudes (...) above the ellipsoid along lines (..., 3) that miss it.

    Parameters
    ----------
    origin_m : ndarray (3,)
        Earth-fixed start of the lines.
    direction : ndarray (..., 3)
        Unit vectors.
    """
    axes = np.array([SEMI_MAJOR_AXIS_M, SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M])
    start, step = origin_m / axes, direction / axes
    closest = -(step @ start) / np.sum(step * step, axis=-1)
    # Near its lowest point the altitude of a line is a parabola.
    below, middle, above = (
        geographic(origin_m + (closest + offset)[..., None] * direction)[2] for offset in (-_OFFSET_M, 0.0, _OFFSET_M)
    )
    slope, bend = 0.5 * (above - below), 0.5 * (above + below) - middle
    lowest: Array = middle - slope**2 / (4.0 * bend)
    return lowest
