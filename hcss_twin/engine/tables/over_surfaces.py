"""Tables for the surfaces of a scene, and look-up with the class and temperature of each point.

Each state of a surface, a class at a temperature, has tables of its own. A point takes those of its class; in a field
of temperature it is interpolated between them (:class:`hcss_twin.plan.surfaces.TemperatureAxis`). The points of a
pixel are averaged afterwards.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.cube.variables import SURFACE_CLASS, SURFACE_TEMPERATURE
from hcss_twin.engine.scene_points import nearest
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.over_directions import PixelViews, pixel_views
from hcss_twin.engine.tables.over_points import Group, PointLookUp
from hcss_twin.engine.tables.radiance_tables import RadianceTables, TableReader, with_largest_errors
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.surface_classes import SEA, SurfaceState
from hcss_twin.plan.surfaces import TemperatureAxis
from hcss_twin.plan.windows import Window, pixel_sums, points_of
from hcss_twin.providers import SurfaceMap

Thickness = NDArray[np.float32]


def plan_over(plan: Plan, state: SurfaceState) -> Plan:
    """Return the plan of the same scene with one surface everywhere; only the scenario's own sea has waves."""
    assembly = plan.assembly.over(state)
    waves = plan.waves if assembly.surface is None else None
    return replace(plan, assembly=assembly, waves=waves, surfaces=None)


def tables_over_surfaces(plan: Plan, tables_of: Callable[[Plan], RadianceTables]) -> RadianceTables:
    """Return the tables of all surfaces of a plan.

    Parameters
    ----------
    tables_of : callable
        Computes the tables of a plan with one surface.

    Returns
    -------
    RadianceTables
        Tables with the most wavenumbers, with the largest errors of all states, and all tables as ``over_surfaces``.
    """
    assert plan.surfaces is not None
    each = tuple(tuple(tables_of(plan_over(plan, state)) for state in states) for states in plan.surfaces.states)
    every = [tables for states in each for tables in states]
    temperature = plan.surfaces.estimated_error
    return replace(with_largest_errors(every), over_surfaces=each, temperature_error=temperature)


