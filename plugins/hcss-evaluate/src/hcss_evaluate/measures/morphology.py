"""Cloud morphology of an image in a few numbers, and eq 24 of the HCSS paper, which compares two images."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_evaluate.measures.box_counting import body_dimension, boundary_dimension
from hcss_evaluate.measures.checks import checked_mask, complete_part, range_within
from hcss_evaluate.measures.histogram_metrics import histogram_metrics, to_grey_levels
from hcss_evaluate.measures.images import SMALLEST_SIDE, checked_image
from hcss_evaluate.measures.semivariance import semivariances
from hcss_twin.providers import Array, ImageError


def relative_errors(real: Sequence[float], simulated: Sequence[float]) -> tuple[float, ...]:
    """Return the errors of eq 24, |real - simulated| / |simulated|, as fractions.

    Parameters
    ----------
    real, simulated : sequence of float
        The same metrics of both images; no simulated value may be 0. Exchange the images for errors relative to the
        real values.
    """
    return tuple(abs(one - other) / abs(other) for one, other in zip(real, simulated, strict=True))


def root_mean_square(errors: Sequence[float]) -> float:
    """Return the RMSE of eq 24, in the unit of the errors."""
    return math.sqrt(sum(error**2 for error in errors) / len(errors))


# Lags in pixels for the slope and the anisotropy: the shortest possible.
_SHORT_LAGS = 2

# Number of semivariances, common to both axes, at which the ratio of lengths is evaluated; they must span a factor of
# 1.1.
_LEVELS = 9
_NARROWEST = math.log(1.1)

# Fewer pairs of cloudy neighbours along an axis do not constrain a variogram.
_FEWEST_PAIRS = 100


@dataclass(frozen=True)
class Morphology:
    """Metrics of a cloud image; the first four are those of Tables VIII and IX of the HCSS paper.

    Attributes
    ----------
    entropy : float
        EV, bits (eq 21).
    density : float
        Den (eq 22); the paper prints ten times this value.
    diagonal_peak : float
        DP (eq 23); grows with the number of pixels.
    fractal_dimension : float
        FD as the paper probably defines it: box counting of the body below the grey levels (``body_dimension``). It
        grows with coverage.
    coverage : float
        Fraction of cloudy pixels.
    surface_dimension : float
        Fractal dimension D of the cloudy values, from the variogram of pairs of cloudy pixels at lags 1 and 2
        (``variogram_dimension``).
    boundary_dimension : float
        Fractal dimension of the mask boundary; NaN if all counted pixels are cloudy or all are clear.
    anisotropy : float
        Ratio of the semivariance along y to that along x (geometric mean over lags 1 and 2) for pairs of cloudy pixels:
        1 if both axes are alike, greater if clouds are elongated along x.
    aspect : float
        Ratio of the correlation lengths along x and y: the geometric mean of the ratio of the lags at which the
        variograms along x and y have equal semivariance, over the semivariances common to both at lags 1, 2, 4, ... up
        to an eighth of the shorter side. For a field f(x / a, y / b) it is a / b. NaN if they have no common range, as
        for white noise.
    """

    entropy: float
    density: float
    diagonal_peak: float
    fractal_dimension: float
    coverage: float
    surface_dimension: float
    boundary_dimension: float
    anisotropy: float
    aspect: float


@dataclass(frozen=True)
class MorphologyErrors:
    """Relative errors of eq 24, as fractions, and their root mean square."""

    entropy: float
    density: float
    diagonal_peak: float
    fractal_dimension: float
    rmse: float


def morphology(values: NDArray[Any], mask: NDArray[np.bool_], valid: NDArray[np.bool_] | None = None) -> Morphology:
    """Measure the shape of the clouds in an image.

    Cloudy values are mapped linearly to grey levels 1 to 255 between their minimum and maximum (C_min and C_max of eq
    7), and clear pixels to level 0, as in Fig 14 of the HCSS paper. Raises ImageError if no pixel is cloudy, cloudy
    values are not finite or all equal, an axis has fewer than 100 pairs of cloudy pixels or no variation at lag 1 or 2,
    or there is no 32 x 32 rectangle without missing pixels.

    Parameters
    ----------
    values : ndarray of float32, float64 or integers (rows, columns)
        Any quantity that increases with cloud (thickness, cloud fraction value, radiance): at least 32 x 32 pixels, any
        unit. Clear pixels may have any value, including NaN.
    mask : ndarray of bool (rows, columns)
        Cloudy pixels.
    valid : ndarray of bool (rows, columns), optional
        Pixels that are not missing; default: all. Pairs of neighbours are used if both are valid, coverage refers to
        the valid pixels, and boxes are counted in the largest rectangle without missing pixels.
    """
    pixels = checked_image("values", values)
    cloudy = checked_mask("mask", mask, pixels.shape)
    known = np.ones(pixels.shape, np.bool_) if valid is None else checked_mask("valid", valid, pixels.shape)
    cloudy = cloudy & known
    count = int(np.count_nonzero(cloudy))
    if count == 0:
        raise ImageError("mask: no pixel is cloudy, allowed: one or more cloudy pixels")
    low, high = range_within("values", pixels, cloudy)
    if low == high:
        raise ImageError(f"values: all cloudy pixels are {low:g}, allowed: values that vary")
    grey = to_grey_levels(pixels, low, high, mask=cloudy)
    histogram = histogram_metrics(grey, valid=known)
    surface, anisotropy, aspect = _surface(pixels, cloudy)
    whole = complete_part(known)
    boxes, outlined = grey[whole], cloudy[whole]
    if min(boxes.shape) < SMALLEST_SIDE:
        rows, columns = boxes.shape
        raise ImageError(
            f"valid: the largest part without missing pixels has {rows} x {columns}, allowed: {SMALLEST_SIDE} or "
            "more along each axis"
        )
    return Morphology(
        entropy=histogram.entropy,
        density=histogram.density,
        diagonal_peak=histogram.diagonal_peak,
        fractal_dimension=body_dimension(boxes).dimension,
        coverage=count / int(np.count_nonzero(known)),
        surface_dimension=surface,
        boundary_dimension=boundary_dimension(outlined).dimension
        if outlined.any() and not outlined.all()
        else math.nan,
        anisotropy=anisotropy,
        aspect=aspect,
    )


def _surface(values: NDArray[Any], cloudy: NDArray[np.bool_]) -> tuple[float, float, float]:
    """Return the surface dimension, the ratio of semivariances (y to x), and the ratio of lengths (x to y)."""
    lags = [1, 2]
    while 2 * lags[-1] <= min(values.shape) // 8:
        lags.append(2 * lags[-1])
    measured = semivariances(values, lags, cloudy)
    pairs = np.minimum(measured.pairs_x, measured.pairs_y)
    short = slice(0, _SHORT_LAGS)
    if pairs[short].min() < _FEWEST_PAIRS:
        raise ImageError(
            f"mask: {pairs[short].min()} pairs of cloudy pixels along an axis, allowed: {_FEWEST_PAIRS} or more"
        )
    if min(measured.along_x[short].min(), measured.along_y[short].min()) <= 0.0:
        raise ImageError("values: cloudy values do not vary along an axis, allowed: values that vary along both")
    along_x, along_y = (
        np.log(axis[: np.argmin(np.append(pairs >= _FEWEST_PAIRS, False))])
        for axis in (measured.along_x, measured.along_y)
    )
    ratio = math.exp(float(np.mean(along_y[short] - along_x[short])))
    first, second = np.log(measured.pooled[short])
    dimension = 3.0 - 0.5 * float(second - first) / math.log(2.0)
    return dimension, ratio, _ratio_of_lengths(along_x, along_y)


def _ratio_of_lengths(along_x: Array, along_y: Array) -> float:
    """Return the mean ratio of lags with equal semivariance, from its logarithms at lags 1, 2, 4, ..."""
    # Where a variogram decreases because of sampling noise, it is held constant, so that it can be inverted.
    rising_x, rising_y = np.maximum.accumulate(along_x), np.maximum.accumulate(along_y)
    low, high = max(rising_x[0], rising_y[0]), min(rising_x[-1], rising_y[-1])
    if high - low < _NARROWEST:
        return math.nan
    octave = np.arange(rising_x.size, dtype=np.float64)
    shared = np.linspace(low, high, _LEVELS)
    shift = np.interp(shared, rising_x, octave) - np.interp(shared, rising_y, octave)
    return float(2.0 ** np.mean(shift))


def morphology_errors(true: Morphology, simulated: Morphology) -> MorphologyErrors:
    """Compare two images by eq 24 of the HCSS paper.

    Each error is |true - simulated| / simulated, with the simulated value in the denominator as printed, so that
    exchanging the images changes it. The RMSE is over EV, Den, DP and FD.

    Raises ImageError if a simulated value is 0, such as the entropy of an image with a single grey level.
    """
    names = ("entropy", "density", "diagonal_peak", "fractal_dimension")
    for name in names:
        if getattr(simulated, name) == 0.0:
            raise ImageError(f"simulated.{name}: 0 given, allowed: anything else, as eq 24 divides by it")
    errors = relative_errors([getattr(true, name) for name in names], [getattr(simulated, name) for name in names])
    return MorphologyErrors(**dict(zip(names, errors, strict=True)), rmse=root_mean_square(errors))
