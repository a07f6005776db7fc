"""Expected variograms of many fractal fields at once, and the likelihood of a fractal dimension based on them.

A chain needs about 100 000 variograms, so the sums of ``models/clouds/fractal/expected_variogram.py`` are compiled here
as a second implementation; a test compares both.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.posterior.octaves import Octaves, mean_density
from hcss_evaluate.posterior.parameter_space import SHAPE
from hcss_twin.core.kernels import kernel
from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.providers import Array

# Known to compiled code, which reads no attributes of classes.
_NEAREST_FROM = Octave.NEAREST_FROM

# Radius of the kernel, cells.
_REACH_CELLS = 4.0

# Quadrature nodes of the mean over pairs of pixels of a frame.
_PAIR_NODE, _PAIR_WEIGHT = np.polynomial.legendre.leggauss(48)


@dataclass(frozen=True)
class BatchVariogram:
    """Tables that all fields share.

    Attributes
    ----------
    curvature : ndarray (N,)
        Of :class:`hcss_twin.models.clouds.fractal.expected_variogram.KernelCorrelation`.
    octaves : Octaves
        First octave, and possible last ones.
    """

    curvature: Array
    octaves: Octaves

    @classmethod
    def of(cls, octaves: Octaves) -> BatchVariogram:
        """Tabulate the kernel, which takes about 30 ms."""
        return cls(KernelCorrelation.tabulate().curvature, octaves)

    def __call__(
        self, shapes: Array, lags: NDArray[np.int64], pixel_size_m: float, rows: int, columns: int
    ) -> tuple[Array, Array]:
        """Return semivariograms along x, then along y, and the variance within one frame, for each last octave.

        The semivariogram is 1 - correlation of the field, which has unit variance; for the variance within a frame see
        :func:`hcss_twin.models.clouds.fractal.expected_variogram.KernelCorrelation.frame_variance`.

        Parameters
        ----------
        shapes : ndarray (N, 4)
            H, gamma, Lx, Ly; L in cells per 16 km.
        lags : ndarray of int64 (M,)
            Pixels, 1 or more.

        Returns
        -------
        ndarray (N, K, 2 M), ndarray (N, K)
        """
        lasts = self.octaves.lasts
        semivariogram = np.empty((shapes.shape[0], len(lasts), 2 * lags.size))
        variance = np.empty((shapes.shape[0], len(lasts)))
        _fill(
            np.ascontiguousarray(shapes, dtype=np.float64),
            lags.astype(np.float64),
            pixel_size_m / Octave.REFERENCE_LENGTH_M,
            rows,
            columns,
            self.octaves.first,
            np.array(lasts),
            self.curvature,
            _PAIR_NODE,
            _PAIR_WEIGHT,
            semivariogram,
            variance,
        )
        return semivariogram, variance


@kernel(inline="always")
def _distance(lag_cells: float, curvature: Any) -> Any:
    """Return 1 - correlation of points at a distance in cells."""
    lag = min(lag_cells, _REACH_CELLS)
    position = lag * ((curvature.size - 1) / _REACH_CELLS)
    low = min(int(position), curvature.size - 2)
    fraction = position - low
    return lag * lag * (curvature[low] * (1.0 - fraction) + curvature[low + 1] * fraction)


@kernel()
def _pair_mean(step: float, count: int, curvature: Any, node: Any, weight: Any) -> float:
    """Return the mean correlation of pairs of ``count`` pixels along one axis."""
    if step >= _NEAREST_FROM:
        return 1.0 / count
    cells = step * count
    reach = min(1.0, _REACH_CELLS / cells)
    total = 0.0
    for i in range(node.size):
        lag = 0.5 * reach * (node[i] + 1.0)
        total += weight[i] * (1.0 - lag) * (1.0 - _distance(lag * cells, curvature))
    return reach * total


@kernel()
def _fill(
    shapes: Any,
    lags: Any,
    pixel: float,
    rows: int,
    columns: int,
    first: int,
    lasts: Any,
    curvature: Any,
    node: Any,
    weight: Any,
    semivariogram: Any,
    variance: Any,
) -> None:
    for n in range(shapes.shape[0]):
        hurst, gamma, cells_x, cells_y = shapes[n, 0], shapes[n, 1], shapes[n, 2], shapes[n, 3]
        done, total, common = 0, 0.0, 0.0
        semivariogram[n, 0] = 0.0
        for k in range(first, lasts[-1] + 1):
            share = gamma ** (-2.0 * hurst * (k - first))
            step_x, step_y = cells_x * gamma**k * pixel, cells_y * gamma**k * pixel
            total += share
            common += (
                share
                * _pair_mean(step_x, columns, curvature, node, weight)
                * _pair_mean(step_y, rows, curvature, node, weight)
            )
            for m in range(lags.size):
                apart = 1.0 if step_x >= _NEAREST_FROM else _distance(lags[m] * step_x, curvature)
                semivariogram[n, done, m] += share * apart
                apart = 1.0 if step_y >= _NEAREST_FROM else _distance(lags[m] * step_y, curvature)
                semivariogram[n, done, lags.size + m] += share * apart
            if k == lasts[done]:
                # The sum up to here, which is also the beginning of the next longer one.
                if k < lasts[-1]:
                    semivariogram[n, done + 1] = semivariogram[n, done]
                semivariogram[n, done] /= total
                variance[n, done] = 1.0 - common / total
                done += 1


# The lags of hcss_evaluate.measures.fractal_dimension.
_LAGS = np.array([1, 2], dtype=np.int64)


@dataclass(frozen=True)
class DimensionLikelihood:
    """Normal likelihood of a dimension, centred on that of the expected variogram.

    D = 3 - slope / 2, where the slope is that of the logarithm of the field's semivariance (mean of both axes) between
    lags of 1 and 2 pixels, as measured by ``variogram_dimension``.

    Attributes
    ----------
    dimension, error : float
        Measured dimension and its standard deviation.
    rows, columns, pixel_size_m
        Size and pixel size of the measured image.
    variogram : BatchVariogram
        Expected variogram of the field.
    """

    dimension: float
    error: float
    rows: int
    columns: int
    pixel_size_m: float
    variogram: BatchVariogram

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises PosteriorError if the dimension is not between 2 and 3, or the error not positive.
        """
        if not 2.0 <= self.dimension <= 3.0:
            closest = 2 if self.dimension < 2.0 else 3
            raise PosteriorError(f"fractal dimension: {self.dimension:g} given, allowed: 2 to 3; closest is {closest}")
        if not 0.0 < self.error < math.inf:
            raise PosteriorError(f"error of the fractal dimension: {self.error:g} given, allowed: greater than 0")

    def expected(self, shapes: Array) -> Array:
        """Return the dimension (N, K) for H, gamma, Lx, Ly (N, 4) and each last octave."""
        semivariance, _ = self.variogram(shapes, _LAGS, self.pixel_size_m, self.rows, self.columns)
        near = semivariance[..., 0] + semivariance[..., 2]
        far = semivariance[..., 1] + semivariance[..., 3]
        return np.asarray(3.0 - 0.5 * np.log(far / near) / math.log(2.0))

    def __call__(self, values: Array) -> Array:
        """Return the log-likelihood (N,), up to a constant, of H, gamma, Lx, Ly, coverage (N, 5)."""
        difference = (self.expected(values[:, : len(SHAPE)]) - self.dimension) / self.error
        return mean_density(-0.5 * difference * difference)

    def draw_lasts(self, values: Array, rng: np.random.Generator) -> NDArray[np.int64]:
        """Draw a last octave (N,) for each of H, gamma, Lx, Ly, coverage (N, 5), given the dimension."""
        difference = (self.expected(values[:, : len(SHAPE)]) - self.dimension) / self.error
        return self.variogram.octaves.draw(-0.5 * difference * difference, rng)
