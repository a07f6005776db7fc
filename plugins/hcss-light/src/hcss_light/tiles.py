"""Views that vary over an image: squares of pixels in each of which the directions of the view are constant.

The line of sight of a pixel meets the flat side of the clouds at its own place, or another altitude if their tops vary;
a direction that is not its own displaces it elsewhere in the clouds by at most the distance in height times the
difference of the tangents of the zenith angles.
"""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from hcss_light.voxels import LightError
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, View

if TYPE_CHECKING:
    from hcss_light.scattered import ScatteredLight

LEAST_SIDE = 32
"""Pixels along the sides of the smallest squares; in smaller ones most of the time would go into the clouds around."""

LEAST_SIDE_SMALL = 8
"""The same for rays that form no grid on the ground, whose pixels are often larger than the points of the scene, and
for clouds with tops of their own."""

MOST_DISPLACED, MOST_OF_WHOLE = 0.5, 0.1
"""Largest displacement of a line of sight at the farthest end of the clouds, in points; of clouds that are displaced as
a whole, as lines of sight are those through points of the sea."""


class Tiles:
    """Squares of an image with one direction of the view each.

    Parameters
    ----------
    light : ScatteredLight
        Toward any of the views.

    Attributes
    ----------
    side : int
        Pixels along the sides.
    displaced : float
        Largest displacement of a line of sight within the clouds, in points.

    Raises
    ------
    LightError
        If the view varies so much that squares would have to be smaller than :data:`LEAST_SIDE`.
    """

    def __init__(self, plan: Plan, light: ScatteredLight) -> None:
        self._views, self._size = plan.views_over_image(), (plan.image.rows, plan.image.columns)
        self._rays = None if plan.is_grid else plan.rays
        self._times_s = plan.frame_times_s[:1] if plan.is_grid else plan.frame_times_s[[0, -1]]
        points, most = light.farthest_m / plan.scene.point_m, MOST_OF_WHOLE if light.through_sea else MOST_DISPLACED
        side, least = max(LightStage.largest_square // plan.samples_per_pixel, 1), LEAST_SIDE
        if self._rays is not None:
            side, least = min(side, LEAST_SIDE), LEAST_SIDE_SMALL
        elif light.through_sea:
            least = LEAST_SIDE_SMALL
        self.side = min(max(self._size), side)
        while (displaced := points * self._turn()) > most and self.side > least:
            self.side = max(self.side // 2, least)
        self.displaced = displaced
        if displaced > most:
            raise LightError(
                f"views that vary over the image displace lines of sight by {displaced:.2g} points in squares of "
                f"{self.side} pixels; allowed: {most:g}: a higher sensor or larger pixels need less"
            )

    def view_of(self, row: int, column: int, time_s: float) -> View:
        """Return the view from the middle of the part of a square that lies in the image, at a time."""
        (view,) = self._at([self._middle(row, column)], time_s)
        return view

    @property
    def corners(self) -> list[View]:
        """Views from the squares in the corners of the image."""
        last = [-(-size // self.side) - 1 for size in self._size]
        places = product(self._times_s.tolist(), (0, last[0]), (0, last[1]))
        return [self.view_of(row, column, time_s) for time_s, row, column in places]

    def _middle(self, row: int, column: int) -> tuple[float, float]:
        edges = [
            (min(max(at * self.side, 0), size), min(max((at + 1) * self.side, 0), size))
            for at, size in zip((row, column), self._size, strict=True)
        ]
        return 0.5 * sum(edges[0]), 0.5 * sum(edges[1])

    def _at(self, places: list[tuple[float, float]], time_s: float) -> list[View]:
        """Return the views from rows and columns, counted from the edges of the image."""
        rows, columns = self._size
        if self._rays is not None:
            row, column = (
                [min(max(int(at), 0), size - 1) for at in axis]
                for axis, size in zip(zip(*places, strict=True), self._size, strict=True)
            )
            return self._rays.views_of_pixels(row, column, time_s)
        views: list[View] = self._views.at([(2.0 * x / columns - 1.0, 2.0 * y / rows - 1.0) for y, x in places])
        return views

    def _turn(self) -> float:
        """Return the largest difference of tangents between a corner and the middle of squares all over the image."""
        count = [-(-size // self.side) for size in self._size]
        largest = 0.0
        numbers = (sorted({0, number // 2, number - 1}) for number in count)
        for time_s, row, column in product(self._times_s.tolist(), *numbers):
            y, x = self._middle(row, column)
            half = [min(0.5 * self.side, 0.5 * size) for size in self._size]
            corners = [(y + up * half[0], x + right * half[1]) for up, right in product((-1.0, 1.0), repeat=2)]
            tangents = np.array([_tangent(direction) for direction in self._at([(y, x), *corners], time_s)])
            largest = max(largest, float(np.max(np.hypot(*(tangents[1:] - tangents[0]).T))))
        return largest


def _tangent(view: View) -> Array:
    azimuth = math.radians(view.azimuth_deg)
    return math.tan(math.radians(view.zenith_deg)) * np.array([math.cos(azimuth), math.sin(azimuth)])
