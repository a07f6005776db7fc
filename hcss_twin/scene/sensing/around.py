"""Radiance of a frame together with what a sensor sees around it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hcss_twin.scene.footprint import Window, cut, length, relative
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.sensing.made_sensor import MadeSensor
from hcss_twin.scene.stream import PartMaker
from hcss_twin.scene.tables.radiance_tables import TOTAL, RadianceTables
from hcss_twin.scene.tiles import tile_shape


class SceneAround:
    """Puts clean frames into the scene around them.

    Parameters
    ----------
    plan : Plan
    tables : RadianceTables or None
        As the frames were made with.
    sensor : MadeSensor
        The plan's, made for the part of the scene that it is given.
    """

    def __init__(self, plan: Plan, tables: RadianceTables | None, sensor: MadeSensor) -> None:
        self._plan, self._sensor = plan, sensor
        self._maker = PartMaker(plan, tables)

    def frame(self, index: int, radiance: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return radiance (B, y, x) of what the sensor is given of a frame.

        Parameters
        ----------
        index : int
            Number of the frame, from 0.
        radiance : ndarray of float32 (B, y, x)
            Of the cube; it is taken as it is, and only what is around it is computed.
        """
        given, cube = self._sensor.given, self._sensor.cube
        if given == cube:
            return radiance
        wide = np.empty((radiance.shape[0], length(given[0]), length(given[1])), dtype=np.float32)
        wide[:, *relative(cube, given)] = radiance
        tile = tile_shape(self._plan)
        for strip in _strips(given, cube):
            for part in [strip] if tile is None else cut(strip, *tile):
                arrays, _ = self._maker.part(index, part)
                wide[:, *relative(part, given)] = arrays[TOTAL]
        return wide


def _strips(given: Window, cube: Window) -> Iterator[Window]:
    """Yield what is given below, above, left and right of the cube."""
    (rows, columns), (inner_rows, inner_columns) = given, cube
    candidates = (
        (slice(rows.start, inner_rows.start), columns),
        (slice(inner_rows.stop, rows.stop), columns),
        (inner_rows, slice(columns.start, inner_columns.start)),
        (inner_rows, slice(inner_columns.stop, columns.stop)),
    )
    yield from (window for window in candidates if length(window[0]) and length(window[1]))
