"""Cloud shadows on the clear sea, in each frame.

The layer is divided into slices of equal height, in each of which the sun's path moves by at most one point along
either axis. The cloud in a slice is sampled at the nearest point to the path at the middle height of the slice; there
it extends from the layer's flat side by the thickness, or, of generators with ``cloud_depth_m``, from its top down by
its height. For a uniform layer the slices add up to its thickness.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method
from hcss_twin.core.kernels import kernel
from hcss_twin.cube.variables import SHADOW_MASK
from hcss_twin.engine.scene_points import at_rays, interpolated
from hcss_twin.engine.stages.stage import FramePart, PartWindow, Stage
from hcss_twin.engine.tables.point_axis import PointAxis
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.engine.tables.view_states import OneView, ViewStates, point_states
from hcss_twin.physics.geometry import displacement_m
from hcss_twin.plan.hanging_levels import add_hanging, spanning
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.point_shifts import PointShifts
from hcss_twin.plan.windows import Window, length, points_of
from hcss_twin.providers import CloudGenerator, CloudLayer, Sun

Thickness = NDArray[np.float32]


@dataclass(frozen=True)
class SunPaths:
    """Slices of one layer along the sun's paths at one instant.

    Attributes
    ----------
    shifts : ndarray of int64 (S, 2)
        Displacement in points (rows, columns) from the sea point to its path in each slice.
    from_flat_m : ndarray (S,)
        Distance from the layer's flat side to the near face of the slice; of bodies, the altitude of its lower face.
    slice_m : float
        Height of each slice.
    bodies : bool
        Whether clouds have tops and heights of their own, whether or not the sensor sees them there.
    """

    shifts: NDArray[np.int64]
    from_flat_m: NDArray[np.float64]
    slice_m: float
    bodies: bool = False

    def stay_at(self, shift: tuple[int, int]) -> bool:
        """Whether all slices have the same displacement."""
        return bool(np.all(self.shifts == np.array(shift)))

    def heights_m(self, generator: CloudGenerator, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return the vertical path length (y, x) in cloud of the sun's paths to the points of a window.

        Dividing by the cosine of the sun's zenith angle gives the path length.

        Parameters
        ----------
        generator : CloudGenerator
            With the method ``displaced_m`` of :class:`hcss_twin.plan.displaced_clouds.DisplacedClouds`.
        """
        first, last = self.shifts.min(axis=0), self.shifts.max(axis=0)
        wide = tuple(
            slice(window.start, window.stop + int(high - low))
            for window, low, high in zip((rows, columns), first, last, strict=True)
        )
        start = int(first[0]), int(first[1])
        thickness = generator.displaced_m(time_s, *wide, start)  # type: ignore[attr-defined]
        heights = np.zeros((rows.stop - rows.start, columns.stop - columns.start), dtype=np.float32)
        if self.bodies:
            ends = generator.displaced_ends_m(time_s, *wide, start)  # type: ignore[attr-defined]
            add_hanging(heights, thickness, *ends, self.shifts - first, float(self.from_flat_m[0]), self.slice_m)
            return heights
        _add_slices(heights, np.ascontiguousarray(thickness), self.shifts - first, self.from_flat_m, self.slice_m)
        return heights


def sun_paths(layer: CloudLayer, sun: Sun, point_m: float, bodies: bool = False) -> SunPaths:
    """Divide a layer into slices for the sun at one instant: where tops vary, all heights that have clouds."""
    moved = displacement_m(layer.thickness_max_m, sun.zenith_deg, sun.azimuth_deg)
    count = max(1, math.ceil(float(np.max(np.abs(moved))) / point_m))
    middle = layer.base_m + layer.thickness_max_m * (np.arange(count) + 0.5) / count
    away = displacement_m(middle, sun.zenith_deg, sun.azimuth_deg).T
    from_base = layer.thickness_max_m * np.arange(count) / count
    from_flat = from_base if layer.anchor == "base" else from_base[::-1]
    if bodies:
        from_flat = layer.base_m + from_base
    shifts = np.rint(away / point_m).astype(np.int64)
    return SunPaths(shifts, from_flat, layer.thickness_max_m / count, bodies)


