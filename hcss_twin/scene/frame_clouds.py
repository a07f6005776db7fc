"""The clouds of one instant, window by window, also of generators for which a pixel depends on its whole frame."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import CloudGenerator, Grid
from hcss_twin.scene.building.whole_frames import sums_up
from hcss_twin.scene.footprint import Window, points_of
from hcss_twin.scene.plan import Plan

Thickness = NDArray[np.float32]

WHOLE_POINTS = 2**24
"""Points (4096 x 4096) up to which a frame is made whole by a generator that could also sum it up beforehand."""


class FrameClouds:
    """Thickness of every layer at the points of one instant.

    Parameters
    ----------
    plan : Plan
    time_s : float
    summaries : sequence, optional
        Those of :func:`summaries_of` at the same instant, where they are known already.
    """

    def __init__(self, plan: Plan, time_s: float, summaries: Sequence[Any] | None = None) -> None:
        self._plan, self._time_s = plan, time_s
        self._summaries = summaries_of(plan, time_s) if summaries is None else summaries

    def thickness_m(self, window: Window) -> list[Thickness]:
        """Thickness of each layer at the points of a window of the image, or of what is around it.

        Outside the image only of generators that have ``thickness_around_m``.
        """
        if not _is_inside(window, self._plan.grid):
            return self._around_m(window)
        rows, columns = (points_of(pixels, self._plan.samples_per_pixel) for pixels in window)
        found: list[Thickness] = []
        for generator, cloudy, whole, summary in zip(
            self._plan.generators, self._plan.cloudy_layers, self._whole, self._summaries, strict=True
        ):
            if not cloudy:
                size = rows.stop - rows.start, columns.stop - columns.start
                found.append(np.zeros(size, dtype=np.float32))
            elif whole is not None:
                found.append(whole[rows, columns])
            elif summary is not None:
                found.append(generator.thickness_in_frame_m(self._time_s, rows, columns, summary))  # type: ignore[attr-defined]
            else:
                found.append(generator.thickness_m(self._time_s, rows, columns))
        return found

    def _around_m(self, window: Window) -> list[Thickness]:
        rows, columns = (points_of(pixels, self._plan.samples_per_pixel) for pixels in window)
        size = rows.stop - rows.start, columns.stop - columns.start
        return [
            generator.thickness_around_m(self._time_s, rows, columns, summary)  # type: ignore[attr-defined]
            if cloudy
            else np.zeros(size, dtype=np.float32)
            for generator, cloudy, summary in zip(
                self._plan.generators, self._plan.cloudy_layers, self._around, strict=True
            )
        ]

    @cached_property
    def _whole(self) -> list[Thickness | None]:
        """Whole frames of the layers that are made so."""
        plan = self._plan
        return [
            generator.thickness_m(self._time_s, *_all_points(plan))
            if cloudy and _is_made_whole(plan, generator)
            else None
            for generator, cloudy in zip(plan.generators, plan.cloudy_layers, strict=True)
        ]

    @cached_property
    def _around(self) -> list[Any]:
        """What windows around the image need to know of it."""
        plan = self._plan
        return [
            generator.frame_summary(self._time_s)  # type: ignore[attr-defined]
            if cloudy and summary is None and not generator.declares.tileable
            else summary
            for generator, cloudy, summary in zip(
                plan.generators, plan.cloudy_layers, self._summaries, strict=True
            )
        ]


def summaries_of(plan: Plan, time_s: float) -> list[Any]:
    """Return for each layer what windows need to know of their whole frame; None where that is nothing, or no cloud.

    It takes as long as making the frame two to three times, without its memory.
    """
    return [
        generator.frame_summary(time_s) if cloudy and _is_summed_up(plan, generator) else None  # type: ignore[attr-defined]
        for generator, cloudy in zip(plan.generators, plan.cloudy_layers, strict=True)
    ]


def _is_summed_up(plan: Plan, generator: CloudGenerator) -> bool:
    points = plan.grid.rows * plan.grid.columns * plan.samples_per_pixel**2
    return not generator.declares.tileable and points > WHOLE_POINTS and sums_up(generator)


def _is_made_whole(plan: Plan, generator: CloudGenerator) -> bool:
    return not generator.declares.tileable and not _is_summed_up(plan, generator)


def _is_inside(window: Window, grid: Grid) -> bool:
    return all(
        pixels.start >= 0 and pixels.stop <= size
        for pixels, size in zip(window, (grid.rows, grid.columns), strict=True)
    )


def _all_points(plan: Plan) -> Window:
    grid: Grid = plan.grid
    rows, columns = (slice(0, size * plan.samples_per_pixel) for size in (grid.rows, grid.columns))
    return rows, columns
