"""Detail below the pixel of an image, extrapolated from its octaves of 2 to 8 pixels.

The halvings of :mod:`hcss_skies.detail` are undone: the image is averaged to cells of 8, 4 and 2 pixels. Inside clouds,
the variance of cells about their parents falls by 2^(1 - exponent) per octave. The logarithm of cells over the plane
through their parents' neighbours has the variance that a halving adds, in units of the steepness there: in 22 SEVIRI
images it is the same at all three sizes, so that it is taken to be the same below the pixel. Give an image without its
sensor's blur; the mean over a pixel is part of the law.
"""

from __future__ import annotations

import math

import numpy as np

from hcss_skies.detail import FLOOR, steepness
from hcss_skies.example import DETAIL_STRENGTHS, Detail
from hcss_twin.providers import Array

_SIDES = 8, 4, 2
"""Of cells, pixels."""

_FEWEST_CELLS = 20
"""Cells of 8 pixels inside clouds, for an error of a tenth."""

EXPONENTS = 5.0 / 3.0, 4.0
"""Exponents that are extrapolated. Fields of small cumulus are flatter at pixels of 3 km, where clouds end; inside
clouds the spectrum of turbulence is the flattest."""

# Thinner cells, in parts of the 99th percentile, are edges or clear sky, whose logarithms tell of noise.
_LEAST = 0.3

# In skies of known detail exponents of 1.6, 2.3 and 3.0 appear as 1.51, 1.87 and 2.27, because planes through
# neighbours carry detail on, and strengths a tenth too small.
_AT, _GAIN, _STRONGER = 1.4, 1.84, 1.1


def fit_detail(height: Array) -> Detail | None:
    """Return the detail of a field (rows, columns), 0 where clear; None with too little cloud or too few pixels.

    Thickness is taken as proportional to ``height``. Values beyond the allowed ones are replaced by the closest.
    """
    rows, columns = (length // _SIDES[0] * _SIDES[0] for length in height.shape)
    if min(rows, columns) < 5 * _SIDES[0]:
        return None
    level = np.maximum(height[:rows, :columns], 0.0) / max(float(np.percentile(height, 99.0)), 1e-9)
    coarse, middle, fine = (_averaged(level, side) for side in _SIDES)
    squares = _squared_logarithms(coarse, middle), _squared_logarithms(middle, fine)
    steep = steepness(coarse), steepness(middle)
    logarithms, weight = 0.0, 0.0
    for square, slope in zip(squares, steep, strict=True):
        known = np.isfinite(square)
        logarithms += float(np.sum(square[known]))
        weight += float(np.sum(slope[known] + FLOOR))
    # Both octaves of the same places, inside clouds.
    inside = np.isfinite(squares[0])
    octaves = _deviations(coarse, middle)[1:-1, 1:-1], _averaged(_deviations(middle, fine), 2)[1:-1, 1:-1]
    variances = [float(np.sum(each[inside])) for each in octaves]
    cells = int(inside.sum())
    if cells < _FEWEST_CELLS or not min(variances) > 0.0:
        return None
    exponent = 1.0 - math.log2(variances[1] / variances[0])
    exponent = float(np.clip(_AT + _GAIN * (exponent - _AT), *EXPONENTS))
    strength = _STRONGER * math.sqrt(logarithms / weight / (1.0 - 2.0 ** (1.0 - exponent)))
    return Detail(float(np.clip(strength, *DETAIL_STRENGTHS)), exponent)


def _averaged(field: Array, side: int) -> Array:
    mean: Array = field.reshape(field.shape[0] // side, side, field.shape[1] // side, side).mean(axis=(1, 3))
    return mean


def _deviations(parents: Array, children: Array) -> Array:
    """Return the mean squared deviation of children, by parent."""
    return _averaged((children - np.kron(parents, np.ones((2, 2)))) ** 2, 2)


def _squared_logarithms(parents: Array, children: Array) -> Array:
    """Return the mean squared logarithm of children over a smooth field, by inner parent; NaN where it is thin."""
    slope_y = 0.125 * (parents[2:, 1:-1] - parents[:-2, 1:-1])
    slope_x = 0.125 * (parents[1:-1, 2:] - parents[1:-1, :-2])
    middle = parents[1:-1, 1:-1]
    lowest = np.full(middle.shape, np.inf)
    logarithms = []
    for up in (0, 1):
        for right in (0, 1):
            child = children[2 + up : -2 : 2, 2 + right : -2 : 2]
            smooth = middle + (2.0 * up - 1.0) * slope_y + (2.0 * right - 1.0) * slope_x
            lowest = np.minimum(lowest, np.minimum(child, smooth))
            logarithms.append(np.log(np.maximum(child, 1e-9) / np.maximum(smooth, 1e-9)))
    values = np.stack(logarithms)
    square: Array = np.mean((values - values.mean(axis=0)) ** 2, axis=0)
    return np.where(lowest > _LEAST, square, np.nan)
