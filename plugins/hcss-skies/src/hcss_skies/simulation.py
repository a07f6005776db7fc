"""The cloud generator `simulation`: an unbounded sky of films from large-eddy simulation, at their own pace."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_skies.blended import key_of
from hcss_skies.blending import put_in_layer
from hcss_skies.example import read_example
from hcss_skies.film import LEVELS, Bytes, Film
from hcss_skies.library import find_example, find_film
from hcss_skies.pace import Pace, TurnedPixels, turned
from hcss_skies.parameters import SimulationParameters
from hcss_skies.places import Places, read_smooth
from hcss_skies.playing import lay_over, play, show, show_beside, with_clouds
from hcss_skies.reel import NO_SHIFT, Reel, Seen, blocks, extinction_m1, parts, read_heights, read_reel, usual_at_ranks
from hcss_skies.relief import DENSEST, LEAST_M, shares_of
from hcss_twin.providers import Array, CloudDeclaration, CloudInputs, CloudLayer, Problem, ProviderError, ScenarioError

FADE_S = 300.0
"""Time in which a patch becomes another one at the end of its piece."""

SPACING = 0.4
"""Distance of lattice points in parts of the box: patches twice as wide show most of it."""

MAGNIFIED = 4.0
"""Most pixels along a cell: smaller ones would need detail that the simulation has not."""

_FROM = 0.78
"""Smallest pixel in cells: larger cells would blur it."""

_LARGEST = 1.4
"""Largest pixel in cells of the coarsest averages, which are three along the box."""

_COARSEST = 3

_LOWEST = 1e-3
"""Share of the film's tops that count as the lowest one: tables need the range of tops to be short."""

_LEAST_RISE = 0.01
"""Least height of the lowest top above the base of the layer, in parts of its depth."""

_OF_WIDER = 0.36
"""Share of the variance of sheets that has four times the size, where pixels are large enough."""

_SKIES, _COARSE_SKIES = (1, 2, 1, 2, 1, 2), (1, 4, 2, 4)
"""How many times clouds are magnified, where pixels are large enough, in skies that are laid over one another."""

_COARSE = 8
"""Cells of the film along a pixel from which on there are fewer skies."""

_WINDOWS, _SIDE, _APART_M = 5, 48, 150e3
"""Windows along an axis, their side in pixels, and their distance, in which the cover of large pixels is measured."""

_AS_RANKED = np.empty((0, LEVELS), np.float32)

_NO_HEIGHTS = np.empty((0, 2, LEVELS), np.float32)

_TILE = 1024

TOPS = "clouds.parameters.tops"


