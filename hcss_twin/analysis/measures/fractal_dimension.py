"""Fractal dimension of a grey-level surface from the slope of its variogram or of its power spectrum.

Each estimate has a standard error from the estimator's bias and spread on exact fractional Brownian surfaces, which
``benchmarks/fractal_dimension.py`` measures and writes to the JSON file beside this module.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fftfreq, rfftfreq

from hcss_twin.analysis.measures.checks import checked_image
from hcss_twin.analysis.measures.power_spectrum import windowed_power
from hcss_twin.analysis.measures.semivariance import semivariances
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ImageError


@dataclass(frozen=True)
class DimensionEstimate:
    """A fractal dimension, 2 to 3 of a grey-level surface and 1 to 2 of a boundary, with the method and its settings.

    The standard error is the root mean square error (bias and spread) of the estimator on surfaces of this dimension
    and size, as measured in docs/development/fractal-dimension.md; NaN where it was not measured.
    """

    dimension: float
    standard_error: float
    method: str


@dataclass(frozen=True)
class EstimatorCalibration:
    """Results of ``benchmarks/fractal_dimension.py``, interpolated.

    Attributes
    ----------
    log_size : ndarray of float64 (sizes,)
        Logarithm of the sides of the square surfaces, ascending.
    dimension : ndarray of float64 (dimensions,)
        D = 3 - H of the surfaces, ascending.
    mean, spread : dict of str to ndarray of float64 (sizes, dimensions)
        Mean and standard deviation of each estimator over the surfaces; of "boundary" plus one, so that all would be D.
    """

    log_size: Array
    dimension: Array
    mean: dict[str, Array]
    spread: dict[str, Array]

    def standard_error(self, method: str, dimension: float, size: float, larger: bool = True) -> float:
        """Return the root mean square error of ``method`` for an estimate ``dimension``.

        ``size`` is the shorter side of the image, or the root of its number of pixels. Linear in D and in the logarithm
        of the size, and constant beyond the roughest, smoothest and smallest surfaces measured; beyond the largest as
        well, or NaN unless ``larger``. An estimate outside 2 to 3 is wrong by that much at least, which is added in
        quadrature.
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

        Linear in between, and in extrapolation: beyond the roughest and smoothest surfaces with the slope of the last
        two, beyond the largest with that in the logarithm of the size.
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
def estimator_calibration() -> EstimatorCalibration:
    """Return the calibration that the package carries."""
    content = json.loads(Path(__file__).with_suffix(".json").read_text(encoding="utf-8"))
    tables = content["methods"].items()
    return EstimatorCalibration(
        np.log(np.array(content["sizes"], dtype=np.float64)),
        3.0 - np.array(content["hurst"])[::-1],
        {name: np.array(table["mean"])[:, ::-1] for name, table in tables},
        {name: np.array(table["spread"])[:, ::-1] for name, table in tables},
    )


# The window spreads what is slower than three waves per image.
_FEWEST_WAVES = 3.0

# Sampling folds the spectrum beyond the Nyquist wavenumber of .5 back; above this it is too much.
_HIGHEST = 0.15

# Small images go higher, to keep three octaves, but not beyond this.
_HIGHEST_OF_SMALL = 0.25
_RINGS_PER_OCTAVE = 4


def default_band(side: int) -> tuple[float, float]:
    """Return the band of wavenumbers for a shorter side, cycles per pixel."""
    low = _FEWEST_WAVES / side
    return low, max(_HIGHEST, min(8.0 * low, _HIGHEST_OF_SMALL))


