"""Surfaces in frames: class and temperature of each pixel, and what the stages after it find below a window."""

from __future__ import annotations

from hcss_twin.cube.variables import SURFACE_CLASS, SURFACE_TEMPERATURE
from hcss_twin.engine.ground import Ground
from hcss_twin.engine.stages.stage import FramePart, PartWindow, Stage


class SurfaceStage(Stage):
    """Tells which surface lies below each point."""

    title = "surfaces"
    reads = ("truth",)
    writes = ("ground",)

    def __init__(self, ground: Ground) -> None:
        self._ground = ground

    def apply(self, part: FramePart, window: PartWindow) -> None:
        """Look up the surface of a window, and write the requested truth."""
        surface = window.ground = self._ground.at(part.time_s, window.window)
        if window.observed or SURFACE_CLASS in part.truth:
            window.surface = self._ground.main_class(surface)
        if SURFACE_CLASS in part.truth:
            part.truth[SURFACE_CLASS][window.inside] = window.surface
        if SURFACE_TEMPERATURE in part.truth:
            part.truth[SURFACE_TEMPERATURE][window.inside] = self._ground.mean_temperature_K(surface)
