"""Thermal radiance of clear air at the limb and above ground at grazing angles, in tables over the tangent height.

A line of sight passes spherical shells down to its lowest point, and up again unless it ends at the sea. The amounts of
absorbers of a shell are those of its vertical thickness times the length of the line in it, and add along the line; the
transmittance is that of their sum, as for paths to the ground. With the transmittance t from the camera to the ends of
a segment of temperature T the radiance is

    L = sum B(T) [t(near end) - t(far end)],

so that isothermal air gives (1 - t) B exactly; the sea adds B t as a black body, since it reflects air of nearly its
temperature. Clouds and scattered sunlight are left out.

Lines are refracted: n r sin(zenith) is constant along them (Bouguer's law), and with x = n r in place of the radius r
the length in a shell is that of a straight line. The tangent height of the table is that of the straight line outside
the air, by which pixels are known: rays graze the ground where it is (n - 1) R, 1.7 km.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hcss_payload.earth import SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M
from hcss_payload.rays import geographic
from hcss_twin.plan.assembly import Assembly
from hcss_twin.providers import EARTH_RADIUS_M, Array, Path, Problem, Profile, ScenarioError, planck, to_space

TOP_M = 100e3
"""Altitude above which there is no air."""

_FINE, _COARSE, _FINE_TO_M = 50.0, 200.0, 20e3
"""Thickness of shells, in whose lowest one amounts err by a sixth of it over their scale height, m."""

_NODES_M = np.concatenate((np.arange(0.0, 25e3, 500.0), np.arange(25e3, 60e3, 1e3), np.arange(60e3, TOP_M, 2e3)))
"""Lowest points of the lines of the table that miss the ground."""

_BELOW_M = np.concatenate(
    ([1.0, 10.0, 30.0], np.array([0.1, 0.2, 0.5, 1.0, 2.0, 4.0]) * 1e3, np.arange(6e3, 28e3, 2e3))
)
"""Tangent heights of lines that end at the sea, below that of the line that grazes it."""

_REFRACTIVITY_K_PA = 77.6e-8
"""(n - 1) T / p of dry air in the infrared (E. K. Smith and S. Weintraub, Proc. IRE 41, 1953)."""

_SEGMENT_M = 1e3
"""Thickness of segments of one temperature."""

_OFFSET_M = 50e3
"""Distance along a line at which its altitude is compared with that of its lowest point."""


class Limb:
    """Radiance of the limb above the ground of a scene.

    Raises
    ------
    ScenarioError
        If the atmosphere has no amounts of absorbers, which add along a line.
    """

    def __init__(self, assembly: Assembly) -> None:
        grid = assembly.spectral_grid
        if not hasattr(assembly.transmittance, "absorber_amounts"):
            message = (
                "'limb' needs an atmosphere with amounts of absorbers, which add along a line of sight, as "
                "'band-model'; allowed: that one, or 'missing'; closest is 'missing'"
            )
            raise ScenarioError([Problem("camera.beyond", message)])
        shells, spectral = Shells(assembly.profile), (grid.wavenumber_cm1, grid.weights_cm1)
        above = limb_radiance(assembly.transmittance, shells, *spectral, _NODES_M)
        grazing = shells.straight_m(0.0) - _BELOW_M[::-1]
        ends = grazing, assembly.sea_temperature_K
        below = ground_radiance(assembly.transmittance, shells, *spectral, *ends)
        self._heights_m = np.concatenate((grazing, [shells.straight_m(node_m) for node_m in _NODES_M]))
        self._radiance = np.concatenate((below, above))

    @property
    def lowest_m(self) -> float:
        """Tangent height at which the table begins: that of view zenith 84.9 degrees at the ground."""
        return float(self._heights_m[0])

    def __call__(self, tangent_m: Array) -> Array:
        """Return the radiance (B, ...) at tangent heights (...) of straight lines, below the ground, too.

        Its logarithm is linear between those of the table.
        """
        # Above the last height the air ends within the pixel of a camera.
        logarithm = np.log(np.maximum(self._radiance, 1e-30))
        of_bands = [np.exp(np.interp(tangent_m, self._heights_m, band_logarithm)) for band_logarithm in logarithm.T]
        return np.where(tangent_m < TOP_M, np.stack(of_bands), 0.0)


class Shells:
    """Spherical shells of air, along which lines of sight bend.

    Attributes
    ----------
    level_m : ndarray (N,)
    bent_m : ndarray (N,)
        Radius times refractive index of the levels.
    """

    def __init__(self, profile: Profile, refraction: bool = True) -> None:
        self.profile = profile
        self.level_m = np.concatenate((np.arange(0.0, _FINE_TO_M, _FINE), np.arange(_FINE_TO_M, TOP_M + 1.0, _COARSE)))
        inside = np.minimum(self.level_m, float(profile.altitude_m[-1]))
        refractivity = _REFRACTIVITY_K_PA * profile.pressure_at(self.level_m) / profile.temperature_at(inside)
        self.bent_m = (EARTH_RADIUS_M + self.level_m) * (1.0 + refractivity * float(refraction))

    def straight_m(self, lowest_m: float) -> float:
        """Return the tangent height of the straight line outside the air, of the line that is lowest at a level."""
        return float(self.bent_m[np.searchsorted(self.level_m, lowest_m - 1e-6)]) - EARTH_RADIUS_M

    def lengths(self, first: int, impact_m: float) -> Array:
        """Return the length of a line over the thickness of the shells from a level upward."""
        bent = self.bent_m[first:]
        along: Array = np.diff(np.sqrt(np.maximum(bent - impact_m, 0.0) * (bent + impact_m))) / np.diff(bent)
        return along


def limb_radiance(provider: Any, shells: Shells, wavenumber_cm1: Array, weights_cm1: Array, lowest_m: Array) -> Array:
    """Return the radiance (N, B) of clear air along lines of sight whose lowest points (N,) are multiples of 200 m.

    Parameters
    ----------
    provider : TransmittanceProvider
        With ``absorber_amounts``.
    weights_cm1 : ndarray (B, V)
        Of the bands at the wavenumbers (V,).
    """
    return _radiance(
        provider, shells, wavenumber_cm1, weights_cm1, [(float(height_m), None) for height_m in lowest_m], None
    )


def ground_radiance(
    provider: Any, shells: Shells, wavenumber_cm1: Array, weights_cm1: Array, tangent_m: Array, sea_temperature_K: float
) -> Array:
    """Return the radiance (N, B) of clear air before a black sea, along lines with straight tangent heights (N,)."""
    lines = [(0.0, EARTH_RADIUS_M + float(height_m)) for height_m in tangent_m]
    return _radiance(provider, shells, wavenumber_cm1, weights_cm1, lines, sea_temperature_K)


def _radiance(
    provider: Any,
    shells: Shells,
    wavenumber_cm1: Array,
    weights_cm1: Array,
    lines: Sequence[tuple[float, float | None]],
    sea_temperature_K: float | None,
) -> Array:
    """Return the radiance (N, B) along lines, given by lowest level and impact parameter (None: tangent there)."""
    levels, profile = shells.level_m, shells.profile
    # Outside its levels the profile has no air.
    top = float(profile.altitude_m[-1])
    above = [to_space(float(min(level, top)), 0.0) if level < top else Path() for level in levels]
    vertical = -np.diff(provider.absorber_amounts(above), axis=0)
    result = []
    for height, impact in lines:
        first = int(np.searchsorted(levels, height - 1e-6))
        along = shells.lengths(first, float(shells.bent_m[first]) if impact is None else impact)
        # Amounts from the lowest point to each level.
        upward = np.concatenate(
            (np.zeros((1, vertical.shape[1])), np.cumsum(along[:, None] * vertical[first:], axis=0))
        )
        ends = _segments(levels[first:])
        to_ends = upward[ends]
        near = provider.transmittance_of_amounts(wavenumber_cm1, upward[-1] - to_ends)
        far = np.zeros((2, 1))
        if sea_temperature_K is None:
            far = provider.transmittance_of_amounts(wavenumber_cm1, upward[-1] + to_ends)
        altitude = np.minimum(levels[first:][ends], top)
        temperature = profile.temperature_at(0.5 * (altitude[1:] + altitude[:-1]))
        source = planck(wavenumber_cm1[None, :], temperature[:, None])
        spectrum = np.sum(source * (np.diff(near, axis=0) - np.diff(far, axis=0)), axis=0)
        if sea_temperature_K is not None:
            spectrum += near[0] * planck(wavenumber_cm1, sea_temperature_K)
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
