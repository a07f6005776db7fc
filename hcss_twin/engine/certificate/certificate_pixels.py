"""The pixels that a certificate checks: drawn at random while the frames are made, some of each kind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.engine.certificate.part_sample import Counts, DrawnPixels, PartSample, Thickness, smallest
from hcss_twin.engine.tables.spectrum import checked_frames
from hcss_twin.plan.plan import Plan

PIXELS_PER_FRAME = 24
"""Frames are as many as there are so many pixels: each has a sun of its own, which costs the model most."""

POINTS_PER_PIXEL = 4
"""Points that a pixel may have on average; of pixels with more, fewer are checked."""


@dataclass(frozen=True)
class SampledPixels:
    """Pixels of one frame: their clouds and what the cube says.

    Attributes
    ----------
    frame : int
        Number of the frame in the cube.
    time_s : float
    stratum : ndarray (M,)
    row, column : ndarray (M,)
    thickness_m : ndarray of float32 (M, L, P)
        Of each layer at the points of the pixel.
    radiance : ndarray of float32 (M, Q, B)
        The total and the terms that are looked up, as the cube has them.
    pixels : ndarray (S,)
        Pixels of each stratum in the frame that could have been drawn.
    in_shadow, with_waves : ndarray (S,)
        Those that the reference cannot follow: in the shadow of a cloud, and clear in part with drawn waves.
    """

    frame: int
    time_s: float
    stratum: NDArray[np.int64]
    row: NDArray[np.int64]
    column: NDArray[np.int64]
    thickness_m: Thickness
    radiance: NDArray[np.float32]
    pixels: Counts
    in_shadow: Counts
    with_waves: Counts


class PixelSample:
    """What is drawn from the frames of a run, the same in every run of a plan.

    Parameters
    ----------
    plan : Plan
        Its ``output.certificate`` is how many pixels are drawn; fewer where a pixel has more than four points.

    Attributes
    ----------
    frames : list of SampledPixels
        What was drawn, once the frames are made.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self.frames: list[SampledPixels] = []
        asked = plan.scenario.output.certificate
        count = min(asked, max(1, POINTS_PER_PIXEL * asked // plan.samples_per_pixel**2))
        self._count = _per_frame(count, plan.frame_times_s.size)

    def of_frame(self, index: int) -> FrameSample | None:
        """Return what gathers the pixels of a frame; None if nothing is drawn from it."""
        count = self._count.get(index)
        return None if count is None else FrameSample(self._plan, index, count, self.frames)

    def of_part(self, index: int, before: int = 0, corner: tuple[int, int] = (0, 0)) -> PartSample | None:
        """Return what draws from a part of a frame, as in :class:`PartSample`; None if nothing is drawn from it."""
        count = self._count.get(index)
        return None if count is None else PartSample(self._plan, index, count, before, corner)


class FrameSample:
    """Gathers what was drawn from the parts of one frame.

    Each pixel gets a random number, and those with the smallest are kept: of each stratum a simple random sample.
    """

    def __init__(self, plan: Plan, index: int, count: int, found: list[SampledPixels]) -> None:
        self._plan, self._index, self._count, self._found = plan, index, count, found
        self._drawn: list[DrawnPixels] = []

    def add(self, drawn: DrawnPixels) -> None:
        """Take what was drawn from a part; parts come in order."""
        self._drawn.append(drawn)

    def finish(self) -> None:
        """Keep as many as the certificate wants, once all parts are there."""
        place = np.concatenate([each.place for each in self._drawn])
        key = np.concatenate([each.key for each in self._drawn])
        pixels = np.sum([each.pixels for each in self._drawn], axis=0)
        chosen = np.concatenate(
            [smallest(key, place[:, 0] == number, count) for number, count in enumerate(allot(self._count, pixels))]
        )
        stratum, row, column = place[chosen].T
        self._found.append(
            SampledPixels(
                frame=self._index,
                time_s=float(self._plan.frame_times_s[self._index]),
                stratum=stratum,
                row=row,
                column=column,
                thickness_m=np.concatenate([each.points for each in self._drawn])[chosen],
                radiance=np.concatenate([each.radiance for each in self._drawn])[chosen],
                pixels=pixels,
                in_shadow=np.sum([each.in_shadow for each in self._drawn], axis=0),
                with_waves=np.sum([each.with_waves for each in self._drawn], axis=0),
            )
        )


def allot(count: int, pixels: Counts) -> Counts:
    """Share a number of draws among strata: half alike, half by size, and one to each as far as they go.

    Parameters
    ----------
    pixels : ndarray (S,)
        Pixels of each stratum; no stratum gets more.
    """
    taken = np.zeros_like(pixels)
    present = pixels > 0
    if not np.any(present):
        return taken
    goal = 0.5 * present / np.sum(present) + 0.5 * pixels / np.sum(pixels)
    for _ in range(min(count, int(np.sum(pixels)))):
        behind = np.full(pixels.size, np.inf)
        np.divide(taken, goal, out=behind, where=taken < pixels)
        taken[np.lexsort((-goal, behind))[0]] += 1
    return taken


def _per_frame(count: int, frames: int) -> dict[int, int]:
    """Return the pixels to draw from each frame that is drawn."""
    if count == 0:
        return {}
    parts = min(max(1, count // PIXELS_PER_FRAME), frames)
    chosen = checked_frames(parts, frames)
    return {frame: count // parts + (place < count % parts) for place, frame in enumerate(chosen)}
