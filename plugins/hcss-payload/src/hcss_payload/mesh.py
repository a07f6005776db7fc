"""Mesh of rays: exact lines of sight every few pixels, interpolated between them where this is accurate.

Rays cost more than the interpolation of their values. A block of pixels between four rays is interpolated where the
interpolation in the middle of its sides, where it is worst, misses the exact ray by less than a tolerance in pixels;
otherwise, and wherever a block and its neighbours meet the limb, each pixel has its exact ray. Since the rays in the
middles are known then, values are interpolated between them, too, with a quarter of that error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hcss_payload.camera import Camera
from hcss_payload.pose import Pose
from hcss_payload.rays import meet
from hcss_payload.shutter import LinePoses
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array

STEP, TOLERANCE_PX = 8, 0.02

Values = Callable[[Array], Array]
"""Values (N, K) at positions (N, 3) on the surface."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Lines of sight of a camera at a pose, on the surface at an altitude.

    Parameters
    ----------
    altitude_m : float
        Of the surface above the ellipsoid.
    points : int
        Points along each side of a pixel; each is the centre of its square.
    step, tolerance_px : int, float
        Points between rays, and the largest error of a point's place in the image, in pixels.
    lines : LinePoses, optional
        Poses of the lines, if they differ from that of the frame.
    """

    camera: Camera
    pose: Pose
    altitude_m: float = 0.0
    points: int = 1
    step: int = STEP
    tolerance_px: float = TOLERANCE_PX
    lines: LinePoses | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of points."""
        return self.camera.rows * self.points, self.camera.columns * self.points

    def exact_m(self, row: Array, column: Array) -> Array:
        """Return the positions (..., 3) that points (...) of the image see; NaN in space."""
        return meet(*self.rays(row, column), self.altitude_m)

    def rays(self, row: Array, column: Array) -> tuple[Array, Array]:
        """Return the origin (3,) or origins (..., 3), and the Earth-fixed directions (..., 3), of points (...)."""
        per = self.points
        at_row = (row + 0.5) / per - 0.5
        direction = self.camera.directions(at_row, (column + 0.5) / per - 0.5)
        if self.lines is None:
            return self.pose.position_m, self.pose.to_earth(direction)
        return self.lines.rays(at_row, direction)

    def positions_m(self) -> Array:
        """Return the positions (y, x, 3) that all points see; NaN in space."""
        return self.values(lambda positions: positions)

    def values(self, of: Values) -> Array:
        """Return values (y, x, K) at all points, interpolated like the lines of sight; NaN in space.

        Parameters
        ----------
        of : callable
            Returns smooth values (N, K) at positions (N, 3).
        """
        return MeshValues(self, of).window(slice(0, self.shape[0]), slice(0, self.shape[1]))

    @property
    def exact_share(self) -> float:
        """Share of points with an exact ray."""
        (up, *_), (left, *_) = (_weights(nodes, size) for nodes, size in zip(self._nodes, self.shape, strict=True))
        return float(np.mean(self._exact[np.ix_(up // 2, left // 2)]))

    @cached_property
    def _nodes(self) -> tuple[Array, Array]:
        """Rows and columns of the rays: every step and the last (for a single line the one beside it), and middles."""
        last = [max(1, size - 1) for size in self.shape]
        rows, columns = (_with_middles(np.append(np.arange(0, size, self.step), size)) for size in last)
        return rows, columns

    @cached_property
    def _rays(self) -> Array:
        """Positions (2 n - 1, 2 m - 1, 3) at the nodes and in the middles between them."""
        row, column = self._nodes
        return self.exact_m(row[:, None], column[None, :])

    @cached_property
    def _exact(self) -> NDArray[np.bool_]:
        """Whether each block, by the row and column of its first node, needs exact rays."""
        rays = self._rays
        missed = np.isnan(rays[..., 0])
        along = rays[::2, 1::2] - 0.5 * (rays[::2, :-1:2] + rays[::2, 2::2])
        down = rays[1::2, ::2] - 0.5 * (rays[:-1:2, ::2] + rays[2::2, ::2])
        along_px, down_px = self._in_pixels(along, rays[::2, 1::2]), self._in_pixels(down, rays[1::2, ::2])
        error = np.fmax(along_px[:-1], along_px[1:]) + np.fmax(down_px[:, :-1], down_px[:, 1:])
        # Nine rays of each block: the limb passes where some miss, and may bulge into the blocks beside.
        height, width = missed.shape[0] - 2, missed.shape[1] - 2
        nine = [missed[i : height + i : 2, j : width + j : 2] for i in range(3) for j in range(3)]
        limb = np.pad(np.any(nine, axis=0) & ~np.all(nine, axis=0), 1)
        height, width = limb.shape[0] - 2, limb.shape[1] - 2
        near = np.any([limb[i : height + i, j : width + j] for i in range(3) for j in range(3)], axis=0)
        exact: NDArray[np.bool_] = near | (error > self.tolerance_px)
        return exact

    def _in_pixels(self, error_m: Array, position_m: Array) -> Array:
        """Return the distance in the image, in pixels, between exact and interpolated positions.

        The interpolated position also sinks below the curved surface. Only its motion along the surface counts:
        latitude, longitude and the place in the plane of the scene do not depend on the rest.
        """
        up = position_m / np.linalg.norm(position_m, axis=-1, keepdims=True)
        moved = position_m + error_m - np.sum(error_m * up, axis=-1, keepdims=True) * up
        places = [
            self.camera.pixels(self.pose.to_body(positions - self.pose.position_m)) for positions in (position_m, moved)
        ]
        return np.hypot(places[1][0] - places[0][0], places[1][1] - places[0][1])


class MeshValues:
    """Values along the lines of sight of a mesh, for windows of points; a point has the same bits in every window.

    Parameters
    ----------
    of : callable
        Returns smooth values (N, K) at positions (N, 3).
    """

    def __init__(self, mesh: Mesh, of: Values) -> None:
        self._mesh, self._of = mesh, of
        self.at_nodes = _where_met(of, mesh._rays)

    def window(self, rows: slice, columns: slice) -> Array:
        """Return the values (y, x, K) at the points of a window; NaN in space. Outside the image all rays are exact."""
        mesh = self._mesh
        height, width = mesh.shape
        if rows.start < 0 or columns.start < 0 or rows.stop > height or columns.stop > width:
            row, column = (np.arange(span.start, span.stop, dtype=np.float64) for span in (rows, columns))
            return _where_met(self._of, mesh.exact_m(row[:, None], column[None, :]))
        of_rows, of_columns = mesh._nodes
        up, down, y = (weights[rows] for weights in _weights(of_rows, height))
        left, right, x = (weights[columns] for weights in _weights(of_columns, width))
        result = np.empty((up.size, left.size, self.at_nodes.shape[2]))
        _interpolate(self.at_nodes, up, down, y, left, right, x, result)
        row, column = np.nonzero(mesh._exact[np.ix_(up // 2, left // 2)])
        if row.size:
            exact = mesh.exact_m((row + rows.start).astype(np.float64), (column + columns.start).astype(np.float64))
            result[row, column] = _where_met(self._of, exact)
        return result


def _where_met(of: Values, position_m: Array) -> Array:
    """Return values (..., K) at positions (..., 3); NaN where those are."""
    met = ~np.isnan(position_m[..., 0])
    inside = of(position_m[met])
    result = np.full((*met.shape, inside.shape[-1]), np.nan)
    result[met] = inside
    return result


def _weights(nodes: Array, size: int) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Return the nodes before and after each point (size,), and the point's place between them."""
    first = np.clip(np.searchsorted(nodes, np.arange(size), side="right") - 1, 0, max(0, nodes.size - 2))
    last = np.minimum(first + 1, nodes.size - 1)
    return first, last, (np.arange(size) - nodes[first]) / (nodes[last] - nodes[first])


def _with_middles(nodes: NDArray[np.int64]) -> Array:
    result = np.empty(2 * nodes.size - 1)
    result[::2], result[1::2] = nodes, 0.5 * (nodes[1:] + nodes[:-1])
    return result


@kernel()
def _interpolate(nodes, up, down, y, left, right, x, result):  # type: ignore[no-untyped-def]
    """Write values (y, x, K) between nodes (n, m, K), by the nodes before and after rows and columns."""
    width, size = nodes.shape[1], nodes.shape[2]
    line = np.empty((width, size))
    for i in range(up.size):
        above, below = nodes[up[i]], nodes[down[i]]
        for j in range(left[0], right[left.size - 1] + 1):
            for k in range(size):
                line[j, k] = above[j, k] + y[i] * (below[j, k] - above[j, k])
        for j in range(left.size):
            first, last = left[j], right[j]
            for k in range(size):
                result[i, j, k] = line[first, k] + x[j] * (line[last, k] - line[first, k])
