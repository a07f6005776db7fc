"""How much the resolved waves can change the radiance of a pixel, so that they may be neglected.

A resolved wave tilts the whole population of facets in a pixel by its slope. Tilts of three standard deviations are
considered; waves of a Gaussian sea exceed them in 0.3 % of the pixels.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from hcss_twin.core.arrays import Array

SIGMAS = 3.0
_STEEPEST_VIEW = np.radians(89.9)


class _Emitter(Protocol):
    def emissivity(self, wavenumber_cm1: Array, mu: Array) -> Array: ...


def thermal_contrast_bound(
    sea: _Emitter, wavenumber_cm1: Array, mu: Array, slope: float, sky_share: float = 0.0
) -> Array:
    """Return the greatest relative change (M, V) of emitted and reflected thermal radiance.

    |Change of emissivity| (1 - sky_share) over emissivity, the greater of both directions of tilt. The emissivity at a
    tilted view stands for that of tilted facets; views that a tilt would bring below the horizon count as 89.9 degrees.

    Parameters
    ----------
    sea : sea model
    wavenumber_cm1 : ndarray (V,)
    mu : ndarray (M,)
        Cosines of the view zenith angle.
    slope : float
        Standard deviation of the resolved slope.
    sky_share : float
        Radiance of the sky over that of a black sea; 0 is the sky of greatest contrast.
    """
    level = sea.emissivity(wavenumber_cm1, mu)
    zenith, tilt = np.arccos(mu), float(np.arctan(SIGMAS * slope))
    greatest = np.zeros_like(level)
    for sign in (-1.0, 1.0):
        view = np.minimum(np.abs(zenith + sign * tilt), _STEEPEST_VIEW)
        greatest = np.maximum(greatest, np.abs(sea.emissivity(wavenumber_cm1, np.cos(view)) - level))
    change, whole = greatest * (1.0 - sky_share), level + (1.0 - level) * sky_share
    # A sea that sends nothing, as under foam of emissivity 0, changes by nothing or by infinitely much.
    black = np.where(change > 0.0, np.inf, 0.0)
    return np.asarray(np.divide(change, whole, out=black, where=whole > 0.0), dtype=np.float64)


def tilted_glint_bound(
    mirror_slope: tuple[float, float], mean_square_slope: float, rms: tuple[float, float], view: tuple[float, float]
) -> float:
    """Return the greatest change of the glint over tilted parts, relative to the glint of the sea as a whole.

    Parameters
    ----------
    mirror_slope : (float, float)
        Slope, upwind and crosswind, of the facets that mirror the sun into the sensor.
    mean_square_slope : float
        Of the whole sea, taken as isotropic.
    rms : (float, float)
        Deviations of the resolved slope, upwind and crosswind; at least a tenth of the whole variance is taken to
        be left below the pixel.
    view : (float, float)
        Horizontal components, upwind and crosswind, of the direction toward the sensor.

    Notes
    -----
    All tilts within the ellipse of three standard deviations: the Gaussian density of what is left at the mirror slope,
    over the area the part shows, of which at least a tenth remains.
    """
    radius, angle = np.meshgrid(np.linspace(0.0, SIGMAS, 25), np.linspace(0.0, 2.0 * np.pi, 97))
    upwind, crosswind = radius * np.cos(angle) * rms[0], radius * np.sin(angle) * rms[1]
    half = 0.5 * mean_square_slope
    left = [max(half - each**2, 0.1 * half) for each in rms]
    away = (mirror_slope[0] - upwind) ** 2 / left[0] + (mirror_slope[1] - crosswind) ** 2 / left[1]
    whole = (mirror_slope[0] ** 2 + mirror_slope[1] ** 2) / half
    # Far from the glint the ratio overflows where the glint itself is 0: e^300 is as good as infinity.
    density = half / math.sqrt(left[0] * left[1]) * np.exp(np.minimum(0.5 * (whole - away), 300.0))
    sine = math.hypot(*view)
    area = 1.0 - (upwind * view[0] + crosswind * view[1]) / math.sqrt((1.0 - sine) * (1.0 + sine))
    return float(np.max(np.abs(density / np.maximum(area, 0.1) - 1.0)))
