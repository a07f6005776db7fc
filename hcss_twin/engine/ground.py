"""The surface at the points of a scene's frames: class and temperature, as providers of surfaces give them."""

from __future__ import annotations

from collections.abc import Hashable

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.engine.scene_points import nearest
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.surface_classes import SEA, SurfaceState
from hcss_twin.plan.surfaces import PlannedSurfaces
from hcss_twin.plan.windows import Window, pixel_sums, points_of
from hcss_twin.providers import SurfaceMap


class Ground:
    """Surfaces of a scene.

    Parameters
    ----------
    surfaces : PlannedSurfaces
        Those of the plan.
    """

    def __init__(self, plan: Plan, surfaces: PlannedSurfaces) -> None:
        (of_scene,) = plan.assembly.surfaces
        self._plan, self._provider = plan, of_scene.provider
        self._classes, self._samples = surfaces.classes, plan.samples_per_pixel
        self._last: tuple[Hashable, Window, SurfaceMap] | None = None

    def at(self, time_s: float, window: Window) -> SurfaceMap:
        """Return the surface at the points of a window of pixels; the last one is kept."""
        key = self._plan.rays.frame_key(time_s)
        if self._last is None or self._last[:2] != (key, window):
            rows, columns = (points_of(pixels, self._samples) for pixels in window)
            of_scene = self._plan.is_grid
            surface = self._provider.surface(time_s, rows, columns) if of_scene else self._sampled(time_s, window)
            self._last = key, window, surface
        return self._last[2]

    def _sampled(self, time_s: float, window: Window) -> SurfaceMap:
        """Return the surface at the points of the scene that are nearest to those of a window of pixels."""
        scene = self._plan.scene
        row, column = scene.in_points(*self._plan.rays.points_m(window, time_s, 0.0))
        below = scene.around(row, column)
        if below is None:
            return SurfaceMap(np.zeros(row.shape, dtype=np.uint8), np.full(row.shape, self._classes[0].low_K))
        surface = self._provider.surface(time_s, *(points_of(pixels, scene.samples) for pixels in below))
        corner, kelvin = scene.corner_of(below), surface.temperature_K
        kelvin = None if kelvin is None else nearest(kelvin, row, column, corner)
        return SurfaceMap(nearest(surface.number, row, column, corner), kelvin)

    @property
    def sea(self) -> int:
        """Number of the class ``sea``; -1 without it."""
        names = [surface.name for surface in self._classes]
        return names.index(SEA) if SEA in names else -1

    def main_class(self, surface: SurfaceMap) -> NDArray[np.uint8]:
        """Return the class at most points of each pixel (y, x)."""
        if self._samples == 1:
            number: NDArray[np.uint8] = surface.number.astype(np.uint8)
            return number
        counts = [pixel_sums(surface.number == number, self._samples) for number in range(len(self._classes))]
        most: NDArray[np.uint8] = np.argmax(counts, axis=0).astype(np.uint8)
        return most

    def temperature_K(self, surface: SurfaceMap) -> Array:
        """Return the temperature of each point."""
        constant: Array = np.array([of_class.low_K for of_class in self._classes])[surface.number]
        if surface.temperature_K is None:
            return constant
        field = np.array([of_class.low_K < of_class.high_K for of_class in self._classes])[surface.number]
        return np.where(field, surface.temperature_K, constant)

    def mean_temperature_K(self, surface: SurfaceMap) -> Array:
        """Return the mean temperature of each pixel (y, x)."""
        mean: Array = pixel_sums(self.temperature_K(surface), self._samples) / self._samples**2
        return mean

    def states(self, surface: SurfaceMap) -> list[SurfaceState]:
        """Return the state of each point, row by row, at its own temperature."""
        pairs = zip(surface.number.ravel().tolist(), self.temperature_K(surface).ravel().tolist(), strict=True)
        return [self._classes[number].at(kelvin) for number, kelvin in pairs]
