"""Octaves of the fractal sky as a pixel sees them: those finer than its footprint become a variance.

A pixel averages the clouds over its footprint. Of an octave with cells of the size of the footprint only a part of the
amplitude is left, and finer octaves are noise inside the pixel, which shifts its mean radiance but not its place. The
amplitude that is left is the square root of the variance of a mean over the footprint; the variance that is removed
blurs the radiance as a function of the field (:mod:`hcss_payload.live.radiance`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from hcss_payload.checks import PayloadError
from hcss_twin.core.arrays import Array
from hcss_twin.models.clouds.fractal.octaves import Octave, separate_octaves
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.models.clouds.fractal.rows import cubic_weights
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Grid, Motion

FINEST_CELLS = 2.4
"""Cells per footprint of the finest octave that keeps a shape; of finer ones less than a tenth of the variance."""

KEYFRAME_ERROR, INTERVALS_S = 0.01, (0.25, 64.0)
"""Error of the field between keyframes, in standard deviations, and the limits of the time between them."""

_INDEPENDENT = 0.7

_STEPS = 64
"""Positions per cell at which the covariance of an octave is sampled."""


@lru_cache(maxsize=1)
def cell_covariance() -> Array:
    """Return the covariance of an octave along one axis at distances of 0, 1/64, ... 4 cells, mean over positions.

    An octave interpolates independent numbers with the weights of Keys' kernel, scaled to unit variance.
    """
    fraction = (np.arange(_STEPS) + 0.5) / _STEPS
    weights = np.asarray(cubic_weights(fraction))  # of nodes -1, 0, 1, 2
    covariance = np.zeros(4 * _STEPS + 1)
    for lag in range(covariance.size):
        place = np.arange(_STEPS) + lag
        other, shift = weights[place % _STEPS], place // _STEPS
        for node in range(4):
            same = node - shift
            inside = (same >= 0) & (same < 4)
            covariance[lag] += np.sum(weights[inside, node] * other[inside, same[inside]]) / _STEPS
    return covariance


def mean_variance(cells: float) -> float:
    """Return the variance of the mean over a length in cells: 2 / s^2 times the integral of (s - t) C(t) to s."""
    if cells < 1.0 / _STEPS:
        return 1.0
    covariance = cell_covariance()
    lag = np.arange(covariance.size) / _STEPS
    inside = lag <= cells
    integrand = np.where(inside, (cells - lag) * covariance, 0.0)
    # The trapezoidal rule, with the end of the interval between two samples.
    whole = float(np.sum(0.5 * (integrand[1:] + integrand[:-1])[inside[1:]])) / _STEPS
    last = int(np.flatnonzero(inside)[-1])
    rest = 0.5 * integrand[last] * (cells - lag[last]) if last + 1 < lag.size else 0.0
    return min(1.0, 2.0 * (whole + rest) / cells**2)


def between(cells: float) -> float:
    """Return the mean variance along one axis between points so many cells apart, interpolated linearly: 2/3 + C/3."""
    covariance = cell_covariance()
    return 2.0 / 3.0 + float(np.interp(cells, np.arange(covariance.size) / _STEPS, covariance)) / 3.0


def shape_of(plan: Plan) -> FractalParameters:
    """Return the shape of the clouds of a plan's only layer, which are fractal."""
    generator: Any = plan.assembly.generators[0]
    shape: FractalParameters = generator.parameters
    return shape


@dataclass(frozen=True)
class SeenOctaves:
    """Octaves as a footprint leaves them.

    Attributes
    ----------
    octaves : tuple of Octave
        With the variance that is left between the points of a tile, from which it is interpolated.
    removed : float
        Variance of the field inside a pixel.
    """

    octaves: tuple[Octave, ...]
    removed: float


def seen_octaves(shape: FractalParameters, motion: Motion, point_m: float, width_m: tuple[float, float]) -> SeenOctaves:
    """Return the octaves of a sky that a footprint leaves.

    Parameters
    ----------
    shape : FractalParameters
        Complete.
    point_m : float
        Distance of the points of a tile.
    width_m : (float, float)
        Width of the footprint along x and y of the sky.

    Raises
    ------
    PayloadError
        If even the coarsest octave is noise inside a pixel.
    """
    every = separate_octaves(shape, Grid(1, 1, point_m), motion, noise=False)
    kept, left = [], 0.0
    for octave in every:
        cells = [scale.step * width / point_m for scale, width in zip((octave.x, octave.y), width_m, strict=True)]
        if max(cells) <= FINEST_CELLS:
            own = octave.variance * mean_variance(cells[0]) * mean_variance(cells[1])
            kept.append(replace(octave, variance=own / (between(octave.x.step) * between(octave.y.step))))
            left += own
    if not kept:
        raise PayloadError(
            f"camera: pixels of {width_m[0]:.4g} m x {width_m[1]:.4g} m on the ground hold several cells of the "
            "coarsest octave of the clouds; allowed: smaller ones, or coarser clouds"
        )
    return SeenOctaves(tuple(kept), max(0.0, 1.0 - left))


def keyframe_interval_s(octaves: Sequence[Octave]) -> float:
    """Return the time between keyframes, a power of two, for which the field between them errs by a hundredth.

    In the middle between keyframes a fraction f of a cell apart, an octave errs by about f^2 / 2 of its amplitude (its
    second derivative has an rms of 4 per cell^2), and by at most 0.7, where keyframes are independent.
    """
    interval, longest = INTERVALS_S
    while interval < longest:
        errors = [
            octave.variance * min(_INDEPENDENT, 0.5 * (2.0 * interval * octave.t.step) ** 2) ** 2 for octave in octaves
        ]
        if sum(errors) > KEYFRAME_ERROR**2:
            break
        interval *= 2.0
    return interval
