"""How much the resolved waves can change the radiance of a pixel, so that they may be left out.

A resolved wave tilts the whole population of facets in a pixel by its slope. Tilts of three standard deviations are
considered; waves of a Gaussian sea exceed them in 0.3 % of the pixels.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.sea.wave_field import cutoff_frequency_rad_s
from hcss_twin.models.sea.wave_spectrum import WaveSpectrum

SIGMAS = 3.0
_STEEPEST_VIEW = np.radians(89.9)


class _Emitter(Protocol):
    def emissivity(self, wavenumber_cm1: Array, mu: Array) -> Array: ...


def resolved_slope(spectrum: WaveSpectrum, pixel_size_m: float) -> float:
    """Return the standard deviation of the resolved slope along the steepest direction, the wind's.

    Directions scatter with the density 2/pi cos^2, which puts three quarters of the variance along the wind.

    Raises
    ------
    ValueError
        If the pixel size is not above 0.
    """
    total = spectrum.resolved_mean_square_slope(cutoff_frequency_rad_s(pixel_size_m))
    return float(np.sqrt(0.75 * total))


def thermal_contrast_bound(
    sea: _Emitter, wavenumber_cm1: Array, mu: Array, slope: float, sky_share: float = 0.0
) -> Array:
    """Return the greatest relative change (M, V) of emitted and reflected thermal radiance.

    Parameters
    ----------
    sea : sea model
        Its emissivity at tilted views stands for that of tilted facets.
    wavenumber_cm1 : ndarray (V,)
        Wavenumbers.
    mu : ndarray (M,)
        Cosines of the view zenith angle.
    slope : float
        Standard deviation of the resolved slope, from :func:`resolved_slope`.
    sky_share : float
        Radiance of the sky over that of a black sea; 0 is the sky of greatest contrast.

    Returns
    -------
    ndarray (M, V)
        |change of emissivity| (1 - sky_share) over emissivity, the greater of both directions of tilt. Views
        that a tilt would bring below the horizon count as 89.9 degrees.
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


def glint_contrast_bound(mirror_slope: Array, mean_square_slope: float, slope: float) -> Array:
    """Return the greatest relative change of the glint.

    Parameters
    ----------
    mirror_slope : ndarray
        Slope of the facets that mirror the sun into the sensor (0 in the centre of the glint); any shape.
    mean_square_slope : float
        Of the facets below the pixel.
    slope : float
        Standard deviation of the resolved slope.

    Returns
    -------
    ndarray
        Same shape: change of the Gaussian density where its centre moves toward the mirror slope.
    """
    shift = SIGMAS * slope
    nearer = np.maximum(np.abs(mirror_slope) - shift, 0.0)
    gain = (mirror_slope**2 - nearer**2) / mean_square_slope
    loss = ((np.abs(mirror_slope) + shift) ** 2 - mirror_slope**2) / mean_square_slope
    return np.asarray(np.maximum(np.expm1(gain), -np.expm1(-loss)), dtype=np.float64)


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
