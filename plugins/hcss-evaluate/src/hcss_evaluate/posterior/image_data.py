"""Image statistics for a fit: the variogram of normal scores, with clear pixels at the threshold.

In cloudy pixels, grey levels are an increasing function of the field V. They have the ranks of the field whatever the
function (brightness exponent, eq 7, a calibration), so ranks are converted to standard normal scores z. Clear pixels,
known only to lie below the threshold t, are set to it: y = max(z, t).

For a bivariate normal pair with correlation rho, the semivariance (1/2) E[(max(a, t) - max(b, t))^2] is a function of
rho and t alone (Gaussian anamorphosis: J.-P. Chiles and P. Delfiner, Geostatistics, 2nd ed., Wiley 2012, section 6.3).
A table of it converts the expected variogram of V to that of y.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri
from scipy.stats import rankdata

from hcss_evaluate.matching.structure import STILL, CloudImage, image_structure, octave_lags
from hcss_evaluate.measures.images import SMALLEST_SIDE
from hcss_twin.core.kernels import kernel
from hcss_twin.models.clouds.fractal.field import FractalField
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import Array, Grid, ImageError

# Bins for ranking simulated fields; a step is less than 2e-4 of the field's standard deviation.
_BINS = 1 << 16
_TABLE_NODES, _SMALLEST, _LARGEST = 160, 1e-7, 1.999
_NODE, _WEIGHT = np.polynomial.legendre.leggauss(96)
_FARTHEST = 8.0


def image_scores(level: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the normal scores (rows, columns) of an image whose clear pixels are 0.

    Equal levels get the mean of their ranks.

    Raises ImageError if no pixel is cloudy, or no two cloudy pixels differ.
    """
    cloudy = level > 0.0
    values = level[cloudy]
    if values.size == 0:
        raise ImageError("image: no pixel is cloudy, allowed: one or more cloudy pixels")
    if values.min() == values.max():
        raise ImageError(f"image: all cloudy pixels are {values.min():g}, allowed: values that vary")
    clear = level.size - values.size
    scores = np.full(level.shape, _threshold(clear, level.size), dtype=np.float32)
    scores[cloudy] = ndtri((clear + rankdata(values) - 0.5) / level.size)
    return scores


def rank_scores(cloudy: int, size: int) -> NDArray[np.float32]:
    """Return the score of each half rank 0, 1/2, ... of ``size`` pixels, at least the threshold (2 size + 1,)."""
    ranks = np.clip(0.5 * np.arange(2 * size + 1), 0.5, size - 0.5)
    scores = np.maximum(ndtri(ranks / size), _threshold(size - cloudy, size))
    return np.asarray(scores, dtype=np.float32)


def still_field(parameters: FractalParameters, grid: Grid, seed: int) -> NDArray[np.float32]:
    """Return the field V (rows, columns) of one frame, to the last bit that of the fractal generator.

    Without its checks, and without its cache of nodes for the next frames, it takes a fifth of the time.
    """
    octaves = Octave.merge_noise(Octave.separate(parameters, grid, STILL))
    once = tuple(replace(octave, t=Octave.AxisScale(0.0, nearest=True)) for octave in octaves)
    y, x = (FractalField.PixelWindow(0, count, 0.5 - count / 2) for count in (grid.rows, grid.columns))
    return FractalField(seed, once, threads=1).window(0.0, y, x)


