"""The pixels that a certificate checks: drawn at random while the frames are made, some of each kind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.scene.certificate.checked_frames import checked_frames
from hcss_twin.scene.certificate.strata import strata, stratum_names
from hcss_twin.scene.footprint import pixel_sums, points_of
from hcss_twin.scene.plan import Plan

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
Thickness = NDArray[np.float32]

PIXELS_PER_FRAME = 24
"""Frames are as many as there are so many pixels: each has a sun of its own, which costs the model most."""

POINTS_PER_PIXEL = 4
"""Points that a pixel may have on average; of pixels with more, fewer are checked."""

LOOKED_AT_FIRST = 64
"""Pixels of a window, by their numbers and times as many as are drawn, among which those of a stratum are looked for
first."""

_SEED_KEY = 2**17
"""Keeps the draw apart from the seeds of clouds and waves."""


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
    """Draws pixels of a run, the same in every run of a plan.

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
        """Return what draws from a frame; None if nothing is drawn from it."""
        count = self._count.get(index)
        return None if count is None else FrameSample(self._plan, index, count, self.frames)


class FrameSample:
    """Draws pixels of one frame, window by window.

    Each pixel gets a random number, and those with the smallest are kept: of each stratum a simple random sample.
    """

    def __init__(self, plan: Plan, index: int, count: int, found: list[SampledPixels]) -> None:
        self._plan, self._index, self._count, self._found = plan, index, count, found
        self._random = _random(plan.scenario.seed, 1 + index)
        size, layers = len(stratum_names(len(plan.layers))), len(plan.layers)
        self._pixels, self._in_shadow, self._with_waves = (np.zeros(size, dtype=np.int64) for _ in range(3))
        self._key = np.empty(0)
        self._place = np.empty((0, 3), dtype=np.int64)
        self._points = np.empty((0, layers, plan.samples_per_pixel**2), dtype=np.float32)

    def look(
        self,
        window: tuple[slice, slice],
        thickness_m: Sequence[Thickness],
        shaded: NDArray[np.bool_] | None,
    ) -> None:
        """Draw from a window.

        Parameters
        ----------
        window : (slice, slice)
            Rows and columns, in pixels.
        thickness_m : sequence of ndarray (window rows x samples, window columns x samples)
            Of each layer.
        shaded : ndarray of bool (window rows, window columns) or None
            Pixels with a point in the shadow of a cloud.
        """
        samples = self._plan.samples_per_pixel
        shape = window[0].stop - window[0].start, window[1].stop - window[1].start
        stratum = strata(self._plan.layers, thickness_m, shape, samples)
        free = np.ones(shape, dtype=np.bool_)
        if shaded is not None:
            self._in_shadow += self._count_of(stratum[shaded])
            free &= ~shaded
        if self._plan.waves is not None:
            wavy = free & _clear_in_part(thickness_m, shape, samples)
            self._with_waves += self._count_of(stratum[wavy])
            free &= ~wavy
        key = self._random.random(shape)
        here = self._count_of(stratum[free])
        self._pixels += here
        # Of most strata those with the smallest numbers are among these.
        first = np.argwhere(free & (key < LOOKED_AT_FIRST * self._count / key.size))
        kind = stratum[first[:, 0], first[:, 1]]
        for number, wanted in enumerate(np.minimum(here, self._count).tolist()):
            places = first[kind == number]
            if places.shape[0] < wanted:
                places = np.argwhere(free & (stratum == number))
            order = np.argsort(key[places[:, 0], places[:, 1]], kind="stable")[:wanted]
            rows, columns = places[order].T
            self._keep(number, key[rows, columns], rows, columns, window, thickness_m)

    def finish(self, radiance: NDArray[np.float32]) -> None:
        """Keep what was drawn, with the radiance (Q, B, y, x) of the frame."""
        taken = allot(self._count, self._pixels)
        chosen = np.concatenate(
            [np.flatnonzero(self._place[:, 0] == number)[:count] for number, count in enumerate(taken)]
        )
        stratum, row, column = self._place[chosen].T
        self._found.append(
            SampledPixels(
                frame=self._index,
                time_s=float(self._plan.frame_times_s[self._index]),
                stratum=stratum,
                row=row,
                column=column,
                thickness_m=self._points[chosen],
                radiance=np.ascontiguousarray(np.moveaxis(radiance[:, :, row, column], -1, 0)),
                pixels=self._pixels,
                in_shadow=self._in_shadow,
                with_waves=self._with_waves,
            )
        )

    def _keep(
        self,
        number: int,
        keys: Array,
        rows: NDArray[np.intp],
        columns: NDArray[np.intp],
        window: tuple[slice, slice],
        thickness_m: Sequence[Thickness],
    ) -> None:
        """Add pixels of one stratum, and let go of those whose numbers are too large; the rest by their numbers."""
        samples = self._plan.samples_per_pixel
        points = np.empty((keys.size, *self._points.shape[1:]), dtype=np.float32)
        for pixel, (row, column) in enumerate(zip(rows.tolist(), columns.tolist(), strict=True)):
            at = points_of(slice(row, row + 1), samples), points_of(slice(column, column + 1), samples)
            for layer, thickness in enumerate(thickness_m):
                points[pixel, layer] = thickness[at].ravel()
        place = np.stack(
            (np.full(keys.size, number), rows + window[0].start, columns + window[1].start), axis=1
        )
        old = self._place[:, 0] == number
        key = np.concatenate((self._key[old], keys))
        order = np.argsort(key, kind="stable")[: self._count]
        self._key = np.concatenate((self._key[~old], key[order]))
        self._place = np.concatenate((self._place[~old], np.concatenate((self._place[old], place))[order]))
        self._points = np.concatenate(
            (self._points[~old], np.concatenate((self._points[old], points))[order])
        )

    def _count_of(self, stratum: NDArray[np.int8]) -> Counts:
        return np.bincount(stratum, minlength=self._pixels.size)


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


def _random(seed: int, number: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_SEED_KEY, number)))


def _clear_in_part(
    thickness_m: Sequence[Thickness], shape: tuple[int, int], samples: int
) -> NDArray[np.bool_]:
    """Pixels (y, x) with a point without any cloud."""
    clear = np.ones((shape[0] * samples, shape[1] * samples), dtype=np.bool_)
    for thickness in thickness_m:
        clear &= thickness <= 0
    found: NDArray[np.bool_] = pixel_sums(clear, samples) > 0
    return found
