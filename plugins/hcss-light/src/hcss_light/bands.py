"""Clouds and light of each band, for a few groups of wavenumbers, as they reach the sensor.

All radiance is counted at the sensor: a body at altitude z counts as its Planck radiance times the transmittance of the
gas above, plus the emission of that gas. Scattering keeps such sums in proportion. Along the view gas then changes
nothing; along other directions it draws them toward those of a black body (:mod:`hcss_light.source`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_light.source import Particles, Surroundings
from hcss_twin.models.atmosphere.path_radiance import path_radiance
from hcss_twin.providers import Array, Leg, Path, Sun, planck, to_space
from hcss_twin.providers.light import LightInputs

SPREAD, MOST_GROUPS = 0.05, 4
"""Standard deviation of the single-scattering albedo for which one more group is used, and how many at most."""

HEIGHTS = 9
"""Altitudes at which the gas is asked; linear in between."""

SUN_SHARE = 0.1
"""Share of sunlight that counts as radiance in the means over a band."""

DIFFUSE_DEG = 53.0
"""Zenith angle that stands for the hemisphere."""

LOWEST_SUN_DEG = 88.0


@dataclass(frozen=True)
class Group:
    """Wavenumbers of a band with similar clouds.

    Attributes
    ----------
    particles : Particles
        Means over the wavenumbers.
    around : Surroundings
        Integrals over the band's share.
    places : ndarray of int
        The wavenumbers, by their numbers among all.
    """

    particles: Particles
    around: Surroundings
    places: NDArray[np.intp]


def groups_of_bands(
    inputs: LightInputs, altitude_m: Array, sun: Sun | None, divided: Sequence[Sequence[Group]] | None = None
) -> list[list[Group]]:
    """Return the groups of each band, at the altitudes (Z,) of the slices.

    Parameters
    ----------
    divided : sequence of sequences of Group, optional
        Groups with the same wavenumbers; by default those with similar clouds.
    """
    wavenumber, layer = inputs.wavenumber_cm1, inputs.layer
    cloud = inputs.optics.single_scattering(layer.microphysics, wavenumber)
    heights = np.linspace(layer.base_m, layer.top_m, HEIGHTS)
    up = [to_space(float(height), inputs.view.zenith_deg) for height in heights]
    gas = inputs.transmittance.transmittance(wavenumber, up)
    air = path_radiance(inputs.transmittance, inputs.profile, wavenumber, heights.tolist(), inputs.view.zenith_deg)
    kelvin = inputs.profile.temperature_at(heights)
    if layer.temperature_K is not None:
        kelvin = np.full_like(heights, layer.temperature_K)
    black = planck(wavenumber[None], kelvin[:, None])
    emitted = black * gas + air
    sky = sky_radiance(inputs, wavenumber, layer.top_m) * gas[-1] + air[-1]
    across = np.cos(np.radians(inputs.view.zenith_deg))
    logarithm = np.log(np.maximum(gas, 1e-30))
    absorption = np.maximum(np.gradient(logarithm, heights, axis=0), 0.0) * across
    below = inputs.clear(sun) - sunlight_of_air(inputs, sun)
    glint, mirrored = np.zeros_like(below), mirrored_clouds(inputs, heights, gas)
    sunlight = np.zeros_like(emitted)
    if sun is not None and sun.zenith_deg <= LOWEST_SUN_DEG:
        both = [path + to_space(float(height), sun.zenith_deg) for path, height in zip(up, heights, strict=True)]
        irradiance = inputs.solar_irradiance(wavenumber) / sun.distance_au**2
        sunlight = inputs.transmittance.transmittance(wavenumber, both) * irradiance
        glint = inputs.sea_sun(sun)
    signal = (black * gas + SUN_SHARE * sunlight)[HEIGHTS // 2]
    result = []
    for band, weights in enumerate(inputs.weights_cm1):
        used = np.flatnonzero(weights > 0.0)
        groups = []
        parts = (
            _grouped(used, (weights * signal)[used], cloud.albedo[used])
            if divided is None
            else [group.places for group in divided[band]]
        )
        for some in parts:
            share, extinction = (weights * signal)[some], cloud.extinction_m1[some]
            if not np.any(share > 0.0):
                share = weights[some]
            scattered = share * extinction * cloud.albedo[some]
            particles = Particles(
                float(np.sum(share * extinction) / np.sum(share)),
                float(np.sum(scattered) / np.sum(share * extinction)),
                np.sum(cloud.moments[:, some] * scattered, axis=1) / max(np.sum(scattered), 1e-300),
            )

            def integral(values: Array, some: NDArray[np.intp] = some, weights: Array = weights) -> Array:
                result: Array = np.interp(altitude_m, heights, np.sum(values[:, some] * weights[some], axis=1))
                return result

            around = Surroundings(
                integral(emitted),
                float(np.sum(sky[some] * weights[some])),
                float(np.sum(below[some] * weights[some])),
                integral(sunlight),
                np.interp(altitude_m, heights, np.sum(absorption[:, some] * share, axis=1) / np.sum(share)),
                float(np.sum(glint[some] * weights[some])),
                integral(mirrored),
            )
            groups.append(Group(particles, around, some))
        result.append(groups)
    return result


def mirrored_clouds(inputs: LightInputs, altitude_m: Array, gas: Array) -> Array:
    """Return the radiance (Z, V) at the sensor that the sea adds if it mirrors opaque cloud at altitudes, not the sky.

    ``gas`` (Z, V): transmittance from there to the sensor.
    """
    wavenumber, zenith = inputs.wavenumber_cm1, inputs.view.zenith_deg
    across = np.cos(np.radians([zenith]))
    reflected = 1.0 - inputs.sea.emissivity(wavenumber, across)[0]
    (whole,) = inputs.transmittance.transmittance(wavenumber, [to_space(0.0, zenith)])
    kelvin = inputs.profile.temperature_at(altitude_m)
    if inputs.layer.temperature_K is not None:
        kelvin = np.full_like(altitude_m, inputs.layer.temperature_K)
    low, high = (sky_radiance(inputs, wavenumber, float(end_m), zenith) for end_m in altitude_m[[0, -1]])
    part = ((altitude_m - altitude_m[0]) / (altitude_m[-1] - altitude_m[0]))[:, None]
    # Down to the sea as much gas as the same line of sight has there upward.
    down = whole / np.maximum(gas, np.maximum(whole, 1e-30))
    result: Array = (
        reflected * whole * down * (planck(wavenumber[None], kelvin[:, None]) - (1 - part) * low - part * high)
    )
    return result


def sky_radiance(inputs: LightInputs, wavenumber: Array, altitude_m: float, zenith_deg: float = DIFFUSE_DEG) -> Array:
    """Return the thermal radiance (V,) of the sky at an altitude."""
    if inputs.transmittance.declares.legs == "to_space":
        (seen,) = path_radiance(inputs.transmittance, inputs.profile, wavenumber, [altitude_m], zenith_deg)
        return np.asarray(seen)
    higher = inputs.profile.altitude_m[inputs.profile.altitude_m > altitude_m]
    levels = np.concatenate(([altitude_m], higher))
    paths = [Path(), *(Path((Leg(altitude_m, float(level_m), zenith_deg),)) for level_m in higher)]
    transmittance = inputs.transmittance.transmittance(wavenumber, paths)
    kelvin = inputs.profile.temperature_at(levels)
    source = planck(wavenumber[None], 0.5 * (kelvin[1:] + kelvin[:-1])[:, None])
    result: Array = np.sum(source * -np.diff(transmittance, axis=0), axis=0)
    return result


def sunlight_of_air(inputs: LightInputs, sun: Sun | None) -> Array:
    """Return the sunlight (V,) that the air above all clouds scatters once into the view, at the sensor.

    Tables of columns have it, clouds do not shade it, and no path through clouds changes it. What the air below tops
    scatters counts as radiance from below. 0 with providers that give none, and where the engine has none
    because the sun is near the horizon somewhere along the line of sight.
    """
    if sun is None:
        return np.zeros(inputs.wavenumber_cm1.size)
    return inputs.air_sun(sun, max(cloud.layer.top_m for cloud in inputs.stack))


def _grouped(places: NDArray[np.intp], signal: Array, albedo: Array) -> list[NDArray[np.intp]]:
    """Divide wavenumbers into groups of similar albedo and equal signal."""
    total = float(np.sum(signal))
    if not total > 0.0:
        return [places]
    mean = np.sum(signal * albedo) / total
    spread = float(np.sqrt(np.sum(signal * (albedo - mean) ** 2) / total))
    count = int(np.clip(round(spread / SPREAD), 1, min(MOST_GROUPS, places.size)))
    order = np.argsort(albedo, kind="stable")
    middle = (np.cumsum(signal[order]) - 0.5 * signal[order]) / total
    number = np.minimum((middle * count).astype(np.intp), count - 1)
    return [places[np.sort(order[number == group])] for group in range(count) if np.any(number == group)]
