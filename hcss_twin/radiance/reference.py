"""The reference path: dense spectrum, no tables, nothing skipped, one pixel at a time.

Slow and plainly right. Everything fast is tested against it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import trapezoid

from hcss_twin.providers import RadianceModel, Sun
from hcss_twin.radiance.spectral_grid import SpectralGrid

Array = NDArray[np.float64]


def reference_radiance(
    model: RadianceModel, grid: SpectralGrid, thickness_m: Sequence[float] | Array, sun: Sun | None
) -> Array:
    """Band radiance of single pixels.

    Parameters
    ----------
    thickness_m : sequence of float (N,) or array (N, L)
        Cloud thickness of each pixel, 0 for clear sky; with one column per layer of the scene. (N,) is short for a
        single layer.
    sun : Sun or None
        Where the sun is at that pixel's time.

    Returns
    -------
    ndarray (N, B)
        W m-2 sr-1.
    """
    thickness = np.asarray(thickness_m, dtype=np.float64)
    columns = thickness[:, None] if thickness.ndim == 1 else thickness
    result = np.empty((columns.shape[0], len(grid.nodes)))
    for pixel, column in enumerate(columns):
        if np.any(column > 0):
            terms = model.cloudy(grid.wavenumber_cm1, column[None, :], sun)
            spectrum = sum(np.asarray(term)[0] for term in terms.values())
        else:
            terms = model.clear(grid.wavenumber_cm1, sun)
            spectrum = sum(np.asarray(term) for term in terms.values())
        for band, (nodes, response) in enumerate(zip(grid.nodes, grid.response, strict=True)):
            result[pixel, band] = trapezoid(spectrum[nodes] * response, grid.wavenumber_cm1[nodes])
    return result
