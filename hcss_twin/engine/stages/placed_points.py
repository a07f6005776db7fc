"""Small elements in the image: where they appear, in which pieces, and what higher bodies leave of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.physics.squares import Rectangle, segments, share_left
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.rays import Rays, instants_s
from hcss_twin.plan.windows import Window, points_of
from hcss_twin.providers import ElementPoint

Thickness = NDArray[np.float32]

Place = tuple[float, float]
"""Row and column in the image; pixel n extends from n to n + 1."""

LARGEST_DRAWN = 16.0
"""Side in pixels up to which sensors draw squares through their point spread; larger ones are blurred as the image."""

_RATE_S = 1e-3
"""Time over which the motion of elements against the image is measured, around the instant."""

_STEPS_PER_PIXEL = 8
"""Instants of the integration time for each pixel by which a small element moves."""


@dataclass(frozen=True)
class Piece:
    """The part of a small element that a sensor draws at one place.

    Attributes
    ----------
    row, column : float
        Place in the image; pixel n extends from n to n + 1.
    rate : (float, float)
        Rows and columns per second by which it moves against the image.
    radiance : ndarray (B,)
        What it adds to its pixel.
    pixel : (int, int)
        Row and column of the pixel that holds it.
    behind : ndarray of float32 (B,)
        Radiance of this pixel without small elements.
    """

    row: float
    column: float
    rate: tuple[float, float]
    radiance: Array
    pixel: tuple[int, int]
    behind: NDArray[np.float32]


@dataclass(frozen=True)
class Share:
    """A piece of a small element before its light is known: its place, and its share of the whole."""

    row: float
    column: float
    share: float


@dataclass(frozen=True)
class PlacedPoint:
    """A small element where it appears in the image.

    Attributes
    ----------
    number : int
        Of its section, from 1.
    row, column : ndarray (M,)
        Place at each instant of the exposure: one, if the cube shows an instant.
    rate : (float, float)
        Rows and columns per second of what the exposure does not show.
    area : float
        Area of a body, in pixels; 0: a plume.
    side : float
        Side of the square that is drawn, in pixels; 0: a point.
    """

    number: int
    point: ElementPoint
    row: Array
    column: Array
    rate: tuple[float, float]
    area: float
    side: float

    @property
    def is_resolved(self) -> bool:
        """Whether it is larger than a pixel, so that clouds may hide a part of it."""
        return self.area > 1.0

    @property
    def place(self) -> tuple[float, float]:
        """Row and column of its middle, in the middle of the exposure."""
        return float(self.row.mean()), float(self.column.mean())

    @property
    def outline(self) -> Rectangle:
        """The square of a body."""
        row, column, half = *self.place, 0.5 * math.sqrt(self.area)
        return row - half, row + half, column - half, column + half

    def window(self, within: Window) -> Window:
        """Return the pixels of a window that may hold its pieces."""
        rows, columns = (
            slice(
                max(math.floor(positions.min() - 0.5 * self.side), pixels.start),
                min(math.floor(positions.max() + 0.5 * self.side) + 1, pixels.stop),
            )
            for positions, pixels in zip((self.row, self.column), within, strict=True)
        )
        return rows, columns

    def pieces(self, within: Window, higher: Sequence[Rectangle], samples: int) -> dict[tuple[int, int], list[Share]]:
        """Return its visible pieces in each pixel of a window, with their shares of the whole.

        Parameters
        ----------
        higher : sequence of Rectangle
            Outlines of higher bodies.
        samples : int
            Points along each side of a pixel, at which clouds differ.
        """
        found: dict[tuple[int, int], list[Share]] = {}
        middle, whole = self.place, 0.5 * math.sqrt(self.area)
        parts = math.ceil(0.5 * samples) if self.is_resolved else 1
        for row, column in zip(self.row.tolist(), self.column.tolist(), strict=True):
            down, across = (
                list(zip(*(values.tolist() for values in segments(at, self.side, pixels, parts)), strict=True))
                for at, pixels in ((row, within[0]), (column, within[1]))
            )
            off = middle[0] - row, middle[1] - column
            for (y, at_row, low, high), (x, at_column, left, right) in product(down, across):
                share, outline = 1.0, (at_row - whole, at_row + whole, at_column - whole, at_column + whole)
                if self.side:  # otherwise a body smaller than a pixel is one piece
                    share, outline = (high - low) * (right - left) / self.side**2, (low, high, left, right)
                if higher:
                    moved = [edge + off[n // 2] for n, edge in enumerate(outline)]
                    share *= share_left((moved[0], moved[1], moved[2], moved[3]), higher)
                if share > 0.0:
                    found.setdefault((y, x), []).append(Share(at_row, at_column, share / self.row.size))
        return found


def placed_point(plan: Plan, number: int, point: ElementPoint, time_s: float) -> PlacedPoint | None:
    """Return a small element of a section, by its number, at its place in the image; None if it is not seen."""
    if (seen := _seen(plan.rays, point, time_s)) is None:
        return None
    row, column, rate = seen
    area = 0.0
    if point.area_m2 is not None:
        at_m = point.x_m, point.y_m, point.altitude_m
        area = point.area_m2 / plan.rays.pixel_area_m2(float(row.mean()), float(column.mean()), time_s, at_m)
    side = max(point.side_m / plan.grid.pixel_size_m, math.sqrt(area) if area > 1.0 else 0.0)
    return PlacedPoint(number, point, row, column, rate, area, side)


def _seen(rays: Rays, point: ElementPoint, time_s: float) -> tuple[Array, Array, tuple[float, float]] | None:
    """Return row and column (M,) of a small element at the instants that the frame shows, and its further motion.

    The motion is in rows and columns per second. None if it is not seen.
    """
    row, column = _at(rays, point, time_s, 0.0)
    beside = max(rays.image.rows, rays.image.columns) + point.side_m / rays.image.pixel_size_m
    if not all(-beside < at < size + beside for at, size in ((row, rays.image.rows), (column, rays.image.columns))):
        return None
    half = 0.5 * (rays.integration_s or _RATE_S)
    (row_0, column_0), (row_1, column_1) = (_at(rays, point, time_s, later) for later in (-half, half))
    if rays.integration_s == 0.0:
        return np.array([row]), np.array([column]), ((row_1 - row_0) / _RATE_S, (column_1 - column_0) / _RATE_S)
    count = max(rays.instants, math.ceil(_STEPS_PER_PIXEL * math.hypot(row_1 - row_0, column_1 - column_0)))
    places = [_at(rays, point, time_s, later) for later in instants_s(rays.integration_s, count)]
    rows, columns = (np.array(positions) for positions in zip(*places, strict=True))
    return rows, columns, (0.0, 0.0)


def _at(rays: Rays, point: ElementPoint, time_s: float, later_s: float) -> Place:
    """Return the row and column of a small element at a time after that of the frame."""
    start = point.x_m, point.y_m, point.altitude_m
    x_m, y_m, z_m = (np.array([at + later_s * speed]) for at, speed in zip(start, point.velocity_m_s, strict=True))
    row, column = rays.project(x_m, y_m, z_m, time_s, later_s)
    return float(row[0]), float(column[0])


def higher_than(point: PlacedPoint, ascending: Sequence[PlacedPoint]) -> list[Rectangle]:
    """Return the outlines of the bodies above an element; at the same altitude later ones hide earlier ones."""
    first = next(number for number, element in enumerate(ascending, start=1) if element is point)
    return [element.outline for element in ascending[first:] if element.area]


def merged(pieces: Sequence[Share | Piece], weights: Array) -> Array:
    """Return the weighted mean of row and column (2,)."""
    places = np.array([(piece.row, piece.column) for piece in pieces])
    mean: Array = weights @ places / np.sum(weights)
    return mean


class WindowPieces:
    """The window that small elements are added to, and those so far: what each adds to each pixel.

    Attributes
    ----------
    drawn, large : dict of (int, int) to list of (PlacedPoint, Share, ndarray (B,))
        Pieces that sensors draw, and those of squares that are too large for it.
    """

    def __init__(
        self, window: Window, in_part: Window, thickness_m: Sequence[Thickness], radiance: NDArray[np.float32]
    ) -> None:
        self._window, self._in_part, self._thickness_m, self.radiance = window, in_part, thickness_m, radiance
        self.drawn = dict[tuple[int, int], list[tuple[PlacedPoint, Share, Array]]]()
        self.large = dict[tuple[int, int], list[tuple[PlacedPoint, Share, Array]]]()

    def at(self, pixel: tuple[int, int]) -> tuple[int, int]:
        """Return the row and column of a pixel of the image in the part."""
        (rows, columns), (y, x) = self._window, self._in_part
        return pixel[0] - rows.start + y.start, pixel[1] - columns.start + x.start

    def holds(self, pixel: tuple[int, int]) -> bool:
        """Whether a pixel of the image is in the window."""
        return all(pixels.start <= at < pixels.stop for at, pixels in zip(pixel, self._window, strict=True))

    def points_of(self, pixel: tuple[int, int], samples: int) -> list[Thickness]:
        """Return the thickness of each layer at the points of a pixel."""
        corner = (at - pixels.start for at, pixels in zip(pixel, self._window, strict=True))
        rows, columns = (points_of(slice(first, first + 1), samples) for first in corner)
        return [thickness[rows, columns] for thickness in self._thickness_m]


def point_of(place: Place, pixel: tuple[int, int], samples: int) -> tuple[int, int]:
    """Return row and column of the point of a pixel that a place is in."""
    i, j = (min(int((at - first) * samples), samples - 1) for at, first in zip(place, pixel, strict=True))
    return i, j
