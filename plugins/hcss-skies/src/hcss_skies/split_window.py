"""Height of thin clouds from two channels near 10.8 and 12.0 um: the split window.

Ice and water absorb more at 12.0 um than at 10.8 um. A thin cloud lets less of the warm sea through there and is
colder; an opaque one has the same brightness temperature in both (T. Inoue, "On the temperature and effective
emissivity determination of semi-transparent cirrus clouds by bi-spectral measurements in the 10 um window region", J.
Meteorol. Soc. Japan 63, 88-99, 1985).
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter, maximum_filter

from hcss_twin.providers import Array, planck

WAVELENGTHS_UM = 10.8, 12.0

DEPTH_RATIO = 1.1
"""Optical thickness at 12.0 um per optical thickness at 10.8 um; 1.08 for large crystals, 1.2 for small ones."""

_HIGHEST_M, _HEIGHTS = 12_000.0, 49

_NOISE_K = 0.3
"""Of the difference of the two channels, and of the clear sky between cells of warm water."""

_SPREAD_M = 3000.0
"""Of heights around those of the coldest clouds nearby, where the two channels do not tell."""

_ENVELOPE_PIXELS, _SMOOTH_PIXELS = 4, 2.0
_COLDEST_K = 185.0


def height_above_opaque_m(first_K: Array, second_K: Array, clear_K: float, lapse_K_m: float) -> Array:
    """Return how far cloud tops are above an opaque cloud with the same brightness temperature at 10.8 um.

    The mean over heights of 0 to 12 km, weighted by how well they explain the second channel and by how close they are
    to those of the coldest clouds nearby; smoothed.

    Parameters
    ----------
    first_K, second_K : ndarray (rows, columns)
        Brightness temperature at 10.8 and 12.0 um.
    clear_K : float
        Of the clear sky at 10.8 um.
    lapse_K_m : float
        Lapse rate of the air.
    """
    one, two = (1e4 / wavelength_um for wavelength_um in WAVELENGTHS_UM)
    clear = first_K > clear_K - 1.0
    second_clear = float(np.median(second_K[clear])) if clear.any() else clear_K
    sea, second_sea = _black(one, clear_K), _black(two, second_clear)
    first, second = _black(one, first_K), _black(two, second_K)
    kelvin_at_sea = second_sea - _black(two, second_clear - 1.0)
    opaque_m = (clear_K - first_K) / lapse_K_m
    envelope = gaussian_filter(maximum_filter(opaque_m, 2 * _ENVELOPE_PIXELS + 1), _ENVELOPE_PIXELS)
    nearby = np.maximum(envelope - opaque_m, 0.0)
    heights = np.linspace(0.0, _HIGHEST_M, _HEIGHTS)
    misfit = np.empty((heights.size, *first_K.shape))
    for number, height in enumerate(heights):
        cloud_K = np.maximum(first_K - lapse_K_m * height, np.minimum(_COLDEST_K, first_K))
        cloud = _black(one, cloud_K)
        through = np.clip((first - cloud) / np.maximum(sea - cloud, 1e-9 * sea), 0.0, 1.0) ** DEPTH_RATIO
        expected = (1.0 - through) * _black(two, cloud_K) + through * second_sea
        misfit[number] = ((expected - second) / (_NOISE_K * kelvin_at_sea)) ** 2 + ((height - nearby) / _SPREAD_M) ** 2
    weight = np.exp(-0.5 * (misfit - misfit.min(axis=0)))
    mean = np.einsum("n,nij->ij", heights, weight) / weight.sum(axis=0)
    smooth: Array = gaussian_filter(mean, _SMOOTH_PIXELS)
    return smooth


def _black(wavenumber_cm1: float, kelvin: Array | float) -> Array:
    return planck(np.asarray(wavenumber_cm1), kelvin)
