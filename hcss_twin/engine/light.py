"""Light between columns of cloud: the radiance that a plugin adds to the look-up, on squares of a fixed lattice.

A square of points is computed together with the clouds around it that matter. The lattice does not depend on windows,
so that a pixel has the same bits in all of them.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.choose_light import light_inputs
from hcss_twin.plan.clouds import moving
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.windows import Window, length, pixel_sums
from hcss_twin.providers import Sun
from hcss_twin.providers.light import LightTransport

LARGEST_SQUARE, SQUARES_OF_FRAME = 128, 64
"""Points along the sides of a square of the lattice; small images are one square. Squares of a frame in memory."""

KEPT_S, MOST_KEPT = 60.0, 2**22
"""Time between two instants whose light in clouds is kept, and most columns of cloud (of some 100 bytes each)."""


_Square = tuple[Any, Array, Array, Array, Array, Array]


class LightStage:
    """Radiance of frames of a plan with light between columns of cloud.

    Where the transport can, light in clouds is computed every :data:`KEPT_S` only, and moves with the clouds: each
    frame is the mean of its two neighbours in time, by their distances.
    """

    def __init__(self, plan: Plan, tables: RadianceTables) -> None:
        assert plan.light is not None
        self._plan, self._name = plan, plan.light.name
        self._transport: LightTransport = plan.light.transport(light_inputs(plan, tables.spectrum.nodes))
        samples, (layer,) = plan.samples_per_pixel, plan.layers
        pixels = min(max(plan.grid.rows, plan.grid.columns), max(LARGEST_SQUARE // samples, 1))
        self._pixels, self._layer = pixels, layer
        self._reach = [tuple(-(-each // samples) for each in both) for both in self._transport.reach]
        seen = [tuple(-(-each // samples) + 1 for each in both) for both in getattr(self._transport, "seen", ())]
        # Squares of two instants, with those of clouds that enter the image.
        squares = 2 * (-(-plan.grid.rows // pixels) + 1) * (-(-plan.grid.columns // pixels) + 1)
        columns = squares * math.prod((pixels + sum(each)) * samples for each in seen)
        often = seen and 3.0 * plan.scenario.frames.interval <= KEPT_S and columns <= MOST_KEPT
        self._seen, self._most_kept = seen if often else None, squares
        speed = moving(plan.assembly.motion, plan.scenario.clouds.layers[0], plan.scenario)
        east, north = speed.cloud_velocity_m_s
        self._speed = np.array([north, east - speed.platform_speed_m_s]) / plan.grid.pixel_size_m
        self._lights: OrderedDict[float, tuple[Sun | None, Any, Any]] = OrderedDict()
        self._kept: OrderedDict[tuple[float, int, int], Any] = OrderedDict()
        self._time_s: float | None = None
        # Light, clouds and their displacement, amount, share and change of squares of this frame and the one before.
        self._squares: OrderedDict[tuple[int, int, int], _Square] = OrderedDict()
        self._before = self._squares

    def fill(
        self, radiance: NDArray[np.float32], window: Window, place: Window, time_s: float, clouds: Any, look_up: Any
    ) -> None:
        """Write the radiance (B, y, x) of a window of the image, from its FrameClouds, to its place in a part."""
        if self._time_s != time_s:
            self._time_s, self._before, self._squares = time_s, self._squares, OrderedDict()
        for number, (own_s, part) in enumerate(self._instants(time_s)):
            moved = self._speed * (time_s - own_s)
            self._add(radiance, window, place, number, (own_s, part, moved), clouds, look_up)

    def _add(
        self, radiance: NDArray[np.float32], window: Window, place: Window, number: int,
        instant: tuple[float, float, Array], clouds: Any, look_up: Any,
    ) -> None:  # fmt: skip
        own_s, part, moved = instant
        side, samples, by = self._pixels, self._plan.samples_per_pixel, np.floor(moved).astype(int).tolist()
        spans = [
            ((each.start - far) // side, -(-(each.stop - far) // side)) for each, far in zip(window, by, strict=True)
        ]
        for row, column in product(*(range(*each) for each in spans)):
            first, key = (row * side + by[0], column * side + by[1]), (number, row, column)
            if key not in self._squares:
                self._squares[key] = self._square(key, first, own_s, moved - by, clouds)
                if len(self._squares) > SQUARES_OF_FRAME:
                    self._squares.popitem(last=False)
            inner, outer = [], []
            for start, wanted, where in zip(first, window, place, strict=True):
                low, high = max(start, wanted.start), min(start + side, wanted.stop)
                inner.append(slice((low - start) * samples, (high - start) * samples))
                outer.append(slice(low - wanted.start + where.start, high - wanted.start + where.start))
            *_, amount, share, change = self._squares[key]
            values = self._looked_up(look_up, amount[*inner], radiance.shape[0])
            values = np.maximum(values * share[:, *inner] + change[:, *inner], 0.0)
            for band, own in zip(radiance, values, strict=True):
                mean = own if samples == 1 else pixel_sums(own, samples) / samples**2
                band[*outer] = mean if part == 1.0 else part * mean + (band[*outer] if number else 0.0)

    def _instants(self, time_s: float) -> list[tuple[float, float]]:
        """Return the instants whose light a frame has, with their shares."""
        first = KEPT_S * math.floor(time_s / KEPT_S)
        # Films of clouds end with the sequence.
        last = min(first + KEPT_S, max(float(self._plan.frame_times_s[-1]), time_s))
        if self._seen is None or time_s == last:
            return [(time_s, 1.0)]
        share = (time_s - first) / (last - first)
        return [(first, 1.0 - share), (last, share)] if share > 0.0 else [(first, 1.0)]

    def _light(self, time_s: float, clouds: Any) -> tuple[Any, Any]:
        """Return light, the same without sun or with the same one, and FrameClouds of an instant."""
        if time_s not in self._lights:
            sun = self._plan.sun_at(time_s)
            known = [light for own, light, _ in self._lights.values() if own == sun]
            self._lights[time_s] = sun, known[0] if known else self._transport.at(sun), clouds.at(time_s)
            if len(self._lights) > 2:
                self._lights.popitem(last=False)
        return self._lights[time_s][1:]

    def _square(
        self, key: tuple[int, int, int], first: tuple[int, int], own_s: float, moved: Array, clouds: Any
    ) -> _Square:
        samples, side, (light, around) = self._plan.samples_per_pixel, self._pixels, self._light(own_s, clouds)
        reach = self._reach if self._seen is None else self._seen
        wide = _around(first, side, reach)
        (thickness,) = clouds.thickness_m(wide)
        before = self._before.pop(key, None)
        still = before is not None and before[0] is light and (self._seen is None or np.array_equal(before[2], moved))
        if before is not None and still and np.array_equal(before[1], thickness):
            return before
        kept = [] if self._seen is None else [self._kept_of(own_s, key[1:], light, around), moved * samples]
        amount, share, change = light.correct(np.ascontiguousarray(thickness), *kept)
        shape = tuple(length(each) * samples for each in wide)
        bands = (len(self._plan.bands),)
        for given, expected in ((amount, shape), (share, bands + shape), (change, bands + shape)):
            if given.shape != expected or not np.all(np.isfinite(given)):
                label = f"light '{self._name}': correct() broke its contract"
                raise ProviderError(f"{label}: expected finite values of shape {expected}, got shape {given.shape}")
        own = [slice(before * samples, (before + side) * samples) for before, _ in reach]
        return light, thickness.copy(), moved, amount[*own].copy(), share[:, *own].copy(), change[:, *own].copy()

    def _kept_of(self, time_s: float, place: tuple[int, int], light: Any, clouds: Any) -> Any:
        """Return the light in the clouds of a square of the lattice at an instant."""
        assert self._seen is not None
        key, samples, side = (time_s, *place), self._plan.samples_per_pixel, self._pixels
        if key not in self._kept:
            first = place[0] * side, place[1] * side
            (thickness,) = clouds.thickness_m(_around(first, side, self._reach))
            inner = [
                slice((far - near) * samples, (far + side + high) * samples)
                for (far, _), (near, high) in zip(self._reach, self._seen, strict=True)
            ]
            self._kept[key] = light.keep(np.ascontiguousarray(thickness), inner)
            if len(self._kept) > self._most_kept:
                self._kept.popitem(last=False)
        self._kept.move_to_end(key)
        return self._kept[key]

    def _looked_up(self, look_up: LookUp, amount_m: Array, channels: int) -> Array:
        """Return the radiance (C, y, x) of columns; below the thinnest cloud of the tables it is linear."""
        least, most = self._layer.thickness_min_m, self._layer.thickness_max_m
        cloudy, clear = (np.empty((channels, *amount_m.shape), dtype=np.float32) for _ in range(2))
        look_up.fill(cloudy, [np.clip(amount_m, least, most).astype(np.float32)])
        look_up.fill(clear, [np.zeros(amount_m.shape, dtype=np.float32)])
        share = np.minimum(amount_m / least, 1.0)
        values: Array = share * cloudy + (1.0 - share) * clear
        return values


def _around(first: tuple[int, int], side: int, reach: Any) -> Window:
    """Return the window of a square and of the pixels around it."""
    rows, columns = (slice(start - low, start + side + high) for start, (low, high) in zip(first, reach, strict=True))
    return rows, columns
