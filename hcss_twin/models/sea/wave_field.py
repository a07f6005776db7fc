"""Resolved waves of an image, longer than two pixels: slopes for a moving platform, and bounds on their effect.

The field is a sum of plane waves of random phase. It is unbounded, so that all windows of all frames show the same sea,
and has no visible period (the wavelengths have no common multiple). The rest of Cox and Munk's mean-square slope is
subpixel.

A resolved wave tilts all facets in a pixel by its slope. A Gaussian sea is within three standard deviations (an
ellipse) in 98.9 % of the pixels. Radiance tables end at four standard deviations along either axis (a rectangle), where
steeper waves are clipped: bounds over that rectangle hold for any pixel.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.sea import pierson_moskowitz
from hcss_twin.models.sea.plane_waves import PlaneWaveSums
from hcss_twin.models.sea.wave_spectrum import WaveSpectrum
from hcss_twin.providers import Grid, Motion


class WaveField:
    """One realisation of the resolved sea.

    Parameters
    ----------
    spectrum : WaveSpectrum
        Elevation spectrum at the wind speed.
    wind_from_deg : float
        Bearing that the wind comes from; wave directions have the density 2/pi cos^2 about downwind.
    pixel_size_m : float
        Size of a pixel, above 0; waves of at least twice this length are resolved.
    seed : int
        Selects the realisation.
    x_bearing_deg, y_bearing_deg : float
        Bearings of increasing columns and rows, clockwise from north.
    components : int
        Number of waves, all with the same mean-square slope.

    Attributes
    ----------
    pixel_size_m : float
        Size of a pixel.
    cutoff_rad_s : float
        Frequency of the shortest wave.
    resolved_mean_square_slope : float
        Sum of the mean-square slopes of the waves.
    frequency_rad_s, phase_rad : ndarray (W,)
        Of each wave; the phase is that of its elevation's cosine at time 0 in the corner of pixel 0, 0.
    k_x_rad_m, k_y_rad_m : ndarray (W,)
        Wave vectors along columns and along rows.

    Raises
    ------
    ValueError
        If the pixel size is not above 0 or there are no components.
    """

    def __init__(
        self,
        spectrum: WaveSpectrum,
        wind_from_deg: float,
        pixel_size_m: float,
        seed: int,
        x_bearing_deg: float = 90.0,
        y_bearing_deg: float = 0.0,
        components: int = 512,
    ) -> None:
        if components < 1:
            raise ValueError(f"components {components}: allowed at least 1")
        self.pixel_size_m = float(pixel_size_m)
        self.cutoff_rad_s = cutoff_frequency_rad_s(pixel_size_m)
        self.resolved_mean_square_slope = spectrum.resolved_mean_square_slope(self.cutoff_rad_s)
        if self.resolved_mean_square_slope == 0.0:
            components = 0
            self.frequency_rad_s = np.zeros(0)
        else:
            self.frequency_rad_s = spectrum.slope_frequencies_rad_s(components, self.cutoff_rad_s)
        random = np.random.default_rng(seed)
        self.phase_rad = 2.0 * np.pi * random.random(components)
        # One direction from each of equally likely sectors, so that the split between along-wind and crosswind slope
        # follows the law for every seed, not only on average.
        share = (random.permutation(components) + random.random(components)) / max(components, 1)
        bearing = np.radians(wind_from_deg + 180.0) + _scatter(share)
        wavenumber = self.frequency_rad_s**2 / pierson_moskowitz.GRAVITY_M_S2
        self.k_x_rad_m = wavenumber * np.cos(bearing - np.radians(x_bearing_deg))
        self.k_y_rad_m = wavenumber * np.cos(bearing - np.radians(y_bearing_deg))
        self._slope = math.sqrt(2.0 * self.resolved_mean_square_slope / max(components, 1))
        self._wavenumber = wavenumber

    def slopes(self, time_s: float, rows: slice, columns: slice, x_m: float = 0.0) -> NDArray[np.float32]:
        """Return the slopes (2, y, x) along columns and along rows at the pixel centres of a window.

        Parameters
        ----------
        time_s : float
            Time; each wave travels with the frequency sqrt(g k) of deep water.
        rows, columns : slice
            Window with a start and a stop; any integers, because the field is unbounded.
        x_m : float
            Position of column 0, for a moving window.
        """
        # Pixel centres; the derivative of a wave of elevation a cos(p) is -a k sin(p).
        centre = 0.5 * self.pixel_size_m
        phase = (
            self.phase_rad - self.frequency_rad_s * time_s + self.k_x_rad_m * (x_m + centre) + self.k_y_rad_m * centre
        )
        return self._sums.at(phase, rows, columns)

    @cached_property
    def _sums(self) -> PlaneWaveSums:
        amplitudes = -self._slope * np.stack((self.k_x_rad_m, self.k_y_rad_m)) / self._wavenumber
        return PlaneWaveSums(self.k_x_rad_m * self.pixel_size_m, self.k_y_rad_m * self.pixel_size_m, amplitudes)

    def elevation_m(self, time_s: float, rows: slice, columns: slice) -> Array:
        """Return the elevation (y, x) of the resolved waves, in metres; see :meth:`slopes`."""
        y, x = (np.arange(part.start, part.stop) + 0.5 for part in (rows, columns))
        down = np.exp(
            1j * (np.outer(y * self.pixel_size_m, self.k_y_rad_m) + self.phase_rad - self.frequency_rad_s * time_s)
        )
        along = np.exp(1j * np.outer(self.k_x_rad_m, x * self.pixel_size_m))
        height: Array = ((down * (self._slope / self._wavenumber)) @ along).real
        return height


def _scatter(share: Array) -> Array:
    """Return the quantiles (angles) of the distribution with density 2/pi cos^2."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2001)
    return np.asarray(np.interp(share, 0.5 + (angle + 0.5 * np.sin(2.0 * angle)) / np.pi, angle))


