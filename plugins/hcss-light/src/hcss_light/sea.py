"""The sea among broken clouds: where clouds shade it, and where it mirrors them instead of the sky.

Both are differences from the clear column, as they reach the sensor through the gas. The sun's paths to the sea point
of each line of sight cross whole points, as in :mod:`hcss_light.slices`; the forward peak of scattering counts as not
scattered, because the waves spread sunlight over wider angles. Mirrored are the clouds in the direction of a flat sea,
as bodies that emit; waves blur them, so that every second point of each axis is enough.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcss_light.slices import RAYS, Field, Slices, aside, march
from hcss_light.source import Direction, Particles, Surroundings
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

MOST_SHADED = 512
"""Points aside from which shadows come; suns that are too low for that cast none on the sea."""

STEP = 2
"""Points from one column of cloud to the next that the sea mirrors."""

FAINT = 1e-4
"""Share of the radiance of the clear column below which reflected sunlight counts as none."""


@dataclass(frozen=True)
class SeaPaths:
    """Cloud over the sea points of lines of sight.

    Attributes
    ----------
    to_sun_m : ndarray (R, y, x) or None
        Path in cloud times cosine of the rays of the sun to parts of each point; None without shadows.
    mirrored : ndarray (Z, y, x)
        Density of some columns, the highest slice first.
    """

    to_sun_m: Field | None
    mirrored: Field


class Sea:
    """Geometry of the sea points of lines of sight.

    Parameters
    ----------
    reference_m : float
        Altitude at which the line of sight of a point meets the column with its row and column.
    """

    def __init__(self, slices: Slices, view: Direction, sun: Direction | None, reference_m: float) -> None:
        self._slices, self._view, self._step = slices, view, STEP
        point = -_away(slices, reference_m, view)
        self._to_sun = None
        self._up = 1.0
        if sun is not None and np.max(np.abs(_away(slices, slices.top_m, sun))) <= MOST_SHADED:
            self._to_sun = point + slices.shifts(sun.zenith_deg, sun.azimuth_deg, 0.0)
            self._up = float(sun.vector[2])
        self._mirrored = point - slices.shifts(view.zenith_deg, view.azimuth_deg, 0.0)

    def apart(self) -> Sea:
        """Return the sea below columns of which none sees another: each is a uniform cloud above its own sea."""
        result = copy(self)
        result._step, result._mirrored = 1, np.zeros_like(self._mirrored)
        result._to_sun = None if self._to_sun is None else np.zeros_like(self._to_sun)
        return result

    @property
    def to_sun(self) -> Array | None:
        """Rows and columns (Z, 2) from points to the columns on the sun's path to their sea point; None: too far."""
        return self._to_sun

    @property
    def reach(self) -> tuple[tuple[int, int], ...]:
        """Rows, and columns, of points before and after others whose clouds matter to them."""
        moves = [self._mirrored, *([] if self._to_sun is None else [self._to_sun])]
        least, most = (limit([limit(move, axis=0) for move in moves], axis=0) for limit in (np.min, np.max))
        # Interpolation, and rays to parts of a point.
        return tuple(
            (math.ceil(max(-float(low), 0.0)) + 2 * STEP, math.ceil(max(float(high), 0.0)) + 2 * STEP)
            for low, high in zip(least, most, strict=True)
        )

    def paths(self, density: Field, shaded: bool) -> SeaPaths:
        """Return the cloud over the sea points of lines of sight through points of clouds (Z, y, x)."""
        to_sun = None
        if shaded and self._to_sun is not None:
            to_sun = np.zeros((RAYS, *density.shape[1:]), dtype=np.float32)
            add_paths(density, self._to_sun, to_sun)
            to_sun *= np.float32(self._slices.height_m)
        return SeaPaths(to_sun, np.ascontiguousarray(density[::-1, :: self._step, :: self._step]))

    def change(self, paths: SeaPaths, particles: Particles, around: Surroundings, shape: Sequence[int]) -> Array:
        """Return what clouds change (y, x) in the radiance of the sea of a group of wavenumbers."""
        result = np.zeros(tuple(shape))
        if paths.to_sun_m is not None and around.glint > 0.0:
            depth = particles.scaled[0] / self._up * paths.to_sun_m
            result -= around.glint * (1.0 - np.mean(np.exp(-depth), axis=0))
        if around.mirrored is not None:
            seen = np.empty(paths.mirrored.shape[1:], dtype=np.float32)
            nothing = np.zeros((0, 1, 1), dtype=np.float32)
            march(
                paths.mirrored, nothing, around.mirrored[::-1].copy(), particles.absorbing_m1, self._slices.height_m,
                float(self._view.vector[2]), self._mirrored[::-1] / self._step, 0.0, seen,
            )  # fmt: skip
            if self._step == 1:
                return np.asarray(result + seen)
            count = paths.mirrored.shape[1:]
            rows, columns = between(count[0], shape[0]), between(count[1], shape[1])
            result += rows @ seen @ columns.T
        return result


def _away(slices: Slices, height_m: float, toward: Direction) -> Array:
    """Return rows and columns (2,) by which a line from the sea is displaced at a height."""
    return np.asarray(height_m * toward.vector[:2] / toward.vector[2] / slices.point_m)


def between(columns: int, points: int) -> Array:
    """Return weights (points, columns) for linear interpolation between every second point."""
    position = np.minimum(np.arange(points) / STEP, columns - 1.0)
    weights: Array = np.maximum(1.0 - np.abs(position[:, None] - np.arange(columns)), 0.0)
    return weights


@kernel()
def add_paths(density: Any, shifts: Any, paths: Any) -> None:
    """Add the density of the points that rays to parts of each point cross."""
    count, rows, columns = density.shape
    for s in range(count):
        for ray in range(RAYS):
            down, right = aside(shifts[s, 0], shifts[s, 1], ray)
            right %= columns
            for y in range(rows):
                crossed, path = density[s, (y + down) % rows], paths[ray, y]
                for x in range(columns - right):
                    path[x] += crossed[x + right]
                for x in range(columns - right, columns):
                    path[x] += crossed[x + right - columns]
