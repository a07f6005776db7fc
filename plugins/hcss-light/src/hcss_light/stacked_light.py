"""Tiers for scenes with several cloud layers; as :mod:`hcss_light.transport` for one.

The engine's tables are read at the amounts of cloud of all layers along the line of sight of each point, and the
difference between broken and uniform layers, both by successive orders or by sums of exponentials, is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import product
from typing import Any, ClassVar

import numpy as np

from hcss_light.bands import sunlight_of_air
from hcss_light.scattered import ScatteredLight, share_and_change, shining
from hcss_light.sea import FAINT as FAINT_GLINT
from hcss_light.sea import MOST_SHADED
from hcss_light.slices import Field, paths
from hcss_light.source import Direction
from hcss_light.stack import Stack, reach_of, stack_of
from hcss_light.stacked_sea import StackedPaths, StackedSea
from hcss_light.stacked_source import StackedGroup, stacked_groups, stacked_radiance, stacked_source, stacked_sunlight
from hcss_light.stacked_sums import emitted_radiance, of_sun_alone, stacked_integrals, sun_depth
from hcss_light.stated import differences, lowest_sun
from hcss_light.sums import RATES, fitted_weights
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Sun
from hcss_twin.providers.light import LightInputs

FINE_NODES, FINE_SLICES = 4, 8
"""Thicknesses of uniform cloud in each of the first slices, and how many these are; half as many in the others."""

Window = Sequence[slice]
WHOLE = (slice(None), slice(None))


class StackedSource(ScatteredLight):
    """Light in several layers of broken cloud, tier ``source``.

    Attributes
    ----------
    knows_surfaces, knows_rays, knows_tops : bool
        As of :class:`~hcss_light.transport.SourceLight`.
    """

    knows_surfaces: ClassVar[bool] = True
    knows_rays: ClassVar[bool] = True
    knows_tops: ClassVar[bool] = True

    def __init__(self, inputs: LightInputs) -> None:
        super().__init__(inputs)
        self.stack = stack = stack_of(inputs, self._steepest_deg, self._optical)
        within, across = [stack.shifts(stack.view)], []
        for sun in self._suns:
            moved = stack.shifts(sun)
            within += [moved[part] - moved[part.start] for part in stack.parts]
            across += [moved - moved[end] for part in stack.parts for end in (part.start, part.stop - 1)]
        self.reach_of_light = reach_of(within, 2 + (self._spread if self.tier == "source" else 0))
        """Points around others that send light to them; and with the shadows of higher layers and those on the sea."""
        far = reach_of([np.clip(shift, -MOST_SHADED, MOST_SHADED) for shift in across], 1)
        shadows = [(a + c, b + d) for (a, b), (c, d) in zip(self.reach_of_light, far, strict=True)]
        seas = [StackedSea(stack, sun).reach for sun in (None, *self._suns)]
        self.reach: tuple[tuple[int, int], ...] = tuple(map(tuple, np.max([shadows, *seas], axis=0).tolist()))

    @property
    def edges_m(self) -> tuple[Array, ...]:
        """Altitudes at which the shares of heights of each layer are asked."""
        return tuple(layer.edges_m for layer in self.stack.layers)

    @cached_property
    def _differences(self) -> list[Array]:
        # Shadows from farther away are those of the same clouds, continued periodically.
        source = self if self.tier == "source" else StackedSource(self._inputs)
        instants = [light.at(lowest_sun(self._inputs)) for light in dict.fromkeys((source, self))]
        return differences(self._inputs.image, instants, source.reach_of_light, self._clouds)

    def _clouds(self, rows: slice, columns: slice) -> tuple[Field, list[Field | None]]:
        """Return the thickness (L, y, x) of all layers in the first frame, and their shares of heights."""
        clouds = [
            cloud.clouds(rows, columns, edges) for cloud, edges in zip(self._inputs.stack, self.edges_m, strict=True)
        ]
        return np.stack([thickness for thickness, _ in clouds]), [shares for _, shares in clouds]

    @classmethod
    def stage(cls, plan: Plan, tables: RadianceTables) -> LightStage:
        """Return the computation of frames."""
        from hcss_light.stacked_stage import StackedStage  # not for plans alone

        return StackedStage(plan, tables)

    def at(self, sun: Sun | None) -> StackedLight:
        """Return the light at one instant."""
        sun = shining(sun)
        return StackedLight(self.tier, self._inputs, self.stack, stacked_groups(self._inputs, self.stack, sun), sun)


class StackedSlant(StackedSource):
    """The tier ``slant``."""

    tier: ClassVar[str] = "slant"
    cost: ClassVar[float] = 1.0


class StackedLight:
    """Light at one instant."""

    def __init__(
        self, tier: str, inputs: LightInputs, stack: Stack, groups: Sequence[Sequence[StackedGroup]], sun: Sun | None
    ) -> None:
        self._stack, self._shape, self._groups = stack, inputs.shape, groups
        self._air = inputs.weights_cm1 @ sunlight_of_air(inputs, sun)
        self._sun = None if sun is None else Direction(sun.zenith_deg, sun.azimuth_deg)
        self._sea = StackedSea(stack, self._sun)
        self._most_m = [cloud.layer.thickness_max_m for cloud in inputs.stack]
        self._nodes_m = [
            _nodes(cloud.layer.thickness_min_m, slices.height_m, slices.count)
            for cloud, slices in zip(inputs.stack, stack.layers, strict=True)
        ]
        # Weights (L, C) of the sums of each layer; None in the tier ``source``.
        self._weights = [[None if tier == "source" else self._fitted(member) for member in group] for group in groups]
        self._own_tops = [cloud.tops_vary for cloud in inputs.stack]
        self._tops_vary = any(self._own_tops)
        self._nights = self._groups
        if self._sun is not None:
            self._nights = [[_at_night(member) for member in group] for group in groups]
        if not self._tops_vary:
            thickness = np.stack(np.meshgrid(*self._nodes_m, indexing="ij"))
            flat = thickness.reshape(*thickness.shape[:2], -1)
            self._uniform, self._dark = (
                values.reshape(-1, *thickness.shape[1:]) for values in self._apart(flat, [None] * len(flat))
            )

    def _apart(self, thickness_m: Array | Field, shares: Sequence[Field | None]) -> tuple[Array, Array]:
        """Return the radiance (B, y, x) of columns (L, y, x) of which none sees another, and what it is at night."""
        apart = self._stack.apart()
        densities, of_suns = self._densities(thickness_m, shares), []
        suns = ((self._groups, self._sun), (self._nights, None)) if self._sun is not None else ((self._groups, None),)
        for groups, sun in suns:
            sea = StackedSea(apart, sun, 1)
            given: Any = apart, sea, sun, densities, densities, thickness_m, sea.paths(densities, True), WHOLE
            of_suns.append(self._of_bands(groups, *given, 1))
        return of_suns[0], of_suns[-1]

    def _of_bands(self, groups: Sequence[Sequence[StackedGroup]], *given: Any) -> Array:
        """Return the radiance (B, y, x) of the groups of each band."""
        bands = zip(groups, self._weights, strict=True)
        return np.array(
            [
                sum(_seen(member, sums, *given) for member, sums in zip(group, weights, strict=True))
                for group, weights in bands
            ]
        )

    def _fitted(self, group: StackedGroup) -> Array:
        """Return the weights (L, C) with which sums of sunlight in uniform clouds of each layer give its radiance."""
        apart, sun, alone = self._stack.apart(), self._sun, of_sun_alone(group)
        weights = np.zeros((len(self._nodes_m), RATES.size))
        if sun is None or not np.any(group.around.sunlight > 0.0):
            return weights
        for number, nodes_m in enumerate(self._nodes_m):
            thickness = np.zeros((len(self._nodes_m), 1, nodes_m.size), dtype=np.float32)
            thickness[number] = nodes_m
            densities = self._densities(thickness, [None] * len(thickness))
            depth = apart.optical(densities, group.scaled_m1)
            source = stacked_source(apart, densities, alone, sun, None, 1)
            radiance = stacked_radiance(apart, depth, source, 0.0)
            integrals = stacked_integrals(apart, depth, sun_depth(apart, depth, sun), group.around.sunlight)[number]
            weights[number] = fitted_weights(integrals.reshape(RATES.size, -1), radiance.ravel())
        return weights

    def _densities(self, thickness_m: Array | Field, shares: Sequence[Field | None]) -> list[Field]:
        return [
            slices.density(np.ascontiguousarray(thickness, dtype=np.float32), self._shape, share)
            for slices, thickness, share in zip(self._stack.layers, thickness_m, shares, strict=True)
        ]

    def uniform(self, amount_m: Array | Field, shares: Any = None) -> Array:
        """Return the radiance (B, y, x) of uniform layers of amounts (L, y, x) by this tier, and of the air above.

        If the tops of a layer vary, that of the columns themselves, with the shares of heights of that layer.
        """
        of_clouds, _ = self._without_others(amount_m, shares)
        return of_clouds + self._air[:, None, None]

    def _without_others(self, amount_m: Array | Field, shares: Any) -> tuple[Array, Array]:
        """Return the radiance (B, y, x) of uniform layers, or of columns with own tops, and what it is at night."""
        if not self._tops_vary:
            return self._between(self._uniform, amount_m), self._between(self._dark, amount_m)
        count, *shape = amount_m.shape
        in_a_row = [
            share.reshape(share.shape[0], 1, -1) if own and share is not None else None
            for own, share in zip(self._own_tops, shares, strict=True)
        ]
        day, night = self._apart(np.asarray(amount_m, np.float32).reshape(count, 1, -1), in_a_row)
        return day.reshape(-1, *shape), night.reshape(-1, *shape)

    def _between(self, values: Array, amount_m: Array | Field) -> Array:
        places = []
        for nodes, layer_amount in zip(self._nodes_m, amount_m, strict=True):
            low = np.clip(np.searchsorted(nodes, layer_amount, side="right") - 1, 0, nodes.size - 2)
            places.append((low, (layer_amount - nodes[low]) / (nodes[low + 1] - nodes[low])))
        result = np.zeros((values.shape[0], *amount_m.shape[1:]))
        for corner in product((0, 1), repeat=len(places)):
            weight, at = np.ones(amount_m.shape[1:]), []
            for up, (low, part) in zip(corner, places, strict=True):
                weight = weight * (part if up else 1.0 - part)
                at.append(low + up)
            result += weight * values[:, *at]
        return result

    def correct(
        self, thickness_m: Field, shares: Sequence[Field | None] | None = None, inner: Window = WHOLE
    ) -> tuple[Array, Array, Array]:
        """Return the amounts (L, y, x) at which the tables are read, m, their share and what is added (B, y, x).

        Of layers with tops of their own, the tables are read at the columns above the points.

        Parameters
        ----------
        thickness_m : ndarray of float32 (L, Y, X)
            Of each layer.
        shares : sequence of ndarray (Z, Y, X) or None, optional
            Of each column between the altitudes ``edges_m`` of the transport, by layer.
        inner : (slice, slice)
            Rows and columns among which light is scattered; the clouds around them only cast shadows.
        """
        shares = shares or [None] * len(thickness_m)
        amount, total = self.seen(thickness_m, shares, inner)
        if self._tops_vary:
            own = np.reshape(self._own_tops, (-1, 1, 1))
            amount = np.where(own, np.asarray(thickness_m)[:, *inner], amount)
        near = [None if share is None else share[:, *inner] for share in shares]
        return amount, *self.beside_columns(total, amount, near)

    def seen(self, thickness_m: Field, shares: Sequence[Field | None], inner: Window = WHOLE) -> tuple[Array, Array]:
        """Return the amounts (L, y, x) of cloud on lines of sight, m, and their radiance (B, y, x)."""
        stack, densities = self._stack, self._densities(thickness_m, shares)
        near = [np.ascontiguousarray(density[:, *inner]) for density in densities]
        amount = np.empty((len(near), *near[0].shape[1:]))
        moved = stack.shifts(stack.view)
        for layer_amount, density, part, slices, most in zip(
            amount, near, stack.parts, stack.layers, self._most_m, strict=True
        ):
            path = np.empty(density.shape[1:], dtype=np.float32)
            paths(density, slices.height_m, moved[part], path)
            np.minimum(path, most, out=layer_amount)
        glints = any(
            member.around.glint > FAINT_GLINT * member.around.below for group in self._groups for member in group
        )
        given: Any = stack, self._sea, self._sun, densities, near, amount, self._sea.paths(densities, glints), inner
        return amount, self._of_bands(self._groups, *given)

    def beside_columns(
        self, total: Array, amount_m: Array | Field, shares: Sequence[Field | None]
    ) -> tuple[Array, Array]:
        """Return the share of the tables, and what is added to it, each (B, y, x).

        Parameters
        ----------
        total : ndarray (B, y, x)
            Radiance of broken cloud.
        amount_m, shares : ndarray (L, y, x), sequence of ndarray (Z, y, x) or None
            Of the columns at which the tables are read; shares for layers with tops of their own.
        """
        return share_and_change(total, *self._without_others(amount_m, shares), self._air)


def _seen(
    group: StackedGroup, weights: Array | None, stack: Stack, sea: StackedSea, sun: Direction | None,
    densities: Sequence[Field], near: Sequence[Field], amount_m: Array, over_sea: StackedPaths, inner: Window,
    wide: int = 2,
) -> Array:  # fmt: skip
    """Return the radiance (y, x) of a group among clouds (Z, y, x) of each layer, with those (Z, Y, X) around them.

    With ``weights`` (L, C) in the tier ``slant``.
    """
    around, scaled, sunlight = group.around, group.scaled_m1, None
    shines = sun is not None and bool(np.any(around.sunlight > 0.0))
    changed = sea.change(over_sea, group, densities[0].shape[1:])[*inner]
    if weights is not None:
        radiance = emitted_radiance(stack, stack.optical(near, group.absorbing_m1), group)
        if shines and sun is not None:
            to_sun = np.ascontiguousarray(sun_depth(stack, stack.optical(densities, scaled), sun)[:, *inner])
            integrals = stacked_integrals(stack, stack.optical(near, scaled), to_sun, around.sunlight)
            radiance += np.tensordot(weights, integrals, axes=2)
        unveiled = _through(group.absorbing_m1, stack, amount_m)
        return np.asarray(radiance + unveiled * changed)
    if shines and sun is not None:
        lit = stacked_sunlight(stack, stack.optical(densities, scaled), sun)
        sunlight = np.ascontiguousarray(lit[:, *inner])
    source = stacked_source(stack, near, group, sun, sunlight, wide)
    radiance = stacked_radiance(stack, stack.optical(near, scaled), source, around.below)
    return np.asarray(radiance + _through(scaled, stack, amount_m) * changed)


def _through(extinctions_m1: Sequence[float], stack: Stack, amount_m: Array) -> Array:
    """Return the share of the sea's light (y, x) that cloud of amounts (L, y, x) on the line of sight leaves."""
    depth = np.tensordot(np.array(extinctions_m1) / float(stack.view.vector[2]), amount_m, axes=1)
    return np.asarray(np.exp(-depth))


def _at_night(group: StackedGroup) -> StackedGroup:
    """Return a group without the sun."""
    around = group.around
    dark = replace(around, below=around.below - around.glint, glint=0.0, sunlight=np.zeros_like(around.sunlight))
    return replace(group, around=dark)


def _nodes(least_m: float, slice_m: float, count: int) -> Array:
    """Return thicknesses (N,) of uniform cloud: none, the thinnest, from which tables are linear to none, and more."""
    fine = np.arange(FINE_NODES * FINE_SLICES) / FINE_NODES
    coarse = np.arange(FINE_SLICES, count + 0.25, 2.0 / FINE_NODES)
    thicker = slice_m * np.concatenate((fine, coarse))
    return np.concatenate(([0.0, least_m], thicker[thicker > least_m]))
