"""Fractal dimension of a grey-level surface from the slope of its variogram or power spectrum.

The standard error of each estimate includes the bias and spread of the estimator on exact fractional Brownian surfaces;
``benchmarks/fractal_dimension.py`` measures them and writes the JSON file next to this module.
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

from hcss_evaluate.measures.images import checked_image
from hcss_evaluate.measures.semivariance import semivariances
from hcss_twin.providers import Array, ImageError
from hcss_twin.reports.power_spectrum import Rings


@dataclass(frozen=True)
class DimensionEstimate:
    """A fractal dimension (2 to 3 for a grey-level surface, 1 to 2 for a boundary) with the method and its settings.

    The standard error is the root mean square error (bias and spread) of the estimator on surfaces of this dimension
    and size, as given in docs/development/fractal-dimension.md; NaN if it was not measured.
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
        Mean and standard deviation of each estimator over the surfaces; "boundary" is increased by one to be comparable
        to D.
    """

    log_size: Array
    dimension: Array
    mean: dict[str, Array]
    spread: dict[str, Array]

    def standard_error(self, method: str, dimension: float, size: float, larger: bool = True) -> float:
        """Return the root mean square error of ``method`` for an estimate ``dimension``.

        ``size`` is the shorter side of the image, or the square root of its number of pixels. The error is interpolated
        linearly in D and in the logarithm of the size, and is constant beyond the roughest, smoothest and smallest
        surfaces measured; beyond the largest it is constant with ``larger``, else NaN. The distance of an estimate from
        the range 2 to 3 is added in quadrature.
        """
        log_size = math.log(size)
        if log_size > self.log_size[-1] + 1e-9 and not larger:
            return math.nan
        bias = self.mean[method] - self.dimension
        by_size = np.array([np.interp(dimension, self.dimension, row) for row in np.hypot(bias, self.spread[method])])
        outside = max(2.0 - dimension, 0.0, dimension - 3.0)
        return math.hypot(float(np.interp(log_size, self.log_size, by_size)), outside)

    def calibrated(self, method: str, value: float, size: float) -> float:
        """Return the D for which the mean estimate of ``method`` is ``value``, in images of side ``size``.

        Interpolation and extrapolation are linear: beyond the roughest and smoothest surfaces with the slope of the
        last two, beyond the largest with the slope in the logarithm of the size.
        """
        table, log_size = self.mean[method], math.log(size)
        upper = int(np.clip(np.searchsorted(self.log_size, log_size), 1, self.log_size.size - 1))
        step = self.log_size[upper] - self.log_size[upper - 1]
        share = (log_size - self.log_size[upper - 1]) / step
        expected = (1.0 - share) * table[upper - 1] + share * table[upper]
        after = int(np.clip(np.searchsorted(expected, value), 1, expected.size - 1))
        slope = (self.dimension[after] - self.dimension[after - 1]) / (expected[after] - expected[after - 1])
        return float(self.dimension[after - 1] + slope * (value - expected[after - 1]))


@cache
def estimator_calibration() -> EstimatorCalibration:
    """Return the calibration that is part of the package."""
    content = json.loads(Path(__file__).with_suffix(".json").read_text(encoding="utf-8"))
    tables = content["methods"].items()
    return EstimatorCalibration(
        np.log(np.array(content["sizes"], dtype=np.float64)),
        3.0 - np.array(content["hurst"])[::-1],
        {name: np.array(table["mean"])[:, ::-1] for name, table in tables},
        {name: np.array(table["spread"])[:, ::-1] for name, table in tables},
    )


# The window smears wavenumbers below three cycles per image.
_FEWEST_WAVES = 3.0

# Above this wavenumber, aliasing from beyond the Nyquist wavenumber of .5 is too strong.
_HIGHEST = 0.15

# Upper limit for small images, which use higher wavenumbers to cover three octaves.
_HIGHEST_OF_SMALL = 0.25
_RINGS_PER_OCTAVE = 4


def default_band(side: int) -> tuple[float, float]:
    """Return the default wavenumber band for a shorter side, cycles per pixel."""
    low = _FEWEST_WAVES / side
    return low, max(_HIGHEST, min(8.0 * low, _HIGHEST_OF_SMALL))


def spectral_dimension(image: NDArray[Any], band: tuple[float, float] | None = None) -> DimensionEstimate:
    """Estimate D = 4 - beta / 2 from a radially averaged power spectrum k^(-beta).

    A self-affine surface with Hurst exponent H has beta = 2 H + 2 and D = 3 - H. The least-squares plane is subtracted
    from the image and a Hann window applied along each axis; power is averaged over rings, four per octave of
    wavenumber; a least-squares fit in logarithms, weighted with the number of waves in each ring, gives the slope. The
    error is NaN unless the band is the default. Raises ImageError if the image is too small, constant, a plane, or not
    finite, or if the band contains fewer than three rings with waves.

    Parameters
    ----------
    image : ndarray of float32, float64 or integers (rows, columns)
        At least 32 x 32 pixels, any unit.
    band : tuple of float, optional
        Lowest and highest wavenumber, cycles per pixel, up to .5. Default: 3 cycles per shorter side to .15; in images
        of less than 160 pixels the upper end is 24 cycles per side, at most .25.
    """
    pixels = checked_image("image", image)
    side = min(pixels.shape)
    low, high = default_band(side) if band is None else band
    if not 0.0 < low < high <= 0.5:
        raise ImageError(f"band: {low} to {high} given, allowed: 0 < low < high <= 0.5 cycles per pixel")
    rows, columns = pixels.shape
    power, _ = Rings.windowed_power(pixels)
    wavenumber = np.hypot(fftfreq(rows)[:, None], rfftfreq(columns)).ravel()
    rings = max(3, round(_RINGS_PER_OCTAVE * math.log2(high / low)))
    inside = np.flatnonzero((wavenumber >= low) & (wavenumber < high))
    logs = np.log(wavenumber[inside])
    ring = ((logs - math.log(low)) * (rings / math.log(high / low))).astype(np.int64)
    ring = np.minimum(ring, rings - 1)
    # The FFT of a real image stores half the waves, but those along y in full.
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
    log_wavenumber = np.bincount(ring, share * logs, rings)[full] / waves[full]
    slope = float(np.polyfit(log_wavenumber, np.log(mean_power), 1, w=np.sqrt(waves[full]))[0])
    dimension = 4.0 + slope / 2.0
    error = estimator_calibration().standard_error("spectrum", dimension, side) if band is None else math.nan
    return DimensionEstimate(dimension, error, f"spectrum, {low:.3g} to {high:.3g} cycles per pixel")


# Fewer pairs do not constrain a slope.
_FEWEST_PAIRS = 100


def variogram_dimension(
    image: NDArray[Any], lags: Sequence[int] = (1, 2), mask: NDArray[np.bool_] | None = None
) -> DimensionEstimate:
    """Estimate D = 3 - slope / 2 from the slope of log semivariance against log lag.

    A self-affine surface with Hurst exponent H has the variogram |h|^(2 H) and D = 3 - H. The semivariances of both
    axes are averaged, and the slope is a least-squares fit. The result is not limited to 2 to 3: white noise is near 3,
    a smooth image near 2. The error applies to complete floating-point images with lags 1 and 2, for the number of
    pairs used; it is NaN for other lags. Raises ImageError if the image is too small, constant over the pairs, or not
    finite in used pixels, if there are fewer than 100 pairs at a lag, or if the lags do not differ.

    Parameters
    ----------
    image : ndarray of float32, float64 or integers (rows, columns)
        At least 32 x 32 pixels, any unit.
    lags : sequence of int
        Two or more different distances in pixels.
    mask : ndarray of bool (rows, columns), optional
        Only pairs with both pixels in the mask are used; default: all. Other pixels may be NaN.
    """
    pixels = checked_image("image", image)
    variogram = semivariances(pixels, lags, mask)
    if np.unique(variogram.lags).size < 2:
        raise ImageError(f"lags: {tuple(lags)} given, allowed: two or more different ones; closest is (1, 2)")
    pairs = variogram.pairs_x + variogram.pairs_y
    if pairs.min() < _FEWEST_PAIRS:
        lag = variogram.lags[pairs.argmin()]
        raise ImageError(f"mask: {pairs.min()} pairs of pixels at lag {lag}, allowed: {_FEWEST_PAIRS} or more")
    pooled = variogram.pooled
    if not np.all(pooled > 0.0):
        lag = variogram.lags[np.argmin(pooled > 0.0)]
        raise ImageError(f"image: semivariance 0 at lag {lag}, allowed: values that vary")
    slope = np.polyfit(np.log(variogram.lags.astype(np.float64)), np.log(pooled), 1)[0]
    listed = ", ".join(str(lag) for lag in variogram.lags)
    dimension = float(3.0 - slope / 2.0)
    if tuple(variogram.lags) == (1, 2):
        error = estimator_calibration().standard_error("variogram", dimension, math.sqrt(float(pairs.min()) / 2.0))
    else:
        error = math.nan
    return DimensionEstimate(dimension, error, f"variogram, lags {listed}")