AT_ONCE = 4
"""Slices that are added to a row of points together, which is read and written once for all of them."""


@kernel()
def _add_slices(heights, thickness, shifts, from_flat, slice_m):  # type: ignore[no-untyped-def]
    """Add the cloud of each slice to ``heights``, in single precision like the thickness."""
    full = np.float32(slice_m)
    tallest = np.zeros(thickness.shape[0], np.float32)
    for y in range(tallest.size):
        for x in range(thickness.shape[1]):
            tallest[y] = max(tallest[y], thickness[y, x])
    most = shifts.shape[0] + AT_ONCE
    row, column, near = np.empty(most, np.int64), np.empty(most, np.int64), np.empty(most, np.float32)
    # All slices of a row, which stays in the processor's cache, before the next one.
    for y in range(heights.shape[0]):
        height, count = heights[y], 0
        for s in range(shifts.shape[0]):
            row[count], column[count], near[count] = y + shifts[s, 0], shifts[s, 1], np.float32(from_flat[s])
            count += tallest[row[count]] > near[count]
        while count % AT_ONCE > 0:  # slices that no cloud reaches
            row[count], column[count], near[count] = row[0], column[0], np.float32(np.inf)
            count += 1
        for s in range(0, count, AT_ONCE):
            near0, near1, near2, near3 = near[s], near[s + 1], near[s + 2], near[s + 3]
            cloud0, cloud1 = thickness[row[s], column[s] :], thickness[row[s + 1], column[s + 1] :]
            cloud2, cloud3 = thickness[row[s + 2], column[s + 2] :], thickness[row[s + 3], column[s + 3] :]
            for x in range(height.size):
                two = height[x] + _in_slice(cloud0[x], near0, full) + _in_slice(cloud1[x], near1, full)
                height[x] = two + _in_slice(cloud2[x], near2, full) + _in_slice(cloud3[x], near3, full)


@kernel(inner=True, forceinline=True)
def _in_slice(thickness, near, full):  # type: ignore[no-untyped-def]
    return min(max(thickness - near, np.float32(0)), full)


class ShadowStage(Stage):
    """Sunlight that clouds keep from the clear points of each surface.

    Parameters
    ----------
    of_surfaces : sequence of sequence of RadianceTables
        Of each class of surface, at each value of the effects and toward each view; none if no requested variable
        requires radiance: the mask needs no tables.
    effects : sequence of PointAxis
        Effects of points.
    """

    title = "shadows of clouds"
    reads = ("truth", "columns", "texture", "ground")
    writes = ("sunlight",)

    def __init__(
        self, plan: Plan, of_surfaces: Sequence[Sequence[RadianceTables]], effects: Sequence[PointAxis[Any]] = ()
    ) -> None:
        self._plan, self._tables, self._effects = plan, of_surfaces, effects
        self._point_m = plan.scene.point_m
        self._shifts: list[tuple[int, int] | PointShifts | None] = [None] * len(plan.layers)
        if plan.is_grid:
            self._shifts = [plan.assembly.slant.of_view(layer, self._point_m) for layer in plan.layers]
        self._at = cached_method(self._shadows, 1)
        self._kept_back = np.empty(0, np.float32)

    def apply(self, part: FramePart, window: PartWindow) -> None:
        """Subtract the sunlight that clouds keep from the clear points, and fill the mask if requested."""
        shadows = self.at(part.time_s)
        if shadows is None:
            return
        mask = part.truth.get(SHADOW_MASK)
        if mask is None:
            mask = np.zeros(part.radiance.shape[1:], dtype=np.uint8)
        (rows, columns), samples, in_cloud = window.inside, window.samples, shadows.in_cloud(window.window)
        kept_back = np.zeros((0, 0, 0), dtype=np.float32)
        if self._plan.waves.varies and part.radiance.size:
            window.kept_back = kept_back = self._memory(len(self._plan.bands), *in_cloud.shape[1:])
        corner, shaded = (rows.start, columns.start), bool(np.max(in_cloud, initial=0.0) > 0.0)
        if not shaded:
            kept_back[:] = 0.0
        for surface, of_surface in enumerate(shadows.of_surfaces if shaded else ()):
            clear, weights = window.clear_points(surface), of_surface.states.weights(window.window)
            changes = self._plan.texture.change_between(of_surface.by_texture, *window.perturbation)
            texture = *changes, window.perturbation[0]
            _cast(
                part.radiance, mask, kept_back, *corner, samples, clear, in_cloud, of_surface.tables, texture, weights
            )
        window.shaded = mask[window.inside] > 0

    def _memory(self, *shape: int) -> NDArray[np.float32]:
        """Return memory that the next window uses again: new pages for each frame would take longer than shadows."""
        if self._kept_back.size < math.prod(shape):
            self._kept_back = np.empty(math.prod(shape), np.float32)
        return self._kept_back[: math.prod(shape)].reshape(shape)

    def at(self, time_s: float) -> InstantShadows | None:
        """Return the shadows at a time; None if there are none."""
        return self._at(time_s, self._plan.rays.frame_key(time_s))

    def _shadows(self, time_s: float, key: Hashable) -> InstantShadows | None:
        """Return the shadows at a time, seen through the rays of a key."""
        plan, sun = self._plan, self._plan.sun_of_frame(time_s)
        if not sun.is_up:
            return None
        paths: list[SunPaths | None] = []
        for layer, generator, shift in zip(plan.layers, plan.assembly.generators, self._shifts, strict=True):
            span = spanning(layer, generator)
            bodies = span is not layer or hasattr(generator, "cloud_depth_m")
            met = sun_paths(span, sun, self._point_m, bodies)
            # If line of sight and sun path intersect the layer at the same point, it is clear or cloudy for both: clear
            # points meet no cloud there. If all points are such, nothing is computed.
            same = isinstance(shift, tuple) and not met.bodies and met.stay_at(shift)
            paths.append(None if same else met)
        return InstantShadows(plan, self._tables, self._effects, time_s, sun, paths) if any(paths) else None


