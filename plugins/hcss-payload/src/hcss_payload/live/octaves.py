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
from hcss_twin.models.clouds.fractal.field import FractalField
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Grid, Motion

FADING_CELLS, FINEST_CELLS = 1.8, 2.4
"""Cells per footprint from which on an octave fades, and at which it is gone: a shape that small is noise."""

KEYFRAME_ERROR, INTERVALS_S = 0.01, (0.25, 64.0)
"""Error of the field between keyframes, in standard deviations, and the limits of the time between them."""

_INDEPENDENT = 0.7

_STEPS = 512
"""Positions per cell at which the covariance of an octave is sampled."""

_PAIRS = 32
"""Separations along half a side of a footprint at which covariances are averaged."""


@lru_cache(maxsize=1)
def cell_covariance() -> Array:
    """Return the covariance of an octave along one axis at distances of 0, 1/512, ... 4 cells, mean over positions.

    An octave interpolates independent numbers with the weights of Keys' kernel, scaled to unit variance.
    """
    weights = FractalField.Lattice.weights((np.arange(_STEPS) + 0.5) / _STEPS)  # of nodes -1, 0, 1, 2
    kernel = weights[:, ::-1].T.ravel()  # what one number adds along the axis
    covariance = np.correlate(kernel, kernel, "full")[kernel.size - 1 :] / _STEPS
    return np.append(covariance, 0.0)


def separations(footprint: Array, lag: Array) -> tuple[Array, Array]:
    """Return separations (N, 2) in m of two points in two footprints a lag (2,) apart, and their shares (N,).

    Parameters
    ----------
    footprint : ndarray (2, 2)
        Sides of the parallelogram, x and y: to the next column and to the next row.
    """
    # Along a side separations have the density 1 - |u|; near 0, where fine octaves matter, they are dense.
    position = (np.arange(_PAIRS) + 0.5) / _PAIRS
    apart, share = position**2, 2.0 * position / _PAIRS * (1.0 - position**2)
    side, weight = np.concatenate((-apart[::-1], apart)), np.concatenate((share[::-1], share))
    weight /= weight.sum()
    u, v = (coordinate.ravel() for coordinate in np.meshgrid(side, side))
    return lag + u[:, None] * footprint[0] + v[:, None] * footprint[1], np.outer(weight, weight).ravel()


def field_covariance(octave: Octave, separation_m: Array, point_m: float) -> Array:
    """Return the covariance (N,) of an octave of variance 1 at separations (N, 2); its steps are those of points."""
    covariance = cell_covariance()
    distance = np.abs(separation_m) * (_STEPS / point_m) * np.array([octave.x.step, octave.y.step])
    # A product of both axes; beyond the last sample nothing is correlated.
    x, y = (np.interp(axis_distance, np.arange(covariance.size), covariance, right=0.0) for axis_distance in distance.T)
    product: Array = x * y
    return product


def between(cells: float, lag: float = 0.0) -> float:
    """Return the mean covariance along one axis, a lag (in points) apart, of a linear interpolation between points.

    Parameters
    ----------
    cells : float
        Distance of the points, in cells.
    """
    covariance = cell_covariance()
    points = np.floor(lag) + np.arange(-1, 3)
    away = np.abs(lag - points)
    # The cubic B-spline, which is the covariance of the weights; at a lag of 0: 2/3 + C/3.
    weight = np.where(away < 1.0, 2.0 / 3.0 - away**2 + 0.5 * away**3, np.maximum(0.0, 2.0 - away) ** 3 / 6.0)
    covariances = np.interp(np.abs(points) * cells * _STEPS, np.arange(covariance.size), covariance, right=0.0)
    return float(weight @ covariances)


def shape_of(plan: Plan) -> FractalParameters:
    """Return the shape of the clouds of a plan's only layer, which are fractal."""
    generator: Any = plan.assembly.generators[0]
    shape: FractalParameters = generator.parameters
    return shape


