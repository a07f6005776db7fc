"""Fractal dimension by differential box counting of an 8-bit image."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hcss_twin.errors import ImageError
from hcss_twin.evaluation.checks import checked_image
from hcss_twin.evaluation.fractal_dimension.estimate import DimensionEstimate


def box_counting_dimension(image: NDArray[Any], levels: int = 256, calibrated: bool = True) -> DimensionEstimate:
    """Estimate D = d log N / d log(1 / s), N the boxes of side s that the grey surface passes through.

    N. Sarkar and B. B. Chaudhuri, "An efficient differential box-counting approach to compute
    fractal dimension of image", IEEE Trans. Syst. Man Cybern. 24, 115-120 (1994)

    Raises
    ------
    ImageError
    """
    pixels = checked_image("image", image)
    if not 2 <= levels <= 256:
        raise ImageError(f"levels: {levels} given, allowed: 2 to 256; closest is {min(max(2, levels), 256)}")
    raise NotImplementedError
