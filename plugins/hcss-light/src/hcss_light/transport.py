"""Tiers of light for scenarios: how broken clouds differ from columns.

For each point the engine's tables are read at the amount of cloud along its own line of sight, and the difference
between broken and uniform cloud, both by the same faster method, is added. Uniform cloud thus keeps the radiance of the
tables, with all its accuracy, and errors that the method makes for broken and uniform cloud alike cancel. Errors of
sunlight are in proportion to it: where shadows leave a share of the sunlight of uniform cloud, that share of the
difference between tables and method counts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from hcss_light.bands import Group, groups_of_bands, sunlight_of_air
from hcss_light.kept import KeptSource
from hcss_light.scattered import ScatteredLight, share_and_change, shining
from hcss_light.sea import FAINT as FAINT_GLINT
from hcss_light.sea import Sea, SeaPaths
from hcss_light.slices import Field, Slices, slices_of
from hcss_light.source import Direction, Surroundings, absorbed_radiance, scattered_source, sourced_radiance
from hcss_light.stated import differences, lowest_sun
from hcss_light.sums import fitted_weights, sun_integrals
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Sun
from hcss_twin.providers.light import LightInputs

NODES_PER_SLICE = 4


class SourceLight(ScatteredLight):
    """Light in one layer of broken clouds, tier ``source``.

    Attributes
    ----------
    knows_surfaces : bool
        Whether there may be a map of the ground: each point has the light over its own class of surface.
    knows_rays : bool
        Whether pixels may form no grid on the ground, as those of cameras.
    knows_tops : bool
        Whether clouds may have tops of their own. A line of sight crosses clouds of several, so that no one of their
        tables is that of its cloud: the difference is then that from the pixel's own column, by the same method.
    """

    knows_surfaces: ClassVar[bool] = True
    knows_rays: ClassVar[bool] = True
    knows_tops: ClassVar[bool] = True

    def __init__(self, inputs: LightInputs) -> None:
        super().__init__(inputs)
        layer, view = inputs.layer, inputs.view
        given = layer.base_m, layer.top_m, layer.anchor, inputs.point_m
        self.slices = slices_of(*given, self._steepest_deg, self._optical[0])
        spread = self._spread if self.tier == "source" else 0
        seen = self.slices.shifts(view.zenith_deg, view.azimuth_deg, inputs.reference_m)
        zenith, azimuth = np.radians([(sun.zenith_deg, sun.azimuth_deg) for sun in self._suns]).reshape(-1, 2).T
        lit = self._heights[0] * np.tan(zenith) * np.stack((np.cos(azimuth), np.sin(azimuth)))
        before, after = (
            [
                math.ceil(max(sign * float(limit(shift)), 0.0) + max(float(np.max(sign * sun, initial=0.0)), 0.0))
                for shift, sun in zip(seen.T, lit, strict=True)
            ]
            for sign, limit in ((-1.0, np.min), (1.0, np.max))
        )
        # One point for each of two interpolations.
        self.reach = tuple((low + spread + 2, high + spread + 2) for low, high in zip(before, after, strict=True))
        toward = Direction(view.zenith_deg, view.azimuth_deg)
        seas = [Sea(self.slices, toward, sun, inputs.reference_m).reach for sun in (None, *self._suns)]
        self.sea_reach: tuple[tuple[int, int], ...] = tuple(map(tuple, np.max([self.reach, *seas], axis=0).tolist()))
        if self.tier == "source":
            self.seen = tuple(
                (math.ceil(max(-float(np.min(shift)), 0.0)) + 2, math.ceil(max(float(np.max(shift)), 0.0)) + 2)
                for shift in seen.T
            )

    @property
    def edges_m(self) -> Array:
        """Altitudes at which the shares of heights are asked."""
        return self.slices.edges_m

    @cached_property
    def _differences(self) -> list[Array]:
        source = self if self.tier == "source" else SourceLight(self._inputs)
        instants = source._instants(lowest_sun(self._inputs), "source", "slant")

        def clouds(rows: slice, columns: slice) -> tuple[Field, Field | None]:
            thickness, shares = self._inputs.clouds(rows, columns, source.edges_m)
            return np.ascontiguousarray(thickness), shares

        return differences(self._inputs.image, instants, source.reach, clouds)

    @classmethod
    def stage(cls, plan: Plan, tables: RadianceTables) -> LightStage:
        """Return the computation of frames, which keeps the light in clouds if it can."""
        from hcss_light.stage import stage  # not for plans alone

        return stage(plan, tables, cls.tier == "source")

    def at(self, sun: Sun | None) -> InstantLight:
        """Return the light at one instant."""
        (instant,) = self._instants(sun, self.tier)
        return instant

    def _instants(self, sun: Sun | None, *tiers: str) -> list[InstantLight]:
        """Return the light at one instant in several tiers."""
        sun = shining(sun)
        groups = groups_of_bands(self._inputs, self.slices.middle_m, sun)
        return [InstantLight(tier, self._inputs, self.slices, groups, sun) for tier in tiers]


class SlantLight(SourceLight):
    """The tier ``slant``."""

    tier: ClassVar[str] = "slant"
    cost: ClassVar[float] = 1.0


class InstantLight:
    """Light at one instant; see :class:`hcss_twin.providers.light.InstantLight`."""

    def __init__(
        self, tier: str, inputs: LightInputs, slices: Slices, groups: list[list[Group]], sun: Sun | None
    ) -> None:
        layer = inputs.layer
        self._air = inputs.weights_cm1 @ sunlight_of_air(inputs, sun)
        view = Direction(inputs.view.zenith_deg, inputs.view.azimuth_deg)
        to_sun = None if sun is None else Direction(sun.zenith_deg, sun.azimuth_deg)
        self._sea = Sea(slices, view, to_sun, inputs.reference_m)
        self._glints = any(
            member.around.glint > FAINT_GLINT * member.around.below for group in groups for member in group
        )
        self._slices, self._shape, self._tops_vary = slices, inputs.shape, inputs.tops_vary
        self._least_m, self._most_m = layer.thickness_min_m, layer.thickness_max_m
        nodes = np.linspace(0.0, self._most_m, NODES_PER_SLICE * slices.count + 1)
        # Between no cloud and the thinnest the engine's tables are linear, and so is this one.
        self._nodes_m = np.concatenate(([0.0, self._least_m], nodes[nodes > self._least_m]))
        columns = slices.density(self._nodes_m[None].astype(np.float32))
        lights = [
            [GroupLight(tier, slices, member, view, to_sun, inputs.reference_m) for member in group] for group in groups
        ]
        self._lights = lights
        for group_light in (group_light for light in lights for group_light in light):
            group_light.fit(columns)
        self._nights = lights
        if to_sun is not None:
            self._nights = [[group_light.at_night() for group_light in light] for light in lights]
        if not self._tops_vary:
            self._uniform, self._dark = self._apart(columns)

    def _apart(self, columns: Field) -> tuple[Array, Array]:
        """Return the radiance (B, N) of columns (Z, 1, N) of which none sees another, and what it is at night."""
        sea = self._sea.apart()
        paths = sea.paths(columns, self._glints)
        of_suns = []
        for lights in (self._lights, self._nights) if self._nights is not self._lights else (self._lights,):
            of_lights = (sum(group_light.apart(columns, sea, paths) for group_light in light) for light in lights)
            of_suns.append(np.array(list(of_lights)))
        return of_suns[0], of_suns[-1]

    def over_sea(self, thickness_m: Field, shares: Field | None = None) -> list[Array]:
        """Return what clouds (y, x) change in the radiance of the sea (y, x) below the lines of sight, by group."""
        density = self._slices.density(thickness_m, self._shape, shares)
        paths = self._sea.paths(density, self._glints)
        return [
            group_light.over_sea(self._sea, paths, thickness_m.shape) for light in self._lights for group_light in light
        ]

    def uniform(self, amount_m: Array | Field, shares: Field | None = None) -> Array:
        """Return the radiance (B, y, x) of uniform cloud by this tier, and of the air.

        Of clouds with tops of their own that of the columns (y, x) themselves, with their shares of heights.
        """
        of_clouds, _ = self._without_others(amount_m, shares)
        return of_clouds + self._air[:, None, None]

    def _without_others(self, amount_m: Array | Field, shares: Field | None) -> tuple[Array, Array]:
        """Return the radiance (B, y, x) of uniform cloud, or of columns with own tops, and what it is at night."""
        if self._tops_vary:
            density = self._slices.density(np.asarray(amount_m, np.float32), self._shape, shares)
            found = self._apart(density.reshape(density.shape[0], 1, -1))
            day, night = (of_sun.reshape(-1, *amount_m.shape) for of_sun in found)
            return day, night
        day, night = (
            np.array([np.interp(amount_m, self._nodes_m, band) for band in curves])
            for curves in (self._uniform, self._dark)
        )
        return day, night

    def keep(self, thickness_m: Field, inner: Sequence[slice], shares: Field | None = None) -> KeptSource:
        """Return the source functions of clouds (y, x) within some rows and columns."""
        density = self._slices.density(thickness_m, self._shape, shares)
        sources = [group_light.source(density)[:, *inner] for light in self._lights for group_light in light]
        return KeptSource.of(density[:, *inner], sources)

    def correct(
        self,
        thickness_m: Field,
        kept: KeptSource | None = None,
        moved: Sequence[float] = (0.0, 0.0),
        shares: Field | None = None,
        over_sea: Sequence[Array] | None = None,
    ) -> tuple[Array, Array, Array]:
        """Return the amount (y, x) at which the tables are read, m, their share and what is added (B, y, x).

        Of clouds with tops of their own, the tables are read at the columns above the points.

        Parameters
        ----------
        kept : KeptSource, optional
            Of the same clouds before they moved by so many rows and columns.
        shares : ndarray (Z, y, x), optional
            Of each column between the altitudes ``edges_m`` of the transport.
        over_sea : sequence of ndarray (y, x), optional
            From :meth:`over_sea`, with more clouds around; by default the clouds are continued periodically.
        """
        amount, total = self.seen(thickness_m, kept, moved, shares, over_sea)
        if self._tops_vary:
            amount = thickness_m.astype(np.float64)
        np.minimum(amount, self._most_m, out=amount)
        return amount, *self.beside_columns(total, amount, shares)

    def seen(
        self,
        thickness_m: Field,
        kept: KeptSource | None = None,
        moved: Sequence[float] = (0.0, 0.0),
        shares: Field | None = None,
        over_sea: Sequence[Array] | None = None,
    ) -> tuple[Array, Array]:
        """Return the amount (y, x) of cloud on lines of sight, m, and their radiance (B, y, x); as :meth:`correct`."""
        seas = iter(self.over_sea(thickness_m, shares) if over_sea is None else over_sea)
        density = self._slices.density(thickness_m, self._shape, shares)
        sources = iter(() if kept is None else kept.at(density, moved))
        total = np.zeros((len(self._lights), *thickness_m.shape))
        amount = np.zeros(thickness_m.shape)
        for band, light in zip(total, self._lights, strict=True):
            for group_light in light:
                amount, radiance = group_light.radiance(density, next(sources, None))
                band += radiance + group_light.unveiled(amount) * next(seas)
        return amount, total

    def beside_columns(self, total: Array, amount_m: Array | Field, shares: Field | None) -> tuple[Array, Array]:
        """Return the share of the tables, and what is added to it, each (B, y, x).

        Parameters
        ----------
        total : ndarray (B, y, x)
            Radiance of broken cloud.
        amount_m, shares : ndarray (y, x), ndarray (Z, y, x) or None
            Of the columns at which the tables are read; shares for clouds with tops of their own alone.
        """
        uniform, dark = self._without_others(amount_m, shares)
        return share_and_change(total, uniform, dark, self._air)


class GroupLight:
    """Light of one group of wavenumbers in one tier."""

    def __init__(
        self, tier: str, slices: Slices, group: Group, view: Direction, sun: Direction | None, reference_m: float
    ) -> None:
        self._tier, self._slices, self._group, self._view = tier, slices, group, view
        self._sun = sun if sun is not None and np.any(group.around.sunlight > 0.0) else None
        self._reference_m = reference_m
        self._weights: Array | None = None

    def at_night(self) -> GroupLight:
        """Return the same light without the sun."""
        around = self._group.around
        group = replace(self._group, around=replace(around, below=around.below - around.glint, glint=0.0))
        return GroupLight(self._tier, self._slices, group, self._view, None, self._reference_m)

    def over_sea(self, sea: Sea, paths: SeaPaths, shape: Sequence[int]) -> Array:
        """Return what clouds change in the radiance of the sea (y, x)."""
        return sea.change(paths, self._group.particles, self._group.around, shape)

    def unveiled(self, amount_m: Array) -> Array:
        """Return the share of the light of the sea that cloud on the line of sight leaves."""
        particles = self._group.particles
        extinction = particles.scaled[0] if self._tier == "source" else particles.absorbing_m1
        return np.asarray(np.exp(-extinction / float(self._view.vector[2]) * amount_m))

    def _alone(self) -> GroupLight:
        """Return the same light of columns of which none sees another."""
        apart = GroupLight(self._tier, self._slices.apart(), self._group, self._view, self._sun, self._reference_m)
        apart._weights = self._weights
        return apart

    def fit(self, columns: Field) -> None:
        """Fit the sums for sunlight of the tier slant to uniform clouds (Z, 1, N)."""
        if self._tier == "slant" and self._sun is not None:
            dark = replace(self._group.around, emitted=np.zeros(self._slices.count), sky=0.0, below=0.0, glint=0.0)
            alone = self._alone()
            integrals, radiance = alone._integrals(columns)[:, 0], alone._sourced(columns, dark)[1][0]
            self._weights = fitted_weights(integrals, radiance)

    def apart(self, columns: Field, sea: Sea, paths: SeaPaths) -> Array:
        """Return the radiance (N,) of columns (Z, 1, N) of which none sees another.

        Parameters
        ----------
        sea, paths
            Of columns that are apart, and of these.
        """
        amount, radiance = self._alone().radiance(columns)
        of_sea = self.over_sea(sea, paths, amount.shape)
        return np.asarray((radiance + self.unveiled(amount) * of_sea)[0])

    def source(self, density: Field) -> Field:
        """Return the source function (Z, y, x) toward the view."""
        return scattered_source(
            self._slices, density, self._group.particles, self._group.around, self._view, self._sun
        )  # fmt: skip

    def radiance(self, density: Field, source: Field | None = None) -> tuple[Array, Array]:
        """Return the amount of cloud (m), and the radiance, each (y, x), along the lines of sight.

        The tier ``source`` may be given its source function.
        """
        around = self._group.around
        if self._tier == "source":
            return self._sourced(density, around, source)
        particles, view = self._group.particles, self._view
        amount, radiance = absorbed_radiance(self._slices, density, particles, around, view, self._reference_m)
        if self._weights is not None:
            for weight, integral in zip(self._weights, self._integrals(density), strict=True):
                radiance += weight * integral
        return amount, radiance

    def _sourced(self, density: Field, around: Surroundings, source: Field | None = None) -> tuple[Array, Array]:
        given = self._group.particles, around, self._view, self._sun, self._reference_m, source
        return sourced_radiance(self._slices, density, *given)

    def _integrals(self, density: Field) -> Array:
        assert self._sun is not None
        particles, sunlight = self._group.particles, self._group.around.sunlight
        return sun_integrals(self._slices, density, particles, sunlight, self._view, self._sun, self._reference_m)
