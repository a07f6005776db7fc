"""Detail below the pixel of an image, extrapolated from its octaves of 2 to 8 pixels.

The image is averaged to cells of 8, 4 and 2 pixels. The variance of cells about their parents falls from one octave to
the next by a factor that gives the exponent of the spectrum. The strength is the one with which the first halving of
the pixels of the example has the variance of its pixels about cells of 2 pixels, times this factor, even where that is
flatter than any exponent which is extrapolated: the spectrum has no step at the pixel. Give an image without its
sensor's blur; the mean over a pixel is part of the law.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcss_skies.detail import deviation_of, moments_of
from hcss_skies.example import DETAIL_STRENGTHS, Detail
from hcss_skies.fibres import textures
from hcss_skies.refining import MARGIN, refine
from hcss_twin.providers import Array

_SIDES = 8, 4, 2
"""Of cells, pixels."""

_LEAST_SIDE, _LEAST_COVER = 40, 0.02
"""Smallest image, pixels, and smallest share of pixels with cloud, for an error of a tenth."""

EXPONENTS = 5.0 / 3.0, 4.0
"""Exponents that are extrapolated: inside clouds the spectrum of turbulence is the flattest."""

BELOW = 2.2
"""Exponent below the pixel of flatter images: fields of small clouds are flat at pixels of 3 km, where clouds end, but
2.2 to 2.4 is measured below (a Landsat image at 30 m)."""

WEAKEST, STRONGEST = 0.34, 0.7
"""Strengths that are extrapolated; measured ones are .27 to .37; .34 leaves no
step across the pixel above 1.5 dB in the mean. Images whose spectrum is flat down to the pixel would
get .9 and more for a spectrum without a step, which looks like grain; or 0, where their edges alone have the variance
of the octave, and clouds would be smooth inside."""

_BISECTIONS = 12


def fit_detail(height: Array, cells: Array | None = None) -> Detail | None:
    """Return the detail of a field (rows, columns), 0 where clear; None with too little cloud or too few pixels.

    ``cells`` is the field of the example that is halved; default: ``height``. Thickness is taken as proportional to
    both. Values beyond the allowed ones are replaced by the closest.
    """
    level, halved = _level(height), _level(height if cells is None else cells)
    if min(level.shape) < _LEAST_SIDE or np.mean(level > 0.1) < _LEAST_COVER:
        return None
    coarse, middle, fine = (_averaged(level, side) for side in _SIDES)
    octaves = _octave(coarse, middle), _octave(middle, fine)
    if not min(octaves) > 0.0:
        return None
    image_exponent = 1.0 - math.log2(octaves[1] / octaves[0])
    exponent = min(image_exponent, EXPONENTS[1]) if image_exponent >= EXPONENTS[0] else BELOW
    wanted = _octave(_averaged(halved, 2), halved) * min(octaves[1] / octaves[0], 1.0)
    weakest = DETAIL_STRENGTHS[0] if image_exponent >= EXPONENTS[0] else WEAKEST
    low, high, fibres = weakest, STRONGEST, textures()
    for _ in range(_BISECTIONS):
        strength = 0.5 * (low + high)
        low, high = (strength, high) if _first_halving(halved, strength, exponent, fibres) < wanted else (low, strength)
    strength = STRONGEST if high == STRONGEST else 0.5 * (low + high)
    return Detail(WEAKEST if low == weakest == WEAKEST else strength, exponent)


def _level(field: Array) -> Array:
    """Return a field in parts of its 99th percentile, without what whole cells of 8 pixels do not cover."""
    rows, columns = (length // _SIDES[0] * _SIDES[0] for length in field.shape)
    level: Array = np.maximum(field[:rows, :columns], 0.0) / max(float(np.percentile(field, 99.0)), 1e-9)
    return level


def described(detail: Detail | None) -> str:
    """Return a sentence on the detail of an image.

    A spectrum k^-e along a line is that of a surface with fractal dimension (7 - e) / 2, for e of 1 to 3.
    """
    if detail is None:
        return "Too little cloud to estimate the detail below the pixel; `example` takes that of other images."
    dimension = f"{3.5 - 0.5 * detail.exponent:.2f}" if detail.exponent <= 3.0 else "2"
    limits = [
        " (limit of the extrapolation)" if limited else ""
        for limited in (detail.strength in (WEAKEST, STRONGEST), detail.exponent == EXPONENTS[1])
    ]
    if detail.exponent == BELOW:
        limits[1] = " (the image is flatter; this is that of other images below 3 km)"
    return (
        "Detail below the pixel, extrapolated from octaves of 2 to 8 pixels without the sensor's blur: strength "
        f"{detail.strength:.2f}{limits[0]}, exponent {detail.exponent:.2f}{limits[1]}, fractal dimension {dimension}."
    )


def _first_halving(level: Array, strength: float, exponent: float, fibres: NDArray[np.int16]) -> float:
    """Return the variance of the halves of pixels about the pixels."""
    children = np.empty((2 * level.shape[0] - 4 * MARGIN, 2 * level.shape[1] - 4 * MARGIN))
    most = 1.0001 * float(level.max())  # as in the generator, whose layer ends at the highest cloud of the example
    law = np.array([deviation_of(exponent, 0)])
    refine(children, level, np.zeros(2, np.int64), strength, law, most, 0.1, fibres, *moments_of([1], [math.nan]))
    return _octave(level[MARGIN:-MARGIN, MARGIN:-MARGIN], children)


def _octave(parents: Array, children: Array) -> float:
    """Return the mean squared deviation of children from their parents."""
    return float(np.mean((children - np.kron(parents, np.ones((2, 2)))) ** 2))


def _averaged(field: Array, side: int) -> Array:
    mean: Array = field.reshape(field.shape[0] // side, side, field.shape[1] // side, side).mean(axis=(1, 3))
    return mean
