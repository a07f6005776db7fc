"""The shape of the clouds in an image in a few numbers, and how far two images differ in them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.errors import ImageError
from hcss_twin.evaluation.checks import checked_image, checked_mask, finite_range
from hcss_twin.evaluation.fractal_dimension.body import body_dimension
from hcss_twin.evaluation.fractal_dimension.boundary import boundary_dimension
from hcss_twin.evaluation.histogram_metrics import histogram_metrics, to_grey_levels
from hcss_twin.evaluation.semivariance import semivariances

# Lags of the two slopes and of the ratio of axes, pixels.
_LAGS = (1, 2)

# Fewer pairs of cloudy neighbours along an axis say nothing about a variogram.
_FEWEST_PAIRS = 100


@dataclass(frozen=True)
class Morphology:
    """Measures of a cloud image; the first four are those of Tables VIII and IX of the HCSS paper.

    Attributes
    ----------
    entropy : float
        EV, bits (eq 21).
    density : float
        Den (eq 22); the paper prints ten times it.
    diagonal_peak : float
        DP (eq 23); grows with the number of pixels.
    fractal_dimension : float
        FD as the paper seems to mean it: box counting of the body under the grey levels
        (``body_dimension``). Grows with coverage.
    coverage : float
        Cloudy part of the pixels.
    surface_dimension : float
        Fractal dimension D of the cloudy values, from the variogram at lags 1 and 2 of pairs of cloudy
        pixels, as ``variogram_dimension`` does it.
    boundary_dimension : float
        Fractal dimension of the mask's boundary; NaN where all is cloudy.
    anisotropy : float
        Semivariance along y over that along x, at equal lags (geometric mean over lags 1 and 2), over pairs
        of cloudy pixels: 1 where both axes are alike, greater where clouds are long along x.
    aspect : float
        Length along x over length along y at which values have changed by as much:
        anisotropy^(1 / (2 H)), H = 3 - surface_dimension, because semivariance grows as lag^(2 H). NaN where
        H is not greater than 0.05: neighbours as unlike as any two pixels have no length.
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


def morphology(values: NDArray[Any], mask: NDArray[np.bool_]) -> Morphology:
    """Measure the shape of the clouds in an image.

    Cloudy values become the grey levels 1 to 255, linearly between their least and greatest (the
    C_min and C_max of eq 7), and clear pixels level 0, as in Fig 14 of the HCSS paper.

    Parameters
    ----------
    values : ndarray of float32, float64 or integers (rows, columns)
        Anything that grows with cloud (thickness, cloud fraction value, radiance): at least 32 x 32
        pixels, any unit. Clear pixels may be anything, NaN included.
    mask : ndarray of bool (rows, columns)
        Cloudy pixels.

    Raises
    ------
    ImageError
        If no pixel is cloudy, cloudy values are not finite or all equal, an axis has fewer than 100
        pairs of cloudy pixels at lag 1 or 2, or one of them does not vary along an axis.
    """
    pixels = checked_image("values", values)
    cloudy = checked_mask("mask", mask, pixels.shape)
    counted = pixels[cloudy]
    if counted.size == 0:
        raise ImageError("mask: no pixel is cloudy, allowed: one or more cloudy pixels")
    finite_range("values (cloudy pixels)", counted)
    grey = to_grey_levels(pixels, float(counted.min()), float(counted.max()), mask=cloudy)
    histogram = histogram_metrics(grey)
    surface, anisotropy = _surface(pixels, cloudy)
    hurst = 3.0 - surface
    whole = counted.size == pixels.size
    return Morphology(
        entropy=histogram.entropy,
        density=histogram.density,
        diagonal_peak=histogram.diagonal_peak,
        fractal_dimension=body_dimension(grey).dimension,
        coverage=counted.size / pixels.size,
        surface_dimension=surface,
        boundary_dimension=math.nan if whole else boundary_dimension(cloudy).dimension,
        anisotropy=anisotropy,
        aspect=anisotropy ** (0.5 / hurst) if hurst > 0.05 else math.nan,
    )


def _surface(values: NDArray[Any], cloudy: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the surface dimension and the ratio of semivariances, y over x."""
    found = semivariances(values, _LAGS, cloudy)
    fewest = int(min(found.pairs_x.min(), found.pairs_y.min()))
    if fewest < _FEWEST_PAIRS:
        raise ImageError(
            f"mask: {fewest} pairs of cloudy pixels along an axis, allowed: {_FEWEST_PAIRS} or more"
        )
    if min(found.along_x.min(), found.along_y.min()) <= 0.0:
        raise ImageError(
            "values: cloudy values do not vary along an axis, allowed: values that vary along both"
        )
    ratio = math.exp(float(np.mean(np.log(found.along_y) - np.log(found.along_x))))
    first, second = np.log(found.pooled)
    return 3.0 - 0.5 * float(second - first) / math.log(2.0), ratio


def morphology_errors(true: Morphology, simulated: Morphology) -> MorphologyErrors:
    """Compare two images by eq 24 of the HCSS paper.

    Each error is |true - simulated| / simulated, with the simulated value in the denominator as
    printed, so that exchanging the images changes it. The RMSE is over EV, Den, DP and FD.

    Raises
    ------
    ImageError
        If a simulated value is 0, as the entropy of an image of one grey level is.
    """
    errors = {}
    for name in ("entropy", "density", "diagonal_peak", "fractal_dimension"):
        reference = getattr(simulated, name)
        if reference == 0.0:
            raise ImageError(f"simulated.{name}: 0 given, allowed: anything else, as eq 24 divides by it")
        errors[name] = abs(getattr(true, name) - reference) / abs(reference)
    rmse = math.sqrt(sum(error**2 for error in errors.values()) / len(errors))
    return MorphologyErrors(**errors, rmse=rmse)
