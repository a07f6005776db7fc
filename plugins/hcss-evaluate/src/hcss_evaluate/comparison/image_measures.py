"""Measures of an image, of the temporal change in a sequence, and of the distance between two images' values."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.comparison.definitions import GREY_LEVELS
from hcss_evaluate.measures.box_counting import box_counting_dimension
from hcss_evaluate.measures.checks import complete_part
from hcss_evaluate.measures.fractal_dimension import DimensionEstimate, spectral_dimension, variogram_dimension
from hcss_evaluate.measures.morphology import Morphology, morphology
from hcss_evaluate.measures.power_spectrum import PowerSpectrum, power_spectrum
from hcss_twin.providers import Array, ImageError


@dataclass(frozen=True)
class ImageMeasures:
    """All measures of one image.

    Attributes
    ----------
    morphology : Morphology
        Morphology of the clouds.
    equal_neighbours : float
        Fraction of horizontal neighbours with equal grey levels: DP normalised by the number of pixels.
    mean_level : float
        Mean grey level of cloudy pixels, 1 to 255.
    mean, deviation : float
        Mean and standard deviation of all values, in their unit.
    dimensions : dict of str to DimensionEstimate
        Fractal dimensions of all values, sea and cloud, by "variogram", "spectrum", "box counting" (calibrated) and
        "box counting, raw".
    spectrum : PowerSpectrum or None
        Of all values.
    left_out : tuple of str
        Measures that do not apply to this image, and the reasons.
    """

    morphology: Morphology
    equal_neighbours: float
    mean_level: float
    mean: float
    deviation: float
    dimensions: dict[str, DimensionEstimate]
    spectrum: PowerSpectrum | None
    left_out: tuple[str, ...]


def measure_image(values: Array, level: NDArray[np.float32], known: NDArray[np.bool_]) -> ImageMeasures:
    """Measure an image of values and the grey levels of its clouds.

    ``values`` (rows, columns), at least 32 x 32, have any unit and are NaN where missing; ``level`` is 0 where clear or
    missing and 1 to 255 where cloudy; pixels not ``known`` to be cloudy or clear are excluded. Raises ImageError if the
    clouds cannot be measured (see ``morphology``).
    """
    valid = ~np.isnan(values)
    shape = morphology(level, level > 0.0, known)
    pairs = int(np.count_nonzero(known[:, :-1] & known[:, 1:]))
    whole = complete_part(valid)
    full = values[whole]
    left_out: list[str] = []
    dimensions: dict[str, DimensionEstimate] = {}
    estimators: tuple[tuple[str, Callable[[], DimensionEstimate]], ...] = (
        ("variogram", lambda: variogram_dimension(np.where(valid, values, 0.0), mask=valid)),
        ("spectrum", lambda: spectral_dimension(full)),
        ("box counting", lambda: box_counting_dimension(full)),
        ("box counting, raw", lambda: box_counting_dimension(full, calibrated=False)),
    )
    for name, estimate in estimators:
        dimension = _or_reason(estimate, f"dimension by {name}", left_out)
        if dimension is not None:
            dimensions[name] = dimension
    return ImageMeasures(
        morphology=shape,
        equal_neighbours=shape.diagonal_peak * (GREY_LEVELS - 1) / pairs,
        mean_level=float(np.mean(level[level > 0.0], dtype=np.float64)),
        mean=float(np.mean(values[valid])),
        deviation=float(np.std(values[valid])),
        dimensions=dimensions,
        spectrum=_or_reason(lambda: power_spectrum(full), "power spectrum", left_out),
        left_out=tuple(left_out),
    )


def _or_reason(measure: Callable[[], Any], name: str, left_out: list[str]) -> Any:
    """Return the measurement, or None and record the reason."""
    try:
        return measure()
    except ImageError as error:
        left_out.append(f"{name}: {error}")
        return None


@dataclass(frozen=True)
class TemporalAutocorrelation:
    """Correlation of images as a function of their lag in frames.

    For each ``lag`` in frames (L,), 0, 1, 2, ...: the mean time difference in seconds, NaN if times are unknown; the
    mean correlation over all pairs of images at this lag; and the number of these pairs, which is small at long lags.
    ``pixels`` is the number of pixels used.
    """

    lag: NDArray[np.int64]
    lag_s: Array
    correlation: Array
    pairs: NDArray[np.int64]
    pixels: int

    @property
    def decorrelation_s(self) -> float:
        """Time after which the correlation falls below 1/e, interpolated linearly between lags.

        NaN if it never does, or if it already has in the second image: the images do not resolve the time.
        """
        after = self._first_below
        if after < 2 or np.isnan(self.lag_s).any():
            return math.nan
        ends = slice(after - 1, after + 1)
        return float(np.interp(-1.0 / math.e, -self.correlation[ends], self.lag_s[ends]))

    @property
    def is_unresolved(self) -> bool:
        """Whether the correlation is below 1/e in the second image already."""
        return self._first_below == 1

    @property
    def _first_below(self) -> int:
        below = np.flatnonzero(self.correlation < 1.0 / math.e)
        return int(below[0]) if below.size else 0


def temporal_autocorrelation(frames: NDArray[Any], seconds: Array | None = None) -> TemporalAutocorrelation:
    """Correlate images (T, rows, columns) with later ones at fixed pixels; ``seconds`` (T,) are their times, ascending.

    Two images are correlated pixel by pixel after subtracting the mean of each; pixels that are NaN in any image are
    excluded. Motion through the field of view (wind, platform) reduces the correlation just as change does. Raises
    ImageError if there are fewer than two images, no pixel has values in all, or an image is constant.
    """
    count = frames.shape[0]
    if frames.ndim != 3 or count < 2:
        raise ImageError(f"frames: shape {frames.shape} given, allowed: (T, rows, columns) with T of 2 or more")
    flat = frames.reshape(count, -1).astype(np.float64)
    flat = flat[:, ~np.isnan(flat).any(axis=0)]
    if flat.shape[1] < 2:
        raise ImageError("frames: no two pixels have values in all images, allowed: some")
    flat -= flat.mean(axis=1, keepdims=True)
    length = np.sqrt(np.einsum("ij,ij->i", flat, flat))
    if length.min() == 0.0:
        raise ImageError(f"frames: image {int(length.argmin())} is constant, allowed: values that vary")
    flat /= length[:, None]
    # Rounding must not produce a correlation above 1.
    matrix = np.clip(flat @ flat.T, -1.0, 1.0)
    lag = np.arange(count)
    correlation = np.array([1.0, *(float(np.mean(np.diagonal(matrix, n))) for n in lag[1:])])
    times = np.full(count, np.nan) if seconds is None else np.asarray(seconds, dtype=np.float64)
    lag_s = np.array([float(np.mean(times[n:] - times[: count - n])) for n in lag])
    return TemporalAutocorrelation(lag, lag_s, correlation, count - lag, flat.shape[1])


@dataclass(frozen=True)
class DistributionDistance:
    """Differences between two distributions of values.

    Attributes
    ----------
    mean_difference : float
        Mean of the second minus mean of the first, in the unit of the values.
    deviation_ratio : float
        Standard deviation of the second divided by that of the first.
    wasserstein : float
        Wasserstein distance W1 (mean change that turns one distribution into the other), in the unit of the values.
    wasserstein_centred : float
        W1 after subtracting both means, which measures the difference in shape.
    kolmogorov_smirnov : float
        Maximum difference between the cumulative distributions, 0 to 1.
    """

    mean_difference: float
    deviation_ratio: float
    wasserstein: float
    wasserstein_centred: float
    kolmogorov_smirnov: float


def distribution_distance(first: NDArray[Any], second: NDArray[Any]) -> DistributionDistance:
    """Compare the values of two images.

    Raises ImageError if one has no value.

    Parameters
    ----------
    first, second : ndarray of real numbers, any shapes
        Values in the same unit; NaN where missing.
    """
    one, other = _sorted("first", first), _sorted("second", second)
    mean_one, mean_other = float(np.mean(one)), float(np.mean(other))
    spread_one, spread_other = float(np.std(one)), float(np.std(other))
    width, difference = _cumulative_difference(one, other)
    centred_width, centred = _cumulative_difference(one - mean_one, other - mean_other)
    ratio = spread_other / spread_one if spread_one else (1.0 if spread_other == 0.0 else math.inf)
    return DistributionDistance(
        mean_difference=mean_other - mean_one,
        deviation_ratio=ratio,
        wasserstein=float(width @ difference),
        wasserstein_centred=float(centred_width @ centred),
        kolmogorov_smirnov=float(difference.max()) if difference.size else 0.0,
    )


def _sorted(name: str, values: NDArray[Any]) -> Array:
    flat = np.asarray(values, dtype=np.float64).ravel()
    flat = np.sort(flat[~np.isnan(flat)])
    if flat.size == 0:
        raise ImageError(f"{name}: no value given, allowed: one or more that are not missing")
    return flat


def _cumulative_difference(one: Array, other: Array) -> tuple[Array, Array]:
    """Return the steps between sorted values, and |F1 - F2| on each; one sort is used for both distances."""
    every = np.concatenate([one, other])
    every.sort(kind="stable")
    places = every[:-1]
    difference: Array = np.abs(
        np.searchsorted(one, places, side="right") / one.size
        - np.searchsorted(other, places, side="right") / other.size
    )
    return np.diff(every), difference