class OfSurface(NamedTuple):
    """What shadows take from a class of surface.

    Attributes
    ----------
    tables : tuple of ndarray
        Fraction (L,) of the longest path per metre of height in cloud; ``depth`` (R, L, B, N) and ``loss`` (R, Q, B) of
        the states, as in :class:`ShadowTables`, the former in single precision with heights last.
    by_texture : ndarray (S, R, B)
        Relative change of the sunlight in the states of texture, as in :class:`TextureTables`; S = 0 without texture.
    states : ViewStates
        R states of the tables toward all views.
    """

    tables: tuple[Array, Thickness, Array]
    by_texture: Array
    states: ViewStates


class InstantShadows:
    """Shadows at one instant.

    Parameters
    ----------
    tables : sequence of sequence of RadianceTables
        Of each class of surface, toward each view.
    paths : sequence of SunPaths or None
        Paths through each layer; None if the layer cannot shade points that it leaves clear.

    Attributes
    ----------
    of_surfaces : list of OfSurface
        Of each class of surface.
    """

    def __init__(
        self,
        plan: Plan,
        tables: Sequence[Sequence[RadianceTables]],
        effects: Sequence[PointAxis[Any]],
        time_s: float,
        sun: Sun,
        paths: Sequence[SunPaths | None],
    ) -> None:
        self._plan, self._time_s, self._paths = plan, time_s, paths
        self.of_surfaces = [_of_surface(plan, of_class, effects, time_s, sun) for of_class in tables]

    def in_cloud(self, window: Window) -> Thickness:
        """Vertical path length in each layer's cloud of the sun's paths to the points of a window (L, y, x)."""
        plan, samples = self._plan, self._plan.samples_per_pixel
        heights = []
        for generator, paths in zip(plan.assembly.generators, self._paths, strict=True):
            if paths is None:
                heights.append(np.zeros([length(pixels) * samples for pixels in window], dtype=np.float32))
            else:
                of_scene = partial(self._heights_m, generator, paths)
                heights.append(at_rays(plan, window, self._time_s, 0.0, of_scene, interpolated))
        return heights[0][None] if len(heights) == 1 else np.stack(heights)

    def _heights_m(self, generator: CloudGenerator, paths: SunPaths, window: Window) -> Thickness:
        """Vertical path length in a layer's cloud of the sun's paths to the points of a window of the scene's plane."""
        scene = self._plan.scene
        scene.require_in_reach(generator, window, self._time_s)
        return paths.heights_m(generator, self._time_s, *(points_of(pixels, scene.samples) for pixels in window))


