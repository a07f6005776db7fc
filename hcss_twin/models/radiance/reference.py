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
    result: Array = np.sum(reference_terms(model, grid, thickness_m, sun, together), axis=1)
    return result


def reference_terms(
    model: RadianceModel, grid: SpectralGrid, thickness_m: Sequence[float] | Array, sun: Sun | None, together: int = 1
) -> Array:
    """Return the terms (N, K, B) of the band radiance of single pixels, in the order of ``model.terms``.

    Parameters
    ----------
    model, grid, thickness_m, sun, together
        As for :func:`reference_radiance`.
    """
    thickness = np.asarray(thickness_m, dtype=np.float64)
    columns = thickness[:, None] if thickness.ndim == 1 else thickness
    result = np.empty((columns.shape[0], len(model.terms), len(grid.nodes)))
    cloudy = np.flatnonzero(np.any(columns > 0, axis=1))
    clear = np.setdiff1d(np.arange(columns.shape[0]), cloudy)
    if clear.size:
        result[clear] = _bands(model, grid, model.clear(grid.wavenumber_cm1, sun))
    for start in range(0, cloudy.size, together):
        pixels = cloudy[start : start + together]
        result[pixels] = _bands(model, grid, model.cloudy(grid.wavenumber_cm1, columns[pixels], sun))
    return result


def _bands(model: RadianceModel, grid: SpectralGrid, terms: Mapping[str, Array]) -> Array:
    """Integrate terms (..., V) over the bands, (..., K, B)."""
    spectra = np.stack([np.asarray(terms[name]) for name in model.terms], axis=-2)
    result: Array = spectra @ grid.weights_cm1.T
    return result
