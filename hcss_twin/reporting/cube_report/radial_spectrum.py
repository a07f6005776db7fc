"""Power spectrum of an image, averaged over directions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_LEAST_PIXELS = 8


@dataclass(frozen=True)
class Spectrum:
    """Power against wavenumber.

    Attributes
    ----------
    cycles_per_km : ndarray (K,)
        Mean wavenumber of each ring.
    power : ndarray (K,)
        Mean power density in the ring, units of the image squared times km squared: its integral over the plane of
        wavenumbers is the variance of the tapered image.
    """

    cycles_per_km: Array
    power: Array


def radial_spectrum(image: NDArray[Any], pixel_size_m: float) -> Spectrum | None:
    """Return the power spectrum of an image (y, x) without its mean, tapered by Hann windows along both axes.

    Rings are one wavenumber of the shorter side wide and end at half a cycle per pixel, the highest wavenumber that
    exists in all directions. The taper is scaled to keep the variance of noise (Welch 1967, IEEE Trans. Audio
    Electroacoust. 15, 70-73).

    Returns
    -------
    Spectrum or None
        None where the image has fewer than 8 pixels along a side, values that do not exist, or only one value.
    """
    rows, columns = image.shape
    values = image.astype(np.float64)
    if min(rows, columns) < _LEAST_PIXELS or not np.isfinite(values).all() or np.ptp(values) == 0.0:
        return None
    taper = np.outer(*(0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(n) + 0.5) / n) for n in (rows, columns)))
    tapered = (values - values.mean()) * taper
    cell_km2 = (pixel_size_m / 1e3) ** 2
    density = np.abs(np.fft.fft2(tapered)) ** 2 * cell_km2 / np.sum(taper**2)
    radius = np.hypot(np.fft.fftfreq(rows)[:, None], np.fft.fftfreq(columns)[None, :])  # cycles per pixel
    ring = np.rint(radius * min(rows, columns)).astype(int)
    inside = (ring > 0) & (radius <= 0.5)
    count = np.bincount(ring[inside])[1:]
    mean = [np.bincount(ring[inside], each[inside])[1:] / count for each in (radius, density)]
    return Spectrum(mean[0] / (pixel_size_m / 1e3), mean[1])


def mean_spectrum(images: Iterable[NDArray[Any]], pixel_size_m: float) -> Spectrum | None:
    """Return the mean of the spectra of images of one shape; those that have none do not count."""
    found = [each for image in images if (each := radial_spectrum(image, pixel_size_m)) is not None]
    if not found:
        return None
    return Spectrum(found[0].cycles_per_km, np.mean([each.power for each in found], axis=0))