def _of_surface(
    plan: Plan, tables: Sequence[RadianceTables], effects: Sequence[PointAxis[Any]], time_s: float, sun: Sun
) -> OfSurface:
    """Return what shadows take from one class of surface."""
    of_views = [(of_view.shadows, of_view.texture.sunlight) for of_view in tables if of_view.shadows]
    if not of_views:
        layers = len(plan.layers)
        nothing = np.zeros(layers), np.zeros((1, layers, 0, 2), np.float32), np.zeros((1, 0, 0))
        return OfSurface(nothing, nothing[2], OneView(nothing[2]))
    intervals = max(shadows.depth.shape[2] for shadows, _ in of_views) - 1
    losses, depths = zip(*(shadows.at(time_s, intervals) for shadows, _ in of_views), strict=True)
    loss, depth = np.stack(losses), np.stack(depths)
    texture = np.stack([sunlight.reshape(-1, loss.shape[2]) for _, sunlight in of_views])
    every = np.concatenate([values.reshape(len(of_views), -1) for values in (loss, depth, texture)], axis=1)
    states = point_states(plan, effects, every, time_s)
    ends = np.cumsum([loss[0].size, depth[0].size])
    of_states = zip(np.split(states.values, ends, axis=1), (loss, depth, texture), strict=True)
    loss, depth, texture = (values.reshape(len(values), *toward.shape[1:]) for values, toward in of_states)
    share = 1.0 / (math.cos(math.radians(sun.zenith_deg)) * of_views[0][0].longest_m)
    nodes = np.ascontiguousarray(np.moveaxis(depth, 2, 3), np.float32)
    return OfSurface((share, nodes, loss), np.moveaxis(texture, 1, 0), states)


@kernel(inner=True, forceinline=True)
def _share_kept_back(path):  # type: ignore[no-untyped-def]
    """Return 1 - exp(-path), within 2e-7, for paths from 0; unlike the library's, it is vectorised."""
    one, middle = np.float32(1), np.float32(12582912)  # 1.5 x 2^23: the last bits of a sum with it are a whole number
    power = max(path * np.float32(-1.442695040888963), np.float32(-126))
    whole = power + middle
    f = (power - (whole - middle)) * np.float32(0.6931471805599453)
    far = np.float32(1 / 24) + f * (np.float32(1 / 120) + f * np.float32(1 / 720))
    rest = one + f * (one + f * (np.float32(1 / 2) + f * (np.float32(1 / 6) + f * far)))
    return one - rest * np.int32((np.float32(whole).view(np.int32) + np.int32(127)) << np.int32(23)).view(np.float32)


@kernel(inner=True, inline="always")
def _along(line, values):  # type: ignore[no-untyped-def]
    """Fill a row of pixels with the values of each, or with the only one."""
    if values.size == 1:
        line[:] = np.float32(values[0])
    else:
        for x in range(line.size):
            line[x] = np.float32(values[x])


