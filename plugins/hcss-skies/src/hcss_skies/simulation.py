"""The cloud generator `simulation`: an unbounded sky of films from large-eddy simulation, at their own pace."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from hcss_skies.blending import put_in_layer
from hcss_skies.film import LEVELS, Bytes, Film, read_film, score_of
from hcss_skies.library import find_film
from hcss_skies.motion import densify, filled
from hcss_skies.pace import Pace, Places, turned
from hcss_skies.parameters import SimulationParameters
from hcss_skies.playing import play, show, show_beside
from hcss_skies.relief import DENSEST, LEAST_M, shares_of
from hcss_twin.providers import Array, CloudDeclaration, CloudInputs, CloudLayer, Problem, ProviderError, ScenarioError

FRAME_S = 20.0
"""Time between frames, in which clouds move less than a cell."""

FADE_S = 300.0
"""Time in which a patch becomes another one at the end of its piece."""

SPACING = 0.4
"""Distance of lattice points in parts of the box: patches twice as wide show most of it."""

MAGNIFIED = 4.0
"""Most pixels along a cell: smaller ones would need detail that the simulation has not."""

_LARGEST = 1.4
"""Largest pixel in cells of the coarsest averages, which are eight along the box."""

_COARSEST = 8

_LOWEST = 1e-3
"""Share of the film's tops that count as the lowest one: tables need the range of tops to be short."""

_LEAST_RISE = 0.01
"""Least height of the lowest top above the base of the layer, in parts of its depth."""

_SMOOTH = 2.0
"""Scale in ranks over which usual heights are smoothed."""

_NO_HEIGHTS = np.empty((0, LEVELS), np.float32)

_TILE = 512

TOPS = "clouds.parameters.tops"


