"""Clouds and surfaces of the scene at the points where the rays of a frame meet them.

Each layer is met at the height of its flat side, as in :mod:`hcss_twin.plan.slant_paths`, so that every layer moves
against the sea, and against the others, with the direction of view.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.camera import Camera
from hcss_payload.checks import PayloadError
from hcss_payload.mesh import STEP, Mesh, MeshValues
from hcss_payload.scene_plane import surface_place, to_scene
from hcss_payload.shutter import Exposure
from hcss_twin.core.arrays import Array
from hcss_twin.core.kernels import kernel
from hcss_twin.engine.stream import FrameClouds
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.slant_paths import reference_height_m
from hcss_twin.plan.windows import Window, length, points_of

Thickness = NDArray[np.float32]

LARGEST_POINTS = 2**26
"""Points of the scene below one window."""


class ScenePoints:
    """Where the points of a frame meet a height, in rows and columns of the scene's points.

    Parameters
    ----------
    per_pixel : int
        Points of the frame along each side of a pixel.
    exposure : Exposure
        The instants of the frame.
    """

    def __init__(self, plan: Plan, camera: Camera, exposure: Exposure, altitude_m: float, per_pixel: int) -> None:
        place = plan.scenario.place
        centre = place.latitude, place.longitude

        def in_plane(position_m: Array) -> Array:
            # Below a point at some altitude lies the place with its geodetic latitude; the ellipsoid through it is
            # larger by the altitude and has nearly the same normal.
            x, y, _ = to_scene(*surface_place(position_m), centre)
            return np.stack((x, y), axis=-1)

        self._instants = [
            MeshValues(Mesh(camera, pose, altitude_m, per_pixel, STEP * per_pixel, lines=lines), in_plane)
            for pose, lines in exposure.instants
        ]
        self._which = exposure.shutter.which(per_pixel) if len(self._instants) > 1 else None
        self._grid, self._per, self._per_pixel = plan.grid, plan.scenario.image.samples_per_pixel, per_pixel

    def window(self, window: Window) -> tuple[Array, Array]:
        """Return row and column (y, x) of the points of a window of pixels; centres of points are whole numbers."""
        points = [points_of(pixels, self._per_pixel) for pixels in window]
        places = self._instants[0].window(*points)
        if self._which is not None:
            for number, instant in enumerate(self._instants[1:], start=1):
                own, per = instant.window(*points), self._per_pixel
                for y, x in np.argwhere(self._which == number):
                    places[y::per, x::per] = own[y::per, x::per]
        return self._in_points(places)

    def _in_points(self, place_m: Array) -> tuple[Array, Array]:
        point_m = self._grid.pixel_size_m / self._per
        return (
            place_m[..., 1] / point_m + 0.5 * (self._grid.rows * self._per - 1),
            place_m[..., 0] / point_m + 0.5 * (self._grid.columns * self._per - 1),
        )

    def around_nodes(self) -> Window | None:
        """Return the pixels of the scene that the nodes of the mesh see."""
        each = [self._in_points(instant.at_nodes) for instant in self._instants]
        return self.around(
            *(np.concatenate([np.ravel(place) for place in places]) for places in zip(*each, strict=True))
        )

    def around(self, row: Array, column: Array) -> Window | None:
        """Return the pixels of the scene that hold places; None if all are NaN."""
        if np.all(np.isnan(row)):
            return None
        return _around(row, self._per, self._grid.rows), _around(column, self._per, self._grid.columns)


class RayClouds:
    """Thickness of every layer at the points of one frame."""

    def __init__(self, plan: Plan, camera: Camera, exposure: Exposure) -> None:
        self._plan, self._camera, self._exposure = plan, camera, exposure

    def thickness_m(self, window: Window) -> list[Thickness]:
        """Return the thickness of each layer at the points of a window of pixels, in or around the image."""
        return [self._of_layer(number, window) for number in range(len(self._plan.layers))]

    def below(self, number: int) -> Window | None:
        """Return the pixels of the scene that the nodes of the mesh see through a layer; None if none does."""
        return self._points[number].around_nodes()

    @cached_property
    def _points(self) -> list[ScenePoints]:
        plan = self._plan
        heights = (reference_height_m(layer) for layer in plan.layers)
        return [ScenePoints(plan, self._camera, self._exposure, height, plan.samples_per_pixel) for height in heights]

    @cached_property
    def _clouds(self) -> list[FrameClouds]:
        """Clouds of each layer alone, whose windows differ."""
        plan, assembly = self._plan, self._plan.assembly
        pairs = zip(plan.layers, assembly.generators, strict=True)
        alone = (replace(assembly, layers=(layer,), generators=(generator,)) for layer, generator in pairs)
        per = plan.scenario.image.samples_per_pixel
        return [
            FrameClouds(
                replace(plan, assembly=own, layers=own.layers, samples_per_pixel=per, imager=None),
                self._exposure.pose.time_s,
            )
            for own in alone
        ]

    def _of_layer(self, number: int, window: Window) -> Thickness:
        plan, points = self._plan, self._points[number]
        row, column = points.window(window)
        below = points.around(row, column)
        if below is None or not plan.assembly.cloudy_layers[number]:
            return np.zeros(row.shape, dtype=np.float32)
        require_in_reach(plan, number, below, self._exposure.pose.time_s)
        (field,) = self._clouds[number].thickness_m(below)
        corner = [points_of(pixels, plan.scenario.image.samples_per_pixel).start for pixels in below]
        result = np.empty(row.shape, dtype=np.float32)
        _interpolate(result, np.ascontiguousarray(field), row, column, corner[0], corner[1])
        return result


def require_in_reach(plan: Plan, layer: int, below: Window, time_s: float) -> None:
    """Raise a :class:`PayloadError` if a window of the scene is too large or outside the clouds."""
    rows, columns = below
    inside = (
        rows.start >= 0 and columns.start >= 0 and rows.stop <= plan.grid.rows and columns.stop <= plan.grid.columns
    )
    per = plan.scenario.image.samples_per_pixel
    count = length(rows) * length(columns) * per**2
    if count > LARGEST_POINTS:
        raise PayloadError(
            f"camera: sees {count:.3g} points of the scene at time {time_s:g} s; allowed: up to "
            f"{LARGEST_POINTS:.3g}, with larger image.pixel_size or a smaller field"
        )
    if not inside and not hasattr(plan.assembly.generators[layer], "thickness_around_m"):
        raise PayloadError(
            f"camera: sees rows {rows.start} to {rows.stop} and columns {columns.start} to {columns.stop} of the scene "
            f"at time {time_s:g} s; allowed: its {plan.grid.rows} x {plan.grid.columns} pixels, since this cloud "
            "generator ends there"
        )


def nearest(values: NDArray[Any], row: Array, column: Array, corner: tuple[int, int]) -> NDArray[Any]:
    """Return the values (Y, X) of a window of the scene nearest to places (y, x); those of its edge beyond it."""
    y, x = (
        np.clip(np.rint(np.nan_to_num(place)).astype(np.int64) - first, 0, size - 1)
        for place, first, size in zip((row, column), corner, values.shape, strict=True)
    )
    return values[y, x]


def _around(place: Array, per_pixel: int, size: int) -> slice:
    """Return the pixels of the scene that hold places; those that end on its border stay inside."""
    least, most = float(np.nanmin(place)), float(np.nanmax(place))
    low, high = int(np.floor(least)), int(np.floor(most)) + 2
    # Half a point beyond the outermost centres is still inside the image.
    if least >= -0.5:
        low = max(low, 0)
    if most <= size * per_pixel - 0.5:
        high = min(high, size * per_pixel)
    return slice(low // per_pixel, -(-high // per_pixel))


@kernel()
def _interpolate(result, field, row, column, first_row, first_column):  # type: ignore[no-untyped-def]
    """Interpolate the thickness of a field (Y, X) at places (y, x), counted from the first point of the scene.

    A place is cloudy if the bilinear weights of its cloudy neighbours are at least half; then its thickness is their
    mean, so that none is thinner than the thinnest cloud. Places that are NaN are clear.
    """
    last_y, last_x = field.shape[0] - 1, field.shape[1] - 1
    for i in range(row.shape[0]):
        for j in range(row.shape[1]):
            result[i, j] = 0.0
            if not (row[i, j] == row[i, j] and column[i, j] == column[i, j]):
                continue
            # Whole parts first: a place has the same bits whatever the window.
            top, left = np.floor(row[i, j]), np.floor(column[i, j])
            y, x = row[i, j] - top, column[i, j] - left
            up, side = np.int64(top) - first_row, np.int64(left) - first_column
            if up < 0:
                up, y = 0, 0.0
            elif up >= last_y:
                up, y = max(last_y - 1, 0), 1.0 if last_y > 0 else 0.0
            if side < 0:
                side, x = 0, 0.0
            elif side >= last_x:
                side, x = max(last_x - 1, 0), 1.0 if last_x > 0 else 0.0
            cloudy, total = 0.0, 0.0
            for a in range(2):
                for b in range(2):
                    weight = (y if a else 1.0 - y) * (x if b else 1.0 - x)
                    value = np.float64(field[min(up + a, last_y), min(side + b, last_x)])
                    if weight > 0.0 and value > 0.0:
                        cloudy += weight
                        total += weight * value
            if cloudy >= 0.5:
                result[i, j] = np.float32(total / cloudy)
