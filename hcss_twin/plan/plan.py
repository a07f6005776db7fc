"""The plan of a scene: decisions made before anything is computed."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import ValidationError

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog, branch_of
from hcss_twin.core.notebook import as_html, as_text
from hcss_twin.cube.variables import LAYER, VariableSpec
from hcss_twin.models.radiance.spectral_grid import SpectralBand, SpectralGrid
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.plan.accuracy import Budget, RequestedAccuracy, share_out
from hcss_twin.plan.air_over_field import AirOverField
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.builder import Builder
from hcss_twin.plan.clear_sky import EVEN_SKY, EvenSky
from hcss_twin.plan.directions import SunlitDirections, Views
from hcss_twin.plan.drawing import with_changes
from hcss_twin.plan.effects import Effect, Shadows
from hcss_twin.plan.few_columns import Omission
from hcss_twin.plan.filled_in import FilledIn
from hcss_twin.plan.lines_of_sight import SunTrack
from hcss_twin.plan.numerics import GridRefinement, NumericalLevel
from hcss_twin.plan.omissions import texture_of_sea
from hcss_twin.plan.output import wants_radiance
from hcss_twin.plan.rays import GridRays, Rays
from hcss_twin.plan.scene_analysis import probe_last_frame
from hcss_twin.plan.scene_plane import ScenePlane
from hcss_twin.plan.sensor import BuiltSensor
from hcss_twin.plan.slant_paths import SlantPaths
from hcss_twin.plan.sunlight import COMPUTED, Sunlight
from hcss_twin.plan.views import ONE_VIEW, ViewAxis, views_over_image
from hcss_twin.plan.waves import MEAN_SEA, PlannedWaves, resolve_waves
from hcss_twin.plan.windows import Window, length
from hcss_twin.providers import CloudLayer, Grid, Sun, View
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.scenario.scenario import Scenario

if TYPE_CHECKING:
    from hcss_twin.plan.air_by_place import AirByPlace
    from hcss_twin.plan.cloud_tops import CloudTops
    from hcss_twin.plan.point_effects import PlannedPointEffect
    from hcss_twin.plan.probes import Probed
    from hcss_twin.plan.surfaces import PlannedSurfaces

__all__ = ["Plan"]


@dataclass(frozen=True)
class PlannedLight(Effect):
    """Light transport of a scene: value of ``radiance.light``, package, class, and the error that it states.

    The error is that of each band, rms over pixels relative to the mean radiance. ``choice`` says why it is this one
    where the scenario asks for another than the default.
    """

    kind = "light"

    name: str
    provider: str
    transport: Any
    expected_rms: Mapping[str, float] = field(default_factory=dict)
    choice: str = ""

    def described(self) -> Mapping[str, Any]:
        """Return name, package and stated error."""
        return {"light": {"name": self.name, "provider": self.provider, "expected_rms": dict(self.expected_rms)}}

    def check(self, *of_frame: Any) -> dict[str, Any]:
        """Return what the transport finds about a plan, its tables and a frame for the certificate, if it does."""
        return dict(self.transport.check(*of_frame)) if hasattr(self.transport, "check") else {}


class IndependentColumns(PlannedLight):
    """No light between columns: nothing to state or to apply."""

    varies, described = False, Effect.described


COLUMNS = IndependentColumns("columns", "", None)


@dataclass(frozen=True, repr=False)
class Plan:
    """Immutable, checked description of a run.

    Attributes
    ----------
    catalog : Catalog
        Records the files that were read.
    assembly : Assembly
        The providers of the scene, for radiance and clouds.
    bands : tuple of SpectralBand (B,)
    spectral_grid : SpectralGrid
        Wavenumbers and band weights.
    layers : tuple of CloudLayer (L,)
        From the lowest to the highest.
    view : View
        Direction to the sensor from the image centre.
    grid : Grid
        Image plane, in pixels.
    samples_per_pixel : int
        Points along each side of a pixel.
    extent : (slice, slice)
        Rows and columns of the image to compute.
    frame_times_s : ndarray (F,)
        Seconds after the scenario's start.
    sun_zenith_deg, sun_azimuth_deg : ndarray (F,)
        Angles of the sun at each frame.
    variables : tuple of VariableSpec
        Variables of the cube.
    computed : tuple of VariableSpec
        These, and what variable providers need besides.
    omissions : tuple of Omission
        Approximations and omitted physics, with bounds.
    filled_in : tuple of FilledIn
        Defaults for values that the scenario omits.
    notes : tuple of str
        Limits of the providers that the scene uses.
    numerics : NumericalLevel
        Level of the radiance model.
    grid_refinement : GridRefinement
        Refinement of the spectral grid.
    waves : PlannedWaves
        Resolved waves, or the mean sea.
    sunlight : Sunlight
        Computed, or omitted because it is faint.
    sensor : BuiltSensor
        Sensor of the sensor cube; the clean cube does not depend on it, but for its integration time with a camera.
    views : ViewAxis
        Views with tables, between which those of pixels lie.
    surfaces : tuple of PlannedSurfaces
        States of the surfaces; none for sea everywhere.
    tops : tuple of CloudTops
        Altitudes of cloud tops of layers whose tops vary.
    texture : EvenSky
        Clear sky: even, or with texture.
    land_share : float
        Share of land in the image of a scene without surfaces.
    probes : tuple of Probed
        How the providers of other packages fared with the laws of their kinds.
    rays : Rays
        Where the pixels look, to which ``samples_per_pixel``, ``extent`` and ``variables`` belong.
    light : PlannedLight
        Light between columns of cloud.
    point_effects : tuple of PlannedPointEffect
        Effects of other packages that differ from place to place.
    air_by_place : tuple of AirByPlace
        Places whose air has tables, for rays that form no grid on the ground.
    replan : callable or None
        Plans another scenario with the same options.
    """

    scenario: Scenario
    catalog: Catalog
    assembly: Assembly
    bands: tuple[SpectralBand, ...]
    spectral_grid: SpectralGrid
    layers: tuple[CloudLayer, ...]
    view: View
    grid: Grid
    samples_per_pixel: int
    extent: Window
    frame_times_s: Array
    sun_track: SunTrack
    sun_zenith_deg: Array
    sun_azimuth_deg: Array
    variables: tuple[VariableSpec, ...]
    computed: tuple[VariableSpec, ...]
    accuracy: RequestedAccuracy
    omissions: tuple[Omission, ...]
    filled_in: tuple[FilledIn, ...]
    notes: tuple[str, ...]
    numerics: NumericalLevel
    grid_refinement: GridRefinement
    rays: Rays
    sensor: BuiltSensor
    waves: PlannedWaves = MEAN_SEA
    sunlight: Sunlight = COMPUTED
    views: ViewAxis = ONE_VIEW
    surfaces: tuple[PlannedSurfaces, ...] = ()
    tops: tuple[CloudTops, ...] = ()
    texture: EvenSky = EVEN_SKY
    land_share: float = 0.0
    probes: tuple[Probed, ...] = ()
    light: PlannedLight = COLUMNS
    point_effects: tuple[PlannedPointEffect, ...] = ()
    air_by_place: tuple[AirByPlace, ...] = ()
    replan: Callable[[Scenario], Plan] | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        """Return the plan in a few lines, instead of all its parts."""
        return as_text(*self._summary())

    def _repr_html_(self) -> str:
        """Return the same as a table for notebooks."""
        return as_html(*self._summary())

    def _summary(self) -> tuple[str, list[tuple[str, str]]]:
        rows, columns = self.pixels
        asked = f"{100 * self.accuracy.relative:g} %"
        if self.accuracy.kelvin is not None:
            asked = f"{self.accuracy.kelvin:g} K"
        lines = [
            ("cube", f"{len(self.frame_times_s)} x {rows} x {columns} pixels, {self.uncompressed_bytes / 1e6:.3g} MB"),
            ("bands", ", ".join(f"{band.name} ({band.lower_um:g}-{band.upper_um:g} um)" for band in self.bands)),
            ("clouds", ", ".join(layer.name for layer in reversed(self.layers)) or "none"),
            ("variables", ", ".join(variable.name for variable in self.variables)),
            ("accuracy", f"{asked} asked for" if self.needs_radiance else "no radiance is computed"),
        ]
        lines += [("assumed", f"{item.field} = {item.value}") for item in self.filled_in]
        known = sorted((item for item in self.omissions if item.bound), key=lambda item: -(item.bound or 0.0))
        lines += [("left out", f"{item.what}, at most {100 * (item.bound or 0.0):.2g} %") for item in known[:3]]
        return f"Plan: {self.scenario.title or self.scenario.origin}", lines

    def toward(self, view: View) -> Plan:
        """Return the plan of the same scene in orthographic view from another direction."""
        toward = replace(self, assembly=self.assembly.toward(view), view=view, views=ONE_VIEW)
        if not (isinstance(view, AirOverField.PlacedView) and view.own_sun):
            return toward
        track = replace(self.sun_track, latitude_deg=view.latitude_deg, longitude_deg=view.longitude_deg)
        zenith, azimuth, _ = track.positions(self.frame_times_s)
        return replace(toward, sun_track=track, sun_zenith_deg=zenith, sun_azimuth_deg=azimuth)

    def redrawn(
        self,
        seed: int,
        layers: Sequence[Mapping[str, Any]] = (),
        elements: Sequence[Mapping[str, Any]] | None = None,
        sensor_seed: int | None = None,
    ) -> Plan:
        """Return the plan of the same scene under another sky and with other elements.

        Only clouds, waves, elements and the random numbers of the sensor are made anew, in milliseconds: radiance
        tables are the same. Where that is not all that changes, as where no cloud is left or tops of clouds are those
        of each sky, the scene is planned anew. Filled-in values and notes stay those of this plan.

        Parameters
        ----------
        seed : int
            Of the scenario.
        layers : sequence of mapping, optional
            ``coverage`` and ``edge_taper`` of the first layers of the scenario; by default as they are.
        elements : sequence of mapping, optional
            Parameters of each section of elements; by default as they are.
        sensor_seed : int, optional
            Seed of the sensor, if it is to have one of its own.

        Raises
        ------
        OptionError
            If a layer has another key.
        ScenarioError
            If a value is not allowed; names the field.
        """
        return self.drawn_as(with_changes(self.scenario, seed, layers, elements, sensor_seed))

    def drawn_as(self, scenario: Scenario) -> Plan:
        """Return the plan of a scenario that differs in nothing but what :meth:`redrawn` changes."""
        catalog, before = branch_of(self.catalog), self.assembly
        drawing = before.drawing.of_sections(self.scenario, scenario)
        builder = Builder(catalog.shelf.get_or_compute("registry", Registry.discover), scenario)
        try:
            drawn = drawing.drawn(builder, scenario, catalog)
            builder.raise_problems()
        except ValidationError:  # of parameters of elements: named as everywhere
            raw, base, origin = json.loads(scenario.to_json()), scenario.base, scenario.origin
            Scenario.from_dict(raw, base=base, origin=origin, shelf=catalog.shelf)
            raise
        assembly = before.redrawn(drawing, drawn, builder)
        if not self._serves(assembly, drawn.slant):
            assert self.replan is not None
            return self.replan(scenario)
        probe_last_frame(assembly, float(self.frame_times_s[-1]))
        sensor = self.sensor.in_sky(scenario, catalog, assembly, self.frame_times_s)
        return replace(
            self,
            scenario=scenario,
            catalog=catalog,
            assembly=assembly,
            layers=assembly.layers,
            waves=resolve_waves(scenario, assembly) if self.waves.varies else self.waves,
            sensor=sensor,
            rays=replace(self.rays, assembly=assembly),  # type: ignore[type-var]
        )

    def _serves(self, drawn: Assembly, slant: SlantPaths) -> bool:
        """Whether a scene with other clouds has all else in common with this plan, as planning it would find out.

        The analysis of a scene knows whether there are clouds and clear sky, not how many. Tops of clouds that vary,
        and images as clouds, are those of each sky; rays of packages, and light between columns, are made for one
        scene.
        """
        before = self.assembly
        return (
            self.is_grid
            and not (self.light.varies or self.point_effects)
            and drawn.cloudy_layers == before.cloudy_layers
            and drawn.has_clear_sky == before.has_clear_sky
            and drawn.from_images == before.from_images
            and drawn.met_heights_m == before.met_heights_m
            and drawn.hanging_layers == before.hanging_layers
            and slant.why_not.keys() <= before.slant.why_not.keys()
        )

    def views_over_image(self) -> Views:
        """Return the views over the image, which are all the same if pixels share one view and one air."""
        return views_over_image(self.assembly)

    def views_of_pixels(self, rows: Sequence[int], columns: Sequence[int], time_s: float) -> list[View]:
        """Return the exact view of some pixels, with the sun of their places where these have their own."""
        views, directions = self.rays.views_of_pixels(rows, columns, time_s), self.assembly.directions
        if not isinstance(directions, SunlitDirections):
            return views
        windows = ((slice(row, row + 1), slice(column, column + 1)) for row, column in zip(rows, columns, strict=True))
        seen = [self.rays.locations_deg(window, time_s, self.scenario) for window in windows]
        latitude, longitude = (np.array([float(angle[axis][0, 0]) for angle in seen]) for axis in (0, 1))
        return directions.of_places(views, *Ellipsoid.to_plane(latitude, longitude, *directions.centre_deg))

    def texture_of_sea(self, why: str, needs: str = "") -> Omission:
        """Return the omission of the texture of the sea's temperature, and ``why`` the sea has one temperature."""
        sun = self.sun_up_at(float(self.frame_times_s[0])) if self.sunlight.is_computed else None
        return texture_of_sea(self.assembly, [sun], why, needs)

    def at_level(self, level: int) -> Plan:
        """Return the same plan with the radiance model at another numerical level."""
        return replace(self, assembly=self.assembly.at_level(level))

    @property
    def budget(self) -> Budget:
        """Largest allowed error of each approximation."""
        return share_out(self.accuracy.relative)

    @property
    def pixels(self) -> tuple[int, int]:
        """Rows and columns of the cube."""
        rows, columns = self.extent
        return length(rows), length(columns)

    @property
    def is_window(self) -> bool:
        """Whether the cube covers only part of the image."""
        return self.is_grid and self.pixels != (self.grid.rows, self.grid.columns)

    @property
    def image(self) -> Grid:
        """The image, in pixels."""
        return self.rays.image

    @property
    def effects(self) -> tuple[Effect, ...]:
        """What lets pixels differ beyond their clouds; what stages read and write decides their order."""
        shadows = [Shadows()] * self.has_shadows
        of_points = *self.surfaces, *self.tops, *self.point_effects, *self.air_by_place
        of_columns = self.light, *of_points, self.views, self.texture
        return tuple(effect for effect in (*of_columns, *shadows, self.waves, self.sensor) if effect.varies)

    @property
    def has_shadows(self) -> bool:
        """Whether clouds can cast shadows."""
        return self.assembly.slant.shadows and bool(self.layers) and self.sun_matters

    @property
    def is_grid(self) -> bool:
        """Whether the pixels form a grid on the ground, which is then the plane of the scene."""
        return isinstance(self.rays, GridRays)

    @property
    def cloudy_layers(self) -> list[int]:
        """Numbers of the layers that have cloud at some time; the lowest if none has."""
        return [number for number, cloudy in enumerate(self.assembly.cloudy_layers) if cloudy] or [0]

    @property
    def scene(self) -> ScenePlane:
        """The plane of the scene, in points."""
        return ScenePlane(self.grid, self.scenario.image.samples_per_pixel)

    @property
    def needs_radiance(self) -> bool:
        """Whether any variable requires radiance."""
        return wants_radiance(self.computed)

    @property
    def sun_matters(self) -> bool:
        """Whether the sun is above the horizon in at least one frame and its light is not omitted."""
        return self.sunlight.matters(self.sun_zenith_deg)

    def sun_of_frame(self, time_s: float) -> Sun:
        """Sun at a time; those of all frames are computed together."""
        return self._suns.get(time_s) or self.sun_track.at(time_s)

    @cached_property
    def _suns(self) -> dict[float, Sun]:
        of_frames = zip(*(angles.tolist() for angles in self.sun_track.positions(self.frame_times_s)), strict=True)
        return {time_s: Sun(*sun) for time_s, sun in zip(self.frame_times_s.tolist(), of_frames, strict=True)}

    def sun_at(self, time_s: float) -> Sun | None:
        """Sun for radiance at a time; None below the horizon or if sunlight is omitted."""
        return self.sun_up_at(time_s) if self.sun_matters else None

    def sun_up_at(self, time_s: float) -> Sun | None:
        """Sun at a time; None below the horizon."""
        sun = self.sun_track.at(time_s)
        return sun if sun.is_up else None

    @property
    def uncompressed_bytes(self) -> int:
        """Uncompressed size of the data variables."""
        sizes = {
            "time": self.frame_times_s.size,
            "band": len(self.bands),
            "y": self.pixels[0],
            "x": self.pixels[1],
            LAYER: len(self.layers),
        }
        return sum(
            math.prod(sizes[dim] for dim in spec.dims) * np.dtype(spec.stored_dtype).itemsize for spec in self.variables
        )