@dataclass(frozen=True, eq=False)
class SeenOctaves:
    """Octaves as a footprint leaves them.

    Attributes
    ----------
    octaves : tuple of Octave
        With the variance that is left between the points of a tile, from which it is interpolated.
    removed : float
        Variance of the field inside a pixel.
    every : tuple of Octave
        All octaves of the sky.
    point_m : float
        Distance of the points of a tile, to which the steps of octaves refer.
    footprint : ndarray (2, 2)
        As in :func:`separations`.
    """

    octaves: tuple[Octave, ...]
    removed: float
    every: tuple[Octave, ...]
    point_m: float
    footprint: Array

    def true_covariance(self, separation_m: Array) -> Array:
        """Return the covariance (N,) of the sky at separations (N, 2)."""
        of_octaves = (octave.variance * field_covariance(octave, separation_m, self.point_m) for octave in self.every)
        return np.sum(list(of_octaves), axis=0)  # type: ignore[no-any-return]

    def kept_covariance(self, lag_m: Array) -> float:
        """Return the covariance of the interpolated field of tiles at a lag (2,)."""
        x, y = np.abs(lag_m) / self.point_m
        return sum(octave.variance * between(octave.x.step, x) * between(octave.y.step, y) for octave in self.octaves)


def seen_octaves(shape: FractalParameters, motion: Motion, point_m: float, footprint: Array) -> SeenOctaves:
    """Return the octaves of a sky that a footprint leaves.

    Parameters
    ----------
    shape : FractalParameters
        Complete.
    point_m : float
        Distance of the points of a tile.
    footprint : ndarray (2, 2)
        As in :func:`separations`.

    Raises
    ------
    PayloadError
        If even the coarsest octave is noise inside a pixel.
    """
    every = Octave.separate(shape, Grid(1, 1, point_m), motion, noise=False)
    width_m = np.hypot(*footprint)
    within, share = separations(footprint, np.zeros(2))
    kept, left = [], 0.0
    for octave in every:
        cells = [scale.step * width / point_m for scale, width in zip((octave.x, octave.y), width_m, strict=True)]
        if max(cells) < FINEST_CELLS:
            fading = min(1.0, (FINEST_CELLS - max(cells)) / (FINEST_CELLS - FADING_CELLS))
            seen_variance = fading * octave.variance * float(field_covariance(octave, within, point_m) @ share)
            kept.append(replace(octave, variance=seen_variance / (between(octave.x.step) * between(octave.y.step))))
            left += seen_variance
    if not kept:
        raise PayloadError(
            f"camera: pixels of {width_m[0]:.4g} m x {width_m[1]:.4g} m on the ground hold several cells of the "
            "coarsest octave of the clouds; allowed: smaller ones, or coarser clouds"
        )
    return SeenOctaves(tuple(kept), max(0.0, 1.0 - left), every, point_m, footprint)


def blended(before: SeenOctaves, after: SeenOctaves, later: float) -> SeenOctaves:
    """Return the octaves between two keyframes, whose fields are added with the weights 1 - ``later`` and ``later``."""
    amplitudes = [
        {octave.k: weight * np.sqrt(octave.variance) for octave in seen.octaves}
        for weight, seen in ((1.0 - later, before), (later, after))
    ]
    sums = {octave.k: sum(amplitude.get(octave.k, 0.0) for amplitude in amplitudes) for octave in before.every}
    octaves = tuple(replace(octave, variance=sums[octave.k] ** 2) for octave in before.every if sums[octave.k] > 0.0)
    footprint = before.footprint + later * (after.footprint - before.footprint)
    seen = replace(before, octaves=octaves, footprint=footprint)
    return replace(seen, removed=max(0.0, 1.0 - seen.kept_covariance(np.zeros(2))))


def keyframe_interval_s(octaves: Sequence[Octave], longest: float) -> float:
    """Return the time between keyframes, a power of two, for which the field between them errs by a hundredth.

    In the middle between keyframes a fraction f of a cell apart, an octave errs by about f^2 / 2 of its amplitude (its
    second derivative has an rms of 4 per cell^2), and by at most 0.7, where keyframes are independent.

    Parameters
    ----------
    longest : float
        Limit, s; the result is at least the smallest interval.
    """
    interval = INTERVALS_S[0]
    while 2.0 * interval <= min(longest, INTERVALS_S[1]):
        errors = [
            octave.variance * min(_INDEPENDENT, 0.5 * (2.0 * interval * octave.t.step) ** 2) ** 2 for octave in octaves
        ]
        if sum(errors) > KEYFRAME_ERROR**2:
            break
        interval *= 2.0
    return interval
