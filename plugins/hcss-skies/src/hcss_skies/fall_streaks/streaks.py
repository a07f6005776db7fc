"""Ice that falls out of a generating level: lattices of the level, displacement by shear, and the vertical integral.

The logarithm of ice water at the generating level is a sum of octaves, cubic B-splines over lattices of normal numbers
whose spacing halves from one to the next. Ice water at a displacement d is that of the level without the octaves that
the spread of fall speeds has mixed: the spacing of the finest is d / :data:`REACH`. So each lattice integrates over
displacements up to ``REACH`` of its nodes, as a stencil, and the sums are passed on to the next finer lattice by the
refinement of B-splines, which is exact. The costs are those of the finest lattice and a third more, however far ice is
carried.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_skies.hashing import hashed, normal
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

REACH = 28.0
"""Displacement, in distances of nodes, at which an octave is gone: seven of its wavelengths."""

WAVELENGTH = 4.0
"""Wavelength of an octave in distances of nodes."""

LIFETIME_S_PER_M = 0.12
"""Lifetime per wavelength, 2 min per km, as measured in images."""

_KNOTS = 1.5  # time between independent numbers of a node in lifetimes
_PHASES = 8  # nodes change their numbers at different times
_VALUE = 151.0 / 315.0  # rms of a B-spline surface whose nodes have variance 1
_RATIO = 2.0 ** (-2.0 / 3.0)  # variance of an octave over that of the next longer one: slope -5/3
LONGER = 3
"""Octaves longer than the outer scale."""

CELLS_M = 1200.0
"""Wavelength of generating cells, m."""

_LONG_RATIO = 0.9  # variance of an octave beyond the outer scale over that of the next shorter one
_CELLS_OCTAVES = 1.2
_OCTAVES = 32
_HEIGHTS = 4096
_LEAST = 2e-4  # of a stencil, which is left out


@dataclass(frozen=True)
class Fall:
    """How ice falls through the layer.

    Attributes
    ----------
    depth_m : float
        From the generating level to where the last ice is gone.
    shear_per_s : float
        Change of wind per height.
    speed_m_s : float
        Of fall.
    turning_rad : float
        By which the shear turns over the depth.
    direction : (float, float)
        Unit vector (y, x) along which ice is displaced below the generating level.
    """

    depth_m: float
    shear_per_s: float
    speed_m_s: float
    turning_rad: float
    direction: tuple[float, float]

    def displacement_m(self, below_m: Array) -> Array:
        """Return the displacement (y and x, ...) at depths (ascending, from 0) below the generating level.

        It is the integral of the wind relative to the level over the fall speed; without turning, along the direction
        it is the parabola shear depth^2 / (2 speed).
        """
        scale = self.shear_per_s / self.speed_m_s
        turn = self.turning_rad / self.depth_m
        if abs(self.turning_rad) < 1e-6:
            along, across = 0.5 * scale * below_m**2, 0.0 * below_m
        else:
            along = scale * (1.0 - np.cos(turn * below_m)) / turn**2
            across = scale * (below_m / turn - np.sin(turn * below_m) / turn**2)
        y, x = self.direction
        return np.stack([along * y + across * x, along * x - across * y])


def ice_above(share: Array) -> Array:
    """Return the part of all ice that is above a share of the depth: its density falls as 1 - share^2."""
    return 1.5 * share - 0.5 * share**3


def variances(outer_m: float, cells: float) -> Array:
    """Return the shares (octaves,) of the generating level's variance; wavelengths halve from 8 outer scales on.

    Below the outer scale they fall as those of a spectrum k^-5/3 along a line; a part ``cells`` of all is that of
    generating cells of about :data:`CELLS_M`, log-normal over wavelengths.
    """
    number = np.arange(-LONGER, _OCTAVES - LONGER, dtype=np.float64)
    fractal = np.where(number < 0.0, _LONG_RATIO**-number, _RATIO**number)
    bump = np.exp(-0.5 * (np.log2(outer_m * 0.5**number / CELLS_M) / _CELLS_OCTAVES) ** 2)
    shares: Array = (1.0 - cells) * fractal / fractal.sum() + cells * bump / bump.sum()
    return shares


def stencils(fall: Fall, spacings_m: Array) -> list[NDArray[np.float64]]:
    """Return for each lattice the nodes that a node integrates over: rows of (offset y, offset x, weight).

    All weights together sum to 1.
    """
    share = np.linspace(0.0, 1.0, _HEIGHTS + 1)
    weight = np.diff(ice_above(share))
    to = -fall.displacement_m(0.5 * (share[1:] + share[:-1]) * fall.depth_m)  # where the ice comes from
    far = np.maximum(np.hypot(*to), 1e-6)
    at = np.clip(np.log2(REACH * spacings_m[0] / far), 0.0, spacings_m.size - 1.0)
    found = []
    for n, spacing in enumerate(spacings_m):
        part = weight * np.clip(1.0 - abs(at - n), 0.0, None)
        y, x = to / spacing
        low_y, low_x = np.floor(y).astype(int), np.floor(x).astype(int)
        if not part.any():
            found.append(np.zeros((0, 3)))
            continue
        first = low_y.min(), low_x.min()
        sums = np.zeros((low_y.max() - first[0] + 2, low_x.max() - first[1] + 2))
        for dy in (0, 1):
            for dx in (0, 1):
                near = abs(1 - dy - (y - low_y)) * abs(1 - dx - (x - low_x))
                np.add.at(sums, (low_y - first[0] + dy, low_x - first[1] + dx), part * near)
        j, i = np.nonzero(sums > _LEAST * sums.sum())
        entries = np.stack([j + first[0], i + first[1], sums[j, i]], axis=1)
        entries[:, 2] *= sums.sum() / entries[:, 2].sum()
        found.append(entries)
    return found


@dataclass(frozen=True)
class Lattices:
    """A sky of fall streaks without motion: lattices, the longest waves first.

    Attributes
    ----------
    spacings_m : ndarray (N,)
        Distance of nodes.
    stencils : list of ndarray
        Of :func:`stencils`.
    variances : ndarray (M,)
        Of the logarithm of ice water at the generating level, by octaves; M is at least N.
    seed : int
        Of the random numbers.
    """

    spacings_m: Array
    stencils: list[NDArray[np.float64]]
    variances: Array
    seed: int

    def integral(self, y: Array, x: Array, time: float) -> NDArray[np.float32]:
        """Return the ice water path, with mean 1, at positions (rows, columns) in m.

        Parameters
        ----------
        y, x : ndarray (rows, columns)
            Positions; those of a pixel do not depend on the others.
        time : float
            Time in s; NaN: nothing changes.
        """
        count = self.spacings_m.size
        ends: list[Any] = [None] * count  # of the path's nodes: (first, last) along y and x
        ends[-1] = [
            (math.floor(a.min() / self.spacings_m[-1]) - 1, math.floor(a.max() / self.spacings_m[-1]) + 2)
            for a in (y, x)
        ]
        for n in range(count - 2, -1, -1):
            ends[n] = [(low // 2 - 1, high // 2 + 2) for low, high in ends[n + 1]]
        wide: list[Any] = [None] * count  # of the generating level's
        for n in range(count - 1, -1, -1):
            offsets = self.stencils[n][:, :2].astype(int)
            reach = offsets if len(offsets) else np.zeros((1, 2), int)
            own = [
                (low + int(reach[:, axis].min()) - 1, high + int(reach[:, axis].max()) + 1)
                for axis, (low, high) in enumerate(ends[n])
            ]
            if n + 1 < count:
                own = [
                    (min(low, finer[0] // 2 - 1), max(high, finer[1] // 2 + 2))
                    for (low, high), finer in zip(own, wide[n + 1], strict=True)
                ]
            wide[n] = own
        level = path = np.zeros((0, 0), np.float32)
        for n in range(count):
            size = [high - low + 1 for low, high in wide[n]]
            finer = np.zeros(size, np.float32)
            if n:
                _refine(finer, wide[n][0][0], wide[n][1][0], level, wide[n - 1][0][0], wide[n - 1][1][0])
            level = finer
            amplitude = math.sqrt(self.variances[n]) / _VALUE
            _add_numbers(
                level, wide[n][0][0], wide[n][1][0], np.uint64(self.seed), n, *self._moments(n, amplitude, time)
            )
            sums = np.zeros([high - low + 1 for low, high in ends[n]], np.float32)
            if n:
                _refine(sums, ends[n][0][0], ends[n][1][0], path, ends[n - 1][0][0], ends[n - 1][1][0])
            path = sums
            if len(self.stencils[n]):
                to = self.stencils[n][:, :2].astype(np.int64)
                to += [ends[n][0][0] - wide[n][0][0], ends[n][1][0] - wide[n][1][0]]
                mean = 0.5 * self.variances[: n + 1].sum()
                _integrate(path, _ice(level, np.float32(mean)), to, self.stencils[n][:, 2].astype(np.float32))
        out = np.empty(y.shape, np.float32)
        _interpolate(out, y, x, 1.0 / self.spacings_m[-1], path, ends[-1][0][0], ends[-1][1][0])
        return out

    def _moments(self, n: int, amplitude: float, time: float) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """Return knots in time (phases,) and weights of their numbers (phases, 2)."""
        if math.isnan(time):
            return np.zeros(_PHASES, np.int64), np.tile(np.array([amplitude, 0.0], np.float32), (_PHASES, 1))
        lifetime = LIFETIME_S_PER_M * WAVELENGTH * self.spacings_m[n]
        at = time / (_KNOTS * lifetime) + np.arange(_PHASES) / _PHASES
        angle = 0.5 * np.pi * (at - np.floor(at))
        weights = amplitude * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return np.floor(at).astype(np.int64), weights.astype(np.float32)


@kernel()
def _add_numbers(level: Any, row: int, column: int, seed: Any, octave: int, knots: Any, weights: Any) -> None:
    """Add the numbers of one octave to its nodes."""
    state = hashed(hashed(seed, 9001), octave)
    changes = weights[0, 1] != 0.0 or weights[1, 1] != 0.0
    for i in range(level.shape[0]):
        of_row = hashed(state, row + i)
        for j in range(level.shape[1]):
            node = hashed(of_row, column + j)
            phase = np.int64(node & np.uint64(7))
            total = weights[phase, 0] * np.float32(normal(hashed(node, knots[phase])))
            if changes:
                total += weights[phase, 1] * np.float32(normal(hashed(node, knots[phase] + 1)))
            level[i, j] += total


@kernel(fastmath={"contract"})
def _refine(out: Any, row: int, column: int, coarse: Any, coarse_row: int, coarse_column: int) -> None:
    """Write the nodes of the same B-spline surface at half the distance."""
    six, eighth, half = np.float32(6.0), np.float32(0.125), np.float32(0.5)
    line = np.empty(coarse.shape[1], np.float32)
    for i in range(out.shape[0]):
        k = ((row + i) >> 1) - coarse_row
        if (row + i) & 1:
            for j in range(line.size):
                line[j] = half * (coarse[k, j] + coarse[k + 1, j])
        else:
            for j in range(line.size):
                line[j] = eighth * (coarse[k - 1, j] + six * coarse[k, j] + coarse[k + 1, j])
        for j in range(out.shape[1]):
            m = ((column + j) >> 1) - coarse_column
            if (column + j) & 1:
                out[i, j] = half * (line[m] + line[m + 1])
            else:
                out[i, j] = eighth * (line[m - 1] + six * line[m] + line[m + 1])


@kernel(fastmath={"contract"})
def _ice(level: Any, mean: Any) -> Any:
    """Return the exponential of the B-spline surface at its nodes less a mean; the outermost ones are not written."""
    out = np.empty_like(level)
    four, per = np.float32(4.0), np.float32(1.0 / 36.0)
    line = np.empty(level.shape[1], np.float32)
    for i in range(1, level.shape[0] - 1):
        for j in range(line.size):
            line[j] = level[i - 1, j] + four * level[i, j] + level[i + 1, j]
        for j in range(1, line.size - 1):
            out[i, j] = np.exp(per * (line[j - 1] + four * line[j] + line[j + 1]) - mean)
    return out


@kernel(fastmath={"contract"})
def _integrate(path: Any, ice: Any, to: Any, weights: Any) -> None:
    """Add weighted ice at displaced nodes."""
    for i in range(path.shape[0]):
        for n in range(weights.size):
            row, first, weight = i + to[n, 0], to[n, 1], weights[n]
            for j in range(path.shape[1]):
                path[i, j] += weight * ice[row, first + j]


@kernel(fastmath={"contract"})
def _interpolate(out: Any, y: Any, x: Any, per_m: float, nodes: Any, row: int, column: int) -> None:
    """Write a B-spline surface at positions."""
    one, sixth, half, two = np.float32(1.0), np.float32(1.0 / 6.0), np.float32(0.5), np.float32(2.0 / 3.0)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            at_y, at_x = y[i, j] * per_m, x[i, j] * per_m
            low_y, low_x = math.floor(at_y), math.floor(at_x)
            f, g = np.float32(at_y - low_y), np.float32(at_x - low_x)
            k, m = np.uint64(np.int64(low_y) - row - 1), np.uint64(np.int64(low_x) - column - 1)
            a, b = one - f, one - g
            x0, x3 = sixth * b * b * b, sixth * g * g * g
            x1, x2 = two - g * g + half * g * g * g, two - b * b + half * b * b * b
            total = np.float32(0.0)
            for n in range(4):
                w = sixth * a * a * a
                if n == 1:
                    w = two - f * f + half * f * f * f
                elif n == 2:
                    w = two - a * a + half * a * a * a
                elif n == 3:
                    w = sixth * f * f * f
                at = k + np.uint64(n)
                total += w * (
                    x0 * nodes[at, m] + x1 * nodes[at, m + np.uint64(1)]
                    + x2 * nodes[at, m + np.uint64(2)] + x3 * nodes[at, m + np.uint64(3)]
                )  # fmt: skip
            out[i, j] = total
