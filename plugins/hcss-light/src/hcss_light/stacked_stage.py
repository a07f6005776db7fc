"""Radiance of frames of a scene with several cloud layers, on squares of a lattice fixed to the image.

Rays that form no grid on the ground see the columns that stand at the points of the scene: those nearest to where the
rays meet the flat side of the lowest layer, and of all layers those that lines from there toward the view of a square
of pixels cross.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_light.slices import Field
from hcss_light.stage import SQUARES_OF_FRAME, Window, require_one_shape, shares_of
from hcss_light.tiles import Tiles
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Sun, View


@dataclass(frozen=True)
class _Lit:
    """Transports and light over each class of surface toward one view, under one sun."""

    transports: Sequence[Any]
    lights: Sequence[Any]


class StackedStage(LightStage):
    """Each frame is computed for itself; see :class:`~hcss_twin.engine.stages.light.LightStage`."""

    def __init__(self, plan: Plan, tables: RadianceTables) -> None:
        super().__init__(plan, tables)
        self._numbers, self._nodes = plan.cloudy_layers, tables.spectrum.nodes
        self._own_tops = [number in plan.assembly.hanging_layers for number in self._numbers]
        for number in self._numbers:
            require_one_shape(plan, number)
        self._tiles: Tiles | None = None
        if plan.views.varies:
            transport: Any = self._transport
            self._tiles = Tiles(plan, transport)
            self._pixels = self._tiles.side
        self._lights: OrderedDict[tuple[View | None, Sun | None], _Lit] = OrderedDict()
        self._frame: Any = None

    def fill(
        self, radiance: NDArray[np.float32], window: Window, in_part: Window, time_s: float, clouds: Any, look_up: Any
    ) -> None:
        """Write the radiance (B, y, x) of a window of the image, from its FrameClouds, to its place in a part."""
        frame = time_s, self._plan.rays.frame_key(time_s)
        if self._frame != frame:
            self._frame, self._squares = frame, OrderedDict()
        for square in self.squares(window):
            self._put(square, radiance, window, in_part, clouds, look_up)

    def _lit(self, square: tuple[int, int], time_s: float) -> _Lit:
        """Return the light of a square."""
        view = None if self._tiles is None else self._tiles.view_of(*square, time_s)
        sun = (self._plan if view is None else self._plan.toward(view)).sun_at(time_s)
        if (view, sun) not in self._lights:
            transports: Sequence[Any] = self._transports
            if view is not None:
                inputs = [LightStage.inputs(each.toward(view), self._nodes) for each in self._plans]
                transports = [self._plan.light.transport(of_class) for of_class in inputs]
            self._lights[view, sun] = _Lit(transports, [transport.at(sun) for transport in transports])
            if len(self._lights) > SQUARES_OF_FRAME:
                self._lights.popitem(last=False)
        return self._lights[view, sun]

    def _square(self, extent: Window, clouds: Any) -> tuple[Array, Array, Array]:
        """Return amounts (L, y, x), share and change of radiance (B, y, x) of the points of a square."""
        plan, time_s = self._plan, self._frame[0]
        lit = self._lit((extent[0].start // self._pixels, extent[1].start // self._pixels), time_s)
        if plan.is_grid:
            amount, of_classes = self._among(extent, lit, time_s, clouds)
        else:
            place = plan.scene.in_points(*plan.rays.points_m(extent, time_s, self._reference_m))
            below, shape = plan.scene.around(*place), place[0].shape
            if below is None:
                bands = len(plan.bands), *shape
                return np.zeros((len(self._numbers), *shape)), np.ones(bands), np.zeros(bands)
            corner = plan.scene.corner_of(below)
            row, column = (np.rint(points).astype(np.intp) - first for points, first in zip(place, corner, strict=True))
            amount, of_classes = self._among(below, lit, time_s, clouds)
            amount, of_classes = amount[:, row, column], [total[:, row, column] for total in of_classes]
        edges_m = lit.transports[0].edges_m
        columns: list[Field | None] = [None] * len(self._numbers)
        for index, (number, own) in enumerate(zip(self._numbers, self._own_tops, strict=True)):
            if own:
                amount[index], columns[index] = clouds.as_columns(number, extent, edges_m[index])
        found = [
            light.beside_columns(total, amount, columns) for light, total in zip(lit.lights, of_classes, strict=True)
        ]
        share, change = (self._at_points(values, time_s, extent) for values in zip(*found, strict=True))
        return amount, share, change

    def _among(self, extent: Sequence[slice], lit: _Lit, time_s: float, clouds: Any) -> tuple[Array, list[Array]]:
        """Return amounts (L, y, x) on lines of sight, and radiance (B, y, x) over each class of surface."""
        plan, samples, transport = self._plan, self._plan.scene.samples, lit.transports[0]
        far, near = (
            [tuple(-(-points // samples) for points in both) for both in reach]
            for reach in (transport.reach, transport.reach_of_light)
        )
        window = self.around(extent, far)
        layers = clouds.thickness_m(window) if plan.is_grid else clouds.of_scene_m(window)
        thickness, shares = [], []
        for number, own, edges in zip(self._numbers, self._own_tops, transport.edges_m, strict=True):
            if own:
                of_layer, share = clouds.standing(number, window, edges)
            else:
                of_layer, share = layers[number], shares_of(plan, number, time_s, window, layers[number], edges)
            thickness.append(of_layer)
            shares.append(share)
        inner = [
            slice((before - low) * samples, (before + span.stop - span.start + high) * samples)
            for span, (before, _), (low, high) in zip(extent, far, near, strict=True)
        ]
        cut = [
            slice(low * samples, (low + span.stop - span.start) * samples)
            for span, (low, _) in zip(extent, near, strict=True)
        ]
        found = [light.seen(np.stack(thickness), shares, inner) for light in lit.lights]
        return found[0][0][:, *cut].copy(), [total[:, *cut].copy() for _, total in found]

    def _looked_up(self, look_up: Any, amount_m: Array, channels: int) -> Array:
        """Return the radiance (C, y, x) of columns; below the thinnest cloud of each layer it is linear."""
        result = np.zeros((channels, *amount_m.shape[1:]))
        values = np.empty((channels, *amount_m.shape[1:]), dtype=np.float32)
        for cloudy in product((False, True), repeat=len(self._numbers)):
            weight = np.ones(amount_m.shape[1:])
            layers = [np.zeros(amount_m.shape[1:], dtype=np.float32)] * len(self._plan.layers)
            for number, layer_amount, present in zip(self._numbers, amount_m, cloudy, strict=True):
                layer = self._plan.layers[number]
                part = np.minimum(layer_amount / layer.thickness_min_m, 1.0)
                weight *= part if present else 1.0 - part
                if present:
                    layers[number] = np.clip(layer_amount, layer.thickness_min_m, layer.thickness_max_m).astype(
                        np.float32
                    )
            look_up.fill(values, layers)
            result += weight * values
        return result
