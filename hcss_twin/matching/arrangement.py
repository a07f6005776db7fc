"""Properties of an image that no parameter of the fractal field changes."""

from __future__ import annotations

import math

import numpy as np

from hcss_twin.matching.cloud_image import CloudImage

# Diagonal steps of these many pixels along x and y.
_STEPS = (2, 4, 8)


def obliqueness(image: CloudImage) -> float:
    """Return the ratio of mean square differences along the two diagonals, at least 1.

    1 where clouds are stretched along x or y, or not at all: the lattices of eq 2 are. Geometric mean
    over diagonal steps of 2, 4 and 8 pixels.
    """
    level = image.level.astype(np.float64)
    ratios = []
    for step in _STEPS:
        rising = np.mean((level[step:, step:] - level[:-step, :-step]) ** 2)
        falling = np.mean((level[:-step, step:] - level[step:, :-step]) ** 2)
        ratios.append(math.log(rising / falling))
    return math.exp(abs(float(np.mean(ratios))))


def unevenness(image: CloudImage) -> float:
    """Return the standard deviation of the coverage among the four quarters of an image.

    The field is stationary; a storm or a front that fills a corner is not.
    """
    cloudy = image.cloudy
    rows, columns = cloudy.shape
    quarters = [
        part.mean()
        for half in (cloudy[: rows // 2], cloudy[rows // 2 :])
        for part in (half[:, : columns // 2], half[:, columns // 2 :])
    ]
    return float(np.std(quarters))
