"""Stages: what makes the pixels of a frame, one after another.

A part of a frame is computed window by window. Each stage finds what the stages before it have made of a window, and
changes it: clouds are looked up in tables, then come light between columns, surfaces, texture, shadows, waves and
elements; variables that need whole parts come last. Each declares what it reads and writes, from which this order
follows. A scene has only the stages that it needs (:mod:`.scene_stages`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.plan.windows import Window, length
from hcss_twin.providers import SurfaceMap

if TYPE_CHECKING:
    from hcss_twin.engine.tables.frame_look_up import FrameLookUp

WITH_ELEMENTS, NOT_SEEN = "with elements", "beyond the ground that is computed"
REASONS = (WITH_ELEMENTS, NOT_SEEN)
"""Why the certificate leaves out pixels."""

EVEN = np.zeros((1, 1), np.float32), np.zeros((1, 1), np.float32)
"""Perturbation of pixels without texture."""

Thickness = NDArray[np.float32]
Frame = dict[str, NDArray[Any]]


@dataclass
class FramePart:
    """A part of a frame, while stages compute it.

    Attributes
    ----------
    index : int
        Number of the frame.
    time_s : float
        Time after the start.
    extent : (slice, slice)
        Rows and columns of the part in the image.
    clouds : FrameClouds
        Clouds of the frame.
    look_up : FrameLookUp or None
        Look-up of the part; None without radiance.
    radiance : ndarray of float32 (C, y, x)
        Every band and term of independent columns.
    shown : ndarray of float32 (C, y, x)
        The same with light between columns; without it this is ``radiance`` itself.
    truth : dict of str to ndarray (..., y, x)
        Truth variables.
    added : dict of str to ndarray of float32 (B, y, x)
        What elements add to the radiance, of those variables that are wanted.
    drawn : dict of (int, int) to list
        What small elements added to the pixels, which sensors draw.
    """

    index: int
    time_s: float
    extent: Window
    clouds: FrameClouds
    look_up: FrameLookUp | None
    radiance: NDArray[np.float32]
    shown: NDArray[np.float32]
    truth: Frame = field(default_factory=dict)
    added: Frame = field(default_factory=dict)
    drawn: dict[tuple[int, int], list[Any]] = field(default_factory=dict)

    @contextmanager
    def changing_columns(self, inside: Window) -> Iterator[None]:
        """Let a stage change the radiance of columns in a window; light between columns is shown on top of it."""
        if self.shown is self.radiance:
            yield
            return
        before = self.radiance[:, *inside].copy()
        yield
        self.shown[:, *inside] = np.maximum(self.shown[:, *inside] + (self.radiance[:, *inside] - before), 0.0)


@dataclass
class SeenWindow:
    """What is known of the pixels of a window of a part when its radiance is computed.

    Attributes
    ----------
    inside : (slice, slice)
        Rows and columns, in pixels of the part.
    thickness_m : sequence of ndarray (window rows x samples, window columns x samples)
        Of each layer.
    left_out : dict of str to ndarray of bool (window rows, window columns)
        Pixels whose radiance the certificate cannot compute, by one of ``REASONS``.
    surface : ndarray of uint8 (window rows, window columns) or None
        Class of the surface at most points of each pixel; None where all are the scenario's sea.
    shaded : ndarray of bool (window rows, window columns) or None
        Pixels with points in the shadow of clouds; None without shadows.
    """

    inside: Window
    thickness_m: Sequence[Thickness]
    left_out: dict[str, NDArray[np.bool_]] = field(default_factory=dict)
    surface: NDArray[np.uint8] | None = None
    shaded: NDArray[np.bool_] | None = None


@dataclass
class PartWindow(SeenWindow):
    """A window of a part, while stages compute it.

    Attributes
    ----------
    window : (slice, slice)
        Rows and columns, in pixels of the image.
    samples : int
        Points along each side of a pixel.
    observed : bool
        Whether ``left_out`` and ``surface`` are wanted.
    ground : SurfaceMap or None
        Surface at its points; None where all are the scenario's sea.
    perturbation : (ndarray of float32, ndarray of float32)
        How far texture perturbs the pixels (window rows or 1, window columns or 1), in steps toward warm sea and toward
        dry air.
    kept_back : ndarray of float32 (B, window rows x samples, window columns x samples) or None
        Share of the direct sunlight in each band that clouds keep from clear points, if a later stage needs it; of this
        window alone, whose memory the next one uses again; without meaning at other points.
    """

    window: Window = (slice(0), slice(0))
    samples: int = 1
    observed: bool = False
    ground: SurfaceMap | None = None
    perturbation: tuple[NDArray[np.float32], NDArray[np.float32]] = EVEN
    kept_back: NDArray[np.float32] | None = None

    @cached_property
    def clear(self) -> NDArray[np.bool_]:
        """The points (window rows x samples, window columns x samples) without cloud."""
        if not self.thickness_m:
            return np.ones([length(pixels) * self.samples for pixels in self.window], dtype=np.bool_)
        first, *others = (thickness <= 0.0 for thickness in self.thickness_m)
        for clear in others:
            first &= clear
        return first

    def clear_points(self, surface: int) -> NDArray[np.bool_]:
        """Return the points of a surface without cloud, as ``clear``."""
        return self.clear if self.ground is None else self.clear & (self.ground.number == surface)


class PixelObserver(Protocol):
    """Observes the clouds of a part of a frame during computation, window by window."""

    def observe(self, seen: SeenWindow) -> None:
        """Take a window."""


class Stage:
    """One stage of all parts of a scene, the base of those that ``stages_of`` in ``scene_stages.py`` returns.

    Attributes
    ----------
    title : str
        What it computes, for those who ask what takes how long.
    reads, writes : tuple of str
        Names of what the stage finds and makes, such as ``columns`` (radiance of independent columns) or ``sunlight``
        (its shadows). They alone decide the order: a stage runs after all that write what it reads.
    """

    title = "a stage"
    reads: ClassVar[tuple[str, ...]] = ()
    writes: ClassVar[tuple[str, ...]] = ()

    def begin(self, part: FramePart) -> None:
        """Prepare for the windows of a part; by default nothing."""

    def apply(self, part: FramePart, window: PartWindow) -> None:
        """Compute a window of the part; by default nothing."""

    def finish(self, part: FramePart, frame: Frame) -> None:
        """Add to the variables of a complete part; by default nothing."""

    def windows(self, part: FramePart, area: Window) -> list[Window]:
        """Return windows of an area of the image that hold what sensors draw; by default none."""
        return []
