"""Reference band radiances of single pixels from dense spectra, without tables or interpolation.

It is slow and simple; all faster code is tested against it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.providers import ColumnSetting, RadianceModel
from hcss_twin.providers.column_states import spectra_of


def reference_radiance(
    model: RadianceModel,
    setting: ColumnSetting,
    grid: SpectralGrid,
    thickness_m: Sequence[float] | Array,
    together: int = 1,
) -> Array:
    """Return the band radiance of single pixels.

    Parameters
    ----------
    thickness_m : sequence of float (N,) or array (N, L)
        Cloud thickness of each pixel, 0 for clear sky, with one column per layer; (N,) is short for a single layer.
    together : int
        Number of columns that the model computes together, which is faster.

    Returns
    -------
    ndarray (N, B)
        W m-2 sr-1.
    """
    thickness = np.asarray(thickness_m, dtype=np.float64)
    columns = thickness[:, None] if thickness.ndim == 1 else thickness
    spectra = reference_spectra(model, setting, grid.wavenumber_cm1, columns, together)
    result: Array = np.sum(spectra, axis=1) @ grid.weights_cm1.T
    return result


def reference_spectra(
    model: RadianceModel, setting: ColumnSetting, wavenumber_cm1: Array, thickness_m: Array, together: int = 1
) -> Array:
    """Return the terms (N, K, V) of columns (N, L) at wavenumbers (V,), in the order of ``model.terms``.

    Parameters
    ----------
    model, setting, together
        As for :func:`reference_radiance`.
    """
    result = np.empty((thickness_m.shape[0], len(model.terms), wavenumber_cm1.size))
    if not wavenumber_cm1.size:  # a finer grid of narrow bands may have no new ones
        return result
    for start in range(0, thickness_m.shape[0], together):
        rows = slice(start, start + together)
        result[rows] = spectra_of(model, [setting], wavenumber_cm1, thickness_m[rows])[0]
    return result
