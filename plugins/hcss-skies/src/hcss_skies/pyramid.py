"""What blending samples: normal scores of an example at one pixel size, and the heights that belong to them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import zoom
from scipy.signal import fftconvolve
from scipy.special import ndtr, ndtri

from hcss_skies.blending import CUT
from hcss_skies.example import MAX_SCORE, Example
from hcss_twin.providers import Array

LATTICE_PIXELS = 112.0
"""Largest distance of lattice points in pixels of the example: patches twice as wide keep the shapes of clouds."""

_OF_SIDE = 0.3125
"""Largest distance in parts of the shorter side. Wider patches of a small example all show its middle: a sky repeats
itself like wallpaper, which a classifier of patches of 64 pixels does not see."""

LONG = 1.8
"""Wavelength in lattice distances beyond which patches have too little variance."""

_KEPT = 0.46
"""Part of it that blended skies have (mean over 11 SEVIRI blocks)."""

KNOTS = 1025
"""Entries of the table of heights, evenly spaced in the score: 0.008 standard deviations."""

_MIN_LEVEL_SIDE = 4


@dataclass(frozen=True)
class Level:
    """An example at one pixel size.

    Attributes
    ----------
    scores : ndarray of float32 (2 rows, 2 columns, 2)
        Normal scores of p and x between the pixels, too, so that bilinear interpolation hardly blurs.
    heights_m : ndarray of float32 (1025, 2)
        p and x in m at scores from -4 to 4.
    scale : int
        Side of a pixel in pixels of the example, a power of two.
    spacing : float
        Distance of lattice points in pixels of the example.
    first, span : (float, float)
        Smallest and range of the position (y, x) of a patch's centre, in pixels of the example.
    long, of_excess : float
        Standard deviation of the waves that are added to the score of p because patches have none of that length, and
        their part in the score of x.
    """

    scores: NDArray[np.float32]
    heights_m: NDArray[np.float32]
    scale: int
    spacing: float
    first: tuple[float, float]
    span: tuple[float, float]
    long: float
    of_excess: float


def make_level(example: Example, pixel_size_m: float) -> Level:
    """Return the example for an image of this pixel size: averaged to the closest power of two, never refined."""
    rows, columns = example.opaque.shape
    most = int(math.log2(min(rows, columns) / _MIN_LEVEL_SIDE))
    scale = 1 << max(0, min(most, round(math.log2(pixel_size_m / example.pixel_size_m))))
    spacing = min(LATTICE_PIXELS, min(rows, columns) * _OF_SIDE)
    # A patch reaches one spacing from its centre along x, and sqrt(3) / 2 of it along y, less what is cut off.
    reach = 0.5 * math.sqrt(3.0) * (1.0 - CUT) * spacing, (1.0 - CUT) * spacing
    span = rows - 2.0 * reach[0], columns - 2.0 * reach[1]
    heights = [table[ranks] for ranks, table in _fields(example)]
    if scale > 1:
        heights = [_averaged(height, scale) for height in heights]
    usage = _usage(heights[0].shape, spacing / scale, (span[0] / scale, span[1] / scale))
    pairs = [_scored(height, usage) for height in heights]
    scores = [score for score, _ in pairs]
    long = math.sqrt(_missing(scores[0], LONG * spacing / scale))
    together = float(np.average(scores[0] * scores[1], weights=usage))
    for score, part in zip(scores, (long, together * long), strict=True):
        score *= math.sqrt(1.0 - part**2)
    return Level(
        np.ascontiguousarray(np.stack([_doubled(score) for score, _ in pairs], axis=-1)),
        np.ascontiguousarray(np.stack([table for _, table in pairs], axis=-1), dtype=np.float32),
        scale, spacing, reach, span, long, together,
    )  # fmt: skip


def _missing(score: Array, longest: float) -> float:
    """Return the part of the variance that waves longer than ``longest`` pixels lack in a blended field."""
    rows, columns = score.shape
    waves = np.fft.rfft2((score - score.mean()) * np.outer(np.hanning(rows), np.hanning(columns)))
    power = np.abs(waves) ** 2
    power[:, 1:] *= 2.0
    power[0, 0] = 0.0
    below = np.add.outer(np.fft.fftfreq(rows) ** 2, np.fft.rfftfreq(columns) ** 2) * longest**2 < 1.0
    share = float(power[below].sum() / max(power.sum(), 1e-30))
    return (1.0 - _KEPT) * share / (1.0 - _KEPT * share)


def _fields(example: Example) -> tuple[tuple[NDArray[np.uint8], Array], ...]:
    # Ranks with equal heights stay apart: their order has a meaning, and the score needs no plateau.
    rise = np.arange(example.opaque_m.size) * 1e-6
    return (example.opaque, example.opaque_m + rise), (example.excess, example.excess_m + rise)


def _averaged(height: Array, scale: int) -> Array:
    rows, columns = (side // scale * scale for side in height.shape)
    blocks = height[:rows, :columns].reshape(rows // scale, scale, columns // scale, scale)
    mean: Array = blocks.mean(axis=(1, 3))
    return mean


def _usage(shape: tuple[int, ...], spacing: float, span: tuple[float, float]) -> Array:
    """Return how much each pixel contributes to the variance of a blended field, (rows, columns).

    Patches lie within the example, so that pixels at its border are used less often. Scores weighted by usage make the
    distribution of the blended field that of the example nevertheless.
    """
    half = [math.ceil(spacing)] * 2
    y, x = np.mgrid[-half[0] : half[0] + 1, -half[1] : half[1] + 1] / spacing
    hats = [
        _hat(y - 0.5 * math.sqrt(3.0) * row, x - column - 0.5 * row) ** 4
        for row in range(-2, 3)
        for column in range(-3, 4)
    ]
    share = _hat(y, x) ** 4 / np.maximum(np.sum(hats, axis=0), 1e-12)
    centres = [np.arange(side) + 0.5 - 0.5 * side for side in shape]
    box = [np.clip(0.5 * length + 0.5 - np.abs(centre), 0.0, 1.0) for centre, length in zip(centres, span, strict=True)]
    usage = np.maximum(fftconvolve(np.outer(*box), share, mode="same"), 0.0)
    result: Array = np.maximum(usage, 1e-4 * usage.max())
    return result


def _hat(y: Array, x: Array) -> Array:
    """Return the weight of the lattice point at the origin: linear on triangles of side 1, cut off."""
    v = y * (2.0 / math.sqrt(3.0))
    u = x - 0.5 * v
    hat: Array = np.clip(1.0 - CUT - np.maximum(np.maximum(np.abs(u), np.abs(v)), np.abs(u + v)), 0.0, None)
    return hat


def _scored(height: Array, usage: Array) -> tuple[Array, Array]:
    """Return normal scores by usage (rows, columns), and the heights (1025,) at scores by the plain distribution."""
    if height.min() == height.max():
        return np.zeros(height.shape), np.full(KNOTS, float(height.flat[0]))
    values, member = np.unique(height, return_inverse=True)
    weight = np.bincount(member.ravel(), usage.ravel())
    score = ndtri((np.cumsum(weight) - 0.5 * weight) / weight.sum())[member].reshape(height.shape)
    # Quantisation and flat tails change the variance by a percent.
    mean = np.average(score, weights=usage)
    score = (score - mean) / max(math.sqrt(np.average((score - mean) ** 2, weights=usage)), 1e-9)
    counts = np.bincount(member.ravel())
    middle = (np.cumsum(counts) - 0.5 * counts) / height.size
    table = np.interp(ndtr(np.linspace(-MAX_SCORE, MAX_SCORE, KNOTS)), middle, values)
    return score, table


def _doubled(score: Array) -> NDArray[np.float32]:
    """Return a spline through the pixels at twice their number, sharper by what bilinear interpolation then blurs.

    Linear interpolation between samples half a pixel apart keeps 1 - (1 - cos w) / 3 of the power at w radians per
    sample, on average.
    """
    margin = min(16, *score.shape)
    padded = np.pad(score, margin, mode="symmetric")
    gains = [1.0 / np.sqrt(1.0 - (1.0 - np.cos(np.pi * np.fft.fftfreq(side))) / 3.0) for side in padded.shape]
    sharp = np.fft.ifft2(np.fft.fft2(padded) * np.outer(*gains)).real[margin:-margin, margin:-margin]
    fine: NDArray[np.float32] = zoom(sharp, 2, order=3, mode="reflect", grid_mode=True).astype(np.float32)
    return fine
