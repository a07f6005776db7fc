"""Surfaces of the scene at the points where the rays of a frame meet the sea level."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hcss_payload.directions import Directions
from hcss_payload.ray_clouds import ScenePoints, nearest
from hcss_payload.ray_geometry import FrameGeometry
from hcss_payload.ray_look_up import FrameViews, frame_views, pixel_weights
from hcss_payload.shutter import Exposure
from hcss_twin.core.arrays import Array
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_surfaces import SurfaceLookUp, SurfaceStage
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, length, points_of
from hcss_twin.providers import SurfaceMap


class RaySurfaceStage(SurfaceStage):
    """Surfaces at the points of a camera's frames: those of the nearest points of the scene."""

    def __init__(
        self,
        plan: Plan,
        tables: RadianceTables | None,
        geometry_at: Callable[[float], FrameGeometry],
        exposure_at: Callable[[float], Exposure],
        directions: Directions,
    ) -> None:
        super().__init__(plan, tables)
        self._geometry_at, self._exposure_at, self._directions = geometry_at, exposure_at, directions
        self._points: tuple[float, ScenePoints] | None = None

    def at(self, time_s: float, window: Window) -> SurfaceMap:
        """Return the surface at the points of a window of pixels; the last one is kept."""
        if self._last is None or self._last[:2] != (time_s, window):
            self._last = time_s, window, self._sampled(time_s, window)
        return self._last[2]

    def look_up(self, time_s: float) -> RaySurfaceLookUp:
        """Return the look-up at an instant."""
        of_pass = [[[LookUp(one.at(time_s)) for one in views] for views in own] for own in self._readers]
        geometry, axis = self._geometry_at(time_s), self._plan.views
        assert axis is not None
        tables = [each.table for own in of_pass for views in own for each in views]
        views = frame_views(axis, self._directions, geometry, tables[: len(of_pass[0][0])])
        look_ups = [[views.look_ups(each) for each in own] for own in of_pass]
        found = RaySurfaceLookUp(self._plan, self, look_ups, self._axes, time_s)
        found.seen = views, self._directions, geometry
        return found

    def _sampled(self, time_s: float, window: Window) -> SurfaceMap:
        if self._points is None or self._points[0] != time_s:
            camera = self._geometry_at(time_s).camera
            points = ScenePoints(self._plan, camera, self._exposure_at(time_s), 0.0, self._samples)
            self._points = time_s, points
        row, column = self._points[1].window(window)
        below = self._points[1].around(row, column)
        if below is None:
            return SurfaceMap(np.zeros(row.shape, dtype=np.uint8), np.full(row.shape, self._classes[0].low_K))
        per = self._plan.scenario.image.samples_per_pixel
        scene = points_of(below[0], per), points_of(below[1], per)
        ground = self._provider.surface(time_s, *scene)
        corner = scene[0].start, scene[1].start
        kelvin = None if ground.temperature_K is None else nearest(ground.temperature_K, row, column, corner)
        return SurfaceMap(nearest(ground.number, row, column, corner), kelvin)


class RaySurfaceLookUp(SurfaceLookUp):
    """Look-up of a frame with the surface of each point and the direction of each pixel.

    Attributes
    ----------
    seen : (FrameViews, Directions, FrameGeometry)
        Of the frame.
    """

    seen: tuple[FrameViews, Directions, FrameGeometry]

    def _view_weights(self, here: NDArray[np.intp], window: Window, samples: int) -> Array | None:
        views, directions, geometry = self.seen
        of_pixels = pixel_weights(views, directions, geometry, window)
        row, column = np.divmod(here, length(window[1]) * samples)
        weights: Array = of_pixels[:, (row // samples) * length(window[1]) + column // samples]
        return weights
