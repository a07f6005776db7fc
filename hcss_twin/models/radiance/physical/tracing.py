"""Rays from the sensor into the scene: gas exact along every path with a given number of changes of direction.

Rays are traced through the gaps. At a scattering interface, a ray continues along every stream, with its whole
composite path; after ``order`` changes of direction the closure provides the rest. Light that crosses a cloud directly
does not change direction.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.air import Heights
from hcss_twin.models.radiance.physical.closure import Closure, FrozenLegs, close
from hcss_twin.models.radiance.physical.columns import SceneColumns
from hcss_twin.models.radiance.physical.composite_paths import CompositePaths
from hcss_twin.models.radiance.physical.directions import VIEW
from hcss_twin.models.radiance.physical.terms import AIR, CLOUD, CLOUD_SUN, SCATTERED_AIR, SEA, SEA_SUN, TERMS
from hcss_twin.physics.paths import Path

_BOTH_WAYS = 2
"""Changes of direction of light that a cloud scatters down to a surface, and up from it, seen from the sensor."""


class Rays:
    """P rays traced into the scene.

    Parameters
    ----------
    crossed : CompositePaths (P,)
        Path between the front of each ray and the sensor.
    transmittance : ndarray (P, S)
        Of these paths.
    directions : ndarray of int (P,)
        Index of each ray's direction.
    source : int
        Term for the emission of air: ``AIR`` before the first scattering, ``SCATTERED_AIR`` after it.
    """

    def __init__(
        self, crossed: CompositePaths, transmittance: Array, directions: NDArray[np.int64], source: int
    ) -> None:
        self.crossed = crossed
        self.transmittance = transmittance
        self.directions = directions
        self.source = source


class Tracer:
    """Traces rays through columns with the same layers.

    Parameters
    ----------
    columns : SceneColumns
    order : int
        Changes of direction with exact gas, 0 or more.
    """

    def __init__(self, columns: SceneColumns, order: int) -> None:
        self._columns = columns
        self._order = order

    def radiance(self) -> Array:
        """Return the radiance at the sensor by source, (K, S)."""
        size = self._columns.received.size
        view = Rays(self._columns.crossed(lambda _: Path()), np.ones((1, size)), np.array([VIEW]), AIR)
        return self._down(view, 0, self._order)[:, 0]

    @property
    def frozen(self) -> FrozenLegs | None:
        """Gas behind the view's path, by which light counts that a cloud scatters on its way down and up; or None."""
        return self._closure.frozen if self._order < _BOTH_WAYS else None

    @cached_property
    def _closure(self) -> Closure:
        return close(self._columns, self._order > 0)

    def _down(self, rays: Rays, gap: int, order: int) -> Array:
        """Look down from the upper end of a gap: (K, P, S)."""
        result, rays = self._cross(rays, *self._columns.gap_m(gap), downward=True)
        if gap == len(self._columns.slabs):
            return result + self._sea(rays, gap, order)
        return result + self._cloud(rays, gap, order, from_above=True)

    def _up(self, rays: Rays, gap: int, order: int) -> Array:
        """Look up from the lower end of a gap: (K, P, S)."""
        result, rays = self._cross(rays, *self._columns.gap_m(gap), downward=False)
        if gap == 0:
            result[rays.source] += rays.transmittance * self._columns.space
            return result
        return result + self._cloud(rays, gap - 1, order, from_above=False)

    def _cross(self, rays: Rays, lower_m: Heights, upper_m: Heights, *, downward: bool) -> tuple[Array, Rays]:
        """Return the emission of a leg, and the rays behind it."""
        where = self._columns.directions.zenith_deg
        zeniths = [where[index] for index in rays.directions]
        scattered = self._columns.scattered_sublayers if rays.source == SCATTERED_AIR else 0
        leg = self._columns.air.leg(rays.crossed, rays.transmittance, zeniths, lower_m, upper_m, downward, scattered)
        result = np.zeros((len(TERMS), *leg.emission.shape))
        result[rays.source] = leg.emission
        return result, Rays(leg.crossed, leg.transmittance, rays.directions, rays.source)

    def _sea(self, rays: Rays, gap: int, order: int) -> Array:
        columns = self._columns
        result = self._scattered(
            rays,
            columns.sea.reflection,
            order,
            lambda after, left: self._up(after, gap, left),
            lambda: self._closure.up[gap],
        )
        result[SEA] += rays.transmittance * columns.sea.emissivity[rays.directions] * columns.sea_source
        self._add_sun(result[SEA_SUN], rays, *columns.sun_on_sea())
        return result

    def _cloud(self, rays: Rays, index: int, order: int, *, from_above: bool) -> Array:
        """Look at a cloud from the gap above it or, if not ``from_above``, below it."""
        columns, slab = self._columns, self._columns.slabs[index]
        near = index if from_above else index + 1

        def back(after: Rays, left: int) -> Array:
            return self._up(after, near, left) if from_above else self._down(after, near, left)

        def through(after: Rays, left: int) -> Array:
            result, behind = self._cross(after, slab.base_m, slab.top_m, downward=from_above)
            return result + (self._down(behind, index + 1, left) if from_above else self._up(behind, index, left))

        result = self._scattered(
            rays,
            slab.reflection,
            order,
            back,
            lambda: self._closure.up[near] if from_above else self._closure.down[index],
        )
        result += self._scattered(
            rays,
            slab.transmission,
            order,
            through,
            lambda: self._closure.below[index] if from_above else self._closure.above[index],
        )
        result[CLOUD] += rays.transmittance * columns.slab_emission(index, from_above)[rays.directions]
        self._add_sun(result[CLOUD_SUN], rays, *columns.sun_on_slab(index, from_above))
        # Direct transmission: the same direction, so the order does not change.
        result += slab.direct[rays.directions] * through(rays, order)
        return result

    def _add_sun(self, target: Array, rays: Rays, sunlight: Array, to_sun: CompositePaths) -> None:
        """Add sunlight (D, S) that leaves an interface; the paths of sun and ray are one composite path."""
        if self._columns.directions.sun is None:
            return
        seen = self._columns.air.transmittance(rays.crossed + to_sun)
        target += sunlight[rays.directions] * seen

    def _scattered(
        self, rays: Rays, kernel: Array, order: int, look: Callable[[Rays, int], Array], closure: Callable[[], Array]
    ) -> Array:
        """Return the light from all streams that an interface scatters into the ray directions.

        Parameters
        ----------
        kernel : ndarray (D, N, S)
        look : callable
            Returns the radiance along the streams, given the remaining changes of direction.
        closure : callable
            The same (K, N, S) behind fixed gas, for rays without remaining changes of direction.
        """
        rows = kernel[rays.directions]
        if not np.any(rows):
            return np.zeros((len(TERMS), len(rays.crossed), self._columns.received.size))
        if order == 0:
            result: Array = np.einsum("pjv,sjv->spv", rows, closure())
            return result * rays.transmittance
        streams = np.array(self._columns.directions.stream_indices)
        after = Rays(
            rays.crossed.take(np.repeat(np.arange(len(rays.crossed)), streams.size)),
            np.repeat(rays.transmittance, streams.size, axis=0),
            np.tile(streams, len(rays.crossed)),
            SCATTERED_AIR,
        )
        seen = look(after, order - 1).reshape(len(TERMS), len(rays.crossed), streams.size, -1)
        reflected: Array = np.einsum("pjv,spjv->spv", rows, seen)
        return reflected
