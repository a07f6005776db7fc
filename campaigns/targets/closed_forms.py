"""What a target adds to an image, in closed form: radiometry at its own place, and its image through a sensor.

Written before the code that draws targets. The air, the optics of clouds and the radiance of a column come from the
providers of the scene; everything that the engine does with them for a target is done here once more.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import j1, ndtr

from hcss_twin.physics.paths import Leg, Path, to_space
from hcss_twin.physics.planck import planck

SKY_ZENITH_DEG = 53.0
"""Zenith angle that stands for the whole sky above a diffuse reflector (diffusivity factor 1.66)."""


def added(plan, target, time_s, zenith_deg):
    """Return what a target adds to the radiance of its pixel (B,), and the radiance (B,) that it replaces.

    A plume of intensity I adds t T I / (pixel area across the line of sight). A body of share c adds
    c t [T (emissivity B + reflected) + A - L_behind], where t is the direct transmission of the cloud above its own
    point, T and A transmittance and emission of the air above its altitude, and L_behind the radiance that its own
    column would send without the clouds above it.
    """
    grid, optics, mu = plan.spectral_grid, plan.assembly.optics, math.cos(math.radians(zenith_deg))
    wave, weights, sun = grid.wavenumber_cm1, grid.weights_cm1, plan.sun_at(time_s)
    thickness = own_thickness(plan, target["row"], target["column"], time_s)
    above, below, depth = [], [], np.zeros_like(wave)
    for layer, metres in zip(plan.layers, thickness, strict=True):
        top = float(layer.cloud_top_m(np.array([metres]))[0])
        above.append(min(max(top - target["altitude"], 0.0), metres))
        below.append(0.0 if above[-1] > 0.0 else metres)
        depth += above[-1] * optics.single_scattering(layer.microphysics, wave).extinction_m1
    cloud = np.exp(-depth / mu)
    area_m2 = plan.grid.pixel_size_m**2 * mu
    through = plan.assembly.transmittance.transmittance(wave, [to_space(target["altitude"], zenith_deg)])[0]
    if "intensity" in target:
        mean = weights @ (through * cloud) / weights.sum(axis=1)
        return mean * target["intensity"] / area_m2, np.zeros(len(weights))
    share, emissivity = target["area"] / area_m2, target.get("emissivity", 1.0)
    body = emissivity * planck(wave, target["temperature"]) * through
    if emissivity < 1.0:
        body = body + (1.0 - emissivity) * _reflected(plan, target["altitude"], zenith_deg, sun, depth)
    own = weights @ (body * cloud)
    emission = weights @ _emission(plan, target["altitude"], zenith_deg)
    colour = planck(wave, target["temperature"])
    direct = (weights @ (colour * through * cloud)) / (weights @ (colour * through))
    behind = column(plan, below, sun)
    return share * (own + direct * (emission - behind)), share * direct * behind


def own_thickness(plan, row, column, time_s):
    """Thickness of each layer at the point of the scene that holds a place of the image."""
    samples = plan.samples_per_pixel
    at = [slice(math.floor(each * samples), math.floor(each * samples) + 1) for each in (row, column)]
    return [float(each.thickness_m(time_s, *at)[0, 0]) for each in plan.assembly.generators]


def column(plan, thickness_m, sun):
    """Radiance (B,) of a column with cloud of this thickness in each layer, by the radiance model itself."""
    grid = plan.spectral_grid
    terms = plan.assembly.cloudy(grid.wavenumber_cm1, np.array([thickness_m]), sun)
    return grid.weights_cm1 @ sum(np.asarray(each)[0] for each in terms.values())


def _emission(plan, altitude_m, zenith_deg):
    """Emission (V,) of the air above an altitude, from the transmittances of its layers to space."""
    profile, wave = plan.assembly.profile, plan.spectral_grid.wavenumber_cm1
    own = getattr(plan.assembly.transmittance, "path_radiance", None)
    if own is not None:
        return own(wave, [to_space(altitude_m, zenith_deg)])[0]
    levels = np.concatenate(([altitude_m], profile.altitude_m[profile.altitude_m > altitude_m]))
    to = plan.assembly.transmittance.transmittance(wave, [to_space(float(z), zenith_deg) for z in levels[:-1]])
    to = np.concatenate((to, np.ones((1, wave.size))))
    kelvin = profile.temperature_at(levels)
    layers = [planck(wave, 0.5 * (a + b)) for a, b in zip(kelvin[1:], kelvin[:-1], strict=True)]
    return np.sum(np.array(layers) * np.diff(to, axis=0), axis=0)


def _reflected(plan, altitude_m, zenith_deg, sun, depth):
    """Sunlight and thermal sky (V,) that a white horizontal diffuser sends through the air to the sensor."""
    air, profile, wave = plan.assembly.transmittance, plan.assembly.profile, plan.spectral_grid.wavenumber_cm1
    toward = to_space(altitude_m, zenith_deg)
    levels = np.concatenate(([altitude_m], profile.altitude_m[profile.altitude_m > altitude_m]))
    to = air.transmittance(wave, [toward + Path((Leg(altitude_m, float(z), SKY_ZENITH_DEG),)) for z in levels])
    kelvin = profile.temperature_at(levels)
    layers = [planck(wave, 0.5 * (a + b)) for a, b in zip(kelvin[1:], kelvin[:-1], strict=True)]
    result = np.sum(np.array(layers) * -np.diff(to, axis=0), axis=0)
    if sun is not None:
        mu = math.cos(math.radians(sun.zenith_deg))
        both = air.transmittance(wave, [toward + to_space(altitude_m, sun.zenith_deg)])[0]
        power = plan.assembly.solar_irradiance(wave) / sun.distance_au**2
        result = result + power * mu / math.pi * both * np.exp(-depth / mu)
    return result


def image(sensor, shape, row, column, motion):
    """Image (Y, X) of a point of unit energy, mean over the pixels and over a straight motion (rows, columns).

    ``sensor`` is ("gaussian", sigma) or ("airy", cut-off frequency in cycles per pixel); pixel n extends from n to n+1.
    """
    steps = 1 if not np.any(motion) else 8 * math.ceil(float(np.hypot(*motion))) + 3
    along = (np.arange(steps) + 0.5) / steps - 0.5
    spread = _gaussian if sensor[0] == "gaussian" else _airy
    return np.mean([spread(sensor[1], shape, row + s * motion[0], column + s * motion[1]) for s in along], axis=0)


def _gaussian(sigma, shape, row, column):
    down, across = (
        np.diff(ndtr((np.arange(size + 1) - at) / sigma)) for size, at in zip(shape, (row, column), strict=True)
    )
    return np.outer(down, across)


def _airy(cutoff, shape, row, column, points=6):
    """Diffraction at a circular aperture to 18 pixels; each pixel is the mean of midpoints, near the centre of more."""
    result = np.zeros(shape)
    y, x = np.ogrid[: shape[0], : shape[1]]
    away = np.hypot(y + 0.5 - row, x + 0.5 - column)
    near, far = away < 3.5, (away >= 3.5) & (away < 18.0)

    def mean(rows, columns, count):
        inner = (np.arange(count) + 0.5) / count
        r = np.hypot(rows[:, None, None] + inner[:, None] - row, columns[:, None, None] + inner - column)
        v = np.maximum(np.pi * cutoff * r, 1e-9)
        return np.mean(0.25 * np.pi * cutoff**2 * (2.0 * j1(v) / v) ** 2, axis=(1, 2))

    for where, count in ((near, 3 * points), (far, points)):
        at = np.nonzero(where)
        result[at] = mean(*at, count)
    return result
