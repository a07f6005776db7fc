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
from typing import Any, ClassVar

import numpy as np

from hcss_light.bands import Group, groups_of_bands, sunlight_of_air
from hcss_light.kept import KeptSource
from hcss_light.sea import FAINT as FAINT_GLINT
from hcss_light.sea import Sea, SeaPaths
from hcss_light.slices import Field, Slices, slices_of
from hcss_light.source import Direction, Surroundings, absorbed_radiance, scattered_source, sourced_radiance
from hcss_light.stated import differences, stated_errors
from hcss_light.sums import fitted_weights, sun_integrals
from hcss_twin.engine.light import LightStage
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Sun
from hcss_twin.providers.light import LightInputs

NODES_PER_SLICE = 4
FAINT = 1e-3
"""Share of sunlight in the radiance of uniform cloud below which it counts as none."""

SPREADING = 1.0
"""Light that clouds scatter and emit is taken from up to so many heights of the layer aside."""

MOST_SPREADING = 24
"""The same limit in points."""

LOWEST_SUN_DEG = 85.0
"""Below it sunlight is that of uniform cloud: its rays would cross the whole image."""


class SourceLight:
    """Light in broken clouds, tier ``source``; see :class:`hcss_twin.providers.light.LightTransport`.

    Parameters
    ----------
    inputs : LightInputs

    Raises
    ------
    LightError
        If view or sun are so slanted that too many slices are needed.
    """

    tier: ClassVar[str] = "source"
    cost: ClassVar[float] = 10.0

    def __init__(self, inputs: LightInputs) -> None:
        self._inputs = inputs
        layer, view = inputs.layer, inputs.view
        shone = inputs.sun_zenith_deg <= LOWEST_SUN_DEG
        zenith, azimuth = inputs.sun_zenith_deg[shone], inputs.sun_azimuth_deg[shone]
        cloud = inputs.optics.single_scattering(layer.microphysics, inputs.wavenumber_cm1)
        thickest = float(np.max(cloud.extinction_m1 * (1.0 - cloud.albedo * cloud.moments[1] ** 2)))
        optical = thickest * layer.thickness_max_m
        steepest = max(view.zenith_deg, float(np.max(zenith, initial=0.0)))
        self.slices = slices_of(
            layer.base_m, layer.top_m, layer.anchor, inputs.point_m, steepest, optical
        )  # fmt: skip
        height = layer.thickness_max_m / inputs.point_m
        spread = min(math.ceil(SPREADING * height), MOST_SPREADING) if self.tier == "source" else 0
        seen = self.slices.shifts(view.zenith_deg, view.azimuth_deg, inputs.reference_m)
        lit = height * np.tan(np.radians(zenith)) * np.stack((np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))))
        before, after = (
            [
                math.ceil(max(sign * float(limit(own)), 0.0) + max(float(np.max(sign * sun, initial=0.0)), 0.0))
                for own, sun in zip(seen.T, lit, strict=True)
            ]
            for sign, limit in ((-1.0, np.min), (1.0, np.max))
        )
        # One point for each of two interpolations.
        self.reach = tuple((low + spread + 2, high + spread + 2) for low, high in zip(before, after, strict=True))
        suns = [Direction(*each) for each in zip(zenith.tolist(), azimuth.tolist(), strict=True)]
        toward = Direction(view.zenith_deg, view.azimuth_deg)
        seas = [Sea(self.slices, toward, each, inputs.reference_m).reach for each in (None, *suns)]
        self.sea_reach: tuple[tuple[int, int], ...] = tuple(map(tuple, np.max([self.reach, *seas], axis=0).tolist()))
        if self.tier == "source":
            self.seen = tuple(
                (math.ceil(max(-float(np.min(own)), 0.0)) + 2, math.ceil(max(float(np.max(own)), 0.0)) + 2)
                for own in seen.T
            )

    @staticmethod
    def check(plan: Plan, tables: RadianceTables, frame: int) -> dict[str, Any]:
        """Return how some pixels of a frame compare with Monte Carlo, for the certificate."""
        from hcss_light.comparison import check  # not for plans alone

        return check(plan, tables, frame)

    @property
    def edges_m(self) -> Array:
        """Altitudes at which the shares of heights are asked."""
        return self.slices.edges_m

    def expected_errors(self) -> list[float]:
        """Return the error (B,) to expect: rms over pixels, relative to the mean radiance."""
        own = 0.0 if self.tier == "source" else self._differences[1]
        return stated_errors(self._inputs, self._differences[0], own)

    def errors_of_columns(self) -> list[float]:
        """Return the same of independent columns."""
        return stated_errors(self._inputs, self._differences[0], self._differences[0])

    def over_views(self, plan: Plan) -> tuple[list[float], str]:
        """Return the same errors over an image whose view varies, and a note about its directions.

        Raises
        ------
        LightError
            If directions that are constant in squares would be too wrong.
        """
        from hcss_light.tiles import Tiles  # not for parallel views

        tiles, own = Tiles(plan), self._inputs
        errors = [type(self)(replace(own, view=each)).expected_errors() for each in (own.view, *tiles.corners)]
        text = (
            f"directions of the view are constant in squares of {tiles.side} pixels: lines of sight are displaced by "
        )
        return np.max(errors, axis=0).tolist(), text + f"up to {tiles.displaced:.2g} points at the top of the clouds"

    @cached_property
    def _differences(self) -> list[Array]:
        """How much columns, and the tier ``slant`` if this is it, differ from ``source``."""
        source = SourceLight(self._inputs)
        return differences(self._inputs, source, self if self.tier == "slant" else None)

    @classmethod
    def stage(cls, plan: Plan, tables: RadianceTables) -> LightStage:
        """Return the computation of frames, which keeps the light in clouds if it can."""
        from hcss_light.stage import stage  # not for plans alone

        return stage(plan, tables, cls.tier == "source")

    def at(self, sun: Sun | None) -> InstantLight:
        """Return the light at one instant."""
        if sun is not None and sun.zenith_deg > LOWEST_SUN_DEG:
            sun = None
        groups = groups_of_bands(self._inputs, self.slices.middle_m, sun)
        return InstantLight(self.tier, self._inputs, self.slices, groups, sun)


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
        self._glints = any(each.around.glint > FAINT_GLINT * each.around.below for own in groups for each in own)
        self._slices, self._shape = slices, inputs.shape
        self._least_m, self._most_m = layer.thickness_min_m, layer.thickness_max_m
        nodes = np.linspace(0.0, self._most_m, NODES_PER_SLICE * slices.count + 1)
        # Between no cloud and the thinnest the engine's tables are linear, and so is this one.
        self._nodes_m = np.concatenate(([0.0, self._least_m], nodes[nodes > self._least_m]))
        columns = [slices.density(np.full((1, 1), each, dtype=np.float32)) for each in self._nodes_m]
        lights = [[GroupLight(tier, slices, each, view, to_sun, inputs.reference_m) for each in own] for own in groups]
        self._lights = lights
        self._uniform = self._of_uniform(lights, columns)
        self._dark = self._uniform
        if to_sun is not None:
            self._dark = self._of_uniform([[each.at_night() for each in own] for own in lights], columns)

    def _of_uniform(self, lights: list[list[GroupLight]], columns: Sequence[Field]) -> Array:
        """Return the radiance (B, N) of uniform clouds."""
        paths = [self._sea.paths(each, self._glints) for each in columns]
        result: Array = np.array([sum(each.of_uniform(columns, self._sea, paths) for each in own) for own in lights])
        return result

    def over_sea(self, thickness_m: Field, shares: Field | None = None) -> list[Array]:
        """Return what clouds (y, x) change in the radiance of the sea (y, x) below the lines of sight, by group."""
        density = self._slices.density(thickness_m, self._shape, shares)
        paths = self._sea.paths(density, self._glints)
        return [each.over_sea(self._sea, paths, thickness_m.shape) for own in self._lights for each in own]

    def uniform(self, amount_m: Array | Field) -> Array:
        """Return the radiance (B, y, x) of uniform cloud by this tier, and of the air."""
        own = [np.interp(amount_m, self._nodes_m, each) for each in self._uniform]
        return np.array([each + air for each, air in zip(own, self._air, strict=True)])

    def keep(self, thickness_m: Field, inner: Sequence[slice], shares: Field | None = None) -> KeptSource:
        """Return the source functions of clouds (y, x) within some rows and columns."""
        density = self._slices.density(thickness_m, self._shape, shares)
        sources = [each.source(density)[:, *inner] for own in self._lights for each in own]
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

        Parameters
        ----------
        kept : KeptSource, optional
            Of the same clouds before they moved by so many rows and columns.
        shares : ndarray (Z, y, x), optional
            Of each column between the altitudes ``edges_m`` of the transport.
        over_sea : sequence of ndarray (y, x), optional
            From :meth:`over_sea`, with more clouds around; by default the clouds are continued periodically.
        """
        seas = iter(self.over_sea(thickness_m, shares) if over_sea is None else over_sea)
        density = self._slices.density(thickness_m, self._shape, shares)
        sources = iter(() if kept is None else kept.at(density, moved))
        share, change = np.empty((2, len(self._lights), *thickness_m.shape))
        amount = np.zeros(thickness_m.shape)
        for band, own in enumerate(self._lights):
            total = np.zeros(thickness_m.shape)
            for each in own:
                amount, radiance = each.radiance(density, next(sources, None))
                total += radiance + each.unveiled(amount) * next(seas)
            np.minimum(amount, self._most_m, out=amount)
            uniform, dark = (np.interp(amount, self._nodes_m, each[band]) for each in (self._uniform, self._dark))
            sunlight = uniform - dark
            lit = sunlight > FAINT * uniform
            share[band] = np.where(lit, np.clip((total - dark) / np.where(lit, sunlight, 1.0), 0.0, 1.0), 1.0)
            # Tables have the sunlight that the air above scatters, which is not shaded.
            change[band] = total - share[band] * uniform + (1.0 - share[band]) * self._air[band]
        return amount, share, change


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

    def of_uniform(self, columns: Sequence[Field], sea: Sea, paths: Sequence[SeaPaths]) -> Array:
        """Return the radiance (N,) of uniform clouds, to which the sums for sunlight are fitted in the tier slant."""
        if self._tier == "slant" and self._sun is not None:
            dark = replace(self._group.around, emitted=np.zeros(self._slices.count), sky=0.0, below=0.0, glint=0.0)
            integrals = np.array([self._integrals(each)[:, 0, 0] for each in columns]).T
            self._weights = fitted_weights(
                integrals, np.array([self._sourced(each, dark)[1].item() for each in columns])
            )
        result = []
        for column, path in zip(columns, paths, strict=True):
            amount, radiance = self.radiance(column)
            result.append((radiance + self.unveiled(amount) * self.over_sea(sea, path, (1, 1))).item())
        return np.array(result)

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
            for weight, each in zip(self._weights, self._integrals(density), strict=True):
                radiance += weight * each
        return amount, radiance

    def _sourced(self, density: Field, around: Surroundings, source: Field | None = None) -> tuple[Array, Array]:
        given = self._group.particles, around, self._view, self._sun, self._reference_m, source
        return sourced_radiance(self._slices, density, *given)

    def _integrals(self, density: Field) -> Array:
        assert self._sun is not None
        particles, sunlight = self._group.particles, self._group.around.sunlight
        return sun_integrals(self._slices, density, particles, sunlight, self._view, self._sun, self._reference_m)
