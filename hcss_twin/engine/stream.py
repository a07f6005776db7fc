"""Computation of frames: cloud thickness from the generators, window by window, and the stages of the scene."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.packing import round_to_steps
from hcss_twin.cube.writer import round_bits
from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.engine.stages.scene_stages import SceneTables, stages_of
from hcss_twin.engine.stages.stage import NOT_SEEN, Frame, FramePart, PartWindow, PixelObserver
from hcss_twin.engine.tables.scene_axes import point_axes
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, length, relative, windows

if TYPE_CHECKING:
    from hcss_twin.engine.certificate.certificate_pixels import PixelSample
    from hcss_twin.engine.stages.placed_points import Piece
    from hcss_twin.engine.tables.frame_look_up import FrameLookUp, FrameLookUps
    from hcss_twin.engine.tables.radiance_tables import RadianceTables

__all__ = ["PartMaker"]


def stream(
    plan: Plan, tables: RadianceTables | None, sample: PixelSample | None = None, frames: Sequence[int] | None = None
) -> Iterator[Frame]:
    """Yield each frame's requested variables; memory use does not depend on the number of frames.

    Nor does it depend on the number of points per pixel if the cloud generators compute windows.

    Parameters
    ----------
    tables : RadianceTables or None
        None if no requested variable requires radiance.
    sample : PixelSample, optional
        Samples pixels of the frames during computation.
    frames : sequence of int, optional
        Frame numbers of the whole sequence, from 0; by default all.
    """
    maker = PartMaker(plan, tables)
    for index in range(plan.frame_times_s.size) if frames is None else frames:
        part = None if sample is None else sample.of_part(index)
        frame, radiance = maker.part(index, plan.extent, part)
        if sample is not None and part is not None:
            sample.add_frame(index, [part.drawn(radiance)])
        yield frame


class PartMaker:
    """Computes parts of frames; consecutive calls for the same frame are most efficient.

    Parameters
    ----------
    tables : RadianceTables or None
        None if no requested variable requires radiance.

    Attributes
    ----------
    drawn : dict of (int, int) to list of Piece
        What small elements added to the pixels of the last part, which sensors draw.
    seconds : dict of str to float
        Wall time of the clouds and of each stage of the last part.
    """

    drawn: dict[tuple[int, int], list[Piece]]

    def __init__(self, plan: Plan, tables: RadianceTables | None) -> None:
        self._plan = plan
        self._quantities = 0 if tables is None else len(tables.quantities.names)
        axes = point_axes(plan)
        self._look_ups: FrameLookUps | None = None
        if tables is not None:
            from hcss_twin.engine.tables.frame_look_up import FrameLookUps  # a mask alone needs no radiance

            self._look_ups = FrameLookUps(plan, tables, axes)
        self._stages = stages_of(SceneTables(plan, tables, axes))
        self._lit = any("light between columns" in stage.writes for stage in self._stages)
        self._bits = {spec.name: spec.significant_bits for spec in plan.variables if spec.significant_bits is not None}
        self._packings = {spec.name: spec.packing for spec in plan.variables if spec.packing is not None}
        self._requested = {spec.name for spec in plan.variables}
        self._instant: tuple[Hashable, FrameClouds, FrameLookUp | None] | None = None
        self.seconds = dict[str, float]()

    def part(
        self,
        index: int,
        extent: Window,
        sample: PixelObserver | None = None,
        summaries: Sequence[Any] | None = None,
        time_s: float | None = None,
    ) -> tuple[Frame, NDArray[np.float32]]:
        """Return the requested variables of a part of a frame, and its radiance (Q, B, y, x) as stored in the cube.

        With light between columns the second is that of independent columns, which the certificate checks. The result
        for a pixel is bit-identical in every part.

        Parameters
        ----------
        index : int
            Number of the frame.
        extent : (slice, slice)
            Rows and columns of the image.
        sample : PixelObserver, optional
            Observes the pixels, for example for the certificate.
        summaries : sequence, optional
            As in :class:`FrameClouds`.
        time_s : float, optional
            Time after the start; by default that of the frame.
        """
        plan = self._plan
        self.seconds = {}
        with self._timed("tables of the frame"):
            part = self._begun(index, extent, time_s, summaries)
        for stage in self._stages:
            with self._timed(stage.title):
                stage.begin(part)
        for window in windows(plan.image, plan.samples_per_pixel, inside=extent):
            with self._timed("clouds"):
                seen = PartWindow(relative(window, extent), part.clouds.thickness_m(window))
            seen.window, seen.samples, seen.observed = window, plan.samples_per_pixel, sample is not None
            for stage in self._stages:
                with self._timed(stage.title):
                    stage.apply(part, seen)
            if sample is not None:
                unseen = plan.rays.unseen(window, part.time_s)
                seen.left_out |= {} if unseen is None else {NOT_SEEN: unseen}
                sample.observe(seen)
        frame: Frame = dict(part.truth)
        for stage in self._stages:
            with self._timed(stage.title):
                stage.finish(part, frame)
        self.drawn = part.drawn
        with self._timed("coordinates and missing pixels"):
            plan.rays.complete(frame, part.time_s, extent)
        for name, bits in self._bits.items():
            round_bits(frame[name], bits)
        for name, packing in self._packings.items():
            round_to_steps(frame[name], packing, f"frame {index}, {name}")
        requested = {name: values for name, values in frame.items() if name in self._requested}
        return requested, part.radiance.reshape(self._quantities, len(plan.bands), *part.radiance.shape[1:])

    @contextmanager
    def _timed(self, what: str) -> Iterator[None]:
        began = perf_counter()
        yield
        self.seconds[what] = self.seconds.get(what, 0.0) + perf_counter() - began

    def element_windows(self, index: int, area: Window, time_s: float | None = None) -> list[Window]:
        """Return windows of an area of the image that hold all small elements of a frame that sensors draw."""
        part = self._begun(index, (slice(0, 0), slice(0, 0)), time_s)
        return [window for stage in self._stages for window in stage.windows(part, area)]

    def _begun(
        self, index: int, extent: Window, time_s: float | None, summaries: Sequence[Any] | None = None
    ) -> FramePart:
        """Return a part whose windows are still to be computed."""
        plan = self._plan
        time_s = float(plan.frame_times_s[index]) if time_s is None else time_s
        key = index, plan.rays.frame_key(time_s)
        if self._instant is None or self._instant[0] != key:
            self._instant = None  # one whole frame of clouds at a time
            clouds = FrameClouds(plan, time_s, summaries)
            self._instant = key, clouds, None if self._look_ups is None else self._look_ups.at(time_s)
        _, clouds, look_up = self._instant
        look_up = None if look_up is None else look_up.of_part(extent)
        radiance = np.empty((self._quantities * len(plan.bands), *map(length, extent)), dtype=np.float32)
        shown = np.empty_like(radiance) if self._lit else radiance
        return FramePart(index, time_s, extent, clouds, look_up, radiance, shown)
