"""The expected variogram of the fractal field of eqs 2-4, without simulating it.

V is stationary with unit variance, so that its semivariogram at a lag of h pixels is 1 - rho(h). Each octave
interpolates independent normals with a product kernel and a random offset. Therefore rho is the sum over octaves of
their variance fraction times the kernel autocorrelations along x and y, averaged over the phase in the cell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.models.clouds.fractal.rows import cubic_weights
from hcss_twin.providers import Grid, Motion

__all__ = ["KernelCorrelation"]

# The kernel extends two cells to either side: points four cells apart share no node.
_REACH_CELLS = 4

# Table points per cell, and phases in the average: the correlation error is at most 1e-5.
_PER_CELL = 128

# Gauss-Legendre nodes for the mean over pairs of pixels of a frame.
_PAIR_NODE, _PAIR_WEIGHT = np.polynomial.legendre.leggauss(48)

_STILL = Motion(0.0, (0.0, 0.0), math.inf, 0.0)


@dataclass(frozen=True)
class KernelCorrelation:
    """Tabulated correlation of the interpolated lattice along one axis.

    Attributes
    ----------
    curvature : ndarray (N,)
        (1 - rho(u)) / u^2 at distances u from 0 to 4 lattice cells, evenly spaced. Unlike rho it is nearly linear near
        0, where neighbouring pixels of coarse octaves are.
    """

    curvature: Array

    @classmethod
    @lru_cache(maxsize=1)
    def tabulate(cls) -> KernelCorrelation:
        """Tabulate the autocorrelation of the variance-normalised cubic kernel, once in a process (about 30 ms).

        rho(u) = mean over the phase f in [0, 1) of sum_i w_i(f) w_i(f + u), with w_i the weight of
        node i and sum_i w_i^2 = 1.
        """
        phases = (np.arange(_PER_CELL) + 0.5) / _PER_CELL
        weights = _spread(phases, np.zeros(phases.size, dtype=np.int64))
        lags = np.arange(_REACH_CELLS * _PER_CELL + 1) / _PER_CELL
        # The limit at 0 is evaluated where both rounding and the next order are negligible.
        lags[0] = 1e-4
        curvature = np.empty(lags.size)
        for index, lag in enumerate(lags):
            cell = np.floor(phases + lag)
            shifted = _spread(phases + lag - cell, cell.astype(np.int64))
            # Half the squared difference is 1 - rho for weights of unit norm, without loss of digits.
            curvature[index] = 0.5 * np.mean(np.sum((weights - shifted) ** 2, axis=1)) / lag**2
        curvature.flags.writeable = False
        return cls(curvature)

    def __call__(self, lag_cells: Array) -> Array:
        """Return the correlation at distances (any shape) in cells, of any sign."""
        lag = np.minimum(np.abs(lag_cells), float(_REACH_CELLS))
        # The table is even: an index is faster than a search.
        position = lag * _PER_CELL
        low = np.minimum(position.astype(np.int64), self.curvature.size - 2)
        fraction = position - low
        curvature = self.curvature[low] * (1.0 - fraction) + self.curvature[low + 1] * fraction
        correlation: Array = 1.0 - lag * lag * curvature
        return correlation

    def expected_variogram(
        self, parameters: FractalParameters, pixel_size_m: float, dx_pixels: ArrayLike, dy_pixels: ArrayLike
    ) -> Array:
        """Return the semivariogram E[(V(x + h) - V(x))^2] / 2 of the field V of eqs 2-4 at lags h = (dx, dy).

        Parameters
        ----------
        parameters : FractalParameters
            Shape, complete.
        pixel_size_m : float
            Side of a pixel.
        dx_pixels, dy_pixels : array-like of int, shapes that broadcast
            Lags along x and y; of any sign.

        Returns
        -------
        ndarray, broadcast shape
            0 at lag 0.

        Raises
        ------
        ValueError
            If ``parameters`` are incomplete, or a lag is not a whole number of pixels: a nearest-node octave has no
            values between pixels.
        """
        dx, dy = _whole("dx_pixels", dx_pixels), _whole("dy_pixels", dy_pixels)
        variance, step_x, step_y = _octave_arrays(_octaves(parameters, pixel_size_m))
        along_x = _axis_correlation(dx, step_x, self)
        along_y = _axis_correlation(dy, step_y, self)
        variogram: Array = 1.0 - np.tensordot(along_x * along_y, variance, axes=(-1, 0))
        return variogram

    def frame_variance(self, parameters: FractalParameters, pixel_size_m: float, rows: int, columns: int) -> float:
        """Return the expected variance of V within one frame, which is less than 1 for large cells.

        It is the mean of the semivariogram over all pairs of pixels of the frame: the dispersion variance of
        geostatistics. Raises ValueError if ``parameters`` are incomplete.
        """
        octaves = _octaves(parameters, pixel_size_m)
        return 1.0 - math.fsum(
            octave.variance
            * _pair_mean(octave.x.step, octave.x.nearest, columns, self)
            * _pair_mean(octave.y.step, octave.y.nearest, rows, self)
            for octave in octaves
        )


def _spread(fraction: Array, cell: NDArray[np.int64]) -> Array:
    """Return the weights (N, nodes) of the nodes -1 to 7 for points (N,) in cells (N,) from 0 to 4."""
    weights = np.zeros((fraction.size, _REACH_CELLS + 4))
    np.put_along_axis(weights, cell[:, None] + np.arange(4), cubic_weights(fraction), axis=1)
    return weights


def _pair_mean(step: float, nearest: bool, count: int, kernel: KernelCorrelation) -> float:
    """Return the mean correlation of two independently drawn pixels among ``count`` along one axis."""
    if nearest:
        return 1.0 / count
    reach = min(1.0, _REACH_CELLS / (step * count))
    lag = 0.5 * reach * (_PAIR_NODE + 1.0)
    # The distance of two random points on a line of unit length has the density 2 (1 - lag).
    return float(np.sum(reach * _PAIR_WEIGHT * (1.0 - lag) * kernel(lag * count * step)))


def _octaves(parameters: FractalParameters, pixel_size_m: float) -> tuple[Octave, ...]:
    return Octave.separate(parameters, Grid(1, 1, pixel_size_m), _STILL)


def _octave_arrays(octaves: tuple[Octave, ...]) -> tuple[Array, Array, Array]:
    """Return variances and steps (K,) along x and y; steps are infinite for uncorrelated nearest nodes."""
    table = np.array(
        [(o.variance, math.inf if o.x.nearest else o.x.step, math.inf if o.y.nearest else o.y.step) for o in octaves]
    )
    return table[:, 0], table[:, 1], table[:, 2]


def _axis_correlation(lag: Array, steps: Array, kernel: KernelCorrelation) -> Array:
    """Return the correlation (..., K) along one axis for lags (...) in pixels."""
    # 0 times infinity: a pixel is fully correlated with itself for any step.
    return kernel(lag[..., None] * np.minimum(steps, float(_REACH_CELLS)))


def _whole(name: str, lag: ArrayLike) -> Array:
    values = np.asarray(lag, dtype=np.float64)
    if not np.all(values == np.rint(values)):
        raise ValueError(f"{name}: {lag!r} given, allowed: whole pixels")
    return values
