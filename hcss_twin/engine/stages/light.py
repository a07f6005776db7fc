"""Light between columns of cloud: the radiance that a plugin adds to the look-up, on squares of a fixed lattice.

A square of points is computed together with the clouds around it that matter. The lattice does not depend on windows,
so that a pixel has the same bits in all of them. Its squares end with the image; beyond it, where the blur of a sensor
wants the scene, they are smaller.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Hashable, Iterator, Sequence
from itertools import product
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.engine.ground import Ground
from hcss_twin.engine.stages.stage import FramePart, PartWindow, Stage
from hcss_twin.engine.tables.frame_look_up import FrameLookUp
from hcss_twin.engine.tables.over_point_effect import PointEffectStates
from hcss_twin.engine.tables.over_surfaces import SurfaceStates
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.models.radiance.spectral_grid import SpectralNodes
from hcss_twin.plan.choose_light import light_inputs
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, length, pixel_sums
from hcss_twin.providers import Sun
from hcss_twin.providers.light import InstantLight, LightInputs, LightTransport

__all__ = ["LightStage"]

KEPT_SQUARES = 32
"""Squares in memory."""

BEYOND = 32
"""Pixels along the sides of squares beyond the image: a blur reaches less far than the image is large."""


class LightStage(Stage):
    """Radiance of frames of a plan with light between columns of cloud.

    Attributes
    ----------
    largest_square : int
        Points along the sides of a square of the lattice; small images are one square.
    """

    largest_square: ClassVar[int] = 128

    title = "light between columns"

    reads = ("columns",)
    writes = ("light between columns",)

    @staticmethod
    def inputs(plan: Plan, nodes: SpectralNodes) -> LightInputs:
        """Return the inputs of a light transport for the lowest layer with cloud, and for those above it."""
        return light_inputs(plan, nodes)

    def __init__(self, plan: Plan, tables: RadianceTables) -> None:
        self._plan, self._name = plan, plan.light.name
        inputs, samples = light_inputs(plan, tables.spectrum.nodes), plan.scene.samples
        self._transport: LightTransport = plan.light.transport(inputs)
        # Over each class of surface, at the middle of its temperatures, at each value of effects of points that has
        # tables; one without a map of the ground and such effects.
        self._ground: Ground | None = None
        self._plans, self._transports = [plan], [self._transport]
        for surfaces in plan.surfaces:
            states = SurfaceStates(plan, surfaces)
            self._ground = states.ground
            self._plans = [states.plan_in(plan, of_class[len(of_class) // 2]) for of_class in surfaces.states]
        self._effects = [PointEffectStates(plan, planned) for planned in plan.point_effects]
        for effect in self._effects:
            self._plans = [effect.plan_in(each, value) for each in self._plans for value in effect.nodes]
        if len(self._plans) > 1:
            self._transports = [plan.light.transport(light_inputs(each, tables.spectrum.nodes)) for each in self._plans]
        pixels = min(max(plan.image.rows, plan.image.columns), max(self.largest_square // samples, 1))
        self._pixels, self._layer, self._number = pixels, plan.layers[inputs.number], inputs.number
        self._reference_m = inputs.reference_m
        self._reach = [tuple(-(-points // samples) for points in both) for both in self._transport.reach]
        self._instant: tuple[Hashable, Sun | None, list[InstantLight]] | None = None
        self._squares: OrderedDict[tuple[int, int], tuple[Array, Array, Array]] = OrderedDict()

    def squares(self, window: Window) -> Iterator[Window]:
        """Yield the squares, as rows and columns, that a window in or around the image needs."""
        sizes = self._plan.image.rows, self._plan.image.columns
        yield from product(*(_pieces(wanted, size, self._pixels) for wanted, size in zip(window, sizes, strict=True)))

    @staticmethod
    def around(extent: Sequence[slice], reach: Sequence[tuple[int, ...]]) -> Window:
        """Return the window of some pixels and of those before and after them."""
        rows, columns = (
            slice(span.start - low, span.stop + high) for span, (low, high) in zip(extent, reach, strict=True)
        )
        return rows, columns

    def apply(self, part: FramePart, window: PartWindow) -> None:
        """Write the radiance that is shown: the total; terms remain those of independent columns."""
        part.shown[:, *window.inside] = part.radiance[:, *window.inside]
        self.fill(part.shown, window.window, window.inside, part.time_s, part.clouds, part.look_up)

    def fill(
        self, radiance: NDArray[np.float32], window: Window, in_part: Window, time_s: float, clouds: Any, look_up: Any
    ) -> None:
        """Write the radiance (B, y, x) of a window of the image, from its FrameClouds, to its place in a part."""
        key = self._plan.rays.frame_key(time_s)
        if self._instant is None or self._instant[0] != key:
            sun, last = self._plan.sun_at(time_s), self._instant
            same = last is not None and last[1] == sun
            self._instant = key, sun, last[2] if last and same else [each.at(sun) for each in self._transports]
            self._now_s = time_s
            self._squares = OrderedDict()
        for square in self.squares(window):
            self._put(square, radiance, window, in_part, clouds, look_up)

    def _put(
        self, square: Window, radiance: NDArray[np.float32], window: Window, in_part: Window, clouds: Any, look_up: Any
    ) -> None:
        """Write the radiance of what lies in a window of a square, which is kept for other windows."""
        first = square[0].start, square[1].start
        if first not in self._squares:
            self._squares[first] = self._square(square, clouds)
            if len(self._squares) > KEPT_SQUARES:
                self._squares.popitem(last=False)
        where, means = self._within(first, self._squares[first], window, in_part, look_up, radiance.shape[0])
        for band, mean in zip(radiance[: len(means)], means, strict=True):
            band[*where] = mean

    def _within(
        self,
        first: tuple[int, int],
        square: tuple[Array, Array, Array],
        window: Window,
        in_part: Window,
        look_up: FrameLookUp,
        bands: int,
    ) -> tuple[list[slice], list[Array]]:
        """Return where the pixels of a square that lie in a window stand in a part, and their radiance by band."""
        samples, (amount, share, change) = self._plan.samples_per_pixel, square
        inner, outer = [], []
        for start, points, wanted, where in zip(first, amount.shape[-2:], window, in_part, strict=True):
            low, high = max(start, wanted.start), min(start + points // samples, wanted.stop)
            inner.append(slice((low - start) * samples, (high - start) * samples))
            outer.append(slice(low - wanted.start + where.start, high - wanted.start + where.start))
        look_up = look_up.of_points((outer[0], outer[1]), samples)
        rows, columns = inner
        values = self._looked_up(look_up, amount[..., rows, columns], bands)[: len(share)]
        values = np.maximum(values * share[:, *inner] + change[:, *inner], 0.0)
        return outer, [value if samples == 1 else pixel_sums(value, samples) / samples**2 for value in values]

    def _square(self, extent: Window, clouds: Any) -> tuple[Array, Array, Array]:
        """Return amount (y, x), share and change of radiance (B, y, x) of the points of a square."""
        assert self._instant is not None
        samples, wide = self._plan.samples_per_pixel, self.around(extent, self._reach)
        thickness = clouds.thickness_m(wide)[self._number]
        found = [light.correct(np.ascontiguousarray(thickness)) for light in self._instant[2]]
        shape = tuple(length(pixels) * samples for pixels in wide)
        bands = (len(self._plan.bands),)
        for amount, share, change in found:
            for given, expected in ((amount, shape), (share, bands + shape), (change, bands + shape)):
                if given.shape != expected or not np.all(np.isfinite(given)):
                    label = f"light '{self._name}': correct() broke its contract"
                    raise ProviderError(f"{label}: expected finite values of shape {expected}, got shape {given.shape}")
        inner = [
            slice(before * samples, (before + length(pixels)) * samples)
            for pixels, (before, _) in zip(extent, self._reach, strict=True)
        ]
        amounts, shares, changes = ([part[..., *inner].copy() for part in parts] for parts in zip(*found, strict=True))
        share, change = (self._at_points(values, self._now_s, extent) for values in (shares, changes))
        return amounts[0], share, change

    def _at_points(self, of_states: Sequence[Array], time_s: float, extent: Window) -> Array:
        """Return values (B, y, x) of the points of a part of the image, from those of the plans of :attr:`_plans`."""
        if len(of_states) == 1:
            return of_states[0]
        values, shape = np.stack(of_states), of_states[0].shape
        values = values.reshape(-1, *(len(effect.nodes) for effect in self._effects), shape[0], shape[1] * shape[2])
        for effect in reversed(self._effects):
            between = np.empty((*values.shape[:-3], *values.shape[-2:]))
            for group in effect.groups(time_s, extent):
                at_nodes = values[..., list(group.nodes), :, :][..., group.points]
                between[..., group.points] = np.sum(at_nodes * group.weights, axis=-3)
            values = between
        values = values.reshape(-1, *shape)
        if self._ground is None:
            alike: Array = values[0]
            return alike
        number = self._ground.at(time_s, extent).number.astype(np.intp)
        of_ground: Array = np.take_along_axis(values, number[None, None], axis=0)[0]
        return of_ground

    def _looked_up(self, look_up: FrameLookUp, amount_m: Array, channels: int) -> Array:
        """Return the radiance (C, y, x) of columns; below the thinnest cloud of the tables it is linear."""
        least, most = self._layer.thickness_min_m, self._layer.thickness_max_m
        cloudy, clear = (np.empty((channels, *amount_m.shape), dtype=np.float32) for _ in range(2))
        none = [np.zeros(amount_m.shape, dtype=np.float32)] * len(self._plan.layers)
        some = [*none[: self._number], np.clip(amount_m, least, most).astype(np.float32), *none[self._number + 1 :]]
        look_up.fill(cloudy, some)
        look_up.fill(clear, none)
        share = np.minimum(amount_m / least, 1.0)
        values: Array = share * cloudy + (1.0 - share) * clear
        return values


def _pieces(wanted: slice, size: int, side: int) -> Iterator[slice]:
    """Yield the pieces of an axis that a range needs: of a length in the image, and of :data:`BEYOND` around it."""
    for low, high, step in ((-math.inf, 0, BEYOND), (0, size, side), (size, math.inf, BEYOND)):
        start, stop, origin = max(wanted.start, low), min(wanted.stop, high), size if low == size else 0
        if start < stop:
            for number in range((int(start) - origin) // step, -(-(int(stop) - origin) // step)):
                first = origin + number * step
                yield slice(first, int(min(first + step, high)))