@kernel()
def _cast(  # type: ignore[no-untyped-def]
    radiance, mask, kept_back, row, column, samples, clear, in_cloud, tables, texture, weights
):
    """Shade clear points of a class of surface, in single precision.

    ``kept_back`` (B, y, x) of each clear point, or empty; ``tables`` of :class:`OfSurface`, and ``weights`` (y or 1, x
    or 1, R) of its states; ``texture`` has the relative change of the sunlight, as :meth:`.EvenSky.change_between`
    returns it, and the perturbation of the sea (y or 1, x or 1).
    """
    (part, nodes, loss), (by_texture, by_sea, warmer) = tables, texture
    states, layers, bands, intervals = nodes.shape[0], nodes.shape[1], nodes.shape[2], nodes.shape[3] - 1
    zero, one, two, last = np.float32(0), np.float32(1), np.float32(2), np.float32(intervals - 1)
    width, columns, share = clear.shape[1], clear.shape[1] // samples, 1.0 / (samples * samples)
    # The shaded points of a row: their columns, pixels, weights, and paths in a layer and in all.
    at, pixel, weight = np.empty(width, np.uint32), np.empty(width, np.uint32), np.empty(width, np.float32)
    height, inside, first = np.empty(width, np.float32), np.empty(width, np.float32), np.empty(width, np.uint32)
    path, sums = np.empty((bands, width), np.float32), np.empty((bands, columns), np.float32)
    # Of each pixel: whole rows of contiguous numbers, whose loops are vectorised.
    shaded, own = np.empty(columns, np.bool_), np.empty((states, columns), np.float32)
    warm, change = np.empty(columns, np.float32), np.empty(columns, np.float32)
    of_state, lost = np.empty(columns, np.float32), np.empty(columns, np.float32)
    for y in range(clear.shape[0] // samples):
        of_row = weights[min(y, weights.shape[0] - 1)]
        for r in range(states):
            _along(own[r], of_row[:, r])
        shaded[:] = False
        sums[:] = zero
        for i in range(y * samples, (y + 1) * samples):
            count = 0
            for j in range(width):
                tallest = in_cloud[0, i, j]
                for n in range(1, layers):
                    tallest = max(tallest, in_cloud[n, i, j])
                at[count] = j
                count += clear[i, j] and tallest > zero
            for b in range(kept_back.shape[0]):
                line = kept_back[b, i]
                for j in range(width):
                    line[j] = zero if clear[i, j] else line[j]
            if count == 0:
                continue
            for c in range(count):
                pixel[c] = at[c] // np.uint32(samples)
                shaded[pixel[c]] = True
            for b in range(bands):
                for c in range(count):
                    path[b, c] = zero
            for n in range(layers):
                in_layer, scale = in_cloud[n, i], np.float32(part[n])
                for c in range(count):
                    height[c] = max(in_layer[at[c]], zero)
                for c in range(count):
                    # Nodes are uniform in the square root; paths slightly beyond the last node by rounding extrapolate
                    # the last line.
                    root = math.sqrt(height[c] * scale) * np.float32(intervals)
                    k = min(np.float32(np.int32(root)), last)
                    inside[c] = (root * root - k * k) / (two * k + one)
                    first[c] = np.int32(k)
                for r in range(states):
                    for c in range(count):
                        weight[c] = own[r, pixel[c]] if height[c] > zero else zero
                    for b in range(bands):
                        line, whole = nodes[r, n, b], path[b]
                        for c in range(count):
                            low, high = line[first[c]], line[first[c] + np.uint32(1)]
                            whole[c] += weight[c] * (low + inside[c] * (high - low))
            for b in range(bands):
                kept, total = path[b, :count], sums[b]
                for c in range(count):
                    kept[c] = _share_kept_back(kept[c])
                for c in range(count):
                    total[pixel[c]] += kept[c]
                if kept_back.shape[0] > 0:
                    line = kept_back[b, i]
                    for c in range(count):
                        line[at[c]] = kept[c]
        of_texture = by_texture[:, :, min(y, by_texture.shape[2] - 1)]
        _along(warm, warmer[min(y, warmer.shape[0] - 1)])
        seen = mask[row + y, column : column + columns]
        for x in range(columns):
            seen[x] = np.uint8(1) if shaded[x] else seen[x]
        for b in range(bands):
            total = sums[b]
            change[:] = one
            for r in range(states):
                by_warmth, by_square, of_own = np.float32(by_sea[0, r, b]), np.float32(by_sea[1, r, b]), own[r]
                _along(of_state, of_texture[r, b])
                for x in range(columns):
                    change[x] += of_own[x] * (of_state[x] + warm[x] * (by_warmth + warm[x] * by_square))
            for x in range(columns):
                total[x] *= change[x]
            for q in range(loss.shape[1]):
                lost[:] = zero
                for r in range(states):
                    most, of_own = np.float32(share * loss[r, q, b]), own[r]
                    for x in range(columns):
                        lost[x] += of_own[x] * most
                line = radiance[q * bands + b, row + y, column : column + columns]
                for x in range(columns):
                    # Rounding can make a zero remainder negative.
                    left = max(line[x] - lost[x] * total[x], zero)
                    line[x] = left if total[x] > zero else line[x]
