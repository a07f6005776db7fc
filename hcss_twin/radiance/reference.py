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
    thickness_m : sequence of float (N,)
        Cloud thickness of each pixel, 0 for clear sky.
    sun : Sun or None
        Where the sun is at that pixel's time.

    Returns
    -------
    ndarray (N, B)
        W m-2 sr-1.
    """
    result = np.empty((len(thickness_m), len(grid.nodes)))
    for pixel, thickness in enumerate(thickness_m):
        if thickness > 0:
            terms = model.cloudy(grid.wavenumber_cm1, np.array([float(thickness)]), sun)
            spectrum = sum(np.asarray(term)[0] for term in terms.values())
        else:
            terms = model.clear(grid.wavenumber_cm1, sun)
            spectrum = sum(np.asarray(term) for term in terms.values())
        for band, (nodes, response) in enumerate(zip(grid.nodes, grid.response, strict=True)):
            result[pixel, band] = trapezoid(spectrum[nodes] * response, grid.wavenumber_cm1[nodes])
    return result
