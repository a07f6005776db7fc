"""Power spectrum of an image by wavenumber and by direction, and the distance of two spectra."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.measures.images import checked_image
from hcss_twin.providers import Array
from hcss_twin.reports.power_spectrum import Rings

SECTORS = 12
"""Sectors of wave direction, 15 degrees each over 180 degrees, because opposite waves are equivalent."""

# The taper smears wavenumbers below three cycles per image, and a ring with few waves has no defined direction.
_FEWEST_WAVES = 3.0
_FEWEST_IN_RING = 24

DEPENDENT_WAVES = (35.0 / 18.0) ** 2
"""Waves per independent one: the taper correlates neighbours, 35/18 along each axis."""


@dataclass(frozen=True)
class PowerSpectrum:
    """Power spectral density of an image.

    Attributes
    ----------
    wavenumber : ndarray (R,)
        Mean wavenumber of each ring, cycles per pixel, ascending, below .5.
    power : ndarray (R,)
        Mean density in each ring, squared unit of the image per (cycle per pixel)^2; its integral over the wavenumber
        plane is the variance, and for white noise it equals the variance.
    waves : ndarray (R,)
        Number of waves in each ring.
    direction_deg : ndarray (SECTORS,)
        Centre of each sector: direction of the wave vector, from x (east) toward y (north), 0 to 180.
    by_direction : ndarray (SECTORS,)
        Power of each sector relative to the mean over directions at the same wavenumber, averaged over rings; 1 for
        isotropy.
    degree : float
        Strength a of the anisotropy in power proportional to 1 + a cos 2 (direction - d): 0 for isotropy; 1 and more if
        nearly all wave vectors lie along d.
    degree_noise : float
        Root mean square of ``degree`` for isotropic Gaussian images of this size.
    long_axis_deg : float
        Direction of elongation, d + 90, 0 to 180; meaningful only if ``degree`` is well above ``degree_noise``.
    """

    wavenumber: Array
    power: Array
    waves: Array
    direction_deg: Array
    by_direction: Array
    degree: float
    degree_noise: float
    long_axis_deg: float


def power_spectrum(image: NDArray[Any]) -> PowerSpectrum:
    """Compute the power spectrum of an image by rings (:class:`hcss_twin.reports.power_spectrum.Rings`) and directions.

    For directions, the power of each wave is divided by the mean of its ring, and all rings have equal weight, so that
    large scales do not dominate. Raises ImageError if the image is too small, constant, a plane, or not finite.
    """
    rings = Rings.of(checked_image("image", image))
    full = rings.waves > 0
    smallest_side = min(np.shape(image))
    oriented = full & (rings.wavenumber >= _FEWEST_WAVES / smallest_side) & (rings.waves >= _FEWEST_IN_RING)
    by_direction, cosine, sine = _directions(rings, oriented)
    count = max(1, int(np.count_nonzero(oriented)))
    noise = 2.0 * math.sqrt(float(np.sum(DEPENDENT_WAVES / rings.waves[oriented]))) / count
    return PowerSpectrum(
        wavenumber=rings.wavenumber[full],
        power=rings.power[full],
        waves=rings.waves[full],
        direction_deg=np.arange(SECTORS) * 180.0 / SECTORS,
        by_direction=by_direction,
        degree=2.0 * math.hypot(cosine, sine),
        degree_noise=noise,
        long_axis_deg=(math.degrees(0.5 * math.atan2(sine, cosine)) + 90.0) % 180.0,
    )


def _directions(rings: Rings, oriented: NDArray[np.bool_]) -> tuple[Array, float, float]:
    """Return relative power by sector (SECTORS,), and its means weighted with cos and sin of twice the direction."""
    oriented = oriented & (rings.power > 0.0)
    if not oriented.any():
        return np.full(SECTORS, np.nan), math.nan, math.nan
    chosen = oriented[rings.ring]
    ring, angle = rings.ring[chosen], rings.angle[chosen]
    relative = rings.wave_power[chosen] / rings.power[ring]
    sector = np.rint(np.mod(angle, np.pi) * SECTORS / np.pi).astype(np.int64) % SECTORS
    cell = ring * SECTORS + sector
    size = oriented.size * SECTORS
    count = np.bincount(cell, minlength=size).reshape(-1, SECTORS)[oriented]
    total = np.bincount(cell, relative, size).reshape(-1, SECTORS)[oriented]
    filled = count > 0
    means = np.divide(total, count, out=np.zeros_like(total), where=filled)
    by_direction: Array = means.sum(axis=0) / np.maximum(filled.sum(axis=0), 1)
    # Subtract the mean over the available waves, because the pixel grid has preferred directions of its own.
    moments = []
    for wave in (np.cos(2.0 * angle), np.sin(2.0 * angle)):
        moment = np.bincount(ring, (relative - 1.0) * wave, oriented.size)[oriented] / rings.waves[oriented]
        moments.append(float(np.mean(moment)))
    return by_direction, moments[0], moments[1]


def mean_spectrum(spectra: Sequence[PowerSpectrum]) -> PowerSpectrum | None:
    """Return the mean spectrum of images of one size; None if there are none or their rings differ.

    Anisotropies are averaged as vectors of twice the direction, so that random directions cancel.
    """
    if not spectra or any(spectrum.wavenumber.size != spectra[0].wavenumber.size for spectrum in spectra):
        return None
    waves = np.mean([spectrum.waves for spectrum in spectra], axis=0)
    if not np.array_equal(waves, spectra[0].waves):
        return None
    twice = [np.radians(2.0 * (spectrum.long_axis_deg - 90.0)) for spectrum in spectra]
    vector = complex(
        np.mean([spectrum.degree * np.exp(1j * angle) for spectrum, angle in zip(spectra, twice, strict=True)])
    )
    return PowerSpectrum(
        wavenumber=spectra[0].wavenumber,
        power=np.mean([spectrum.power for spectrum in spectra], axis=0),
        waves=waves,
        direction_deg=spectra[0].direction_deg,
        by_direction=np.mean([spectrum.by_direction for spectrum in spectra], axis=0),
        degree=abs(vector),
        degree_noise=spectra[0].degree_noise,
        long_axis_deg=(math.degrees(0.5 * math.atan2(vector.imag, vector.real)) + 90.0) % 180.0,
    )


def spectral_distance_db(first: PowerSpectrum | None, second: PowerSpectrum | None) -> float:
    """Return the root mean square difference of two spectra in decibels over their common rings.

    Rings, four per octave, have equal weight. 10 dB is a factor of ten in power. NaN if a spectrum or a common ring is
    missing, or a ring has no power.
    """
    if first is None or second is None:
        return math.nan
    low = max(first.wavenumber[0], second.wavenumber[0])
    at = first.wavenumber[first.wavenumber >= low * (1.0 - 1e-9)]
    if at.size == 0 or first.power.min() <= 0.0 or second.power.min() <= 0.0:
        return math.nan
    log_power = np.interp(np.log(at), np.log(first.wavenumber), np.log10(first.power))
    other = np.interp(np.log(at), np.log(second.wavenumber), np.log10(second.power))
    return 10.0 * math.sqrt(float(np.mean((log_power - other) ** 2)))
