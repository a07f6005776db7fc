"""The providers of a scene, and what follows from them: views, clear and cloudy sky, notes and stated accuracy."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.spectral_grid import SolarSpectrum, SpectralBand, SpectralGrid
from hcss_twin.physics.profile import Profile
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.plan.air_over_field import AirOverField
from hcss_twin.plan.builder import Builder, Built
from hcss_twin.plan.combinations import NotComputed
from hcss_twin.plan.filled_in import FilledIn
from hcss_twin.plan.hanging_levels import spanning
from hcss_twin.plan.scene_plane import ScenePlane
from hcss_twin.plan.slant_paths import SlantPaths
from hcss_twin.providers import (
    CloudGenerator,
    CloudLayer,
    ColumnSetting,
    Declaration,
    ElementProvider,
    Grid,
    Motion,
    Optics,
    RadianceModel,
    SeaModel,
    Sun,
    TransmittanceProvider,
    VariableProvider,
    View,
    clear_column,
    cloudy_columns,
)
from hcss_twin.providers.declarations import applying
from hcss_twin.providers.registry.discovery import Entry

if TYPE_CHECKING:
    from hcss_twin.plan.directions import Directions
    from hcss_twin.plan.drawing import Drawing
    from hcss_twin.plan.scene_family import SceneFamily
    from hcss_twin.plan.section_effect import SectionEffect
    from hcss_twin.plan.surface_classes import SceneSurfaces, SurfaceState

__all__ = ["Assembly"]


@dataclass(frozen=True)
class Assembly:
    """The guarded providers of one scene, and their common inputs.

    Attributes
    ----------
    entries : mapping of str to Entry
        Registry entry of each provider, by kind; generators and optics of several layers are numbered.
    samples_per_pixel : int
        Points along a pixel that are averaged.
    particle_fields, optics_fields : tuple of str (L,)
        Scenario fields that define the particles of each layer, and their optics.
    optics_of_layers : tuple of Optics (L,)
        The provider of each layer; ``optics`` asks the right one for any particles.
    model_at : callable
        Returns the radiance model at a numerical level, with sunlight some levels finer.
    air_of : callable
        Returns the air of a view, with a factor of its water vapour.
    sea_of : callable
        Builds the sea model for another temperature.
    built : mapping of str to Built
        How each provider was made, by the same labels as ``entries``.
    code : mapping of str to tuple of str
        What names the code of each provider in keys of cached results.
    lines_of_sight : LinesOfSight or None
        Lines of sight to the sensor; None if its altitude is unknown.
    surfaces : tuple of SceneSurfaces
        Map of the ground; none for sea everywhere.
    surface : SurfaceState or None
        Surface that takes the place of the scenario's sea; None for that sea.
    numerical_level, sunlight_steps : int
        That of the radiance model, and how many levels finer sunlight toward the sensor is.
    air_over_field : AirOverField
        Air over the image.
    drawing : Drawing
        What clouds and elements are made from.
    vapour_factor : float
        Of the water vapour at all levels.
    family : SceneFamily or None
        Of scenes that share columns with this one.
    cloud_notes : tuple of str
        Notes on the cloud types.
    directions : Directions or None
        All directions of view; None if pixels form a grid on the ground.
    reach_m : (float, float) or None
        How far the ground that is seen reaches from the centre along x and y; None: as far as the grid.
    has_texture : bool
        Whether clear sky has texture.
    even_vapour : NotComputed or None
        Why water vapour has none.
    has_bound_air : bool
        Whether the transmittance provider supports no other profile.
    climate_at : callable or None
        Returns air and sea at a latitude and longitude near the image; None if the scenario gives both.
    alterations : tuple of (SectionEffect, float)
        Effects of other packages, each with one value everywhere.
    """

    entries: Mapping[str, Entry]
    bands: tuple[SpectralBand, ...]
    spectral_grid: SpectralGrid
    profile: Profile
    grid: Grid
    samples_per_pixel: int
    motion: Motion
    layers: tuple[CloudLayer, ...]
    generators: tuple[CloudGenerator, ...]
    particle_fields: tuple[str, ...]
    optics_fields: tuple[str, ...]
    transmittance: TransmittanceProvider
    sea: SeaModel
    optics: Optics
    optics_of_layers: tuple[Optics, ...]
    model_at: Callable[[int, int], RadianceModel]
    air_of: Callable[[View, float], AirOverField.Air]
    sea_of: Callable[[float], SeaModel]
    solar_irradiance: SolarSpectrum
    sea_temperature_K: float
    sea_wind_speed_m_s: float
    filled_in: tuple[FilledIn, ...]
    slant: SlantPaths
    code: Mapping[str, tuple[str, ...]]
    air_over_field: AirOverField
    drawing: Drawing
    lines_of_sight: LinesOfSight | None = None
    elements: tuple[ElementProvider, ...] = ()
    derived: tuple[VariableProvider, ...] = ()
    surfaces: tuple[SceneSurfaces, ...] = ()
    surface: SurfaceState | None = None
    numerical_level: int = 0
    sunlight_steps: int = 0
    vapour_factor: float = 1.0
    family: SceneFamily | None = None
    cloud_notes: tuple[str, ...] = ()
    built: Mapping[str, Built] = field(default_factory=dict)
    directions: Directions | None = None
    reach_m: tuple[float, float] | None = None
    has_texture: bool = False
    even_vapour: NotComputed | None = None
    has_bound_air: bool = False
    climate_at: Callable[[float, float], AirOverField.Air] | None = None
    alterations: tuple[tuple[SectionEffect, float], ...] = ()

    @property
    def own_suns(self) -> bool:
        """Whether directions know the sun of each place."""
        return self.directions is not None and self.directions.suns is not None

    def suns_of(self, view: View, suns: Sequence[Sun | None]) -> Sequence[Sun | None]:
        """Return the suns of the place of a view at some frames, or those given if all places have one sun."""
        of_place = None if self.directions is None else self.directions.suns
        return suns if of_place is None else of_place(view)

    @property
    def view(self) -> View:
        """Viewing direction."""
        return self.slant.view

    @property
    def model(self) -> RadianceModel:
        """The radiance model."""
        return self.model_at(self.numerical_level, self.sunlight_steps)

    def setting(self, sun: Sun | None = None, view: View | None = None) -> ColumnSetting:
        """Return what the columns of the scene share under a sun, perhaps toward another view: in the air of its place.

        Raises
        ------
        CatalogError
            If the profiles of the scene do not cover that place.
        """
        view = self.view if view is None else view
        return self._altered(view.sun(sun), view)

    def like(self, setting: ColumnSetting) -> ColumnSetting:
        """Return what columns share in this state of a scene, from a setting of another: its sun is the place's."""
        return self._altered(setting.sun, setting.view)

    def _altered(self, sun: Sun | None, view: View) -> ColumnSetting:
        setting = self._unaltered(sun, view)
        for effect, value in self.alterations:
            setting = effect.apply(setting, value)
        return setting

    def _unaltered(self, sun: Sun | None, view: View) -> ColumnSetting:
        air = self.air_of(view, self.vapour_factor)
        sea, kelvin = air.sea_or(self.sea, self.sea_temperature_K)
        return ColumnSetting(view, sun, sea, kelvin, air.profile, air.transmittance, self.layers, air.memory)

    def altered(self, effect: SectionEffect, value: float) -> Assembly:
        """Return the same scene with one value of an effect everywhere."""
        return replace(self, alterations=(*self.alterations, (effect, value)))

    def spanning(self, sun: Sun | None, view: View) -> list[ColumnSetting]:
        """Return the setting of the scene, or those that span its family."""
        setting = self.setting(sun, view)
        return [setting] if self.family is None else self.family.spanning(setting, self.sea_of)

    def clear(self, wavenumber_cm1: Array, sun: Sun | None) -> dict[str, Array]:
        """Return each term (V,) of clear sky."""
        return clear_column(self.model, self.setting(sun), wavenumber_cm1)

    def cloudy(self, wavenumber_cm1: Array, thickness_m: Array, sun: Sun | None) -> Mapping[str, Array]:
        """Return each term (N, V) of columns with layers of thickness (N, L)."""
        return cloudy_columns(self.model, self.setting(sun), wavenumber_cm1, thickness_m)

    def redrawn(self, drawing: Drawing, drawn: Drawing.Drawn, builder: Builder) -> Assembly:
        """Return the same scene with other clouds and elements, which a builder made."""
        return replace(
            self,
            drawing=drawing,
            layers=tuple(cloud.layer for cloud in drawing.clouds),
            generators=drawn.generators,
            elements=drawn.elements,
            entries={**self.entries, **builder.entries},
            built={**self.built, **builder.built},
        )

    def plane(self, samples: int) -> ScenePlane:
        """Return the plane of the scene, with so many points along each side of a pixel."""
        return ScenePlane(self.grid, samples)

    def toward(self, view: View) -> Assembly:
        """Return the same scene in orthographic view from another direction, with the air of its place."""
        air = self.air_over_field.of(view)
        sea, kelvin = air.sea_or(self.sea, self.sea_temperature_K)
        toward = replace(self, slant=self.slant.toward(view), sea=sea, sea_temperature_K=kelvin)
        return replace(toward, profile=air.profile, transmittance=air.transmittance)

    def at_level(self, level: int) -> Assembly:
        """Return the same scene with the radiance model at another numerical level."""
        return replace(self, numerical_level=level)

    def hanging_from(self, top_m: float, which: int) -> Assembly:
        """Return the same scene with the clouds of one layer at another altitude."""
        layers = list(self.layers)
        layers[which] = layers[which].hanging_from(top_m)
        return replace(self, layers=tuple(layers))

    def perturbed(self, warmer_K: float, vapour_factor: float) -> Assembly:
        """Return the same scene over a warmer sea, in air with another amount of water vapour; land stays as it is."""
        warmer_K = 0.0 if self.surface is not None and self.surface.boundary is not None else warmer_K
        kelvin = self.sea_temperature_K + warmer_K
        sea = self.sea_of(kelvin) if warmer_K else self.sea
        return replace(self, sea=sea, sea_temperature_K=kelvin, vapour_factor=vapour_factor)

    def with_finer_sunlight(self, steps: int) -> Assembly:
        """Return the same scene with sunlight some levels finer than all else, also at other levels."""
        return replace(self, sunlight_steps=steps)

    def over_sea(self, sea: SeaModel) -> Assembly:
        """Return the same scene over another sea of the same temperature."""
        return replace(self, sea=sea)

    def on_grid(self, refinement: int) -> Assembly:
        """Return the same scene on a spectral grid with another refinement."""
        return replace(self, spectral_grid=self.refined_grid(refinement)) if refinement else self

    def refined_grid(self, refinement: int) -> SpectralGrid:
        """Return the spectral grid with another refinement."""
        return SpectralGrid.dense(self.bands, self.transmittance.declares.native_grid_cm1, refinement)

    def over(self, state: SurfaceState) -> Assembly:
        """Return the same scene with one surface everywhere."""
        kelvin = state.temperature_K
        if state.boundary is None and kelvin == self.sea_temperature_K:
            return self
        sea = self.sea_of(kelvin) if state.boundary is None else state.boundary
        return replace(self, sea=sea, sea_temperature_K=kelvin, surface=state)

    @property
    def _of_radiance(self) -> list[Declaration]:
        return [self.transmittance.declares, self.sea.declares, self.model.declares]

    @property
    def _of_additions(self) -> list[Declaration]:
        """Declarations of elements, derived variables and surfaces."""
        providers: list[Any] = [*self.elements, *self.derived]
        for surfaces in self.surfaces:
            boundaries = (class_.boundary for class_ in surfaces.classes)
            providers += [surfaces.provider, *(boundary for boundary in boundaries if boundary is not None)]
        return [provider.declares for provider in providers]

    def notes(
        self, *, air: bool = True, particles: bool = True, radiance: bool = True, sunlight: bool = True
    ) -> tuple[str, ...]:
        """Notes on the limits of the providers that a scene uses; notes on a material only if a layer is made of it.

        Parameters
        ----------
        air, particles, radiance, sunlight : bool
            Whether temperatures of the air, optical properties of clouds, radiance and sunlight are computed.
        """
        notes: list[str] = [*(self.profile.notes if air or radiance else ())]
        for generator in self.generators:
            notes += generator.declares.notes
        notes += self.cloud_notes
        if particles:
            for optics, layer in zip(self.optics_of_layers, self.layers, strict=True):
                notes += optics.declares.notes
                notes += optics.declares.notes_by_material.get(layer.microphysics.material, ())
        for declares in (*(self._of_radiance if radiance else ()), *self._of_additions):
            notes += declares.notes
        notes += self.slant.notes if self.layers else ()
        return applying(notes, sunlight, {band.name: (band.lower_um, band.upper_um) for band in self.bands})

    @property
    def unresolved_bands(self) -> tuple[str, ...]:
        """Warnings about bands that are narrower than the spectral resolution of the atmosphere."""
        resolution, name = self.transmittance.declares.resolution_cm1, self.entries["atmosphere"].name
        return tuple(
            f"band '{band.name}' is {band.width_cm1:.3g} cm-1 wide, but the atmosphere '{name}' knows means over "
            f"{resolution:g} cm-1: lines within it are not resolved, whatever the accuracy"
            for band in self.bands
            if band.width_cm1 < resolution
        )

    @property
    def own_errors(self) -> tuple[str, ...]:
        """Provider-stated accuracy."""
        declarations: list[Declaration] = [generator.declares for generator in self.generators]
        declarations += [optics_of_layer.declares for optics_of_layer in self.optics_of_layers]
        declarations += [*self._of_radiance, *self._of_additions]
        return tuple(dict.fromkeys(error for declares in declarations for error in declares.own_errors))

    @property
    def cloudy_layers(self) -> tuple[bool, ...]:
        """Whether any pixel can have cloud, for each layer; coverage from an image overrides a coverage of 0."""
        return tuple(
            layer.coverage > 0.0 or from_image for layer, from_image in zip(self.layers, self.from_images, strict=True)
        )

    @property
    def from_images(self) -> tuple[bool, ...]:
        """Whether the clouds of each layer are those of an image, which decides their coverage."""
        return tuple(getattr(generator, "image_coverage", None) is not None for generator in self.generators)

    @property
    def hanging_layers(self) -> tuple[int, ...]:
        """Layers whose generators give tops of their own, rather than those of the layer."""
        ranges = [getattr(generator, "cloud_top_range_m", None) for generator in self.generators]
        return tuple(index for index, of_layer in enumerate(ranges) if of_layer is not None)

    @property
    def tops_vary(self) -> bool:
        """Whether there are such layers."""
        return bool(self.hanging_layers)

    @property
    def met_heights_m(self) -> tuple[tuple[float, ...], ...]:
        """Altitudes between which lines of sight meet each layer: that of its flat side, or all where tops vary."""
        spans = map(spanning, self.layers, self.generators)
        return tuple(
            (layer.reference_height_m,) if span is layer else (span.base_m, span.top_m)
            for layer, span in zip(self.layers, spans, strict=True)
        )

    @property
    def highest_met_m(self) -> float:
        """Highest altitude at which lines of sight meet a layer."""
        return max(max(of_layer) for of_layer in self.met_heights_m)

    @property
    def has_cloud(self) -> bool:
        """Whether any pixel can be cloudy."""
        return any(self.cloudy_layers)

    @property
    def has_clear_sky(self) -> bool:
        """Whether any pixel can be clear; full coverage leaves no gap, as the conformance kit checks."""
        return not any(
            layer.coverage == 1.0 and not from_image
            for layer, from_image in zip(self.layers, self.from_images, strict=True)
        )

    @property
    def extreme_thicknesses_m(self) -> Array:
        """Columns (N, L) with combinations of no, thinnest and thickest cloud per layer, except clear sky.

        Of more than two layers these are each layer alone, each two of them, and all.
        """
        choices = [
            (0.0, layer.thickness_min_m, layer.thickness_max_m) if cloudy else (0.0,)
            for layer, cloudy in zip(self.layers, self.cloudy_layers, strict=True)
        ]
        columns = [
            column for column in product(*choices) if 0 < np.count_nonzero(column) <= 2 or _same(column, choices)
        ]
        return np.array(columns, dtype=np.float64).reshape(len(columns), len(self.layers))


def _same(column: Sequence[float], choices: Sequence[Sequence[float]]) -> bool:
    """Whether all layers that can have cloud have their thinnest, or all their thickest one."""
    return any(
        tuple(column) == tuple(of_layer[min(which, len(of_layer) - 1)] for of_layer in choices) for which in (1, 2)
    )
