"""Cloud images as grey levels, their semivariances, and those of the underlying Gaussian field.

Clear pixels are 0, cloudy ones 1 to 255, linear in thickness (eq 7 of the HCSS paper). Measured and simulated images
use the same layer, 1 to 255 thick, so that a grey level means the same in both.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from hcss_evaluate.measures.morphology import Morphology, morphology
from hcss_evaluate.measures.semivariance import semivariances
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import Array, Catalog, CloudInputs, CloudLayer, Grid, ImageError, Microphysics, Motion

# Ratio of the shorter side to the longest lag; a single image constrains longer lags poorly.
_LONGEST = 3

# Nodes of the quadratures and of the inverted table.
_NORMAL_NODES, _SUM_NODES, _DIFFERENCE_NODES, _TABLE_NODES = 4096, 512, 64, 60
_SMALLEST, _LARGEST = 1e-7, 1.8


@dataclass(frozen=True)
class Structure:
    """Semivariances (half the mean square differences) along both axes (N,) at lags in pixels (N,)."""

    lags: NDArray[np.int64]
    along_x: Array
    along_y: Array

    @property
    def both(self) -> Array:
        """Along x, then along y (2 N,)."""
        return np.concatenate([self.along_x, self.along_y])

    @property
    def logarithm(self) -> Array:
        """Natural logarithms along x, then along y (2 N,)."""
        values: Array = np.log(self.both)
        return values


def mean_structure(structures: Sequence[Structure]) -> Structure:
    """Return the mean over several images."""
    return Structure(
        structures[0].lags,
        np.mean([structure.along_x for structure in structures], axis=0),
        np.mean([structure.along_y for structure in structures], axis=0),
    )


def octave_lags(shape: tuple[int, ...]) -> list[int]:
    """Return lags of 1, 2, 4, ... pixels up to a third of the shorter side."""
    return [2**n for n in range(int(math.log2(min(shape) / _LONGEST)) + 1)]


def image_structure(level: NDArray[Any], lags: list[int]) -> Structure:
    """Measure the semivariances of an image (rows, columns), clear pixels included.

    Raises ImageError if the image does not vary at some lag.
    """
    measured = semivariances(level, lags)
    if not (np.all(measured.along_x > 0.0) and np.all(measured.along_y > 0.0)):
        raise ImageError("image: constant along rows or columns, allowed: clouds that vary along both")
    return Structure(measured.lags, measured.along_x, measured.along_y)


def underlying_structure(level: NDArray[Any], measured: Structure) -> Structure:
    """Infer the semivariances of the normal field that maps to the grey levels of an image.

    A grey level is a function g of the pixel's standard normal score; g is the quantile function of the image's grey
    levels, clear pixels included. For two scores with correlation rho, (1/2) E[(g(a) - g(b))^2] is a function of rho
    alone; it is tabulated and inverted (Gaussian anamorphosis, J.-P. Chiles and P. Delfiner, Geostatistics, 2nd ed.,
    Wiley 2012, section 6.3). The unobserved field values of clear pixels are not needed.

    Returns
    -------
    Structure
        1 - rho of normal scores relative to the mean and variance of the frame, limited to 1.8, which a frame with few
        large clouds may reach at long lags.
    """
    one_minus = np.geomspace(_SMALLEST, _LARGEST, _TABLE_NODES)
    table = _grey_semivariance(level, one_minus)

    def invert(values: Array) -> Array:
        return np.exp(np.interp(np.log(values), np.log(table), np.log(one_minus)))

    return Structure(measured.lags, invert(measured.along_x), invert(measured.along_y))


def _grey_semivariance(level: NDArray[Any], one_minus: Array) -> Array:
    """Return (1/2) E[(g(a) - g(b))^2] of normal pairs for each 1 - rho (N,)."""
    values = np.sort(level, axis=None).astype(np.float64)
    score = np.linspace(-5.0, 5.0, _NORMAL_NODES)
    grey = np.interp(ndtr(score), (np.arange(values.size) + 0.5) / values.size, values)
    # a, b = s +- d with independent s and d of the variances (1 + rho) / 2 and (1 - rho) / 2.
    s, d = (ndtri((np.arange(count) + 0.5) / count) for count in (_SUM_NODES, _DIFFERENCE_NODES))
    result = np.empty(one_minus.size)
    for index, part in enumerate(one_minus):
        total = s[:, None] * math.sqrt(1.0 - 0.5 * part)
        half = d[d > 0.0] * math.sqrt(0.5 * part)
        above, below = (np.interp(total + sign * half, score, grey) for sign in (1.0, -1.0))
        result[index] = 0.5 * np.mean((above - below) ** 2)
    return result


# The particles are not used here, but a layer requires them.
_NO_MATTER = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))
LEVELS = (1.0, 255.0)
"""Minimum and maximum grey level of a cloudy pixel."""

STILL = Motion(0.0, (0.0, 0.0), math.inf, 0.0)


@dataclass(frozen=True)
class CloudImage:
    """One image.

    Attributes
    ----------
    level : ndarray of float32 (rows, columns)
        0 where clear, 1 to 255 where cloudy, not rounded; rows run northward, columns eastward.
    pixel_size_m : float
        Side of a pixel.
    """

    level: NDArray[np.float32]
    pixel_size_m: float

    @property
    def cloudy(self) -> NDArray[np.bool_]:
        """Mask of the cloudy pixels."""
        return self.level > 0.0

    @property
    def coverage(self) -> float:
        """Fraction of cloudy pixels."""
        return float(np.count_nonzero(self.level)) / self.level.size

    @property
    def mean_level(self) -> float:
        """Mean grey level of the cloudy pixels."""
        return float(np.sum(self.level, dtype=np.float64)) / max(1, int(np.count_nonzero(self.level)))

    def morphology(self) -> Morphology:
        """Measure the morphology of the clouds.

        Raises ImageError if there is too little cloud or no variation.
        """
        return morphology(self.level, self.cloudy)


def grey_inputs(
    coverage: float, rows: int, columns: int, pixel_size_m: float, seed: int = 0, base: Path | None = None
) -> CloudInputs:
    """Return inputs that make a cloud generator produce grey levels instead of metres.

    Relative paths are resolved from ``base``, by default the working directory.
    """
    layer = CloudLayer("grey levels", 0.0, LEVELS[1], "base", LEVELS[0], coverage, None, _NO_MATTER)
    return CloudInputs(layer, Grid(rows, columns, pixel_size_m), STILL, seed, Catalog(base=base))


def simulate_image(parameters: FractalParameters, coverage: float, like: CloudImage, seed: int) -> CloudImage:
    """Simulate one frame with the size and pixel size of another image.

    Raises ScenarioError if ``parameters`` are incomplete.
    """
    rows, columns = like.level.shape
    generator = FractalClouds(grey_inputs(coverage, rows, columns, like.pixel_size_m, seed), parameters)
    return CloudImage(generator.thickness_m(0.0, slice(0, rows), slice(0, columns)), like.pixel_size_m)
