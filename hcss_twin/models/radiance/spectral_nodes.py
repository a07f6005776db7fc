"""Few weighted wavenumbers whose sums are the band radiances of all columns of a scene.

Spectra of one scene are alike: gas lines, clouds and sun change with thickness and time in few independent ways.
A band therefore needs few wavenumbers, if they and their weights are chosen for the scene's own spectra. Weights that
cannot be negative keep radiances positive and make sums of weights that partition a spectrum partition its band.

The method is an empirical quadrature: wavenumbers are added greedily, and their weights follow by non-negative least
squares (C. L. Lawson and R. J. Hanson, *Solving Least Squares Problems*, 1974, chapter 23), until every spectrum is
summed within the tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.spectral_grid import SpectralGrid


@dataclass(frozen=True)
class SpectralNodes:
    """Wavenumbers at which spectra are computed, and their weights in each band.

    Attributes
    ----------
    wavenumber_cm1 : ndarray (N,)
        Ascending.
    weights_cm1 : ndarray (B, N)
        Band radiance = spectral radiance (N,) @ weights.
    """

    wavenumber_cm1: Array
    weights_cm1: Array


def all_nodes(grid: SpectralGrid) -> SpectralNodes:
    """Return every wavenumber of a grid."""
    return SpectralNodes(grid.wavenumber_cm1, grid.weights_cm1)


def choose_nodes(grid: SpectralGrid, spectra: Array, tolerance: float) -> SpectralNodes:
    """Choose wavenumbers that sum given spectra to their band radiances.

    Parameters
    ----------
    grid : SpectralGrid
        V wavenumbers, B bands.
    spectra : ndarray (S, K, V)
        K terms of S columns.
    tolerance : float
        Greatest error of any term of any column, relative to the column's total in the band.

    Returns
    -------
    SpectralNodes
        A subset of the grid.
    """
    weights = np.zeros_like(grid.weights_cm1)
    for band, own in enumerate(grid.nodes):
        summands = spectra[:, :, own] * grid.weights_cm1[band, own]
        weights[band, own] = grid.weights_cm1[band, own] * _factors(summands, tolerance)
    used = np.flatnonzero(weights.any(axis=0))
    return SpectralNodes(grid.wavenumber_cm1[used], np.ascontiguousarray(weights[:, used]))


def _factors(summands: Array, tolerance: float) -> Array:
    """Factors (V,), most of them 0, of summands (S, K, V) that leave their sums unchanged within the tolerance."""
    # imported here: runs that find their tables should not wait for it
    from scipy.optimize import nnls

    total = np.sum(summands, axis=(1, 2))
    lit = total > 0.0
    rows = (summands[lit] / total[lit, None, None]).reshape(-1, summands.shape[2])
    rows = rows[rows.any(axis=1)]
    target = np.sum(rows, axis=1)
    size = np.linalg.norm(rows, axis=0)
    every = np.ones(summands.shape[2])
    if not rows.size:
        return every
    direction = rows / np.where(size > 0.0, size, 1.0)
    chosen: list[int] = []
    factors, left = np.zeros(0), target
    while np.max(np.abs(left)) > tolerance:
        gain = left @ direction
        gain[chosen] = -np.inf
        best = int(np.argmax(gain))
        if gain[best] <= 0.0 or len(chosen) >= every.size:
            return every
        chosen.append(best)
        factors, _ = nnls(rows[:, chosen], target)
        kept = factors > 0.0
        if not kept[-1]:
            return every
        chosen = [index for index, keep in zip(chosen, kept, strict=True) if keep]
        factors = factors[kept]
        left = target - rows[:, chosen] @ factors
    result = np.zeros_like(every)
    result[chosen] = factors
    return result
