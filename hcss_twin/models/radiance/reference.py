"""Reference band radiances of single pixels from dense spectra, without tables or interpolation.

It is slow and simple; all faster code is tested against it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.providers import RadianceModel, Sun


def reference_radiance(
    model: RadianceModel, grid: SpectralGrid, thickness_m: Sequence[float] | Array, sun: Sun | None, together: int = 1
) -> Array:
    """Return the band radiance of single pixels.

    Parameters
    ----------
    thickness_m : sequence of float (N,) or array (N, L)
        Cloud thickness of each pixel, 0 for clear sky, with one column per layer; (N,) is short for a single layer.
    sun : Sun or None
        Position of the sun at the time of the pixel.
    together : int
        Number of cloudy columns that the model computes together, which is faster.

    Returns
    -------
    ndarray (N, B)
        W m-2 sr-1.
    """
    thickness = np.asarray(thickness_m, dtype=np.float64)
    columns = thickness[:, None] if thickness.ndim == 1 else thickness
    spectra = reference_spectra(model, grid.wavenumber_cm1, columns, sun, together)
    result: Array = np.sum(spectra, axis=1) @ grid.weights_cm1.T
    return result


def reference_spectra(
    model: RadianceModel, wavenumber_cm1: Array, thickness_m: Array, sun: Sun | None, together: int = 1
) -> Array:
    """Return the terms (N, K, V) of columns (N, L) at wavenumbers (V,), in the order of ``model.terms``.

    Parameters
    ----------
    model, sun, together
        As for :func:`reference_radiance`.
    """
    result = np.empty((thickness_m.shape[0], len(model.terms), wavenumber_cm1.size))
    if not wavenumber_cm1.size:  # a finer grid of narrow bands may have no new ones
        return result
    cloudy = np.flatnonzero(np.any(thickness_m > 0, axis=1))
    clear = np.setdiff1d(np.arange(thickness_m.shape[0]), cloudy)
    if clear.size:
        result[clear] = _stacked(model, model.clear(wavenumber_cm1, sun))
    for start in range(0, cloudy.size, together):
        pixels = cloudy[start : start + together]
        result[pixels] = _stacked(model, model.cloudy(wavenumber_cm1, thickness_m[pixels], sun))
    return result


def _stacked(model: RadianceModel, terms: Mapping[str, Array]) -> Array:
    """Stack terms (..., V) to (..., K, V)."""
    return np.stack([np.asarray(terms[name]) for name in model.terms], axis=-2)