class SimulatedClouds:
    """Clouds of a film, patched together without end.

    Cells are averaged to the power of two that is closest to the pixel, so that all pixel sizes show one sky; between
    their middles scores are interpolated, so that outlines are smooth. The coverage is that of the film's own cells:
    larger pixels, parts of which are cloudy, have more. Clouds have the optical thickness of the simulation as far as
    the layer is deep enough.

    The sky is turned so that the wind of the film blows along that of the scene. Tops and bases are fractions of the
    layer, as in the film. With ``tops = "film"`` clouds hang from them, and are as thick as their optical thickness
    needs, also below the layer, but not below the sea. Slant paths cross bodies from the base to the top, and light
    between columns sees them (:attr:`height_shares`).

    Parameters
    ----------
    inputs : CloudInputs
        Layer, image plane, motion, seed and the catalog that records the file.
    parameters : SimulationParameters
        The film.

    Raises
    ------
    CatalogError
        If there is no such film, or its file is damaged.
    ProviderError
        If pixels are too small or too large for it.
    ScenarioError
        If the layer has tapered edges.
    """

    honours: tuple[str, ...] = ("coverage_mode",)

    def __init__(self, inputs: CloudInputs, parameters: SimulationParameters) -> None:
        layer = inputs.layer
        if layer.edge_taper != 0.0:
            message = f"{layer.edge_taper:g} given; simulated clouds have edges of their own; allowed: 0"
            raise ScenarioError([Problem("clouds.edge_taper", message)], origin="simulated clouds")
        self._inputs = inputs
        # The plan makes dozens of skies of a film, with other seeds and layers, to hold them to its laws.
        self._path = find_film(parameters.film, inputs.catalog)
        film, frames = inputs.catalog.parsed(self._path, _film_and_frames)
        self.film, self._frames, self._frames_of_film = film, frames, frames
        scale = _scale_of(film, inputs.grid.pixel_size_m, parameters.film)
        self._cell_m = scale * film.cell_m
        parts = _parts(film)
        of_film = thickness = _in_metres(film, layer)
        if scale > 1:
            self._frames, thickness = averaged(film, self._frames, thickness, scale)

        self._scale, self._of_film_m = scale, of_film
        self._tops_vary = parameters.tops == "film"
        self.cloud_top_range_m = _top_range_m(film, layer) if self._tops_vary else None
        self.skipped: tuple[tuple[str, str], ...] = (
            () if self._tops_vary else (("cloud-top height of the film", f'{TOPS} = "layer": thickness alone varies'),)
        )
        self._last: tuple[tuple[float, ...], list[NDArray[np.float32]]] | None = None
        self.thickness_of_ranks_m = thickness.astype(np.float32)
        self._scores = film.scores[[0, -1]].astype(np.float64)
        last = self._frames.shape[1] - 1.001
        begins = last - min(FADE_S / film.interval_s * parts, 0.5 * last)
        self._lasting = np.array([last, begins])
        self._life_s = begins * film.interval_s / parts
        self._spacing = SPACING * min(self._frames.shape[2:])
        self._shift = self._spacing * np.random.default_rng([inputs.seed, 0xF11]).random(2)
        self._pace = Pace.of(inputs.motion)
        self._turn = turned(film.frame_m_s, inputs.motion.cloud_velocity_m_s)
        self.declares = CloudDeclaration(
            depends_on=self._pace.depends_on,
            evolves=self._pace.evolves,
            notes=tuple(_notes(film, parameters.film, layer)),
        )

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window; 0 is clear sky.

        Raises
        ------
        ValueError
            If the time is not finite.
        """
        if self._tops_vary:
            return self._bodies(time_s, rows, columns)[0].copy()
        return self._thickness(self._played(time_s, rows, columns, 0))

    def thickness_around_m(
        self, time_s: float, rows: slice, columns: slice, summary: None = None
    ) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window that may reach outside the image."""
        return self.thickness_m(time_s, rows, columns)

    def cloud_top_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the altitude of the cloud top (y, x) of any window, with the parameter ``tops = "film"``."""
        return self._bodies(time_s, rows, columns)[1].copy()

    def cloud_depth_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the height (y, x) from the base to the top of any window, with the parameter ``tops = "film"``."""
        return self._bodies(time_s, rows, columns)[2].copy()

    def _bodies(self, time_s: float, rows: slice, columns: slice) -> list[NDArray[np.float32]]:
        """Return thickness, tops and heights (y, x) of a window; the last ones are kept, as the engine asks for all."""
        key = time_s, rows.start, rows.stop, columns.start, columns.stop
        if self._last is None or self._last[0] != key:
            played = self._played(time_s, rows, columns, 2)
            thickness, layer = self._thickness(played), self._inputs.layer
            assert self.cloud_top_range_m is not None
            low, high = (np.float32(end) for end in self.cloud_top_range_m)
            top = np.clip(self._altitude(played[1]), low, high)
            depth = np.clip(top - self._altitude(played[2]), np.float32(LEAST_M), np.float32(layer.thickness_max_m))
            top = np.maximum(top, thickness)
            self._last = key, [thickness, top, depth]
        return self._last[1]

    @property
    def height_shares(self) -> Callable[..., NDArray[np.float32]]:
        """What spreads clouds over heights, the optional member of generators; not there for tops of the film.

        Raises
        ------
        AttributeError
            With ``tops = "film"``.
        """
        if self._tops_vary:
            raise AttributeError("height_shares")
        return self._height_shares

    def _height_shares(
        self, time_s: float, rows: slice, columns: slice, thickness_m: NDArray[np.float32], edges_m: Array
    ) -> NDArray[np.float32]:
        """Return the shares (Z, y, x) of each column between altitudes (Z + 1,), of any window; see ``relief.py``."""
        layer, played = self._inputs.layer, self._played(time_s, rows, columns, 2)
        base, top = (np.minimum(self._altitude(of).astype(np.float64), layer.top_m) for of in played[:0:-1])
        depth = np.maximum(np.maximum(top - base, thickness_m / DENSEST), LEAST_M)
        top = np.minimum(np.maximum(top, layer.base_m + depth), layer.top_m)
        return shares_of(thickness_m, depth, np.asarray(edges_m, np.float64), top - depth, False)

    def _altitude(self, heights: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return altitudes of heights in 255ths of the layer."""
        layer = self._inputs.layer
        altitude: NDArray[np.float32] = np.float32(layer.base_m) + heights * np.float32(layer.thickness_max_m / 255.0)
        return altitude

    def _thickness(self, played: list[NDArray[np.float32]]) -> NDArray[np.float32]:
        thickness, layer = played[0], self._inputs.layer
        put_in_layer(thickness, np.float32(layer.thickness_min_m), np.float32(layer.thickness_max_m))
        return thickness

    def _played(self, time_s: float, rows: slice, columns: slice, heights: int) -> list[NDArray[np.float32]]:
        """Return thickness, and that many of tops and bases in 255ths of the layer, (y, x) of a window.

        Raises
        ------
        ValueError
            If the time is not finite.
        """
        if not math.isfinite(time_s):
            raise ValueError(f"time_s: {time_s} given, allowed: any finite time")
        shape = max(0, rows.stop - rows.start), max(0, columns.stop - columns.start)
        out = [np.empty(shape, np.float32) for _ in range(1 + heights)]
        for i in range(0, shape[0], _TILE):
            for j in range(0, shape[1], _TILE):
                tiles = [field[i : i + _TILE, j : j + _TILE] for field in out]
                self._write(tiles, time_s, rows.start + i, columns.start + j)
        return out

    def _write(self, out: list[NDArray[np.float32]], time_s: float, row: int, column: int) -> None:
        """Write a part of a frame that begins at ``row`` and ``column``."""
        positions = self._pace.positions_m(self._inputs.grid, (row, column), out[0].shape, time_s)
        places = Places.of(positions[0], positions[1], self._turn, self._cell_m)
        first_row, first_column, *shape = places.window
        first, at = (first_row, first_column), (places.y, places.y_turned, places.x, places.x_turned)
        cells = np.empty(shape, np.float32)
        beside = np.empty((len(out) - 1, *shape), np.float32)
        others, usual = self._heights if len(beside) else (self._frames[None][:0], _NO_HEIGHTS)
        key = np.uint64((self._inputs.seed * 0x9E3779B97F4A7C15 + 0xD1B54A32D192ED03) % 2**64)
        play(
            cells, beside, places.needed(*first, *cells.shape), *first, self._frames, others, usual, self._scores,
            self._spacing, self._shift, self.film.sheet, key, time_s * self._pace.rate / self._life_s, self._lasting,
        )  # fmt: skip
        show(out[0], cells, *at, *first, self.thickness_of_ranks_m)
        clear = float(np.count_nonzero(self.thickness_of_ranks_m == 0.0) - 1)
        for shown, field in zip(out[1:], beside, strict=True):
            show_beside(shown, field, cells, clear, *at, *first)

    @cached_property
    def _heights(self) -> tuple[Bytes, NDArray[np.float32]]:
        """Tops and bases (2, pieces, frames, rows, columns) in 255ths of the layer, everywhere, and the usual ones."""
        film, frames, scale = self.film, self._frames_of_film, self._scale
        thicker = np.clip(np.arange(LEVELS) + _ranks_added(film, self._inputs.layer), 0.0, LEVELS - 1.0)
        fields = []
        for field, usual in self._inputs.catalog.parsed(self._path, _heights_of_film):
            moved = (np.interp(thicker, np.arange(LEVELS), usual) / usual).astype(np.float32)
            fields.append(field * moved[frames])
        if scale > 1:  # means over the cloud of larger cells
            weight = (self._of_film_m > 0.0).astype(np.float32)[frames] + np.float32(1e-3)
            total = _blocks(weight, scale)
            fields = [_blocks(weight * field, scale) / total for field in fields]
        heights = np.clip(np.rint(fields), 1.0, 255.0).astype(np.uint8)
        return heights, np.stack([_usual(field, self._frames) for field in heights]).astype(np.float32)


def _film_and_frames(path: Path) -> tuple[Film, Bytes]:
    """Return a film, and its ranks (pieces, frames, rows, columns) in frames between snapshots."""
    film = read_film(path)
    return film, densify(film.ranks, film.motion, film.block, _parts(film))


def _heights_of_film(path: Path) -> list[tuple[Bytes, Array]]:
    """Return tops and bases (pieces, frames, rows, columns) everywhere, and their usual values (256,) at ranks."""
    film, frames = _film_and_frames(path)
    fields = [densify(filled(of), film.motion, film.block, _parts(film)) for of in (film.top, film.base)]
    return [(field, _usual(field, frames)) for field in fields]


def _parts(film: Film) -> int:
    return max(1, round(film.interval_s / FRAME_S))


def _usual(field: Bytes, ranks: Bytes) -> Array:
    """Return the mean height (256,) at ranks."""
    count = np.bincount(ranks.ravel(), minlength=LEVELS) + 1e-9
    total = np.bincount(ranks.ravel(), field.ravel(), minlength=LEVELS) + 1e-9 * float(np.mean(field))
    mean: Array = gaussian_filter1d(total, _SMOOTH) / gaussian_filter1d(count, _SMOOTH)
    return mean


def _blocks(field: NDArray[np.float32], scale: int) -> NDArray[np.float32]:
    """Return means (pieces, frames, rows, columns) over squares of ``scale`` cells."""
    pieces, count, rows, columns = field.shape
    blocks = field.reshape(pieces, count, rows // scale, scale, columns // scale, scale)
    mean: NDArray[np.float32] = blocks.mean(axis=(3, 5), dtype=np.float32)
    return mean


def _top_range_m(film: Film, layer: CloudLayer) -> tuple[float, float]:
    """Return the lowest and the highest cloud top."""
    lowest = float(np.quantile(film.top[film.top > 0], _LOWEST)) / 255.0
    least = max(layer.thickness_min_m, _LEAST_RISE * layer.thickness_max_m)
    return layer.base_m + max(lowest * layer.thickness_max_m, 1.01 * least), layer.top_m


def averaged(film: Film, frames: Bytes, thickness_m: Array, scale: int) -> tuple[Bytes, Array]:
    """Return ranks (pieces, frames, rows, columns) and thickness (256,) of cells ``scale`` times as large.

    Parameters
    ----------
    frames : ndarray of uint8 (pieces, frames, rows, columns)
        Ranks.
    thickness_m : ndarray (256,)
        Thickness at ranks.
    """
    mean, near = _blocks(thickness_m.astype(np.float32)[frames], scale), _blocks(frames.astype(np.float32), scale)
    order = np.lexsort((near.ravel(), mean.ravel()))  # clear cells by how close cloud is
    probability = (np.arange(order.size) + 0.5) / order.size
    first, last = film.scores[0], film.scores[-1]
    found = (score_of(probability, film.sheet) - first) * ((LEVELS - 1) / (last - first))
    ranks = np.empty(order.size, np.uint8)
    ranks[order] = np.clip(np.rint(found), 0, LEVELS - 1).astype(np.uint8)
    return ranks.reshape(mean.shape), np.interp(np.arange(LEVELS), found, mean.ravel()[order])


def extinction_m1(layer: CloudLayer) -> float:
    """Return the extinction of a layer in the visible, 1/m: twice the area of its particles, which are large."""
    particles = layer.microphysics
    radius = np.geomspace(*particles.radius_range_um, 2000)
    number = radius**particles.alpha * np.exp(-particles.b * radius**particles.nu)
    area_um2 = math.pi * np.trapezoid(number * radius**2, radius) / np.trapezoid(number, radius)
    return float(2.0 * particles.number_density_m3 * area_um2 * 1e-12)


def _scale_of(film: Film, pixel_m: float, name: str) -> int:
    """Return the side of the cells for a pixel size, in cells of the film."""
    side = min(film.ranks.shape[2:])
    coarsest = 1
    while side % (2 * coarsest) == 0 and side // (2 * coarsest) >= _COARSEST:
        coarsest *= 2
    pixel = pixel_m / film.cell_m
    if not 1.0 / MAGNIFIED - 1e-9 <= pixel <= _LARGEST * coarsest + 1e-9:
        raise ProviderError(
            f"simulation: pixels of {pixel_m:g} m; allowed: {film.cell_m / MAGNIFIED:g} to "
            f"{_LARGEST * coarsest * film.cell_m:g} m with the film '{name}'"
        )
    return 1 << min(max(0, round(math.log2(pixel))), int(math.log2(coarsest)))


def _in_metres(film: Film, layer: CloudLayer) -> Array:
    """Return the thickness (256,) of ranks: the film's, moved along the scores to the cover of the layer."""
    if layer.coverage <= 0.0:
        return np.zeros(LEVELS)
    ranks = np.arange(LEVELS)
    optical = np.interp(ranks + _ranks_added(film, layer), ranks, film.optical_thickness)
    thinnest = float(film.optical_thickness[film.optical_thickness > 0.0][0])
    # Between a clear and a cloudy rank it is clear; cloud is as thick as the layer allows.
    metres: Array = np.clip(optical / extinction_m1(layer), layer.thickness_min_m, layer.thickness_max_m)
    return metres if layer.coverage >= 1.0 else np.where(optical < thinnest, 0.0, metres)


def _ranks_added(film: Film, layer: CloudLayer) -> float:
    """Return how many ranks the clouds of a film are raised, so that the layer has its cover."""
    clear = np.array([1.0 - film.coverage, 1.0 - layer.coverage])
    scores = score_of(np.clip(clear, 1e-6, 1.0 - 1e-6), film.sheet)
    return float((scores[0] - scores[1]) * (LEVELS - 1) / (film.scores[-1] - film.scores[0]))


def _notes(film: Film, name: str, layer: CloudLayer) -> list[str]:
    notes = [f"Film {name}: {film.kind}, {film.source} ({film.licence})"]
    most = layer.thickness_max_m * extinction_m1(layer)
    thicker = float(np.mean(film.optical_thickness[film.ranks] > 1.02 * most))
    if thicker > 1e-3:
        notes.append(
            f"{thicker:.1%} of the film is thicker than the optical thickness {most:.3g} of the layer's deepest clouds "
            "and gets it; a deeper layer shows more."
        )
    return notes
