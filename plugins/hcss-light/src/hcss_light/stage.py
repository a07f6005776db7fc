"""Radiance of sequences whose light in clouds is kept while they drift, on squares of a lattice that drifts with them.

The lattice does not depend on windows, so that a pixel has the same bits in all of them.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_light.slices import Field
from hcss_light.tiles import Tiles
from hcss_light.voxels import LightError
from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Sun, View

SQUARES_OF_FRAME = 64
"""Squares of a frame in memory."""

KEPT_S, MOST_KEPT = 60.0, 2**22
"""Time between two instants whose light in clouds is kept, and most columns of cloud (of some 100 bytes each)."""

Window = tuple[slice, slice]
"""Ranges of rows and columns, in pixels."""

_Square = tuple[Any, Array, Array, Array, Array, Array]


@dataclass(frozen=True)
class _Lit:
    """Light of a square in each of the plans: over each class of surface, at each value of effects of points.

    ``seen``, ``over_sea``: pixels around it with clouds on lines of sight, and over the sea.
    """

    lights: Sequence[Any]
    clouds: Any
    seen: Any
    over_sea: Any
    edges_m: Array
    toward: tuple[View, Sun | None] | None = None


def stage(plan: Plan, tables: RadianceTables, keeps: bool) -> LightStage:
    """Return the stage of a plan: light is kept if it can be, the frames are close, and the image is not too large."""
    if not plan.is_grid:
        return RayStage(plan, tables, False)
    return DriftingStage(plan, tables, keeps and 3.0 * plan.scenario.frames.interval <= KEPT_S)


def shares_of(
    plan: Plan, number: int, time_s: float, window: Window, thickness_m: Field, edges_m: Array
) -> Field | None:
    """Return how the cloud of points of a layer is spread over heights, if its generator says so."""
    shares = getattr(plan.assembly.generators[number], "height_shares", None)
    samples = plan.scene.samples
    rows, columns = (slice(span.start * samples, span.stop * samples) for span in window)
    result: Field | None = None if shares is None else shares(time_s, rows, columns, thickness_m, edges_m)
    return result


def require_one_shape(plan: Plan, number: int) -> None:
    """Refuse clouds of a layer with a shape in height where another one is asked.

    Raises
    ------
    LightError
        Names the key.
    """
    shapes = hasattr(plan.assembly.generators[number], "height_shares")
    if shapes and plan.scenario.radiance.light_profile != "uniform":
        raise LightError("radiance.light_profile: clouds have a shape in height of their own; allowed: the default")


class DriftingStage(LightStage):
    """Light in clouds is computed every :data:`KEPT_S` only, and moves with the clouds.

    Each frame is the mean of its two neighbours in time, by their distances. Clouds may have any shape in height.

    Parameters
    ----------
    keeps : bool
        False: each frame is computed for itself.
    """

    def __init__(self, plan: Plan, tables: RadianceTables, keeps: bool) -> None:
        super().__init__(plan, tables)
        transport: Any = self._transport
        self._tiles: Tiles | None = None
        self._own_tops = self._number in plan.assembly.hanging_layers
        keeps = keeps and len(self._plans) == 1 and not self._own_tops
        self._sizes = plan.grid.rows, plan.grid.columns
        if plan.views.varies:
            self._tiles, keeps = Tiles(plan, transport), False
            self._pixels, self._nodes = self._tiles.side, tables.spectrum.nodes
            self._of_tiles: OrderedDict[tuple[int, int], _Lit] = OrderedDict()
        samples, pixels = plan.scene.samples, self._pixels
        # One pixel more: clouds lie between the pixels of the instant whose light is kept.
        seen = (
            [tuple(-(-points // samples) + 1 for points in both) for both in transport.seen] if keeps else self._reach
        )
        # Squares of two instants, with those of clouds that enter the image.
        self._most_kept = 2 * (-(-plan.grid.rows // pixels) + 1) * (-(-plan.grid.columns // pixels) + 1)
        columns = self._most_kept * math.prod((pixels + sum(margin)) * samples for margin in seen)
        # The layer without cloud of a scene of two may have another wind.
        winds = {(layer.wind_speed, layer.wind_from) for layer in plan.scenario.clouds.layers}
        self._keeps = keeps and columns <= MOST_KEPT and len(winds) == 1
        self._seen = seen if self._keeps else self._reach
        require_one_shape(plan, self._number)
        self._edges_m: Array = transport.edges_m
        self._over_sea = self._margins(transport, self._seen)
        motion, section = plan.assembly.motion, plan.scenario.clouds.layers[0]
        east, north = motion.cloud_velocity_m_s
        if section.wind_speed is not None or section.wind_from is not None:
            layer, base = section, plan.scenario.motion
            speed = base.wind_speed if layer.wind_speed is None else layer.wind_speed
            toward = math.radians((base.wind_from if layer.wind_from is None else layer.wind_from) + 180.0)
            east, north = speed * math.sin(toward), speed * math.cos(toward)
        self._speed = np.array([north, east - motion.platform_speed_m_s]) / plan.grid.pixel_size_m
        self._drifts = np.ceil(np.abs(self._speed) * KEPT_S).astype(int) + 1
        self._lights: OrderedDict[float, tuple[Sun | None, Sequence[Any], Any]] = OrderedDict()
        self._kept: OrderedDict[tuple[float, int, int], Any] = OrderedDict()
        self._time_s: float | None = None
        # Light, clouds and their displacement, amount, share and change of squares of this frame and the one before.
        self._of_frame: OrderedDict[tuple[int, int, int], _Square] = OrderedDict()
        self._previous = self._of_frame

    def fill(
        self, radiance: NDArray[np.float32], window: Window, region: Window, time_s: float, clouds: Any, look_up: Any
    ) -> None:
        """Write the radiance (B, y, x) of a window of the image, from its FrameClouds, to its place in a part."""
        if self._time_s != time_s:
            self._time_s, self._previous, self._of_frame = time_s, self._of_frame, OrderedDict()
            self._squares = OrderedDict()
        for number, (own_s, part) in enumerate(self._instants(time_s)):
            moved = self._speed * (time_s - own_s)
            self._add(radiance, window, region, number, (own_s, part, moved), clouds, look_up)
        for square in self.squares(window):
            # Beyond the image each frame is computed for itself.
            if any(span.start < 0 or span.start >= size for span, size in zip(square, self._sizes, strict=True)):
                self._put(square, radiance, window, region, clouds, look_up)

    def _square(self, extent: Window, clouds: Any) -> tuple[Array, Array, Array]:
        assert self._time_s is not None
        lit = self._lit((extent[0].start // self._pixels, extent[1].start // self._pixels), self._time_s)
        if self._keeps:
            lit = replace(lit, seen=self._reach, over_sea=self._margins(self._transport, self._reach))
        thickness = clouds.thickness_m(self.around(extent, lit.over_sea))[self._number]
        return self._of_extent(extent, lit, self._time_s, thickness, clouds)

    def _add(
        self, radiance: NDArray[np.float32], window: Window, region: Window, number: int,
        instant: tuple[float, float, Array], clouds: Any, look_up: Any,
    ) -> None:  # fmt: skip
        own_s, part, moved = instant
        side, by = self._pixels, np.floor(moved).astype(int).tolist()
        spans = [
            ((max(span.start, 0) - far) // side, -(-(min(span.stop, size) - far) // side))
            for span, far, size in zip(window, by, self._sizes, strict=True)
        ]
        for row, column in product(*(range(*span) for span in spans)):
            place_of, key = (row * side, column * side), (number, row, column)
            # Squares end with the image, around which light is not kept.
            extent = [
                slice(max(start + far, 0), min(start + far + side, size))
                for start, far, size in zip(place_of, by, self._sizes, strict=True)
            ]
            if key not in self._of_frame:
                self._of_frame[key] = self._of_lattice(key, extent, own_s, moved, clouds)
                if len(self._of_frame) > SQUARES_OF_FRAME:
                    self._of_frame.popitem(last=False)
            *_, amount, share, change = self._of_frame[key]
            square, first = (amount, share, change), (extent[0].start, extent[1].start)
            where, means = self._within(first, square, window, region, look_up, radiance.shape[0])
            for band, mean in zip(radiance[: len(means)], means, strict=True):
                band[*where] = mean if part == 1.0 else part * mean + (band[*where] if number else 0.0)

    def _instants(self, time_s: float) -> list[tuple[float, float]]:
        """Return the instants whose light a frame has, with their shares."""
        first = KEPT_S * math.floor(time_s / KEPT_S)
        # Films of clouds end with the sequence.
        last = min(first + KEPT_S, max(float(self._plan.frame_times_s[-1]), time_s))
        if time_s == last or not self._keeps:
            return [(time_s, 1.0)]
        share = (time_s - first) / (last - first)
        return [(first, 1.0 - share), (last, share)] if share > 0.0 else [(first, 1.0)]

    def _light(self, time_s: float) -> tuple[Sequence[Any], Any]:
        """Return light over each class of surface, the same under the same sun, and FrameClouds of an instant."""
        if time_s not in self._lights:
            sun = self._plan.sun_at(time_s)
            known = [lights for light_sun, lights, _ in self._lights.values() if light_sun == sun]
            lights = known[0] if known else [transport.at(sun) for transport in self._transports]
            self._lights[time_s] = sun, lights, FrameClouds(self._plan, time_s)
            if len(self._lights) > 3:  # of two neighbours, and beyond the image of the frame itself
                self._lights.popitem(last=False)
        return self._lights[time_s][1:]

    def _margins(self, transport: Any, seen: Any) -> list[tuple[int, ...]]:
        """Return pixels around a square with clouds that matter to the sea below, not only to lines of sight."""
        samples = self._plan.scene.samples
        return [
            tuple(max(-(-far // samples), near) for far, near in zip(*both, strict=True))
            for both in zip(transport.sea_reach, seen, strict=True)
        ]

    def _lit(self, square: tuple[int, int], time_s: float) -> _Lit:
        """Return the light of a square at an instant."""
        if self._tiles is None:
            return _Lit(*self._light(time_s), self._seen, self._over_sea, self._edges_m)
        view = self._tiles.view_of(*square, time_s)
        toward = self._plan.toward(view)
        sun, known = toward.sun_at(time_s), self._of_tiles.pop(square, None)
        if known is None or known.toward != (view, sun):
            of_classes = [
                self._plan.light.transport(LightStage.inputs(each.toward(view), self._nodes)) for each in self._plans
            ]
            transport: Any = of_classes[0]
            samples = self._plan.scene.samples
            seen = [tuple(-(-points // samples) for points in both) for both in transport.reach]
            known = _Lit(
                [each.at(sun) for each in of_classes],
                None,
                seen,
                self._margins(transport, seen),
                transport.edges_m,
                (view, sun),
            )
        self._of_tiles[square] = known
        if len(self._of_tiles) > SQUARES_OF_FRAME:
            self._of_tiles.popitem(last=False)
        return known

    def _of_lattice(
        self, key: tuple[int, int, int], extent: Sequence[slice], own_s: float, moved: Array, clouds: Any
    ) -> _Square:
        lit = self._lit(key[1:], own_s)
        light = lit.lights[0]
        thickness = clouds.thickness_m(self.around(extent, lit.over_sea))[self._number]
        before = self._previous.pop(key, None)
        still = before is not None and before[0] is light and np.array_equal(before[2], moved)
        one = len(self._plans) == 1 and not self._own_tops
        if before is not None and still and one and np.array_equal(before[1], thickness):
            return before
        kept: tuple[Any, ...] = ()
        if self._keeps:
            source, first = self._kept_of(own_s, key[1:], light, lit.clouds)
            kept = source, (moved + first - [span.start for span in extent]) * self._plan.samples_per_pixel
        return light, thickness.copy(), moved, *self._of_extent(extent, lit, own_s, thickness, clouds, kept)

    def _of_extent(
        self, extent: Sequence[slice], lit: _Lit, own_s: float, thickness: Field, clouds: Any,
        kept: tuple[Any, ...] = (),
    ) -> tuple[Array, Array, Array]:  # fmt: skip
        """Return amount (y, x), share and change (B, y, x) of pixels, from the clouds in and around them."""
        rows, columns = extent
        if self._own_tops:
            return self._under_tops((rows, columns), self._seen_among(extent, lit, clouds), lit, own_s, clouds)
        shares = self._shares(self._time_s, self.around(extent, lit.over_sea), thickness, lit.edges_m)
        amounts, *of_classes = self._over_classes("correct", extent, lit, thickness, shares, kept)
        share, change = (self._at_points(found, own_s, (rows, columns)) for found in of_classes)
        return amounts[0], share, change

    def _seen_among(self, extent: Sequence[slice], lit: _Lit, clouds: Any) -> Sequence[Array]:
        """Return the radiance (B, y, x) over each class of surface of an extent among clouds with tops of their own."""
        wide = self.around(extent, lit.over_sea)
        thickness, shares = clouds.standing(self._number, wide, lit.edges_m)
        return self._over_classes("seen", extent, lit, thickness, {"shares": shares})[1]

    def _under_tops(
        self, extent: Window, seen: Sequence[Array], lit: _Lit, time_s: float, clouds: Any
    ) -> tuple[Array, Array, Array]:
        """Return amount (y, x), share and change (B, y, x) of pixels that see tops of their own, from what they see."""
        thickness, shares = clouds.as_columns(self._number, extent, lit.edges_m)
        found = [light.beside_columns(total, thickness, shares) for light, total in zip(lit.lights, seen, strict=True)]
        share, change = (self._at_points(values, time_s, extent) for values in zip(*found, strict=True))
        return thickness.astype(np.float64), share, change

    def _over_classes(
        self, method: str, extent: Sequence[slice], lit: _Lit, thickness: Field, shares: dict[str, Field],
        kept: tuple[Any, ...] = (),
    ) -> list[list[Array]]:  # fmt: skip
        """Return each result (..., y, x) of a method of the light over each class of surface, for the pixels alone."""
        samples = self._plan.scene.samples
        inner = [
            slice((far - near) * samples, (far + span.stop - span.start + high) * samples)
            for span, (far, _), (near, high) in zip(extent, lit.over_sea, lit.seen, strict=True)
        ]
        of_seas = [
            [light_of_sea[*inner] for light_of_sea in of_class.over_sea(thickness, **shares)] for of_class in lit.lights
        ]
        shares = {name: np.ascontiguousarray(values[:, *inner]) for name, values in shares.items()}
        near = np.ascontiguousarray(thickness[*inner])
        found = [
            getattr(of_class, method)(near, *kept, **shares, over_sea=over_sea)
            for of_class, over_sea in zip(lit.lights, of_seas, strict=True)
        ]
        cut = [
            slice(before * samples, (before + span.stop - span.start) * samples)
            for span, (before, _) in zip(extent, lit.seen, strict=True)
        ]
        return [[values[..., *cut].copy() for values in of_classes] for of_classes in zip(*found, strict=True)]

    def _shares(self, time_s: float | None, window: Window, thickness_m: Field, edges_m: Array) -> dict[str, Field]:
        assert time_s is not None
        shares = shares_of(self._plan, self._number, time_s, window, thickness_m, edges_m)
        return {} if shares is None else {"shares": shares}

    def _kept_of(self, time_s: float, square: tuple[int, int], light: Any, clouds: Any) -> Any:
        """Return the light in the clouds of a square of the lattice at an instant, and its first row and column.

        Of squares at the edge, only clouds that can enter the image while their light is kept.
        """
        key, samples, side = (time_s, *square), self._plan.samples_per_pixel, self._pixels
        if key not in self._kept:
            extent = [
                slice(max(number * side, -far), min((number + 1) * side, size + far))
                for number, far, size in zip(square, self._drifts, self._sizes, strict=True)
            ]
            wide = self.around(extent, self._reach)
            thickness = clouds.thickness_m(wide)[self._number]
            inner = [
                slice((far - near) * samples, (far + span.stop - span.start + high) * samples)
                for span, (far, _), (near, high) in zip(extent, self._reach, self._seen, strict=True)
            ]
            shares = self._shares(time_s, wide, thickness, self._edges_m)
            source = light.keep(np.ascontiguousarray(thickness), inner, **shares)
            self._kept[key] = source, np.array([span.start for span in extent])
            if len(self._kept) > self._most_kept:
                self._kept.popitem(last=False)
        self._kept.move_to_end(key)
        return self._kept[key]


class RayStage(DriftingStage):
    """Light toward rays that form no grid on the ground: each sees the column of cloud nearest to it.

    The columns below a square of pixels are computed toward the view from its middle. Rays meet them where they meet
    the flat side of the layer.
    """

    def fill(
        self, radiance: NDArray[np.float32], window: Window, region: Window, time_s: float, clouds: Any, look_up: Any
    ) -> None:
        """Write the radiance (B, y, x) of a window of the image, from its FrameClouds, to its place in a part."""
        key = time_s, self._plan.rays.frame_key(time_s)
        if self._key != key:
            self._key, self._time_s, self._squares = key, time_s, OrderedDict()
        for square in self.squares(window):
            self._put(square, radiance, window, region, clouds, look_up)

    _key: Any = None

    def _square(self, extent: Window, clouds: Any) -> tuple[Array, Array, Array]:
        assert self._time_s is not None
        scene, rays, time_s = self._plan.scene, self._plan.rays, self._time_s
        place = scene.in_points(*rays.points_m(extent, time_s, self._reference_m))
        below, bands = scene.around(*place), len(self._plan.bands)
        if below is None:
            shape = place[0].shape
            return np.zeros(shape), np.ones((bands, *shape)), np.zeros((bands, *shape))
        lit = self._lit((extent[0].start // self._pixels, extent[1].start // self._pixels), time_s)
        row, column = (
            np.rint(points).astype(np.intp) - first for points, first in zip(place, scene.corner_of(below), strict=True)
        )
        if self._own_tops:
            seen = [values[:, row, column] for values in self._seen_among(below, lit, clouds)]
            return self._under_tops(extent, seen, lit, time_s, clouds)
        wide = self.around(below, lit.over_sea)
        thickness = clouds.of_scene_m(wide)[self._number]
        shares = self._shares(time_s, wide, thickness, lit.edges_m)
        amounts, *of_classes = self._over_classes("correct", below, lit, thickness, shares)
        share, change = (
            self._at_points([values[:, row, column] for values in found], time_s, extent) for found in of_classes
        )
        return amounts[0][row, column], share, change
