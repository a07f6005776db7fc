"""Pixels for the certificate: a stratified random sample, drawn during the computation of the frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.engine.certificate.part_sample import Counts, DrawnPixels, PartSample, Thickness, smallest
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.sunlight import checked_frames

PIXELS_PER_FRAME = 24
"""Pixels per sampled frame: each frame has its own sun position, which dominates the cost of the model."""

POINTS_PER_PIXEL = 4
"""Mean number of points per checked pixel; fewer pixels are checked if they have more points."""


PIXELS_WITH_TOPS = 12
"""Pixels whose cloud tops have altitudes of their own."""


@dataclass(frozen=True)
class SampledPixels:
    """Sampled pixels of one frame: clouds, and radiance in the cube.

    Attributes
    ----------
    frame : int
        Number of the frame in the cube.
    stratum : ndarray (M,)
    row, column : ndarray (M,)
    thickness_m : ndarray of float32 (M, L, P)
        Thickness of each layer at the points of the pixel.
    radiance : ndarray of float32 (M, Q, B)
        Total and requested terms, as in the cube.
    pixels : ndarray (S,)
        Number of pixels of each stratum in the frame that could have been drawn.
    left_out : ndarray (R, S)
        Number of pixels that the reference cannot compute, for each of ``REASONS`` of ``part_sample``.
    """

    frame: int
    time_s: float
    stratum: NDArray[np.int64]
    row: NDArray[np.int64]
    column: NDArray[np.int64]
    thickness_m: Thickness
    radiance: NDArray[np.float32]
    pixels: Counts
    left_out: Counts


class PixelSample:
    """Pixels drawn from the frames of a run, the same in every run of a plan.

    Parameters
    ----------
    plan : Plan
        Its ``output.certificate`` is the number of pixels to draw; fewer if a pixel has more than four points,
        unless rays other than a grid's have as many, without waves.

    Attributes
    ----------
    frames : list of SampledPixels
        One entry for each sampled frame, once it is complete.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self.frames: list[SampledPixels] = []
        asked, frames = plan.scenario.output.certificate, plan.frame_times_s.size
        count = asked
        # Pixels of other rays have views of their own, which cost more than their points unless each has its own wave.
        if plan.is_grid or plan.waves.varies:
            count = min(asked, max(1, POINTS_PER_PIXEL * asked // plan.samples_per_pixel**2))
        if plan.tops or plan.point_effects or plan.air_by_place:  # each point has a model of its own
            count = min(count, PIXELS_WITH_TOPS)
        parts = min(max(1, count // PIXELS_PER_FRAME), frames)
        chosen = checked_frames(parts, frames) if count else []
        self.counts = {frame: count // parts + (index < count % parts) for index, frame in enumerate(chosen)}
        """Pixels to draw, by frame."""

    @property
    def size(self) -> int:
        """Number of pixels to draw, which the frames have as a rule; those that cannot be recomputed are not drawn."""
        pixels = self._plan.grid.rows * self._plan.grid.columns
        return sum(min(count, pixels) for count in self.counts.values())

    def of_part(self, index: int, before: int = 0, corner: tuple[int, int] = (0, 0)) -> PartSample | None:
        """Return a sampler for a part of a frame, as in :class:`PartSample`; None if nothing is drawn from it."""
        count = self.counts.get(index)
        return None if count is None else PartSample(self._plan, index, count, before, corner)

    def add_frame(self, index: int, parts: Sequence[DrawnPixels]) -> None:
        """Choose pixels from the samples of all parts of a frame, in order.

        Each pixel has a random number; the smallest numbers give a simple random sample of each stratum.
        """
        place, key = (np.concatenate([getattr(part, name) for part in parts]) for name in ("place", "key"))
        pixels = np.sum([part.pixels for part in parts], axis=0)
        chosen = np.concatenate(
            [
                smallest(key, place[:, 0] == number, count)
                for number, count in enumerate(allot(self.counts[index], pixels))
            ]
        )
        stratum, row, column = place[chosen].T
        self.frames.append(
            SampledPixels(
                frame=index,
                time_s=float(self._plan.frame_times_s[index]),
                stratum=stratum,
                row=row,
                column=column,
                thickness_m=np.concatenate([part.points for part in parts])[chosen],
                radiance=np.concatenate([part.radiance for part in parts])[chosen],
                pixels=pixels,
                left_out=np.sum([part.left_out for part in parts], axis=0),
            )
        )


def allot(count: int, pixels: Counts) -> Counts:
    """Divide draws among strata: half equally, half by size, with at least one each if possible.

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