def field_scores(field: NDArray[np.float32], of_ranks: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the scores (rows, columns) of a simulated field, given those of half ranks (:func:`rank_scores`)."""
    low, high = float(field.min()), float(field.max())
    counts = np.zeros(_BINS, dtype=np.int64)
    flat = np.ascontiguousarray(field).reshape(-1)
    scale = np.float32((_BINS - 1) / max(high - low, 1e-30))
    _count(flat, np.float32(low), scale, counts)
    table = of_ranks[2 * np.cumsum(counts) - counts]
    result = np.empty(flat.size, dtype=np.float32)
    _look_up(flat, np.float32(low), scale, table, result)
    return result.reshape(field.shape)


class ScoreSemivariance:
    """Semivariance of scores as a function of the semivariance of the field.

    Parameters
    ----------
    coverage : float
        Fraction of cloudy pixels; 1 means no threshold.
    """

    def __init__(self, coverage: float) -> None:
        self.field = np.geomspace(_SMALLEST, _LARGEST, _TABLE_NODES)
        threshold = -math.inf if coverage >= 1.0 else float(ndtri(1.0 - coverage))
        self.scores = np.array([clipped_semivariance(field, threshold) for field in self.field])
        self._logarithms = np.log(self.field), np.log(self.scores)

    @property
    def table(self) -> tuple[float, float, Array]:
        """First value and step of ln of the field's semivariance, and ln of the semivariance of scores (N,)."""
        fields, scores = self._logarithms
        return float(fields[0]), float(fields[1] - fields[0]), scores

    def logarithm(self, semivariance: Array) -> Array:
        """Return ln of the semivariance of scores for semivariances (any shape) of a field with unit variance.

        Above 2 (a correlation of -1), which a frame with few large clouds may apparently exceed, the value at 2 is
        used.
        """
        result: Array = np.interp(np.log(semivariance), *self._logarithms)
        return result


def clipped_semivariance(one_minus: float, threshold: float) -> float:
    """Return (1/2) E[(max(a, t) - max(b, t))^2] of standard normal a, b with 1 - correlation ``one_minus``.

    With a, b = s + d, s - d for independent normal s, d, the mean over s is analytic and the mean over d uses
    quadrature.
    """
    if threshold == -math.inf:
        return one_minus
    sigma_s, sigma_d = math.sqrt(1.0 - 0.5 * one_minus), math.sqrt(0.5 * one_minus)
    half = 0.5 * _FARTHEST
    d = sigma_d * half * (_NODE + 1.0)
    density = np.exp(-0.5 * (d / sigma_d) ** 2) / math.sqrt(2.0 * math.pi) * half * _WEIGHT
    low, high = (threshold - d) / sigma_s, (threshold + d) / sigma_s
    # Both above the threshold: the difference is 2 d. One above: s + d - t, with s from t - d to t + d.
    inside = ndtr(high) - ndtr(low)
    first, second = _normal(low), _normal(high)
    moment_1 = first - second
    moment_2 = inside + low * first - high * second
    shift = d - threshold
    one = sigma_s**2 * moment_2 + 2.0 * sigma_s * shift * moment_1 + shift**2 * inside
    # Half the square, with both signs of d.
    return float(np.sum(density * (4.0 * d**2 * ndtr(-high) + one)))


def _normal(x: Array) -> Array:
    density: Array = np.exp(-0.5 * x * x) / math.sqrt(2.0 * math.pi)
    return density


def _threshold(clear: int, size: int) -> float:
    return float(ndtri(clear / size)) if clear else -math.inf


@kernel()
def _count(values: Any, low: Any, scale: Any, counts: Any) -> None:
    for i in range(values.size):
        counts[int((values[i] - low) * scale)] += 1


@kernel()
def _look_up(values: Any, low: Any, scale: Any, table: Any, result: Any) -> None:
    for i in range(values.size):
        result[i] = table[int((values[i] - low) * scale)]


# With fewer cloudy or clear pixels, the variogram would describe single clouds or gaps.
_FEWEST_PIXELS = 100


@dataclass(frozen=True)
class ImageData:
    """Measured statistics of one image.

    ``cloudy`` is the number of cloudy pixels; ``variogram`` (2 M,) has the semivariances of normal scores along x, then
    along y, at ``lags`` (M,) in pixels.
    """

    rows: int
    columns: int
    pixel_size_m: float
    cloudy: int
    lags: NDArray[np.int64]
    variogram: Array

    @classmethod
    def of(cls, image: CloudImage, smallest_lag: int = 1) -> ImageData:
        """Measure an image.

        Raises ImageError if the image is too small, has too few cloudy or clear pixels, or does not vary.
        """
        level = image.level
        if level.ndim != 2 or min(level.shape) < SMALLEST_SIDE:
            raise ImageError(
                f"image: {' x '.join(map(str, level.shape))} pixels, allowed: {SMALLEST_SIDE} or more along each axis"
            )
        if not np.all(np.isfinite(level)):
            raise ImageError("image: a pixel is not finite, allowed: grey levels, 0 where clear")
        cloudy = int(np.count_nonzero(level))
        for count, what in ((cloudy, "cloudy"), (level.size - cloudy, "clear")):
            if count < _FEWEST_PIXELS:
                raise ImageError(
                    f"image: {count} of {level.size} pixels are {what}, allowed: {_FEWEST_PIXELS} or more; try another "
                    "part of the image, or another cloud detection method"
                )
        lags = [lag for lag in octave_lags(level.shape) if lag >= smallest_lag]
        if len(lags) < 2:
            raise ImageError(
                f"smallest lag: {smallest_lag} pixels, allowed: 1 to {octave_lags(level.shape)[-2]}, with two lags or "
                "more up to a third of the shorter side"
            )
        structure = image_structure(image_scores(level), lags)
        rows, columns = level.shape
        return cls(rows, columns, image.pixel_size_m, cloudy, structure.lags, structure.both)

    @cached_property
    def rank_scores(self) -> NDArray[np.float32]:
        """Scores of half ranks in simulated images (:func:`rank_scores`)."""
        return rank_scores(self.cloudy, self.rows * self.columns)

    @property
    def coverage(self) -> float:
        """Fraction of cloudy pixels."""
        return self.cloudy / (self.rows * self.columns)

    @property
    def threshold(self) -> float:
        """Normal score above which pixels are cloudy."""
        return float(ndtri(1.0 - self.coverage))

    def simulate(self, shape: Array, octaves: tuple[int, int], seed: int) -> tuple[NDArray[np.float32], float]:
        """Simulate an image of the same size and number of cloudy pixels, with H, gamma, Lx, Ly in ``shape`` (4,).

        Returns its normal scores (rows, columns), and the threshold of the field V above which its pixels are cloudy.
        """
        hurst, gamma, cells_x, cells_y = (float(value) for value in shape)
        parameters = FractalParameters(gamma=gamma, H=hurst, L=(cells_x, cells_y), k=octaves)
        field = still_field(parameters, Grid(self.rows, self.columns, self.pixel_size_m), seed)
        rank = field.size - round(self.coverage * field.size)
        return field_scores(field, self.rank_scores), float(np.partition(field.ravel(), rank)[rank])