class SimulatedClouds:
    """Clouds of a film, patched together without end.

    Cells are averaged to a power of two, so that they are not larger than 1.3 pixels. Those of the film have thickness
    by interpolated scores, so that outlines are smooth. Larger ones hide as much of the sea as those of the film in
    them do in the mean: of the radiance at 10.8 um in a scene. The coverage is that of the film's own cells: of larger
    pixels, which are partly cloudy, more have cloud (:attr:`image_coverage`). Clouds have the optical thickness of the
    simulation as far as the layer is deep enough.

    Where an example decides (``where``), its cold places have more clouds, its clear ones few, and both move and change
    as it does. Pixels that are large enough also have clouds of the film that are magnified, up to four times, for
    structure larger than its box.

    The sky is turned so that the wind of the film blows along that of the scene. Tops and bases are fractions of the
    layer, as in the film; the sun's paths cross bodies between them, and light between columns sees them
    (:attr:`height_shares`). With ``tops = "film"`` clouds hang from them, and are as thick as their optical thickness
    needs, also below the layer, but not below the sea. Lines of sight then cross bodies, too.

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
        reel = inputs.catalog.parsed(self._path, read_reel)
        self.film, self._reel = reel.film, reel
        scale = _scale_of(reel.film, inputs.grid.pixel_size_m, parameters.film)
        self._cell_m, self._scale = scale * reel.film.cell_m, scale
        skies: tuple[int, ...] = _SKIES if scale < _COARSE else _COARSE_SKIES
        if reel.film.sheet:
            skies = 4, 1
        self._tops_vary = parameters.tops == "film"
        self._seen = Seen.of(layer, scale, reel, None if self._tops_vary else inputs.inversion)
        self._table_m, self._adding_up = self._seen.table_m.astype(np.float32), self._seen.adding_up
        self.cloud_top_range_m = _top_range_m(reel.film, layer) if self._tops_vary else None
        self.skipped: tuple[tuple[str, str], ...] = (
            () if self._tops_vary else (("cloud-top height of the film", f'{TOPS} = "layer": thickness alone varies'),)
        )
        self._last: tuple[tuple[float, ...], list[NDArray[np.float32]]] | None = None
        last, of_interval = reel.frames.shape[1] - 1.001, parts(reel.film)
        begins = last - min(FADE_S / reel.film.interval_s * of_interval, 0.5 * last)
        self._lasting = np.array([last, begins])
        self._life_s = begins * reel.film.interval_s / of_interval
        self._shifts = np.random.default_rng([inputs.seed, 0xF11]).random((len(skies), 2))
        self._of_heights: dict[int, tuple[Bytes, NDArray[np.float32]]] = {}
        self._pace = Pace.of(inputs.motion)
        self._turn = turned(reel.film.frame_m_s, inputs.motion.cloud_velocity_m_s)
        notes = _notes(reel, parameters, layer)
        self._places: Places | None = None
        self._change = np.float32(reel.change_of(np.array(layer.coverage)))
        if parameters.where is not None and layer.coverage > 0.0:
            path = find_example(parameters.where, inputs.catalog)
            example = inputs.catalog.parsed(path, read_smooth if reel.film.sheet else read_example)
            if reel.film.sheet and scale >= _COARSE:
                # Averages of so many cells hardly differ, and edges of the example would be smooth, with specks.
                below = round(math.log2(example.pixel_size_m / self._cell_m))
                skies = (1 << min(max(below, 0), 2),) * 2
            self._places = Places(example, reel, layer.coverage, self._cell_m, inputs.seed)
        self._magnified = [min(times, scale) for times in skies]
        self.declares = CloudDeclaration(
            depends_on=self._pace.depends_on, evolves=self._pace.evolves, notes=tuple(notes)
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
        """Return the altitude of the cloud top (y, x) of any window, for shadows and with ``tops = "film"``."""
        return self._bodies(time_s, rows, columns)[1].copy()

    def cloud_depth_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the height (y, x) from the base to the top of any window, as :meth:`cloud_top_m`."""
        return self._bodies(time_s, rows, columns)[2].copy()

    def _bodies(self, time_s: float, rows: slice, columns: slice) -> list[NDArray[np.float32]]:
        """Return thickness, tops and heights (y, x) of a window; the last ones are kept, as the engine asks for all."""
        key = time_s, rows.start, rows.stop, columns.start, columns.stop
        if self._last is None or self._last[0] != key:
            played = self._played(time_s, rows, columns, 2)
            thickness, layer = self._thickness(played), self._inputs.layer
            top, base = (self._altitude(of) for of in played[1:])
            # Slant paths would pass between thin columns whose tops differ.
            least = np.float32(min(self._inputs.grid.pixel_size_m, layer.thickness_max_m))
            if self.cloud_top_range_m is None:
                top, depth = self._standing(thickness, top, np.minimum(base, top - least))
            else:
                low, high = (np.float32(end) for end in self.cloud_top_range_m)
                top = np.clip(top, low, high)
                base = np.maximum(np.minimum(base, top - least), np.float32(layer.base_m))
                depth = np.clip(top - base, np.float32(LEAST_M), np.float32(layer.thickness_max_m))
                top = np.maximum(top, thickness)
            self._last = key, [thickness, top, depth]
        return self._last[1]

    @cached_property
    def image_coverage(self) -> float:
        """Share of pixels with cloud, the optional member of generators; not there for pixels of the film's size.

        Larger ones are partly cloudy, so that more of them have cloud than the layer's coverage, which is that of the
        film's cells.

        Raises
        ------
        AttributeError
            For pixels that are not larger, and without cloud.
        """
        if self._scale == 1 or self._inputs.layer.coverage == 0.0:
            raise AttributeError("image_coverage")
        apart = max(_SIDE, round(_APART_M / self._inputs.grid.pixel_size_m))
        windows = [slice(n * apart, n * apart + _SIDE) for n in range(-(_WINDOWS // 2), _WINDOWS // 2 + 1)]
        cloudy = [np.mean(self.thickness_m(0.0, rows, columns) > 0.0) for rows in windows for columns in windows]
        return float(np.mean(cloudy))

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
        played = self._played(time_s, rows, columns, 2)
        top, depth = self._standing(thickness_m, *(self._altitude(of).astype(np.float64) for of in played[1:]))
        return shares_of(thickness_m, depth, np.asarray(edges_m, np.float64), top - depth, False)

    def _standing(
        self, thickness_m: NDArray[np.float32], top_m: NDArray[Any], base_m: NDArray[Any]
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return tops and heights (y, x) of bodies, all of them in the layer and no denser than can be."""
        layer, number = self._inputs.layer, top_m.dtype.type
        lowest, highest = number(layer.base_m), number(layer.top_m)
        top = np.minimum(top_m, highest)
        depth = np.maximum(
            np.maximum(top - np.minimum(base_m, highest), thickness_m / number(DENSEST)), number(LEAST_M)
        )
        return np.minimum(np.maximum(top, lowest + depth), highest), depth

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
        pixels = TurnedPixels.of(positions[0], positions[1], self._turn, self._cell_m)
        first_row, first_column, *shape = pixels.window
        first, at = (first_row, first_column), (pixels.y, pixels.y_turned, pixels.x, pixels.x_turned)
        needed = pixels.needed(*first, *shape)
        cells, beside = self._cells(time_s * self._pace.rate, first, (shape[0], shape[1]), needed, len(out) - 1)
        show(out[0], cells, *at, *first, self._table_m)
        clear = float(np.count_nonzero(self._table_m == 0.0) - 1)
        for shown, field in zip(out[1:], beside, strict=True):
            show_beside(shown, out[0], field, cells, clear, *at, *first)

    def _cells(
        self, time_s: float, first: tuple[int, int], shape: tuple[int, int], needed: NDArray[np.int64], heights: int
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return ranks (rows, columns) of cells, and that many of tops and bases (F, rows, columns).

        Of each row only the ``needed`` columns (2, rows) are computed: :meth:`TurnedPixels.needed`.
        """
        change = np.full(shape, self._change)
        if self._places is not None:
            change = self._places.change(time_s, first, shape)
        # zeros where no pixel needs a cell: skies are laid over one another everywhere
        cells, beside = np.zeros(shape, np.float32), np.empty((heights, *shape), np.float32)
        if self.film.sheet:
            under = np.empty((0, 0), np.float32)
            if self._magnified[0] > self._magnified[1]:
                under = np.zeros_like(cells)
                self._play(under, beside[:0], needed, time_s, first, np.zeros_like(change), 0, under[:0])
            self._play(cells, beside, needed, time_s, first, change, 1, under)
            return cells, beside
        self._play(cells, beside, needed, time_s, first, change, 0, cells[:0])
        others, more = np.empty_like(cells), np.empty_like(beside)
        for sky in range(1, min(math.ceil(float(change.max())), len(self._magnified))):
            having = with_clouds(needed, change, sky)
            self._play(others, more, having, time_s, first, change, sky, others[:0])
            lay_over(cells, beside, others, more, having, *self._adding_up)
        return cells, beside

    def _play(
        self, out: NDArray[np.float32], beside: NDArray[np.float32], needed: NDArray[np.int64], time_s: float,
        first: tuple[int, int],
        change: NDArray[np.float32], sky: int, under: NDArray[np.float32],
    ) -> None:  # fmt: skip
        """Write one of the skies: what cells show, and other fields; of the first one of sheets the ranks alone."""
        times = self._magnified[sky]
        cells = self._reel.cells(self._seen, self._scale // times)
        others, usual = self._heights(times) if len(beside) else (cells.frames[None][:0], _NO_HEIGHTS)
        spacing, sheet = SPACING * min(cells.frames.shape[2:]), self.film.sheet
        play(
            out, beside, needed, *first, cells.frames, others, usual,
            _AS_RANKED if self._scale == 1 or (sheet and sky == 0) else cells.shown,
            self._reel.per_score, spacing, spacing * self._shifts[sky], sheet,
            np.uint64(key_of(self._inputs.seed, sky)), time_s / (times * self._life_s), self._lasting, change,
            0 if sheet else sky, np.float32(len(self._magnified)), under, np.float32(_OF_WIDER),
        )  # fmt: skip

    def _heights(self, times: int) -> tuple[Bytes, NDArray[np.float32]]:
        """Tops and bases (2, pieces, frames, rows, columns) in 255ths of the layer, everywhere, and the usual ones.

        Those of clouds that are magnified so many times.
        """
        if times in self._of_heights:
            return self._of_heights[times]
        reel, averaged, layer = self._reel, self._scale // times, self._inputs.layer
        fields: list[NDArray[np.float32]] = [
            field.astype(np.float32) for field, _ in self._inputs.catalog.parsed(self._path, read_heights)
        ]
        if averaged > 1:  # means over the cloud of larger cells
            weight = (reel.thickness_m(layer) > 0.0).astype(np.float32)[reel.frames] + np.float32(1e-3)
            total = blocks(weight, averaged)
            fields = [blocks(weight * field, averaged) / total for field in fields]
        heights = np.clip(np.rint(fields), 1.0, 255.0).astype(np.uint8)
        cells = reel.cells(self._seen, averaged)
        at_ranks = [usual_at_ranks(field, cells.frames) for field in heights]
        places = cells.shown[NO_SHIFT].astype(np.float64) + 1e-6 * np.arange(LEVELS)
        usual = [[of, np.interp(np.arange(LEVELS), places, of)] for of in at_ranks]
        self._of_heights[times] = heights, np.array(usual, np.float32)
        return self._of_heights[times]


def _top_range_m(film: Film, layer: CloudLayer) -> tuple[float, float]:
    """Return the lowest and the highest cloud top."""
    lowest = float(np.quantile(film.top[film.top > 0], _LOWEST)) / 255.0
    least = max(layer.thickness_min_m, _LEAST_RISE * layer.thickness_max_m)
    return layer.base_m + max(lowest * layer.thickness_max_m, 1.01 * least), layer.top_m


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
    return 1 << min(max(0, math.floor(math.log2(pixel / _FROM))), int(math.log2(coarsest)))


def _notes(reel: Reel, parameters: SimulationParameters, layer: CloudLayer) -> list[str]:
    film = reel.film
    notes = [f"Film {parameters.film}: {film.kind}, {film.source} ({film.licence})"]
    most = layer.thickness_max_m * extinction_m1(layer)
    thicker = film.share_above(1.02 * most)
    if thicker > 1e-3:
        notes.append(
            f"{thicker:.1%} of the film is thicker than the optical thickness {most:.3g} of the layer's deepest clouds "
            "and gets it; a deeper layer shows more."
        )
    return notes
