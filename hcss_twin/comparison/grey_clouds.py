"""Grey levels of the clouds in one frame, as `hcss match` and the static scenes have them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.clouds.imagery.cloudiness import find_threshold
from hcss_twin.clouds.imagery.grey_levels import relative_grey, thickness_of
from hcss_twin.comparison.choice import EvaluationChoice, Method
from hcss_twin.comparison.footage import Array
from hcss_twin.errors import ImageError

LEVELS = (1.0, 255.0)
"""Of cloudy pixels."""

MEANINGS: dict[Method, str] = {
    "otsu": "Otsu's threshold of the frame's own histogram",
    "local": "the mean of the surroundings, between the sea's limit and Otsu's threshold",
    "coverage": "the cloudiest pixels, as many as --coverage asks for",
    "valid": "every pixel with a value",
    "truth": "the cube's own cloud mask",
}


def grey_clouds(
    values: Array, bright: bool, method: Method, choice: EvaluationChoice, truth: NDArray[np.bool_] | None
) -> NDArray[np.float32]:
    """Return the grey levels of a frame: 0 clear or missing, 1 to 255 cloudy, not rounded.

    Eq 7 of the HCSS paper: linear from the threshold (the least cloudy value, where the mask is no threshold) to the
    99.9th percentile of the cloudy pixels.

    Parameters
    ----------
    values : ndarray (rows, columns)
        NaN where missing.
    bright : bool
        Whether large values are cloud.
    method : str
        How cloud is found, not ``auto``.
    choice : EvaluationChoice
        Coverage and window.
    truth : ndarray of bool or None
        Cloud mask, for method ``truth``.

    Raises
    ------
    ImageError
        If there is no contrast or no cloud.
    """
    known = ~np.isnan(values)
    if not known.any():
        raise ImageError(f"all {values.size} pixels are missing")
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if low == high:
        raise ImageError(f"all pixels have the value {low:g}; clouds need a contrast")
    level = values if bright else -values
    if method == "truth":
        if truth is None:
            raise ImageError("method 'truth': there is no mask; allowed: another method")
        cloudy = truth & known
        lowest = float(level[cloudy].min()) if cloudy.any() else 0.0
    elif method == "valid":
        cloudy, lowest = known, float(np.nanmin(level))
    else:
        assert method != "auto"
        coverage = 0.5 if choice.coverage is None else choice.coverage
        try:
            threshold, lowest = find_threshold(level, method, choice.window_pixels, coverage, level)
        except ValueError as error:
            raise ImageError(f"method '{method}': {error}") from error
        cloudy = level > threshold
    if not cloudy.any():
        raise ImageError(f"no pixel is cloudy by the method '{method}'; allowed: another method or frame")
    grey = np.zeros(values.shape, dtype=np.float32)
    grey[cloudy] = thickness_of(relative_grey(level[cloudy], lowest), *LEVELS)
    return grey