class SurfaceStage:
    """Surfaces of a scene at the points of its frames.

    Parameters
    ----------
    tables : RadianceTables or None
        None if no requested variable requires radiance.
    """

    def __init__(self, plan: Plan, tables: RadianceTables | None) -> None:
        assert plan.surfaces is not None
        assert plan.assembly.surfaces is not None
        self._plan, self._provider = plan, plan.assembly.surfaces.provider
        self._classes, self._samples = plan.surfaces.classes, plan.samples_per_pixel
        states = () if tables is None else tables.over_surfaces
        self._readers = [[[TableReader(one) for one in each.over_views or (each,)] for each in own] for own in states]
        self._axes = [
            TemperatureAxis(plan.spectral_grid, nodes) if len(nodes) > 1 else None for nodes in plan.surfaces.nodes_K
        ]
        self._last: tuple[float, Window, SurfaceMap] | None = None

    def at(self, time_s: float, window: Window) -> SurfaceMap:
        """Return the surface at the points of a window of pixels; the last one is kept."""
        if self._last is None or self._last[:2] != (time_s, window):
            rows, columns = (points_of(pixels, self._samples) for pixels in window)
            of_window = (
                self._provider.surface(time_s, rows, columns) if self._plan.is_grid else self._sampled(time_s, window)
            )
            self._last = time_s, window, of_window
        return self._last[2]

    def look_up(self, time_s: float) -> SurfaceLookUp:
        """Return the look-up at an instant."""
        look_ups = [[[LookUp(one.at(time_s)) for one in views] for views in own] for own in self._readers]
        views = pixel_views(self._plan, time_s, [each.table for each in look_ups[0][0]])
        if views is not None:
            look_ups = [[views.look_ups(each) for each in own] for own in look_ups]
        return SurfaceLookUp(self._plan, self, look_ups, self._axes, time_s, views)

    def _sampled(self, time_s: float, window: Window) -> SurfaceMap:
        """Return the surface at the points of the scene that are nearest to those of a window of pixels."""
        scene = self._plan.scene
        row, column = scene.in_points(*self._plan.rays.points_m(window, time_s, 0.0))
        below = scene.around(row, column)
        if below is None:
            return SurfaceMap(np.zeros(row.shape, dtype=np.uint8), np.full(row.shape, self._classes[0].low_K))
        ground = self._provider.surface(time_s, *(points_of(pixels, scene.samples) for pixels in below))
        corner, kelvin = scene.corner_of(below), ground.temperature_K
        kelvin = None if kelvin is None else nearest(kelvin, row, column, corner)
        return SurfaceMap(nearest(ground.number, row, column, corner), kelvin)

    def other_than(self, number: int, ground: SurfaceMap) -> Thickness:
        """Return 1 where the surface is of another class, else 0: in place of a cloud layer, it hides these points."""
        hidden: Thickness = (ground.number != number).astype(np.float32)
        return hidden

    @property
    def sea(self) -> int:
        """Number of the class ``sea``; -1 without it."""
        names = [each.name for each in self._classes]
        return names.index(SEA) if SEA in names else -1

    def tell(self, truth: dict[str, NDArray[Any]], ground: SurfaceMap, place: Window) -> None:
        """Write the requested truth of a window of points to its place in the part."""
        if SURFACE_CLASS in truth:
            truth[SURFACE_CLASS][place] = self.main_class(ground)
        if SURFACE_TEMPERATURE in truth:
            kelvin = pixel_sums(self.temperature_K(ground), self._samples) / self._samples**2
            truth[SURFACE_TEMPERATURE][place] = kelvin

    def main_class(self, ground: SurfaceMap) -> NDArray[np.uint8]:
        """Return the class at most points of each pixel (y, x)."""
        if self._samples == 1:
            number: NDArray[np.uint8] = ground.number.astype(np.uint8)
            return number
        counts = [pixel_sums(ground.number == number, self._samples) for number in range(len(self._classes))]
        most: NDArray[np.uint8] = np.argmax(counts, axis=0).astype(np.uint8)
        return most

    def temperature_K(self, ground: SurfaceMap) -> Array:
        """Return the temperature of each point."""
        constant: Array = np.array([each.low_K for each in self._classes])[ground.number]
        if ground.temperature_K is None:
            return constant
        field = np.array([each.low_K < each.high_K for each in self._classes])[ground.number]
        return np.where(field, ground.temperature_K, constant)

    def states(self, ground: SurfaceMap) -> list[SurfaceState]:
        """Return the state of each point, row by row, at its own temperature."""
        pairs = zip(ground.number.ravel().tolist(), self.temperature_K(ground).ravel().tolist(), strict=True)
        return [self._classes[number].at(kelvin) for number, kelvin in pairs]


class SurfaceLookUp(PointLookUp):
    """Look-up at one instant in the tables of each point's surface.

    Parameters
    ----------
    look_ups : sequence (class) of sequence (temperature) of sequence (view) of LookUp
    axes : sequence of TemperatureAxis or None
        For each class; None for a constant temperature.
    """

    def __init__(
        self,
        plan: Plan,
        stage: SurfaceStage,
        look_ups: Sequence[Sequence[Sequence[LookUp]]],
        axes: Sequence[TemperatureAxis | None],
        time_s: float,
        views: PixelViews | None,
    ) -> None:
        super().__init__(plan, views)
        self._stage, self._look_ups, self._axes, self._time_s = stage, look_ups, axes, time_s

    def _groups(self, window: Window, samples: int) -> Iterator[Group]:
        ground = self._stage.at(self._time_s, window)
        number = ground.number.ravel()
        for own, (states, axis) in enumerate(zip(self._look_ups, self._axes, strict=True)):
            here = np.flatnonzero(number == own)
            if not here.size:
                continue
            weights: Array | None = None
            if axis is not None:
                assert ground.temperature_K is not None
                weights = axis.weights(ground.temperature_K.ravel()[here])
            yield Group(here, states, weights)
