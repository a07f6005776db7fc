"""Power spectra of patches: how variance is shared among scales and directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fftfreq, rfft2, rfftfreq

from hcss_twin.providers import Array
from hcss_twin.reports.power_spectrum import Rings

_RINGS_PER_OCTAVE = 2
_LONGEST = 2.0
"""Waves per patch of the longest ring: the window smears longer ones."""


def _rings(size: int) -> tuple[NDArray[np.intp], Array, Array]:
    """Return ring (-1: none), wavenumber in cycles per pixel and direction of the waves (size, size // 2 + 1)."""
    along_y, along_x = np.broadcast_arrays(fftfreq(size)[:, None], rfftfreq(size)[None, :])
    wavenumber = np.hypot(along_y, along_x)
    with np.errstate(divide="ignore"):
        ring = np.floor(_RINGS_PER_OCTAVE * np.log2(wavenumber * size / _LONGEST) + 1e-9)
    # Waves along y are stored together with their opposites; only one of each pair counts.
    counted = (ring >= 0) & (wavenumber < 0.5) & ((along_x > 0.0) | (along_y > 0.0))
    return np.where(counted, ring, -1).astype(np.intp), wavenumber, np.arctan2(along_y, along_x)


def power_by_ring(patches: Array) -> tuple[Array, Array, Array]:
    """Return the power spectral density of square patches (P, n, n) by ring of wavenumber.

    Each patch loses its mean and gets a Hann window. There are two rings per octave, from two waves per patch to .5
    cycles per pixel.

    Returns
    -------
    wavenumber : ndarray (R,)
        Geometric mean wavenumber of each ring, cycles per pixel.
    density : ndarray (P, R)
        Squared unit of the patches per (cycle per pixel)^2; white noise has its variance in every ring.
    anisotropy : ndarray (P,)
        Strength a of density proportional to 1 + a cos 2 (direction - d), the mean over rings: 0 for isotropy.
    """
    size = patches.shape[-1]
    window = Rings.hann(size)[:, None] * Rings.hann(size)
    deviation = patches - patches.mean(axis=(1, 2), keepdims=True)
    power = (np.abs(rfft2(deviation * window)) ** 2 / np.sum(window**2)).reshape(len(patches), -1)
    ring, wavenumber, direction = (values.ravel() for values in _rings(size))
    member = ring == np.arange(ring.max() + 1)[:, None]
    density = power @ (member / member.sum(axis=1, keepdims=True)).T
    turn = power @ (member * np.exp(2j * direction)).T / (power @ member.T)
    middle = np.array([np.exp(np.mean(np.log(wavenumber[in_ring]))) for in_ring in member])
    return middle, density, 2.0 * np.abs(turn.mean(axis=1))


def spectral_features(patches: Array) -> dict[str, Array]:
    """Return slope and curvature of the spectrum in log-log axes, the share of each octave, and anisotropy.

    The slope is the exponent of density against wavenumber (-3 for k^-3), the curvature its change per octave.
    """
    wavenumber, density, anisotropy = power_by_ring(patches)
    octaves = np.log2(wavenumber) - np.log2(wavenumber).mean()
    curvature, slope, _ = np.polyfit(octaves, np.log2(density).T, 2)
    variance = density * wavenumber**2
    share = variance / variance.sum(axis=1, keepdims=True)
    found = {"spectral slope": slope, "spectral curvature": 2.0 * curvature, "anisotropy": anisotropy}
    for first in range(0, len(wavenumber), _RINGS_PER_OCTAVE):
        rings = slice(first, first + _RINGS_PER_OCTAVE)
        length = 1.0 / np.sqrt(wavenumber[rings][0] * wavenumber[rings][-1])
        found[f"share of variance at {length:.0f} px"] = share[:, rings].sum(axis=1)
    return found
