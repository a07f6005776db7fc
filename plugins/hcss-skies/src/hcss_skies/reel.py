"""Films as they are played: frames between snapshots, their ranks in the scores that patches are joined by, means."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.special import ndtri

from hcss_skies.film import LEVELS, Bytes, Film, read_film, score_of
from hcss_skies.motion import densify, filled
from hcss_twin.providers import Array, BrightnessInversion, CloudLayer

FRAME_S = 20.0
"""Time between frames, in which clouds move less than a cell."""

NORMAL = 4.0
"""Largest normal score of a sheet's ranks."""

LOWEST, STEP = -256.0, 16.0
"""First of the shifts of a :class:`Cells`, and their distance, in ranks."""

NO_SHIFT = 16
"""Index of the shift 0."""

_SHIFTS = LOWEST + STEP * np.arange(25)

_SMOOTH = 2.0
"""Scale in ranks over which usual heights are smoothed."""

_THIN_M = 10.0
"""Thickness below which the table of larger cells is linear, at most; above it is logarithmic."""

_OPAQUE = 1e-3
"""Least share of the sea that is seen through clouds."""

_KEPT = 12
"""Averages that are kept, of pixel sizes and layers."""


@dataclass(frozen=True)
class Cells:
    """Frames of cells, as large as pixels need.

    Attributes
    ----------
    frames : ndarray of uint8 (pieces, frames, rows, columns)
        Ranks among cells of this size.
    shown : ndarray of float32 (25, 256)
        What cells show, as a place in the table of thickness, if the scores of the film's own cells in them are raised
        by a shift, 16 ranks after the other from -256 on.
    """

    frames: Bytes
    shown: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Reel:
    """A film whose ranks are evenly spaced in the score by which its patches are joined.

    Attributes
    ----------
    film : Film
        As it is in its file.
    frames : ndarray of uint8 (pieces, frames, rows, columns)
        Ranks.
    optical_thickness : ndarray (256,)
        At ranks.
    first, last : float
        Scores of the first and the last rank.
    """

    film: Film
    frames: Bytes
    optical_thickness: Array
    first: float
    last: float
    _cells: dict[tuple[int, Seen], Cells] = field(default_factory=dict, repr=False)

    @property
    def per_score(self) -> float:
        """Ranks in a score."""
        return (LEVELS - 1) / (self.last - self.first)

    def score_of(self, probability: Array) -> Array:
        """Return scores: those of sheets are normal, of other clouds Gumbel's."""
        return np.asarray(ndtri(probability)) if self.film.sheet else score_of(probability, False)

    def change_of(self, cover: Array) -> Array:
        """Return what gives a cover: ranks that are added to a sheet, else how many times as many clouds there are."""
        clear = float(np.count_nonzero(self.optical_thickness == 0.0)) - 0.5
        edge = self.first + clear / self.per_score
        if self.film.sheet:
            return np.asarray((ndtri(np.clip(cover, 1e-6, 1.0 - 1e-6)) + edge) * self.per_score)
        return np.asarray(-np.log1p(-np.minimum(cover, 1.0 - 1e-6)) * math.exp(edge))

    def thickness_m(self, layer: CloudLayer) -> Array:
        """Return the thickness (256,) at ranks in a layer: that of the simulation's optical thickness; 0 is clear."""
        optical = self.optical_thickness
        metres = np.clip(optical / extinction_m1(layer), layer.thickness_min_m, layer.thickness_max_m)
        return np.where(optical > 0.0, metres, 0.0)

    def cells(self, seen: Seen, averaged: int) -> Cells:
        """Return cells of squares of so many of the film's own, which show what is seen."""
        key = averaged, seen
        if key not in self._cells:
            if len(self._cells) >= _KEPT:
                self._cells.pop(next(iter(self._cells)))
            self._cells[key] = self._averaged(seen, averaged)
        return self._cells[key]

    def _averaged(self, seen: Seen, averaged: int) -> Cells:
        """Return cells with the mean of what hides the sea in those of the film.

        A cell half full of opaque cloud is not one of half the optical thickness.
        """
        ranks, frames, few = np.arange(float(LEVELS)), self.frames, self.frames
        if seen.scale == 1:
            return Cells(self.frames, (ranks + _SHIFTS[:, None]).astype(np.float32))
        through = (1.0 - seen.hidden(self.thickness_m(seen.layer))).astype(np.float32)
        if averaged > 1:
            mean, near = blocks(through[frames], averaged), blocks(frames.astype(np.float32), averaged)
            order = np.lexsort((near.ravel(), -mean.ravel()))  # clear cells by how close cloud is
            probability = (np.arange(order.size) + 0.5) / order.size
            flat = np.empty(order.size, np.uint8)
            found = (self.score_of(probability) - self.first) * self.per_score
            flat[order] = np.clip(np.rint(found), 0, LEVELS - 1).astype(np.uint8)
            frames = flat.reshape(mean.shape)
            every = slice(None), slice(None, None, max(1, self.frames.shape[1] // 30))  # frames are alike
            few, of_few = self.frames[every], frames[every].ravel()
            count = np.bincount(of_few, minlength=LEVELS)
        shown = np.empty((_SHIFTS.size, LEVELS), np.float32)
        for row, shift in zip(shown, _SHIFTS, strict=True):
            # More clouds than in the film, which do not fit beside one another, hide more of the sea.
            raised, times = (shift, 1.0) if self.film.sheet or shift < 0.0 else (0.0, math.exp(shift / self.per_score))
            of_cell = np.interp(ranks + raised, ranks, through).astype(np.float32)
            if averaged > 1:
                total = np.bincount(of_few, blocks(of_cell[few], averaged).ravel(), minlength=LEVELS)
                of_cell = np.interp(ranks, ranks[count > 0], total[count > 0] / count[count > 0])
            row[...] = np.interp(1.0 - np.clip(of_cell, 0.0, 1.0) ** times, seen.hidden(seen.table_m), ranks)
        return Cells(frames, shown)


@dataclass(frozen=True, eq=False)
class Seen:
    """How much clouds of a layer hide of the sea, and which thickness cells can show.

    Attributes
    ----------
    layer : CloudLayer
        Layer.
    scale : int
        Side of cells in those of the film.
    table_m : ndarray (256,)
        Thickness that cells show, ascending from 0. Cells of the film have that of their ranks, so that outlines of
        clouds are interpolated; larger ones are partly cloudy.
    thickness_m, share : ndarray (N,)
        Share of the sea that clouds hide: difference of the brightness temperature at 10.8 um to that of the clear sky
        in parts of that of the deepest clouds, or, if it is not known, what clouds of one temperature absorb.
    """

    layer: CloudLayer
    scale: int
    table_m: Array
    thickness_m: Array
    share: Array

    @classmethod
    def of(cls, layer: CloudLayer, scale: int, reel: Reel, inversion: BrightnessInversion | None) -> Seen:
        """Return what is seen of a layer."""
        most = layer.thickness_max_m
        thin = min(_THIN_M, 0.1 * most)
        log = thin * np.expm1(np.linspace(0.0, math.log1p(most / thin), LEVELS))
        share = -np.expm1(-0.5 * extinction_m1(layer) * log)  # half of the visible extinction is absorption
        if scale == 1:
            return cls(layer, scale, reel.thickness_m(layer), log, share)
        if inversion is None:
            return cls(layer, scale, log, log, share / share[-1])
        even = np.linspace(0.0, 1.0, 4 * LEVELS)
        thickness = inversion.thickness_m(inversion.clear_K + even * (inversion.coldest_K - inversion.clear_K))
        first = int(np.argmax(thickness > 0.0))
        return cls(layer, scale, log, np.append(0.0, thickness[first:]), np.append(0.0, even[first:]))

    def hidden(self, thickness_m: Array) -> Array:
        """Return the share of the sea that is hidden."""
        return np.interp(thickness_m, self.thickness_m, self.share)

    @property
    def adding_up(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """What adds up where cells of two skies lie over one another, at places of the table, and the inverse."""
        values = self.table_m
        if self.scale > 1:
            values = -np.log(np.maximum(1.0 - self.hidden(self.table_m), _OPAQUE))
        even = np.linspace(0.0, values[-1], 8 * LEVELS)
        clear = max(int(np.count_nonzero(values == 0.0)) - 1, 0)  # films without a hole have no clear rank
        places = np.interp(even, values[clear:], np.arange(clear, LEVELS))
        return values.astype(np.float32), places.astype(np.float32)

    @cached_property
    def _key(self) -> tuple[object, ...]:
        return self.scale, self.table_m.tobytes(), self.thickness_m.tobytes(), self.share.tobytes()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Seen) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


def read_reel(path: Path) -> Reel:
    """Return the film of a file as it is played."""
    film = read_film(path)
    frames = densify(film.ranks, film.motion, film.block, parts(film))
    first, last = float(film.scores[0]), float(film.scores[-1])
    if not film.sheet:
        return Reel(film, frames, film.optical_thickness, first, last)
    normal = np.linspace(-NORMAL, NORMAL, LEVELS)
    of_rank = ndtri(np.clip(-np.expm1(-np.exp(film.scores)), 1e-12, 1.0 - 1e-12))
    to_normal = np.rint((np.clip(of_rank, -NORMAL, NORMAL) + NORMAL) * (0.5 * (LEVELS - 1) / NORMAL)).astype(np.uint8)
    optical = np.interp(normal, of_rank, film.optical_thickness)
    thinnest = film.optical_thickness[film.optical_thickness > 0.0][0]
    return Reel(film, to_normal[frames], np.where(optical < thinnest, 0.0, optical), -NORMAL, NORMAL)


def read_heights(path: Path) -> list[tuple[Bytes, Array]]:
    """Return tops and bases (pieces, frames, rows, columns) everywhere, and their usual values (256,) at ranks."""
    reel = read_reel(path)
    film = reel.film
    fields = [densify(filled(of), film.motion, film.block, parts(film)) for of in (film.top, film.base)]
    return [(of, usual_at_ranks(of, reel.frames)) for of in fields]


def parts(film: Film) -> int:
    """Return the number of frames in an interval between snapshots."""
    return max(1, round(film.interval_s / FRAME_S))


def usual_at_ranks(heights: Bytes, ranks: Bytes) -> Array:
    """Return the mean height (256,) at ranks."""
    count = np.bincount(ranks.ravel(), minlength=LEVELS) + 1e-9
    total = np.bincount(ranks.ravel(), heights.ravel(), minlength=LEVELS) + 1e-9 * float(np.mean(heights))
    mean: Array = gaussian_filter1d(total, _SMOOTH) / gaussian_filter1d(count, _SMOOTH)
    return mean


def blocks(of_cells: NDArray[np.float32], scale: int) -> NDArray[np.float32]:
    """Return means (pieces, frames, rows, columns) over squares of ``scale`` cells."""
    pieces, count, rows, columns = of_cells.shape
    squares = of_cells.reshape(pieces, count, rows // scale, scale, columns // scale, scale)
    mean: NDArray[np.float32] = squares.mean(axis=(3, 5), dtype=np.float32)
    return mean


def extinction_m1(layer: CloudLayer) -> float:
    """Return the extinction of a layer in the visible, 1/m: twice the area of its particles, which are large."""
    particles = layer.microphysics
    radius = np.geomspace(*particles.radius_range_um, 2000)
    number = radius**particles.alpha * np.exp(-particles.b * radius**particles.nu)
    area_um2 = math.pi * np.trapezoid(number * radius**2, radius) / np.trapezoid(number, radius)
    return float(2.0 * particles.number_density_m3 * area_um2 * 1e-12)
