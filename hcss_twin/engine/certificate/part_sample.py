"""Stratified random sample of pixels from one part of a frame, for the certificate.

Strata are clear pixels, those of them in the shadow of clouds, and thin, edge and thick pixels of each combination of
layers. A pixel is an edge pixel if the cloud of some layer ends in it or in an adjacent pixel (up, down, left or
right). Other cloudy pixels are thick if the thickness of some layer is at least the geometric mean of its limits,
otherwise thin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.engine.stages.stage import REASONS, SeenWindow
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, points_of

Thickness = NDArray[np.float32]


def strata_of(plan: Plan) -> tuple[str, ...]:
    """Return the names (S,) of the strata of a scene, by number."""
    surfaces = [name for surfaces in plan.assembly.surfaces for name in surfaces.names]
    return Certificate.stratum_names(len(plan.layers), surfaces, plan.has_shadows)


Counts = NDArray[np.int64]

LOOKED_AT_FIRST = 64
"""Pixels with the smallest random numbers, searched first for each stratum: this many times the number to draw."""

_SEED_KEY = 2**17
"""Distinguishes the seed of the sample from those of clouds and waves."""


@dataclass(frozen=True)
class DrawnPixels:
    """Sample from a part of a frame, with as many pixels of each stratum as the whole frame may need.

    Attributes
    ----------
    key : ndarray (M,)
        Random number of each pixel.
    place : ndarray (M, 3)
        Stratum, and row and column in the cube.
    points : ndarray of float32 (M, L, P)
    radiance : ndarray of float32 (M, Q, B)
    pixels : ndarray (S,)
        Number of pixels of each stratum that could have been drawn.
    left_out : ndarray (R, S)
        Number of those that the reference cannot compute, for each of ``REASONS``.
    """

    key: Array
    place: NDArray[np.int64]
    points: Thickness
    radiance: NDArray[np.float32]
    pixels: Counts
    left_out: Counts


class PartSample:
    """Samples pixels of a part of one frame, window by window.

    Parameters
    ----------
    index : int
        Number of the frame in the cube.
    count : int
        Maximum number of pixels to draw from the frame.
    before : int
        Number of pixels in earlier parts of the frame, whose random numbers are skipped, so that the sample does not
        depend on which process computes a part.
    corner : (int, int)
        First row and column of the part in the cube.
    """

    def __init__(self, plan: Plan, index: int, count: int, before: int = 0, corner: tuple[int, int] = (0, 0)) -> None:
        self._plan, self._count, self._corner = plan, count, corner
        # One step of the generator for each number between 0 and 1.
        self._random = np.random.Generator(_bits(plan.scenario.seed, 1 + index).advance(before))
        size, layers = len(strata_of(plan)), len(plan.layers)
        self._pixels, self._left_out = np.zeros(size, dtype=np.int64), np.zeros((len(REASONS), size), dtype=np.int64)
        self._key = np.empty(0)
        self._place = np.empty((0, 3), dtype=np.int64)
        self._points = np.empty((0, layers, plan.samples_per_pixel**2), dtype=np.float32)

    def observe(self, seen: SeenWindow) -> None:
        """Draw from a window."""
        window, thickness_m, surface = seen.inside, seen.thickness_m, seen.surface
        samples = self._plan.samples_per_pixel
        shape = window[0].stop - window[0].start, window[1].stop - window[1].start
        stratum = Certificate.stratum_of(self._plan.layers, thickness_m, shape, samples, seen.shaded)
        if surface is not None:
            of_each = Certificate.stratum_names(len(self._plan.layers), shadows=self._plan.has_shadows)
            stratum = stratum + np.int8(len(of_each)) * surface.view(np.int8)
        free = np.ones(shape, dtype=np.bool_)
        for number, reason in enumerate(REASONS):
            if reason in seen.left_out:
                self._left_out[number] += self._count_of(stratum[free & seen.left_out[reason]])
                free &= ~seen.left_out[reason]
        key = self._random.random(shape)
        available = self._count_of(stratum[free])
        self._pixels += available
        # For most strata these contain the smallest numbers.
        rows, columns = np.nonzero(free & (key < LOOKED_AT_FIRST * self._count / key.size))
        kind = stratum[rows, columns]
        for number, wanted in enumerate(np.minimum(available, self._count).tolist()):
            in_stratum = kind == number
            some = rows[in_stratum], columns[in_stratum]
            if some[0].size < wanted:
                every = np.nonzero(free & (stratum == number))
                some = every[0], every[1]
            chosen = smallest(key[some], np.ones(some[0].size, dtype=np.bool_), wanted)
            places = some[0][chosen], some[1][chosen]
            self._keep(number, key[places], *places, window, thickness_m)

    def drawn(self, radiance: NDArray[np.float32]) -> DrawnPixels:
        """Return the sample, with the radiance (Q, B, y, x) of the part."""
        row, column = self._place[:, 1], self._place[:, 2]
        return DrawnPixels(
            key=self._key,
            place=self._place + np.array((0, *self._corner)),
            points=self._points,
            radiance=np.ascontiguousarray(np.moveaxis(radiance[:, :, row, column], -1, 0)),
            pixels=self._pixels,
            left_out=self._left_out,
        )

    def _keep(
        self,
        number: int,
        keys: Array,
        rows: NDArray[np.intp],
        columns: NDArray[np.intp],
        window: Window,
        thickness_m: Sequence[Thickness],
    ) -> None:
        """Add pixels of one stratum, sorted by random number, and drop those whose numbers are too large."""
        samples = self._plan.samples_per_pixel
        points = np.empty((keys.size, *self._points.shape[1:]), dtype=np.float32)
        for pixel, (row, column) in enumerate(zip(rows.tolist(), columns.tolist(), strict=True)):
            at = points_of(slice(row, row + 1), samples), points_of(slice(column, column + 1), samples)
            for layer, thickness in enumerate(thickness_m):
                points[pixel, layer] = thickness[at].ravel()
        place = np.stack((np.full(keys.size, number), rows + window[0].start, columns + window[1].start), axis=1)
        old = self._place[:, 0] == number
        key = np.concatenate((self._key[old], keys))
        order = smallest(key, np.ones(key.size, dtype=np.bool_), self._count)
        self._key = np.concatenate((self._key[~old], key[order]))
        self._place = np.concatenate((self._place[~old], np.concatenate((self._place[old], place))[order]))
        self._points = np.concatenate((self._points[~old], np.concatenate((self._points[old], points))[order]))

    def _count_of(self, stratum: NDArray[np.int8]) -> Counts:
        return np.bincount(stratum, minlength=self._pixels.size)


def _bits(seed: int, number: int) -> np.random.PCG64:
    return np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(_SEED_KEY, number)))


def smallest(key: Array, among: NDArray[np.bool_], count: int) -> NDArray[np.intp]:
    """Indices of the smallest numbers within a mask, ascending."""
    places = np.flatnonzero(among)
    return places[np.argsort(key[places], kind="stable")[:count]]
