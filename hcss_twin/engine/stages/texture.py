"""Clear-sky texture in frames: look-up in the perturbed states, and the polynomials through them."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.cached_method import cached_method
from hcss_twin.core.kernels import kernel
from hcss_twin.cube.variables import SEA_TEMPERATURE, SURFACE_TEMPERATURE, WATER_VAPOUR_FACTOR
from hcss_twin.engine.scene_points import seen_fields
from hcss_twin.engine.stages.stage import FramePart, PartWindow, Stage
from hcss_twin.engine.tables.frame_look_up import FrameLookUp, FrameLookUps
from hcss_twin.engine.tables.point_axis import PointAxis
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.clear_sky import VapourNodes
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.texture import Texture
from hcss_twin.plan.windows import Window, length, pixel_sums, points_of

Thickness = NDArray[np.float32]

PIXELS_AT_ONCE = 2**16
"""Pixels whose states are in memory together: they fit into the processor's cache."""


class TextureStage(Stage):
    """Adds clear-sky texture to frames.

    Parameters
    ----------
    tables : RadianceTables or None
        None if no radiance is needed.
    axes : sequence of PointAxis
        Along which the points of the plan differ.
    of_sea : RadianceTables or None
        Tables of the scenario's sea, whose change with its temperature bends as in clear sky.
    sea : int
        Its class of surface.
    """

    title = "texture of the clear sky"
    reads = ("truth", "columns", "light between columns", "ground")
    writes = ("texture",)

    def __init__(
        self,
        plan: Plan,
        texture: Texture,
        tables: RadianceTables | None,
        axes: Sequence[PointAxis[Any]],
        of_sea: RadianceTables | None,
        sea: int = 0,
    ) -> None:
        self._plan, self._texture, self._layers, self._sea = plan, texture, len(plan.layers), sea
        self._fields = texture.fields(plan.scenario, plan.assembly)
        self._states: list[FrameLookUps] = []
        if tables is not None and of_sea is not None:
            self._states = [FrameLookUps(plan, state, axes) for state in tables.in_texture_states]
            self._vapour = _as_arrays(texture.vapour if texture.water_vapour > 0.0 else VapourNodes(()))
            self._square, self._mixed = of_sea.texture.square.ravel(), of_sea.texture.mixed.reshape(2, -1)
        self._look_ups = cached_method(self._look_ups_at, 1)

    def begin(self, part: FramePart) -> None:
        """Change the whole part, without clouds."""
        if not self._layers:
            rows, columns = part.radiance.shape[1:]
            fields = seen_fields(self._plan, self._fields, part.time_s, part.extent)
            self._change(part, (slice(0, rows), slice(0, columns)), part.extent, (), *fields)

    def apply(self, part: FramePart, window: PartWindow) -> None:
        """Change a window of the part, and keep its perturbation."""
        if not self._layers and SURFACE_TEMPERATURE not in part.truth:
            return
        window.perturbation = warmer, drier = seen_fields(self._plan, self._fields, part.time_s, window.window)
        if window.ground is not None and SURFACE_TEMPERATURE in part.truth:
            of_sea = pixel_sums(window.ground.number == self._sea, window.samples) / window.samples**2
            part.truth[SURFACE_TEMPERATURE][window.inside] += np.float32(self._texture.steps[0]) * warmer * of_sea
        if self._layers:
            with part.changing_columns(window.inside):
                self._change(part, window.inside, window.window, window.thickness_m, warmer, drier)

    def _change(
        self,
        part: FramePart,
        in_part: Window,
        window: Window,
        thickness_m: Sequence[Thickness],
        warmer: NDArray[np.float32],
        drier: NDArray[np.float32],
    ) -> None:
        """Change radiance and truth at a place in a part, which is a window of the image, by its perturbation."""
        radiance, truth, time_s, (rows, columns) = part.radiance, part.truth, part.time_s, window
        if SEA_TEMPERATURE in truth:
            kelvin = np.float32(self._texture.steps[0]) * warmer
            truth[SEA_TEMPERATURE][in_part] = np.float32(self._plan.assembly.sea_temperature_K) + kelvin
        if WATER_VAPOUR_FACTOR in truth:
            truth[WATER_VAPOUR_FACTOR][in_part] = 1.0 - np.float32(self._texture.steps[1]) * drier
        if not self._states or not radiance.size:
            return
        look_ups = self._look_ups(time_s, self._plan.rays.frame_key(time_s))
        samples = self._plan.samples_per_pixel
        sea = self._texture.temperature_K > 0.0
        step = max(1, PIXELS_AT_ONCE // warmer.shape[1])
        shape, width = (len(look_ups), radiance.shape[0]), warmer.shape[1]
        memory = np.empty(len(look_ups) * radiance.shape[0] * min(step, warmer.shape[0]) * width, np.float32)
        for first in range(0, warmer.shape[0], step):
            strip = slice(first, min(first + step, warmer.shape[0]))
            points, size = points_of(strip, samples), math.prod(shape) * length(strip) * width
            states = memory[:size].reshape(*shape, length(strip), width)  # contiguous: one kernel for all strips
            inside = slice(rows.start + strip.start, rows.start + strip.stop), columns
            for look_up, state in zip(look_ups, states, strict=True):
                look_up.of_part(inside).fill(state, [layer[points] for layer in thickness_m], samples)
            corner = in_part[0].start + strip.start, in_part[1].start
            fields = warmer[strip], drier[strip]
            _apply(radiance, *corner, states, sea, *fields, *self._vapour, self._square, self._mixed)

    def _look_ups_at(self, time_s: float, key: Hashable) -> list[FrameLookUp]:
        """Return the look-up in each state at a time, seen through the rays of a key."""
        return [state.at(time_s) for state in self._states]


def _as_arrays(nodes: VapourNodes) -> tuple[NDArray[np.float32], NDArray[np.intp], NDArray[np.float32]]:
    """Return the place of each node of each segment, its number among the states, and the ends of the segments.

    The scene is number -1; unused elements are -2.
    """
    most = max(map(len, nodes.segments), default=0)
    places = np.zeros((len(nodes.segments), most), np.float32)
    numbers = np.full(places.shape, -2, np.intp)
    for segment, own in enumerate(nodes.segments):
        places[segment, : len(own)] = own
        numbers[segment, : len(own)] = [nodes.places.index(place) if place else -1 for place in own]
    return places, numbers, np.array([-np.inf, *nodes.kinks, np.inf], np.float32)


@kernel()
def _apply(  # type: ignore[no-untyped-def]
    radiance, row, column, states, sea, warmer, drier, places, numbers, ends, square, mixed
):
    """Change pixels of an image (C, y, x) along the polynomials through the scene and its states (N, C, y, x).

    ``row`` and ``column`` are those of the first pixel. Whole arrays, of which rows are contiguous: loops over others
    are not vectorised.

    The first state is the warmer sea, if it has texture; its parabola has the curvature of clear sky. The others are
    amounts of vapour: those of segment s are at ``places[s]``, and have the ``numbers[s]`` among them.
    """
    one, count, width = np.float32(1), states.shape[0] - int(sea), warmer.shape[1]
    weight, change = np.empty((count, width), np.float32), np.empty(width, np.float32)
    of_node = np.empty(width, np.float32)
    for y in range(warmer.shape[0]):
        t, q = warmer[y], drier[y]
        weight[:] = 0
        for s in range(numbers.shape[0]):
            low, high = ends[s], ends[s + 1]
            for n in range(numbers.shape[1]):
                if numbers[s, n] < 0:
                    continue
                of_node[:] = 1
                for k in range(numbers.shape[1]):
                    if k != n and numbers[s, k] != -2:
                        place, scale = places[s, k], one / (places[s, n] - places[s, k])
                        for x in range(width):
                            of_node[x] *= (q[x] - place) * scale
                total = weight[numbers[s, n]]
                for x in range(width):
                    total[x] += of_node[x] if low < q[x] <= high else np.float32(0)
        for c in range(radiance.shape[0]):
            line, s2 = radiance[c, row + y, column : column + width], np.float32(square[c])
            warm = states[0, c, y]
            if count == 0:
                for x in range(width):
                    line[x] = max(line[x] + (warm[x] - line[x]) * (t[x] * (one - s2 + s2 * t[x])), np.float32(0))
                continue
            change[:] = 0
            if sea:
                m, n2 = np.float32(mixed[0, c]), np.float32(mixed[1, c])
                for x in range(width):
                    change[x] = (warm[x] - line[x]) * (t[x] * (one - s2 + s2 * t[x] + q[x] * (m + n2 * q[x])))
            for n in range(count):
                state, factor = states[states.shape[0] - count + n, c, y], weight[n]
                for x in range(width):
                    change[x] += factor[x] * (state[x] - line[x])
            for x in range(width):
                line[x] = max(line[x] + change[x], np.float32(0))