def spectral_dimension(image: NDArray[Any], band: tuple[float, float] | None = None) -> DimensionEstimate:
    """Estimate D = 4 - beta / 2 from a radially averaged power spectrum k^(-beta).

    A self-affine surface with Hurst exponent H has beta = 2 H + 2 and D = 3 - H. The image less its plane of least
    squares is multiplied by a Hann window along each axis; power is averaged over rings, four per octave of wavenumber;
    the slope is that of least squares in logarithms, weighted with the number of waves in each ring. The error is NaN
    for other than the default band. Raises ImageError if the image is too small, constant, flat but for a slope, or not
    finite, or if the band holds fewer than three rings with waves in them.

    Parameters
    ----------
    image : ndarray of float32, float64 or integers (rows, columns)
        At least 32 x 32 pixels, any unit.
    band : tuple of float, optional
        Lowest and highest wavenumber, cycles per pixel, up to .5. By default 3 waves per shorter side to .15; in images
        of less than 160 pixels to 24 waves, at most .25.
    """
    pixels = checked_image("image", image)
    side = min(pixels.shape)
    low, high = default_band(side) if band is None else band
    if not 0.0 < low < high <= 0.5:
        raise ImageError(f"band: {low} to {high} given, allowed: 0 < low < high <= 0.5 cycles per pixel")
    rows, columns = pixels.shape
    power, _ = windowed_power(pixels)
    wavenumber = np.hypot(fftfreq(rows)[:, None], rfftfreq(columns)).ravel()
    rings = max(3, round(_RINGS_PER_OCTAVE * math.log2(high / low)))
    inside = np.flatnonzero((wavenumber >= low) & (wavenumber < high))
    logs = np.log(wavenumber[inside])
    ring = ((logs - math.log(low)) * (rings / math.log(high / low))).astype(np.int64)
    ring = np.minimum(ring, rings - 1)
    # Of a real image half the waves are stored; those along y only are stored in full.
    multiplicity = np.full(columns // 2 + 1, 2.0)
    multiplicity[0] = 1.0
    if columns % 2 == 0:
        multiplicity[-1] = 1.0
    share = multiplicity[inside % multiplicity.size]
    waves = np.bincount(ring, share, rings)
    full = waves > 0
    if np.count_nonzero(full) < 3:
        raise ImageError(f"band: {low:g} to {high:g} has waves in {np.count_nonzero(full)} rings, allowed: 3 or more")
    mean_power = np.bincount(ring, share * power.ravel()[inside], rings)[full] / waves[full]
    if not np.all(mean_power > 0.0):
        raise ImageError("image: no power in part of the band, allowed: power at all wavenumbers")
    place = np.bincount(ring, share * logs, rings)[full] / waves[full]
    slope = float(np.polyfit(place, np.log(mean_power), 1, w=np.sqrt(waves[full]))[0])
    dimension = 4.0 + slope / 2.0
    error = estimator_calibration().standard_error("spectrum", dimension, side) if band is None else math.nan
    return DimensionEstimate(dimension, error, f"spectrum, {low:.3g} to {high:.3g} cycles per pixel")


# Fewer pairs say nothing about a slope.
_FEWEST_PAIRS = 100


def variogram_dimension(
    image: NDArray[Any], lags: Sequence[int] = (1, 2), mask: NDArray[np.bool_] | None = None
) -> DimensionEstimate:
    """Estimate D = 3 - slope / 2, the slope that of log semivariance against log lag.

    A self-affine surface with Hurst exponent H has the variogram |h|^(2 H) and D = 3 - H. The semivariances of both
    axes are averaged, the slope is that of least squares. The result is not confined to 2 to 3: white noise is near 3,
    a smooth image near 2. Its error is that of full images of floating-point numbers with lags 1 and 2, for the number
    of pairs that counted; NaN for other lags. Raises ImageError if the image is too small, constant over the pairs, or
    not finite where it counts, if there are fewer than 100 pairs at a lag, or if the lags do not differ.

    Parameters
    ----------
    image : ndarray of float32, float64 or integers (rows, columns)
        At least 32 x 32 pixels, any unit.
    lags : sequence of int
        Two or more different distances in pixels.
    mask : ndarray of bool (rows, columns), optional
        Only pairs with both pixels in it count; all, by default. Other pixels may be NaN.
    """
    pixels = checked_image("image", image)
    found = semivariances(pixels, lags, mask)
    if np.unique(found.lags).size < 2:
        raise ImageError(f"lags: {tuple(lags)} given, allowed: two or more different ones; closest is (1, 2)")
    pairs = found.pairs_x + found.pairs_y
    if pairs.min() < _FEWEST_PAIRS:
        lag = found.lags[pairs.argmin()]
        raise ImageError(f"mask: {pairs.min()} pairs of pixels at lag {lag}, allowed: {_FEWEST_PAIRS} or more")
    pooled = found.pooled
    if not np.all(pooled > 0.0):
        lag = found.lags[np.argmin(pooled > 0.0)]
        raise ImageError(f"image: semivariance 0 at lag {lag}, allowed: values that vary")
    slope = np.polyfit(np.log(found.lags.astype(np.float64)), np.log(pooled), 1)[0]
    listed = ", ".join(str(lag) for lag in found.lags)
    dimension = float(3.0 - slope / 2.0)
    if tuple(found.lags) == (1, 2):
        error = estimator_calibration().standard_error("variogram", dimension, math.sqrt(float(pairs.min()) / 2.0))
    else:
        error = math.nan
    return DimensionEstimate(dimension, error, f"variogram, lags {listed}")
