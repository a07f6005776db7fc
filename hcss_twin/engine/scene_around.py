"""The scene around the frames in space and time, for a sensor that measures them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.cube.variables import TOTAL
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.parts import tile_shape
from hcss_twin.engine.stages.placed_points import Piece
from hcss_twin.engine.stream import PartMaker
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.sensor import BuiltSensor, asking
from hcss_twin.plan.windows import Window, cut, length, relative, strips_around
from hcss_twin.providers import Points

__all__ = ["SceneAround"]

_STEP_S = 60.0
"""Distance of times at which tables can lie: less than that in which sunlight bends."""


class SceneAround:
    """Extends clean frames by the surrounding scene, and gives a sensor the scene at other instants.

    Parameters
    ----------
    tables : RadianceTables or None
        Tables that the frames were computed with.
    sensor : BuiltSensor
        The plan's sensor, built for the extended area.

    Attributes
    ----------
    sensor : BuiltSensor
        The sensor, whose stages can ask for the scene at other instants.
    """

    def __init__(self, plan: Plan, tables: RadianceTables | None, sensor: BuiltSensor) -> None:
        radiance = tuple(spec for spec in plan.computed if spec.name == TOTAL)
        alone = replace(plan.assembly, derived=())
        self._plan = replace(plan, variables=radiance, computed=radiance, assembly=alone)
        self._tile = tile_shape(plan)
        self._maker = PartMaker(self._plan, tables)
        self.sensor = asking(sensor, self.at)
        self._other = self._maker
        if sensor.asking:
            self._other = PartMaker(self._plan, tables_at(self._plan, tables, sensor.instants))

    def frame(
        self, index: int, radiance: NDArray[np.float32] | None, time_s: float | None = None
    ) -> tuple[NDArray[np.float32], Points | None]:
        """Return the radiance (B, y, x) of a frame in the area that the sensor needs, and its small elements apart.

        Parameters
        ----------
        index : int
            Number of the frame, from 0.
        radiance : ndarray of float32 (B, y, x) or None
            Radiance of the cube, used unchanged where it has no small elements; only the surroundings are computed.
            None: the cube has none, and all is computed.
        time_s : float, optional
            Time after the start; by default that of the frame.
        """
        time_s = float(self._plan.frame_times_s[index]) if time_s is None else time_s
        given, cube = self.sensor.given, self.sensor.cube
        drawn = _drawn(self._maker, index, given, time_s)
        if radiance is not None and given == cube:
            wide = radiance.copy() if drawn else radiance
        else:
            wide = np.empty((len(self._plan.bands), length(given[0]), length(given[1])), dtype=np.float32)
            if radiance is not None:
                wide[:, *relative(cube, given)] = radiance
            for rest in (given,) if radiance is None else strips_around(cube, given):
                for part in self._parts(rest):
                    arrays, _ = self._maker.part(index, part, time_s=time_s)
                    wide[:, *relative(part, given)] = arrays[TOTAL]
        _take_away(drawn, wide, given)
        return wide, _as_points(drawn, given)

    def at(self, frame: int, time_s: float, rows: slice, columns: slice) -> tuple[Array, Points | None]:
        """Return the radiance (B, y, x) of a window of the measured area at another time, and its small elements.

        The radiance cannot be written to.
        """
        corner, index = self.sensor.inputs.corner, frame - self._plan.scenario.frames.first
        wanted: Window = tuple(  # type: ignore[assignment]
            slice(pixels.start + first, pixels.stop + first)
            for pixels, first in zip((rows, columns), corner, strict=True)
        )
        radiance = np.empty((len(self._plan.bands), length(rows), length(columns)))
        for part in self._parts(wanted):
            arrays, _ = self._other.part(index, part, time_s=time_s)
            radiance[:, *relative(part, wanted)] = arrays[TOTAL]
        drawn = _drawn(self._other, index, wanted, time_s)
        _take_away(drawn, radiance, wanted)
        radiance.flags.writeable = False
        return radiance, _as_points(drawn, wanted)

    def _parts(self, window: Window) -> Iterator[Window]:
        return iter([window]) if self._tile is None else cut(window, *self._tile)


def _drawn(maker: PartMaker, index: int, area: Window, time_s: float) -> list[list[Piece]]:
    """Return the small elements of an area, pixel by pixel."""
    found: dict[tuple[int, int], list[Piece]] = {}
    for window in maker.element_windows(index, area, time_s):
        maker.part(index, window, time_s=time_s)
        found |= maker.drawn
    return list(found.values())


def _take_away(drawn: Sequence[Sequence[Piece]], radiance: NDArray[Any], area: Window) -> None:
    """Set the pixels (B, y, x) of an area that hold small elements to what is behind these."""
    for pieces in drawn:
        row, column = pieces[0].pixel
        radiance[:, row - area[0].start, column - area[1].start] = pieces[0].behind


def _as_points(drawn: Sequence[Sequence[Piece]], area: Window) -> Points | None:
    pieces = [piece for pixel in drawn for piece in pixel]
    if not pieces:
        return None
    return Points(
        np.array([piece.row for piece in pieces]) - area[0].start,
        np.array([piece.column for piece in pieces]) - area[1].start,
        np.array([piece.rate[0] for piece in pieces]),
        np.array([piece.rate[1] for piece in pieces]),
        np.stack([piece.radiance for piece in pieces], axis=1),
    )


def tables_at(plan: Plan, tables: RadianceTables | None, instants: tuple[float, float]) -> RadianceTables | None:
    """Return tables that hold at other instants, too: new ones if these lie outside the frames and the sun matters."""
    frames = plan.frame_times_s
    before, after = frames[:1] + instants[0], frames[-1:] + instants[1]
    if tables is None or not plan.sun_matters or instants == (0.0, 0.0):
        return tables
    # Tables lie at some of these times: close enough that no sensor sees how radiance bends between them.
    between = np.linspace(before[0], after[0], 1 + math.ceil((after[0] - before[0]) / _STEP_S))
    times = np.unique(np.concatenate((frames, between)))
    zenith, azimuth, _ = plan.sun_track.positions(times)
    return compile_tables(replace(plan, frame_times_s=times, sun_zenith_deg=zenith, sun_azimuth_deg=azimuth))
