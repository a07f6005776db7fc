"""The cloud generator `simulation`: an unbounded sky of films from large-eddy simulation, at their own pace."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcss_skies.blending import put_in_layer
from hcss_skies.film import LEVELS, Bytes, Film, read_film, score_of
from hcss_skies.library import find_film
from hcss_skies.motion import densify
from hcss_skies.pace import Pace
from hcss_skies.parameters import SimulationParameters
from hcss_skies.playing import play, show
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

_TILE = 512


class SimulatedClouds:
    """Clouds of a film, patched together without end.

    Cells are averaged to the power of two that is closest to the pixel, so that all pixel sizes show one sky; between
    their middles scores are interpolated, so that outlines are smooth. The coverage is that of the film's own cells:
    larger pixels, parts of which are cloudy, have more. Clouds have the optical thickness of the simulation as far as
    the layer is deep enough.

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
        self.film = film = read_film(find_film(parameters.film, inputs.catalog))
        scale = _scale_of(film, inputs.grid.pixel_size_m, parameters.film)
        self._cell_m = scale * film.cell_m
        parts = max(1, round(film.interval_s / FRAME_S))
        self._frames = densify(film.ranks, film.motion, film.block, parts)
        thickness = _in_metres(film, layer)
        if scale > 1:
            self._frames, thickness = averaged(film, self._frames, thickness, scale)
        self.thickness_of_ranks_m = thickness.astype(np.float32)
        self._scores = film.scores[[0, -1]].astype(np.float64)
        last = self._frames.shape[1] - 1.001
        begins = last - min(FADE_S / film.interval_s * parts, 0.5 * last)
        self._lasting = np.array([last, begins])
        self._life_s = begins * film.interval_s / parts
        self._spacing = SPACING * min(self._frames.shape[2:])
        self._shift = self._spacing * np.random.default_rng([inputs.seed, 0xF11]).random(2)
        self._pace = Pace.of(inputs.motion)
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
        if not math.isfinite(time_s):
            raise ValueError(f"time_s: {time_s} given, allowed: any finite time")
        out = np.empty((max(0, rows.stop - rows.start), max(0, columns.stop - columns.start)), np.float32)
        for i in range(0, out.shape[0], _TILE):
            for j in range(0, out.shape[1], _TILE):
                tile = out[i : i + _TILE, j : j + _TILE]
                self._write(tile, time_s, rows.start + i, columns.start + j)
        least, most = self._inputs.layer.thickness_min_m, self._inputs.layer.thickness_max_m
        put_in_layer(out, np.float32(least), np.float32(most))
        return out

    def thickness_around_m(
        self, time_s: float, rows: slice, columns: slice, summary: None = None
    ) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window that may reach outside the image."""
        return self.thickness_m(time_s, rows, columns)

    def _write(self, out: NDArray[np.float32], time_s: float, row: int, column: int) -> None:
        """Write a part of a frame that begins at ``row`` and ``column``."""
        positions = self._pace.positions_m(self._inputs.grid, (row, column), out.shape, time_s)
        y, x = (position / self._cell_m - 0.5 for position in positions)
        first = math.floor(y[0]), math.floor(x[0])
        cells = np.empty((math.floor(y[-1]) + 2 - first[0], math.floor(x[-1]) + 2 - first[1]), np.float32)
        key = np.uint64((self._inputs.seed * 0x9E3779B97F4A7C15 + 0xD1B54A32D192ED03) % 2**64)
        play(
            cells, *first, self._frames, self._scores, self._spacing, self._shift, self.film.sheet, key,
            time_s * self._pace.rate / self._life_s, self._lasting,
        )  # fmt: skip
        show(out, cells, y, x, *first, self.thickness_of_ranks_m)


def averaged(film: Film, frames: Bytes, thickness_m: Array, scale: int) -> tuple[Bytes, Array]:
    """Return ranks (pieces, frames, rows, columns) and thickness (256,) of cells ``scale`` times as large.

    Parameters
    ----------
    frames : ndarray of uint8 (pieces, frames, rows, columns)
        Ranks.
    thickness_m : ndarray (256,)
        Thickness at ranks.
    """
    pieces, count, rows, columns = frames.shape
    blocks = pieces, count, rows // scale, scale, columns // scale, scale
    mean = thickness_m.astype(np.float32)[frames].reshape(blocks).mean(axis=(3, 5), dtype=np.float32)
    near = frames.reshape(blocks).mean(axis=(3, 5), dtype=np.float32)
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
    clear = np.array([1.0 - film.coverage, 1.0 - layer.coverage])
    scores = score_of(np.clip(clear, 1e-6, 1.0 - 1e-6), film.sheet)
    moved = ranks + (scores[0] - scores[1]) * (LEVELS - 1) / (film.scores[-1] - film.scores[0])
    optical = np.interp(moved, ranks, film.optical_thickness)
    thinnest = float(film.optical_thickness[film.optical_thickness > 0.0][0])
    # Between a clear and a cloudy rank it is clear; cloud is as thick as the layer allows.
    metres: Array = np.clip(optical / extinction_m1(layer), layer.thickness_min_m, layer.thickness_max_m)
    return metres if layer.coverage >= 1.0 else np.where(optical < thinnest, 0.0, metres)


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
