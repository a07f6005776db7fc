"""Everything that is measured in one image."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.analysis.measures.checks import complete_part
from hcss_twin.analysis.measures.definitions import GREY_LEVELS
from hcss_twin.analysis.measures.fractal_dimension.box_counting import box_counting_dimension
from hcss_twin.analysis.measures.fractal_dimension.estimate import DimensionEstimate
from hcss_twin.analysis.measures.fractal_dimension.slopes import spectral_dimension, variogram_dimension
from hcss_twin.analysis.measures.morphology import Morphology, morphology
from hcss_twin.analysis.measures.power_spectrum import PowerSpectrum, power_spectrum
from hcss_twin.core.errors import ImageError


@dataclass(frozen=True)
class ImageMeasures:
    """What one image is like.

    Attributes
    ----------
    morphology : Morphology
        Of the clouds.
    equal_neighbours : float
        Share of horizontal neighbours of equal grey level: DP without the number of pixels.
    mean_level : float
        Mean grey level of cloudy pixels, 1 to 255.
    mean, deviation : float
        Of all values, in their unit.
    dimensions : dict of str to DimensionEstimate
        Of all values, sea and cloud: "variogram", "spectrum", "box counting" (calibrated) and "box counting, raw".
    spectrum : PowerSpectrum or None
        Of all values.
    left_out : tuple of str
        What does not apply to this image, and why.
    """

    morphology: Morphology
    equal_neighbours: float
    mean_level: float
    mean: float
    deviation: float
    dimensions: dict[str, DimensionEstimate]
    spectrum: PowerSpectrum | None
    left_out: tuple[str, ...]


def measure_image(values: NDArray[np.float64], level: NDArray[np.float32], known: NDArray[np.bool_]) -> ImageMeasures:
    """Measure an image of values and the grey levels of its clouds.

    Parameters
    ----------
    values : ndarray of float64 (rows, columns)
        Any unit; NaN where there is none. At least 32 x 32 pixels.
    level : ndarray of float32 (rows, columns)
        Grey level: 0 where clear or missing, 1 to 255 where cloudy.
    known : ndarray of bool (rows, columns)
        Whether a pixel is known to be cloudy or clear; others count for nothing.

    Raises
    ------
    ImageError
        If the clouds cannot be measured (see ``morphology``).
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
        found = _or_reason(estimate, f"dimension by {name}", left_out)
        if found is not None:
            dimensions[name] = found
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
    """Return what is measured, or None and keep the reason."""
    try:
        return measure()
    except ImageError as error:
        left_out.append(f"{name}: {error}")
        return None
