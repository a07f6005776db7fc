"""What an estimator of the fractal dimension returns.

Bias and spread of the estimators on exact surfaces, measured once and kept with the package.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class DimensionEstimate:
    """A fractal dimension and how far to trust it.

    Attributes
    ----------
    dimension : float
        Fractal dimension: 2 to 3 of a grey-level surface, 1 to 2 of a boundary.
    standard_error : float
        Root mean square error (bias and spread) of the estimator on surfaces of this dimension and size, as
        measured in docs/fractal-dimension.md; NaN where it was not measured.
    method : str
        Name of the estimator and its settings.
    """

    dimension: float
    standard_error: float
    method: str


@dataclass(frozen=True)
class Measured:
    """Results of ``benchmarks/fractal_dimension.py``, interpolated.

    Attributes
    ----------
    log_size : ndarray of float64 (sizes,)
        Logarithm of the sides of the square surfaces, ascending.
    dimension : ndarray of float64 (dimensions,)
        D = 3 - H of the surfaces, ascending.
    mean, spread : dict of str to ndarray of float64 (sizes, dimensions)
        Mean and standard deviation of each estimator over the surfaces; of "boundary" plus one, so that
        all would be D.
    """

    log_size: NDArray[np.float64]
    dimension: NDArray[np.float64]
    mean: dict[str, NDArray[np.float64]]
    spread: dict[str, NDArray[np.float64]]

    @classmethod
    def load(cls) -> Measured:
        """Return what the package carries."""
        return _load()

    def standard_error(self, method: str, dimension: float, size: float, larger: bool = True) -> float:
        """Return the root mean square error of ``method`` for an estimate ``dimension``.

        Linear in D and in the logarithm of the size, and constant beyond the roughest, smoothest and
        smallest surfaces measured. An estimate outside 2 to 3 is wrong by that much at least, which is added
        in quadrature.

        Parameters
        ----------
        method : str
            Name in the table.
        dimension : float
            The estimate.
        size : float
            Shorter side of the image, or the root of its number of pixels.
        larger : bool
            Whether the error of the largest surfaces stands for still larger ones, or NaN.
        """
        place = math.log(size)
        if place > self.log_size[-1] + 1e-9 and not larger:
            return math.nan
        bias = self.mean[method] - self.dimension
        by_size = np.array([np.interp(dimension, self.dimension, row) for row in np.hypot(bias, self.spread[method])])
        outside = max(2.0 - dimension, 0.0, dimension - 3.0)
        return math.hypot(float(np.interp(place, self.log_size, by_size)), outside)

    def calibrated(self, method: str, value: float, size: float) -> float:
        """Return the D whose mean value of ``method`` is ``value``, in images of side ``size``.

        Linear in between, and in extrapolation: beyond the roughest and smoothest surfaces with the slope
        of the last two, beyond the largest with that in the logarithm of the size.
        """
        table, place = self.mean[method], math.log(size)
        upper = int(np.clip(np.searchsorted(self.log_size, place), 1, self.log_size.size - 1))
        step = self.log_size[upper] - self.log_size[upper - 1]
        share = (place - self.log_size[upper - 1]) / step
        expected = (1.0 - share) * table[upper - 1] + share * table[upper]
        after = int(np.clip(np.searchsorted(expected, value), 1, expected.size - 1))
        slope = (self.dimension[after] - self.dimension[after - 1]) / (expected[after] - expected[after - 1])
        return float(self.dimension[after - 1] + slope * (value - expected[after - 1]))


@cache
def _load() -> Measured:
    content = json.loads(Path(__file__).with_name("measured.json").read_text(encoding="utf-8"))
    tables = content["methods"].items()
    return Measured(
        np.log(np.array(content["sizes"], dtype=np.float64)),
        3.0 - np.array(content["hurst"])[::-1],
        {name: np.array(table["mean"])[:, ::-1] for name, table in tables},
        {name: np.array(table["spread"])[:, ::-1] for name, table in tables},
    )
