"""Power spectrum of an image by wavenumber, and the waves of which it is made."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fftfreq, rfft2, rfftfreq

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ImageError

__all__ = ["Rings"]


def without_plane(surface: Array) -> Array:
    """Subtract the least-squares plane (rows, columns); on a full grid its terms are orthogonal."""
    rows, columns = surface.shape
    y = np.arange(rows) - (rows - 1) / 2.0
    x = np.arange(columns) - (columns - 1) / 2.0
    slope_y = float(surface.sum(axis=1) @ y) / (columns * float(y @ y))
    slope_x = float(surface.sum(axis=0) @ x) / (rows * float(x @ x))
    result: Array = surface - surface.mean() - slope_y * y[:, None] - slope_x * x
    return result


RINGS_PER_OCTAVE = 4

_HIGHEST = 0.5


@dataclass(frozen=True)
class Rings:
    """Waves of an image in rings of wavenumber, four per octave up to the Nyquist wavenumber of the axes.

    Attributes
    ----------
    wavenumber : ndarray (R,)
        Mean wavenumber of each ring, cycles per pixel, ascending, below .5; NaN in a ring without waves.
    power : ndarray (R,)
        Mean density in each ring, squared unit of the image per (cycle per pixel)^2; its integral over the wavenumber
        plane is the variance, and for white noise it equals the variance.
    waves : ndarray (R,)
        Number of waves in each ring.
    ring, wave_power, angle : ndarray (N,)
        Ring, power density, and direction from x toward y in radians of each wave.
    """

    wavenumber: Array
    power: Array
    waves: Array
    ring: NDArray[np.int64]
    wave_power: Array
    angle: Array

    @classmethod
    def of(cls, image: NDArray[Any]) -> Rings:
        """Measure an image (rows, columns) of numbers in any unit; x runs along columns, y along rows.

        The least-squares plane is subtracted from the image and a Hann window applied along each axis. Raises
        ImageError if the image is constant, a plane, or not finite.
        """
        density, along_y, along_x = Rings.power_density(image)
        wavenumber = np.hypot(along_y, along_x)
        # Waves along y are stored together with their opposites; only one of each pair is used.
        counted = (along_x > 0.0) | (along_y > 0.0)
        inside = np.flatnonzero((counted & (wavenumber < _HIGHEST)).ravel())
        k, power = wavenumber.ravel()[inside], density.ravel()[inside]
        angle = np.arctan2(np.broadcast_to(along_y, density.shape), along_x).ravel()[inside]
        rings = math.ceil(RINGS_PER_OCTAVE * math.log2(_HIGHEST / (1.0 / max(image.shape))))
        # Rings are counted from the Nyquist wavenumber, so that images of different sizes share them.
        ring = rings - 1 - np.floor(RINGS_PER_OCTAVE * np.log2(_HIGHEST / k)).astype(np.int64)
        ring = np.maximum(ring, 0)
        waves = np.bincount(ring, minlength=rings).astype(np.float64)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean_power = np.bincount(ring, power, rings) / waves
            mean_k = np.bincount(ring, k, rings) / waves
        return cls(mean_k, mean_power, waves, ring, power, angle)

    @staticmethod
    def hann(size: int) -> Array:
        """Return a Hann window (size,) without its end zeros, so that the outer pixels contribute."""
        window: Array = np.sin(np.pi * np.arange(1, size + 1) / (size + 1)) ** 2
        return window

    @staticmethod
    def finite_range(name: str, image: NDArray[Any]) -> tuple[NDArray[Any], float, float]:
        """Return the image with its minimum and maximum.

        Values whose differences would overflow or underflow in double precision are scaled by a power of two, which is
        exact.

        Raises ImageError if a pixel is not finite or all are equal.
        """
        low, high = float(image.min()), float(image.max())
        if not (math.isfinite(low) and math.isfinite(high)):
            raise ImageError(f"{name}: a pixel is not finite, allowed: finite numbers")
        if low == high:
            raise ImageError(f"{name}: all pixels are {low:g}, allowed: values that vary")
        if max(abs(low), abs(high)) > 1e150 or high - low < 1e-150:
            exponent = -math.frexp(max(abs(low), abs(high)))[1]
            image = np.ldexp(image.astype(np.float64), exponent)
            low, high = float(image.min()), float(image.max())
        return image, low, high

    @staticmethod
    def windowed_power(image: NDArray[Any]) -> tuple[Array, float]:
        """Return the power (rows, columns // 2 + 1) of a detrended image under a Hann window, and the image's range.

        The power refers to the image divided by its range. Raises ImageError if the image is constant, a plane, or not
        finite.
        """
        pixels, least, greatest = Rings.finite_range("image", image)
        span = greatest - least
        surface = without_plane((pixels.astype(np.float64) - least) / span)
        if np.abs(surface).max() < 1e-9:
            raise ImageError("image: the values form a plane, allowed: values that deviate from a plane")
        rows, columns = surface.shape
        surface *= Rings.hann(rows)[:, None] * Rings.hann(columns)
        return np.abs(rfft2(surface, overwrite_x=True)) ** 2, span

    @staticmethod
    def power_density(image: NDArray[Any]) -> tuple[Array, Array, Array]:
        """Return the power density (rows, columns // 2 + 1) of :meth:`windowed_power` in the image's unit squared.

        The others are the wavenumbers along y (rows, 1) and x (1, columns // 2 + 1), in cycles per pixel.
        """
        power, span = Rings.windowed_power(image)
        rows, columns = image.shape
        window_y, window_x = Rings.hann(rows), Rings.hann(columns)
        power *= span**2 / (float(window_y @ window_y) * float(window_x @ window_x))
        return power, fftfreq(rows)[:, None], rfftfreq(columns)[None, :]