def cutoff_frequency_rad_s(pixel_size_m: float) -> float:
    """Return the frequency of the wave that is two pixels long, sqrt(pi g / pixel).

    Raises
    ------
    ValueError
        If the pixel size is not above 0 or not finite.
    """
    if not (math.isfinite(pixel_size_m) and pixel_size_m > 0.0):
        raise ValueError(f"pixel_size_m {pixel_size_m}: allowed finite, above 0")
    return math.sqrt(math.pi * pierson_moskowitz.GRAVITY_M_S2 / pixel_size_m)


EAST_DEG, NORTH_DEG = 90.0, 0.0


class ResolvedWaves:
    """Slopes of waves longer than two pixels.

    Parameters
    ----------
    spectrum : WaveSpectrum
        Of elevation.
    wind_from_deg : float
        Bearing the wind comes from.
    grid : Grid
        The image; x points east, y north.
    motion : Motion
        The image moves along x with the platform's speed; waves travel by themselves.
    seed : int
        Selects the realisation.
    """

    def __init__(self, spectrum: WaveSpectrum, wind_from_deg: float, grid: Grid, motion: Motion, seed: int) -> None:
        self._field = WaveField(
            spectrum, wind_from_deg, grid.pixel_size_m, seed, x_bearing_deg=EAST_DEG, y_bearing_deg=NORTH_DEG
        )
        self._speed_m_s = motion.platform_speed_m_s

    def slopes(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return slopes (2, y, x) along x and along y at the pixel centres of a window.

        A pixel's value does not depend on the window.

        Parameters
        ----------
        time_s : float
            Seconds after the scenario's start.
        rows, columns : slice
            Window with a start and a stop.
        """
        x_m = self._speed_m_s * time_s
        return self._field.slopes(time_s, rows, columns, x_m)


SIGMAS = 3.0
"""Standard deviations of the tilts of most pixels."""

MOST = "98.9 % of the clear pixels"
"""Share of tilts within ``SIGMAS``: 1 - exp(-SIGMAS^2 / 2), for two independent Gaussian slopes."""

MOST_SIGMAS = 4.0
"""Table limit in standard deviations along either axis; steeper waves, 1.3e-4 of all, are clipped to the limit."""

_STEEPEST_VIEW = np.radians(89.9)


class _Emitter(Protocol):
    def emissivity(self, wavenumber_cm1: Array, mu: Array) -> Array: ...


def thermal_contrast_bound(
    sea: _Emitter, wavenumber_cm1: Array, mu: Array, slope: float, sky_share: float = 0.0, sigmas: float = SIGMAS
) -> Array:
    """Return the greatest relative change (M, V) of emitted and reflected thermal radiance.

    The bound is |change of emissivity| (1 - sky_share) / emissivity for the worse tilt direction. The emissivity at a
    tilted view represents that of tilted facets; views tilted below the horizon are set to 89.9 degrees.

    Parameters
    ----------
    sea : sea model
    wavenumber_cm1 : ndarray (V,)
    mu : ndarray (M,)
        Cosines of the view zenith angle.
    slope : float
        Standard deviation of the resolved slope.
    sky_share : float
        Sky radiance relative to that of a black sea; 0 gives the greatest contrast.
    sigmas : float
        Largest tilt, in standard deviations.
    """
    level = sea.emissivity(wavenumber_cm1, mu)
    zenith, tilt = np.arccos(mu), float(np.arctan(sigmas * slope))
    greatest = np.zeros_like(level)
    for sign in (-1.0, 1.0):
        view = np.minimum(np.abs(zenith + sign * tilt), _STEEPEST_VIEW)
        greatest = np.maximum(greatest, np.abs(sea.emissivity(wavenumber_cm1, np.cos(view)) - level))
    change, whole = greatest * (1.0 - sky_share), level + (1.0 - level) * sky_share
    # Without emission (foam of emissivity 0) the relative change is 0 or infinite.
    black = np.where(change > 0.0, np.inf, 0.0)
    return np.asarray(np.divide(change, whole, out=black, where=whole > 0.0), dtype=np.float64)


def tilted_glint_bound(
    mirror_slope: tuple[float, float],
    mean_square_slope: float,
    rms: tuple[float, float],
    view: tuple[float, float],
    any_pixel: bool = False,
) -> float:
    """Return the greatest change of the glint over tilted parts, relative to the glint of the sea as a whole.

    Parameters
    ----------
    mirror_slope : (float, float)
        Slope, upwind and crosswind, of the facets that reflect the sun into the sensor.
    mean_square_slope : float
        Of the whole sea, taken as isotropic.
    rms : (float, float)
        Standard deviations of the resolved slope, upwind and crosswind; at least a tenth of the total variance is
        assumed to be subpixel.
    view : (float, float)
        Horizontal components, upwind and crosswind, of the direction toward the sensor.
    any_pixel : bool
        Whether to cover the rectangle of the tables, ``MOST_SIGMAS`` along either axis, rather than the ellipse of
        ``SIGMAS``.

    Notes
    -----
    Subpixel Gaussian density at the specular slope, divided by the projected area of the part (at least a tenth).
    """
    if any_pixel:
        upwind, crosswind = np.meshgrid(*(sigma * np.linspace(-MOST_SIGMAS, MOST_SIGMAS, 65) for sigma in rms))
    else:
        radius, angle = np.meshgrid(np.linspace(0.0, SIGMAS, 25), np.linspace(0.0, 2.0 * np.pi, 97))
        upwind, crosswind = radius * np.cos(angle) * rms[0], radius * np.sin(angle) * rms[1]
    half = 0.5 * mean_square_slope
    left = [max(half - sigma**2, 0.1 * half) for sigma in rms]
    away = (mirror_slope[0] - upwind) ** 2 / left[0] + (mirror_slope[1] - crosswind) ** 2 / left[1]
    whole = (mirror_slope[0] ** 2 + mirror_slope[1] ** 2) / half
    # Far from the glint, where the glint itself is 0, the ratio overflows: e^300 is effectively infinite.
    density = half / math.sqrt(left[0] * left[1]) * np.exp(np.minimum(0.5 * (whole - away), 300.0))
    sine = math.hypot(*view)
    area = 1.0 - (upwind * view[0] + crosswind * view[1]) / math.sqrt((1.0 - sine) * (1.0 + sine))
    return float(np.max(np.abs(density / np.maximum(area, 0.1) - 1.0)))
