"""The cloud generator `example`: an unbounded sky that looks like one example and changes as measured."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from hcss_skies.blended import BlendedExample
from hcss_skies.blending import put_in_layer
from hcss_skies.distribution import ranked
from hcss_skies.example import MAX_SCORE, Detail, read_example
from hcss_skies.library import find_example
from hcss_skies.pace import Pace
from hcss_skies.parameters import ExampleParameters
from hcss_skies.refined import RefinedCells
from hcss_skies.refining import MARGIN
from hcss_skies.relief import depth_of, shares_of, sharpened
from hcss_skies.tops import HangingClouds, between_cells, hanging_clouds, look_up_pairs
from hcss_twin.providers import Array, BrightnessInversion, CloudDeclaration, CloudInputs

DETAIL = Detail(0.31, 2.3)
"""Detail of examples that state none, from SEVIRI and Landsat images."""

# Share of an image that is warmer than its clear sky: what is left out of the texture of the sea.
_WARMEST = 0.01

# Pixels that are this close to the coldest cloud keep room for thicker parts, so that clouds can end inside them.
_FULL, _OPAQUE_K = 0.6, 0.3

# What is so much colder than the thickest cloud of the layer counts as lost.
_COLDER_K = 2.0

# Fuller pixels have no room; share of pixels from which on a note says so.
_NO_ROOM, _NOTED = 0.8, 0.01

# What is seen of a thickness, without a scene in parts of the greatest; optical thickness 1 hides 63 % of the sea.
_VISIBLE, _HIDDEN = 0.1, 0.63

# Tops this far above the clear sky keep their temperature in scenes whose clear sky is warmer or colder.
_DEEP_M = 10_000.0
# The layer lies where the place has it, mostly under an inversion: a deeper or colder example is squeezed until this
# share of its pixels fits into this part of what the layer shows. Colder ones approach the coldest cloud, so that none
# has a flat top.
_HIGHEST, _BELOW = 0.9, 0.93
_KNOTS = 4096  # of the temperature by height, 2.5 m apart

_TILE = 512


class ExampleClouds:
    """Clouds blended from an example.

    The field p, the height of an opaque cloud with the same brightness temperature, becomes thickness by the inversion
    of the scene's own radiance. Pixels of an image are as much colder than the clear sky of the scene as they were than
    that of the image. Heights of other examples, and of clouds with tops of their own, have the temperature of the
    scene's air; the difference of its clear sky vanishes 10 km above. Outside a scene, thickness is linear in p (eq 7
    of the HCSS paper) from the clear sky to the example's highest value.

    At the example's pixel size and above, a pixel has the value at its centre of the example, averaged to the closest
    power of two. Below, it is the mean over the pixel of cells of the example's size that are halved until they are no
    larger than it: all pixel sizes show one sky.

    Parameters
    ----------
    inputs : CloudInputs
        Layer, image plane, motion, seed, inversion.
    parameters : ExampleParameters
        Example, and the detail below its pixel.

    Raises
    ------
    CatalogError
        If there is no such example, or its file is damaged.
    """

    honours: tuple[str, ...] = ("coverage_mode",)

    def __init__(self, inputs: CloudInputs, parameters: ExampleParameters) -> None:
        self._inputs, self._of = inputs, parameters
        self.example = example = read_example(find_example(parameters.example, inputs.catalog))
        of_image = example.detail or DETAIL
        self._detail = Detail(
            of_image.strength if parameters.detail is None else parameters.detail,
            of_image.exponent if parameters.detail_exponent is None else parameters.detail_exponent,
        )
        self._cells = RefinedCells(inputs.grid, example.pixel_size_m, Pace.of(inputs.motion), inputs.seed, self._detail)
        self._pixel = self._cells.pixel
        self._blended_example = BlendedExample(example, inputs.grid.pixel_size_m, inputs.seed)
        level = self._blended_example.level
        self._clear_m = example.clear_m
        self.clear_sky_varies = parameters.clear_sky == "example"
        if self.clear_sky_varies:
            self._clear_m = min(self._clear_m, float(np.quantile(example.opaque_m[example.opaque], _WARMEST)))
        heights = level.heights_m[:, 0].astype(np.float64)
        self._high_m = float(np.quantile(np.maximum(example.opaque_m[example.opaque], self._clear_m), _HIGHEST))
        thickness = self.layer_thickness_m(heights)
        of_pairs = thickness[:, None]
        self._hanging: HangingClouds | None = None
        self._last: tuple[tuple[float, ...], NDArray[np.float32]] | None = None
        self.cloud_top_range_m: tuple[float, float] | None = None
        self.skipped: tuple[tuple[str, str], ...] = (
            ("cloud-top height of the example", 'clouds.parameters.tops = "layer": thickness alone varies'),
        )
        if parameters.tops == "example" and inputs.inversion is not None:
            highest = float(np.max(example.opaque_m[example.opaque] + example.excess_m[example.excess]))
            self._hanging = hanging_clouds(
                inputs.inversion, inputs.layer, self._kelvin_of(heights, inputs.inversion), example.excess_m, highest
            )
            self.cloud_top_range_m, self.skipped = self._hanging.range_m, ()
            at = np.minimum(level.heights_m[:, 1] / self._hanging.step_m, self._hanging.fields.shape[1] - 1).astype(int)
            of_pairs = self._hanging.fields[:, at, 0].astype(np.float64)
            thickness = np.arange(heights.size, dtype=np.float64)  # knots of p, from which thickness follows with x
        # Averaged to large pixels, an example is cloudier than it is; x is taken as independent of p.
        chance = np.exp(-0.5 * np.linspace(-MAX_SCORE, MAX_SCORE, heights.size) ** 2)
        thick = (of_pairs > 0.0) & (of_pairs >= 0.5 * inputs.layer.thickness_min_m)
        cloudy = thick @ chance / chance.sum() if thick.shape[1] > 1 else thick[:, 0]
        self.image_coverage = min(float(chance @ cloudy / chance.sum()), 1.0)  # rounding
        self._pace = Pace.of(inputs.motion)
        self._expected = np.ascontiguousarray(np.stack([thickness, level.heights_m[:, 1]], axis=1), dtype=np.float32)
        self._place_distribution()
        notes = [f"Example {parameters.example}: {example.kind}, {example.source} ({example.licence})"]
        if not example.excess_is_known:
            notes.append("The example has one channel: all its clouds count as opaque where they are coldest.")
        if self.clear_sky_varies:
            notes.append("The texture of clear sky is that of the example, as thin cloud, which counts in masks.")
        if inputs.inversion is not None and self._hanging is None:
            least = inputs.inversion.coldest_K
            colder = float(chance @ (self._seen_kelvin(heights, inputs.inversion) < least - _COLDER_K) / chance.sum())
            if colder > _NOTED:
                notes.append(
                    f"{colder:.0%} of the example is more than {_COLDER_K:g} K colder than the layer's thickest cloud "
                    f"({least:.4g} K) and looks like it; a higher clouds.top shows more, and so does parameters.tops = "
                    "'example'."
                )
        if self._cells.halvings:
            origin = (
                "from octaves of 2 to 8 pixels of the image, extrapolated"
                if example.detail is not None and parameters.detail is None and parameters.detail_exponent is None
                else "given"
                if parameters.detail is not None and parameters.detail_exponent is not None
                else "of other images"
                if example.detail is None
                else "partly given"
            )
            notes.append(
                f"Detail below {example.pixel_size_m:g} m: strength {self._detail.strength:.3g}, exponent "
                f"{self._detail.exponent:.3g}, {origin}. Edges and fibres inside its pixels are made, not measured."
            )
            full = float(chance @ (of_pairs[:, 0] > _NO_ROOM * inputs.layer.thickness_max_m) / chance.sum())
            if full > _NOTED:
                notes.append(
                    f"{full:.0%} of the example's pixels have nearly the greatest thickness of the layer: beside "
                    f"thinner cloud they look like squares of {example.pixel_size_m:g} m; a deeper layer leaves room."
                )
        self.declares = CloudDeclaration(
            depends_on=self._pace.depends_on, evolves=self._pace.evolves, notes=tuple(notes)
        )

    @cached_property
    def _visible_thickness(self) -> float:
        """Return the thickness that hides 63 % of the sea."""
        inversion, most = self._inputs.inversion, self._inputs.layer.thickness_max_m
        if inversion is None:
            return _VISIBLE * most
        kelvin = inversion.clear_K - _HIDDEN * (inversion.clear_K - inversion.coldest_K)
        return max(float(inversion.thickness_m(np.array(kelvin))), 1e-3 * most)

    def _place_distribution(self) -> None:
        """Give the middle of the sky the distribution of the example at time 0, unless it is left to chance."""
        self._tables = self._expected
        if self._of.distribution == "image":
            at_start = partial(self._blend, 0.0)
            self._tables = ranked(self._expected, self.example.opaque.shape, at_start)

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window; 0 is clear sky."""
        return self._window(time_s, rows, columns, 0)

    def thickness_around_m(
        self, time_s: float, rows: slice, columns: slice, summary: None = None
    ) -> NDArray[np.float32]:
        """Return the thickness (y, x) of a window that may reach outside the image."""
        return self._window(time_s, rows, columns, 0)

    def cloud_top_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the altitude of the cloud top (y, x) of any window, with the parameter ``tops = "example"``."""
        return self._window(time_s, rows, columns, 1)

    def top_above_opaque_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return cloud-top height less p, the second field of the example, (y, x) of any window.

        It belongs to the thickness of the same pixel. Below the example's pixel it is that of the closest pixel.

        Raises
        ------
        ValueError
            With ``tops = "example"``: :meth:`cloud_top_m` then has the altitudes.
        """
        if self._hanging is not None:
            raise ValueError('top_above_opaque_m: with tops = "example" ask cloud_top_m')
        return self._window(time_s, rows, columns, 1)

    @property
    def height_shares(self) -> Callable[..., NDArray[np.float32]]:
        """What spreads clouds over heights, the optional member of generators; not there for columns.

        Raises
        ------
        AttributeError
            With ``shape = "columns"`` or ``tops = "example"``.
        """
        if self._of.shape == "columns" or self._hanging is not None:
            raise AttributeError("height_shares")
        return self._height_shares

    def _height_shares(
        self, time_s: float, rows: slice, columns: slice, thickness_m: NDArray[np.float32], edges_m: Array
    ) -> NDArray[np.float32]:
        """Return the shares (Z, y, x) of each column between altitudes (Z + 1,), of any window; see ``relief.py``."""
        layer = self._inputs.layer
        depth = thickness_m.astype(np.float64)
        for i in range(0, depth.shape[0] if self._cells.halvings else 0, _TILE):
            for j in range(0, depth.shape[1], _TILE):
                tile = depth[i : i + _TILE, j : j + _TILE]
                body = self._body(tile.shape, time_s, rows.start + i, columns.start + j)
                tile[...] = depth_of(body, tile, self._inputs.grid.pixel_size_m, layer.thickness_max_m)
        hanging = layer.anchor == "top"
        end_m = layer.top_m if hanging else layer.base_m
        return shares_of(thickness_m, depth, np.asarray(edges_m, np.float64), end_m, hanging)

    def _body(self, shape: tuple[int, ...], time_s: float, row: int, column: int) -> Array:
        """Return thickness that is interpolated between the pixels of the example, in a part of a frame."""
        edges = self._cells.edges(shape, time_s, row, column)
        first = [math.floor(edge[0]) - MARGIN for edge in edges]
        y, x = (np.arange(low, math.ceil(edge[-1]) + MARGIN) + 0.5 for low, edge in zip(first, edges, strict=True))
        cells = sharpened(self._blended(time_s, y, x, 0)[..., 0].astype(np.float64))
        y, x = (0.5 * (edge[1:] + edge[:-1]) - 0.5 for edge in edges)
        return between_cells(cells, y, x, first)

    def layer_thickness_m(self, opaque_m: Array) -> Array:
        """Return the thickness of the layer where the example has heights p: what makes a cloud of each of its pixels.

        Parameters
        ----------
        opaque_m : ndarray (...)
            Heights p of opaque clouds, m.

        Returns
        -------
        ndarray (...)
            Thickness, m, of the same shape; 0 at the example's clear sky and below.
        """
        inversion, layer, clear = self._inputs.inversion, self._inputs.layer, self._clear_m
        top = float(self.example.opaque_m[-1])
        if inversion is None:
            share = np.clip((opaque_m - clear) / max(top - clear, 1.0), 0.0, 1.0)
            thickness = layer.thickness_min_m + (layer.thickness_max_m - layer.thickness_min_m) * share
            return np.where(opaque_m > clear, thickness, 0.0)
        kelvin = self._seen_kelvin(opaque_m, inversion)
        full, opaque = (
            _FULL * layer.thickness_max_m,
            float(inversion.thickness_m(np.array(inversion.coldest_K + _OPAQUE_K))),
        )
        if self.example.lapse_K_m is None:
            (high_K,) = self._seen_kelvin(np.array([self._high_m]), inversion)
            coldest_K = inversion.coldest_K + (_OPAQUE_K if opaque > full else 0.0)
            contrast_K = np.maximum(inversion.clear_K - kelvin, 0.0)
            fitted_K = fitted(contrast_K, inversion.clear_K - high_K, inversion.clear_K - coldest_K)
            kelvin = np.where(opaque_m > clear, inversion.clear_K - fitted_K, kelvin)
        full = max(full, opaque)
        return np.where(opaque_m > clear, np.minimum(inversion.thickness_m(kelvin), full), 0.0).astype(np.float64)

    def _seen_kelvin(self, opaque_m: Array, inversion: BrightnessInversion) -> Array:
        """Return the same without tops: pixels of an image are as much colder than clear sky as they were in it."""
        kelvin, lapse = self._kelvin_of(opaque_m, inversion), self.example.lapse_K_m
        if lapse is not None:
            kelvin = np.where(opaque_m > self._clear_m, inversion.clear_K - lapse * opaque_m, kelvin)
        return kelvin

    def _kelvin_of(self, opaque_m: Array, inversion: BrightnessInversion) -> Array:
        """Return the brightness temperature of the scene where the example has heights p.

        Higher clouds of the example are never warmer. Air above an inversion is: they would be the thinnest ones.
        """
        clear = self._clear_m
        (clear_air_K,) = inversion.air_temperature_K(np.array([clear]))
        deep = max(float(self.example.opaque_m[-1]), clear + _DEEP_M)
        heights = np.linspace(clear, deep, _KNOTS)
        fading = (deep - heights) / (deep - clear)
        above_m = heights - clear
        if self._of.tops == "layer":
            above_m = fitted(above_m, self._high_m - clear, self._inputs.layer.top_m - clear)
        air_K = inversion.air_temperature_K(clear + above_m)
        coldest_K = np.minimum.accumulate(air_K + (inversion.clear_K - clear_air_K) * fading)
        kelvin = np.interp(opaque_m, heights, coldest_K)
        return np.where(opaque_m > clear, kelvin, max(inversion.clear_K, 400.0))

    def _window(self, time_s: float, rows: slice, columns: slice, which: int) -> NDArray[np.float32]:
        if not math.isfinite(time_s):
            raise ValueError(f"time_s: {time_s} given, allowed: any finite time")
        if self._hanging is not None and not self._cells.halvings:
            return np.ascontiguousarray(self._pairs(time_s, rows, columns)[..., which])
        out = np.empty((max(0, rows.stop - rows.start), max(0, columns.stop - columns.start)), np.float32)
        for i in range(0, out.shape[0], _TILE):
            for j in range(0, out.shape[1], _TILE):
                tile = out[i : i + _TILE, j : j + _TILE]
                self._write(tile, time_s, rows.start + i, columns.start + j, which)
        if which:
            return out
        if self._hanging is not None and self._cells.halvings:  # detail knows no tops
            np.minimum(out, self._window(time_s, rows, columns, 1), out=out)
        return self._in_layer(out)

    def _pairs(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return thickness and top (y, x, 2) of a window; the last one is kept, as the engine asks for both."""
        key = time_s, rows.start, rows.stop, columns.start, columns.stop
        last = self._last
        if last is not None and last[0] == key:
            return last[1]
        out = np.empty((max(0, rows.stop - rows.start), max(0, columns.stop - columns.start), 2), np.float32)
        for i in range(0, out.shape[0], _TILE):
            for j in range(0, out.shape[1], _TILE):
                tile = out[i : i + _TILE, j : j + _TILE]
                edges = self._cells.edges(tile.shape, time_s, rows.start + i, columns.start + j)
                y, x = (edge[:-1] + 0.5 * self._pixel for edge in edges)
                tile[...] = self._blended(time_s, y, x)
        self._in_layer(out[..., 0])
        self._last = key, out
        return out

    def _in_layer(self, thickness: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return thickness with the least one of the layer, or 0, where it is thinner."""
        least, most = (
            np.float32(limit) for limit in (self._inputs.layer.thickness_min_m, self._inputs.layer.thickness_max_m)
        )
        put_in_layer(thickness, least, most)
        return thickness

    def _write(self, out: NDArray[np.float32], time_s: float, row: int, column: int, which: int) -> None:
        """Write a part of a frame that begins at ``row`` and ``column``."""
        edges = self._cells.edges(out.shape, time_s, row, column)
        if not self._cells.halvings:
            y, x = (edge[:-1] + 0.5 * self._pixel for edge in edges)
            out[...] = self._blended(time_s, y, x, which)[..., which]
            return
        low, high = self._cells.regions(edges)[0]
        first = list(low)
        y, x = (np.arange(*ends, dtype=np.float64) + 0.5 for ends in zip(low, high, strict=True))
        cells = self._blended(time_s, y, x, which)[..., which]
        if which and self._hanging is not None:
            y, x = (0.5 * (edge[1:] + edge[:-1]) - 0.5 for edge in edges)
            out[...] = between_cells(cells.astype(np.float64), y, x, first)
            return
        if which:
            at = [
                np.floor(0.5 * (edge[1:] + edge[:-1])).astype(np.int64) - low
                for edge, low in zip(edges, first, strict=True)
            ]
            out[...] = cells[np.ix_(*at)]
            return
        most = float(np.float32(self._inputs.layer.thickness_max_m))  # so that full cells stay full
        out[...] = self._cells.means(cells, first, edges, time_s, most, self._visible_thickness)

    def _blended(self, time_s: float, y: Array, x: Array, which: int = 1) -> NDArray[np.float32]:
        """Return thickness, and x or tops, (rows, columns, 2) at positions in pixels of the example.

        With ``which`` 0, x is left out where thickness does not need it.
        """
        out = np.empty((y.size, x.size, 1 if which == 0 and self._hanging is None else 2), np.float32)
        if out.size:
            self._blend(time_s, out, y, x, self._tables)
            if self._hanging is not None:
                look_up_pairs(out, self._hanging.fields, self._hanging.step_m)
        return out

    def _blend(self, time_s: float, out: NDArray[np.float32], y: Array, x: Array, tables: NDArray[np.float32]) -> None:
        """Write the values of tables (N, 2) that belong to the blended scores, (rows, columns, 1 or 2)."""
        self._blended_example.blend(time_s * self._pace.rate, out, y, x, tables, self._pixel)


def fitted(values: Array, high: float, room: float) -> Array:
    """Return values from 0 on that stay below ``room``: in proportion up to ``high``, larger ones squeezed the more.

    The slope is continuous, and at most 1. Nothing changes without room, as where a layer has no cloud to show.
    """
    if room <= 0.0:
        return values
    slope, even = min(1.0, _BELOW * room / max(high, 1e-9)), _BELOW * room
    beyond = np.maximum(slope * values - even, 0.0) / (room - even)
    below: Array = np.minimum(slope * values, even) - (room - even) * np.expm1(-beyond)
    return below
