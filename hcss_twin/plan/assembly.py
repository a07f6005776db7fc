"""Construction of the providers of a scenario and of the radiance model that uses them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import product
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.parameters import COEFFICIENTS
from hcss_twin.models.radiance.spectral_grid import SolarSpectrum, SpectralBand, SpectralGrid, dense_grid
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import Profile
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.plan.builder import Builder, Built, attribute_to_field
from hcss_twin.plan.clouds import assemble_clouds
from hcss_twin.plan.lines_of_sight import lines_of_sight
from hcss_twin.plan.optics import default_optics, particle_optics
from hcss_twin.plan.slant_paths import SlantPaths
from hcss_twin.plan.surroundings import FilledIn, Surroundings, surroundings
from hcss_twin.providers import (
    AtmosphereDeclaration,
    AtmosphereInputs,
    CloudGenerator,
    CloudLayer,
    Declaration,
    ElementInputs,
    ElementProvider,
    Grid,
    Motion,
    Optics,
    RadianceInputs,
    RadianceModel,
    SeaInputs,
    SeaModel,
    SensorBand,
    TransmittanceProvider,
    VariableInputs,
    VariableProvider,
    View,
)
from hcss_twin.providers.declarations import applying
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.bands import spectral_band
from hcss_twin.scenario.models import selected
from hcss_twin.scenario.scenario import Scenario

if TYPE_CHECKING:
    from hcss_twin.plan.surface_classes import SceneSurfaces, SurfaceState

MODELS = 8
"""Radiance models of one scene that are kept."""

PLACEHOLDER_SEA_K, PLACEHOLDER_WIND_M_S = 290.0, 5.0
"""Stand-in for missing surroundings: the sea is built only for its checks, because the scene is rejected anyway."""


@dataclass(frozen=True)
class Assembly:
    """The guarded providers of one scene, and their common inputs.

    Attributes
    ----------
    entries : mapping of str to Entry
        Registry entry of each provider, by kind; generators and optics of several layers are numbered.
    particle_fields, optics_fields : tuple of str (L,)
        Scenario fields that define the particles of each layer, and their optics.
    optics_of_layers : tuple of Optics (L,)
        The provider of each layer; ``optics`` asks the right one for any particles.
    model_of : callable
        Builds the radiance model of the same scene for another sea, view, sea temperature or numerical level.
    sea_of : callable
        Builds the sea model for another temperature.
    built : mapping of str to Built
        How each provider was made, by the same labels as ``entries``.
    code : mapping of str to (str, str, str)
        Name, version and fingerprint of each provider, on which cached results depend.
    lines_of_sight : LinesOfSight or None
        Lines of sight to the sensor; None if its altitude is unknown.
    surfaces : SceneSurfaces or None
        Map of the ground; None for sea everywhere.
    surface : SurfaceState or None
        Surface that takes the place of the scenario's sea; None for that sea.
    numerical_level : int
        That of the radiance model.
    """

    entries: Mapping[str, Entry]
    bands: tuple[SpectralBand, ...]
    spectral_grid: SpectralGrid
    profile: Profile
    grid: Grid
    motion: Motion
    layers: tuple[CloudLayer, ...]
    generators: tuple[CloudGenerator, ...]
    particle_fields: tuple[str, ...]
    optics_fields: tuple[str, ...]
    transmittance: TransmittanceProvider
    sea: SeaModel
    optics: Optics
    optics_of_layers: tuple[Optics, ...]
    model: RadianceModel
    model_of: Callable[[SeaModel, View, float, int], RadianceModel]
    sea_of: Callable[[float], SeaModel]
    solar_irradiance: SolarSpectrum
    sea_temperature_K: float
    sea_wind_speed_m_s: float
    filled_in: tuple[FilledIn, ...]
    slant: SlantPaths
    code: Mapping[str, tuple[str, str, str]]
    lines_of_sight: LinesOfSight | None = None
    elements: tuple[ElementProvider, ...] = ()
    derived: tuple[VariableProvider, ...] = ()
    surfaces: SceneSurfaces | None = None
    surface: SurfaceState | None = None
    numerical_level: int = 0
    built: Mapping[str, Built] = field(default_factory=dict)

    @property
    def view(self) -> View:
        """Viewing direction."""
        return self.slant.view

    def model_over(self, sea: SeaModel) -> RadianceModel:
        """Return the radiance model of the same scene over another sea."""
        return self.model_of(sea, self.view, self.sea_temperature_K, self.numerical_level)

    def model_toward(self, view: View) -> RadianceModel:
        """Return the radiance model of the same scene for another view."""
        return self.model_of(self.sea, view, self.sea_temperature_K, self.numerical_level)

    def toward(self, view: View) -> Assembly:
        """Return the same scene in orthographic view from another direction."""
        return replace(self, slant=replace(self.slant, view=view), model=self.model_toward(view))

    def at_level(self, level: int) -> Assembly:
        """Return the same scene with the radiance model at another numerical level."""
        if level == self.numerical_level:
            return self
        model = self.model_of(self.sea, self.view, self.sea_temperature_K, level)
        return replace(self, model=model, numerical_level=level)

    def on_grid(self, refinement: int) -> Assembly:
        """Return the same scene on a spectral grid with another refinement."""
        return replace(self, spectral_grid=self.refined_grid(refinement)) if refinement else self

    def refined_grid(self, refinement: int) -> SpectralGrid:
        """Return the spectral grid with another refinement."""
        return dense_grid(self.bands, self.transmittance.declares.native_grid_cm1, refinement)

    def over(self, state: SurfaceState) -> Assembly:
        """Return the same scene with one surface everywhere."""
        kelvin = state.temperature_K
        if state.boundary is None and kelvin == self.sea_temperature_K:
            return self
        sea = self.sea_of(kelvin) if state.boundary is None else state.boundary
        model = self.model_of(sea, self.view, kelvin, self.numerical_level)
        return replace(self, sea=sea, sea_temperature_K=kelvin, model=model, surface=state)

    def notes(
        self, *, air: bool = True, particles: bool = True, radiance: bool = True, sunlight: bool = True
    ) -> tuple[str, ...]:
        """Notes on the limits of the providers that a scene uses; notes on a material only if a layer is made of it.

        Parameters
        ----------
        air, particles, radiance, sunlight : bool
            Whether temperatures of the air, optical properties of clouds, radiance and sunlight are computed.
        """
        own: list[Declaration] = []
        if radiance:
            own = [self.transmittance.declares, self.sea.declares, self.model.declares]
        own += [*(each.declares for each in self.elements), *(each.declares for each in self.derived)]
        if self.surfaces is not None:
            own.append(self.surfaces.provider.declares)
            own += [each.boundary.declares for each in self.surfaces.classes if each.boundary is not None]
        notes: list[str] = [*(self.profile.notes if air or radiance else ())]
        for generator in self.generators:
            notes += generator.declares.notes
        if particles:
            for optics, layer in zip(self.optics_of_layers, self.layers, strict=True):
                notes += optics.declares.notes
                notes += optics.declares.notes_by_material.get(layer.microphysics.material, ())
        for declares in own:
            notes += declares.notes
        notes += self.slant.notes if self.layers else ()
        return applying(notes, sunlight, min(band.lower_um for band in self.bands))

    @property
    def own_errors(self) -> tuple[str, ...]:
        """Provider-stated accuracy."""
        declarations: list[Declaration] = [each.declares for each in self.generators]
        declarations += [each.declares for each in self.optics_of_layers]
        declarations += [self.transmittance.declares, self.sea.declares, self.model.declares]
        declarations += [*(each.declares for each in self.elements), *(each.declares for each in self.derived)]
        if self.surfaces is not None:
            declarations.append(self.surfaces.provider.declares)
            declarations += [each.boundary.declares for each in self.surfaces.classes if each.boundary is not None]
        return tuple(dict.fromkeys(error for declares in declarations for error in declares.own_errors))

    @property
    def cloudy_layers(self) -> tuple[bool, ...]:
        """Whether any pixel can have cloud, for each layer; coverage from an image overrides a coverage of 0."""
        return tuple(
            layer.coverage > 0.0 or getattr(generator, "image_coverage", None) is not None
            for layer, generator in zip(self.layers, self.generators, strict=True)
        )

    @property
    def has_cloud(self) -> bool:
        """Whether any pixel can be cloudy."""
        return any(self.cloudy_layers)

    @property
    def has_clear_sky(self) -> bool:
        """Whether any pixel can be clear; full coverage leaves no gap, as the conformance kit checks."""
        return not any(
            layer.coverage == 1.0 and getattr(generator, "image_coverage", None) is None
            for layer, generator in zip(self.layers, self.generators, strict=True)
        )

    @property
    def extreme_thicknesses_m(self) -> Array:
        """Columns (N, L) with every combination of no, thinnest and thickest cloud per layer, except clear sky."""
        choices = [
            (0.0, layer.thickness_min_m, layer.thickness_max_m) if cloudy else (0.0,)
            for layer, cloudy in zip(self.layers, self.cloudy_layers, strict=True)
        ]
        columns = [each for each in product(*choices) if any(each)]
        return np.array(columns, dtype=np.float64).reshape(len(columns), len(self.layers))


def assemble(scenario: Scenario, catalog: Catalog, slant: SlantPaths) -> Assembly:
    """Build all providers of a scenario, with clouds over the whole area of its slant paths.

    Raises
    ------
    ScenarioError
        With every value that is inconsistent with the selected data or provider.
    """
    builder = Builder(catalog.shelf.get_or_compute("registry", Registry.discover))
    sight: LinesOfSight | None = None
    with builder.collect_problems("platform.altitude"):
        sight = lines_of_sight(scenario)
    bands = _bands(builder, scenario, catalog)
    around, transmittance = _atmosphere(builder, scenario, catalog, bands)
    sea = _sea(builder, scenario, catalog, bands, around)
    optics = default_optics(builder, scenario, catalog)
    sea_of = partial(_sea_model, builder, scenario, catalog, around)
    grid = Grid(scenario.image.rows, scenario.image.columns, scenario.image.pixel_size)
    motion = _motion(scenario)
    clouds = assemble_clouds(builder, scenario, catalog, grid, motion, around, slant)
    particles = particle_optics(builder, scenario, catalog, clouds, optics)
    for each, name in {} if particles is None else particles.names.items():
        with builder.collect_problems("bands"):
            _require_bands_inside(bands, each.declares.valid, f"optics provider '{name}'")
    builder.raise_problems()
    if around is None or transmittance is None or sea is None or particles is None:
        raise AssertionError("a provider is missing, and no problem was collected")
    layers = tuple(each.layer for each in clouds)
    spectral_grid = dense_grid(bands, transmittance.declares.native_grid_cm1)
    elements = _elements(builder, scenario, catalog, sensor_bands(bands), grid, slant.view, spectral_grid)
    derived = _derived(builder, scenario, catalog, sensor_bands(bands), grid, slant.view)
    surfaces = None if scenario.surfaces is None else _surfaces(builder, scenario, catalog, bands, around, grid)
    builder.raise_problems()
    solar_irradiance = SolarSpectrum(catalog)

    inputs = RadianceInputs(
        profile=around.profile,
        transmittance=transmittance,
        sea=sea,
        optics=particles.optics,
        layers=layers,
        sea_temperature_K=around.sea_temperature_K,
        view=slant.view,
        solar_irradiance=solar_irradiance,
        wind_from_deg=scenario.sea.wind_from,
    )
    radiance = scenario.radiance

    def new_model(sea: SeaModel, view: View, sea_temperature_K: float, level: int) -> RadianceModel:
        other = replace(inputs, sea=sea, view=view, sea_temperature_K=sea_temperature_K, numerical_level=level)
        chosen = selected(radiance, "model")
        model: RadianceModel = builder.build(Kind.RADIANCE, chosen, other, radiance.parameters)
        return model

    # The same model serves the tables and the certificate, which share its solutions.
    model_of = cast(Callable[[SeaModel, View, float, int], RadianceModel], lru_cache(maxsize=MODELS)(new_model))
    with attribute_to_field("radiance.model", radiance.parameters):
        model = model_of(sea, slant.view, around.sea_temperature_K, 0)
    return Assembly(
        entries=builder.entries,
        bands=tuple(bands),
        spectral_grid=spectral_grid,
        profile=around.profile,
        grid=grid,
        motion=motion,
        layers=layers,
        generators=tuple(each.generator for each in clouds),
        particle_fields=tuple(each.particle_field for each in clouds),
        optics_fields=particles.fields,
        transmittance=transmittance,
        sea=sea,
        optics=particles.optics,
        optics_of_layers=particles.of_layers,
        model=model,
        model_of=model_of,
        sea_of=sea_of,
        solar_irradiance=solar_irradiance,
        sea_temperature_K=around.sea_temperature_K,
        sea_wind_speed_m_s=around.sea_wind_speed_m_s,
        filled_in=around.filled_in,
        slant=slant,
        code={
            name: (entry.qualified_name, entry.version, catalog.shelf.fingerprint(entry.spec.target))
            for name, entry in builder.entries.items()
        },
        lines_of_sight=sight,
        elements=elements,
        derived=derived,
        surfaces=surfaces,
        built=builder.built,
    )


# Each of these returns None where it collects a problem, so that all problems of a scenario are found at once.


def _bands(builder: Builder, scenario: Scenario, catalog: Catalog) -> list[SpectralBand]:
    bands: list[SpectralBand] = []
    for index, band in enumerate(scenario.bands):
        with builder.collect_problems(f"bands[{index}]"):
            bands.append(spectral_band(band, catalog))
    return bands


def atmosphere_parameters(scenario: Scenario) -> dict[str, Any]:
    """Return the parameters of the atmosphere provider, with the file of named coefficients."""
    named = scenario.coefficients
    file = {} if named is None else {"file": COEFFICIENTS[named]}
    return {**scenario.atmosphere.parameters, **file}


def _atmosphere(
    builder: Builder, scenario: Scenario, catalog: Catalog, bands: list[SpectralBand]
) -> tuple[Surroundings | None, TransmittanceProvider | None]:
    around: Surroundings | None = None
    transmittance: TransmittanceProvider | None = None
    atmosphere = scenario.atmosphere
    with builder.collect_problems("atmosphere.provider", atmosphere.parameters):
        name = selected(atmosphere, "provider")
        parameters = atmosphere_parameters(scenario)
        around = surroundings(scenario, catalog, builder.bound_profile(name, parameters, catalog))
        inputs = AtmosphereInputs(around.profile, catalog)
        transmittance = builder.build(Kind.ATMOSPHERE, name, inputs, parameters)
        owner = f"atmosphere provider '{name}'"
        _require_bands_inside(bands, transmittance.declares.valid, owner)
        _require_view_inside(scenario, transmittance.declares, owner)
    return around, transmittance


def _sea(
    builder: Builder, scenario: Scenario, catalog: Catalog, bands: list[SpectralBand], around: Surroundings | None
) -> SeaModel | None:
    # The sea is built even if the surroundings have problems, to find its own problems.
    temperature = PLACEHOLDER_SEA_K if around is None else around.sea_temperature_K
    sea: SeaModel | None = None
    with builder.collect_problems("sea.model", scenario.sea.parameters):
        sea = _sea_model(builder, scenario, catalog, around, temperature)
        _require_bands_inside(bands, sea.declares.valid, f"sea model '{selected(scenario.sea, 'model')}'")
    return sea


def _sea_model(
    builder: Builder, scenario: Scenario, catalog: Catalog, around: Surroundings | None, temperature_K: float
) -> SeaModel:
    wind = PLACEHOLDER_WIND_M_S if around is None else around.sea_wind_speed_m_s
    inputs = SeaInputs(wind, scenario.sea.wind_from, temperature_K, catalog)
    sea: SeaModel = builder.build(Kind.SEA, selected(scenario.sea, "model"), inputs, scenario.sea.parameters)
    return sea


def _surfaces(
    builder: Builder, scenario: Scenario, catalog: Catalog, bands: list[SpectralBand], around: Surroundings, grid: Grid
) -> SceneSurfaces | None:
    from hcss_twin.plan.surface_classes import build_surfaces  # not for scenes of sea alone

    assert scenario.surfaces is not None
    surfaces: SceneSurfaces | None = None
    with builder.collect_problems("surfaces.provider", scenario.surfaces.parameters):
        surfaces = build_surfaces(builder, scenario, catalog, around, grid)
        for each in surfaces.classes:
            if each.boundary is not None:
                _require_bands_inside(bands, each.boundary.declares.valid, f"surface class '{each.name}'")
    return surfaces


def _elements(
    builder: Builder,
    scenario: Scenario,
    catalog: Catalog,
    bands: tuple[SensorBand, ...],
    grid: Grid,
    view: View,
    spectrum: SpectralGrid,
) -> tuple[ElementProvider, ...]:
    def black_body(temperature_K: float) -> Array:
        radiance: Array = np.sum(spectrum.weights_cm1 * planck(spectrum.wavenumber_cm1, temperature_K), axis=1)
        return radiance

    elements: list[ElementProvider] = []
    place = scenario.place
    inputs = ElementInputs(bands, grid, view, black_body, catalog, place.latitude, place.longitude)
    for index, section in enumerate(scenario.elements):
        name = selected(section, "provider")
        with builder.collect_problems(f"elements[{index}].provider", section.parameters):
            label = str(Kind.ELEMENTS) if len(scenario.elements) == 1 else f"{Kind.ELEMENTS}[{index}]"
            try:
                elements.append(builder.build(Kind.ELEMENTS, name, inputs, section.parameters, label))
            except ScenarioError as error:  # of the provider, which does not know the place of its section
                own = f"elements[{index}].parameters"
                raise ScenarioError(
                    [Problem(f"{own}.{each.field}", each.message) for each in error.problems]
                ) from error
    return tuple(elements)


def derived_label(index: int, count: int) -> str:
    """Return the name of a variable provider in the plan and the cube."""
    return str(Kind.VARIABLES) if count == 1 else f"{Kind.VARIABLES}[{index}]"


def _derived(
    builder: Builder, scenario: Scenario, catalog: Catalog, bands: tuple[SensorBand, ...], grid: Grid, view: View
) -> tuple[VariableProvider, ...]:
    sections, derived = scenario.output.derived, list[VariableProvider]()
    for index, section in enumerate(sections):
        with builder.collect_problems(f"output.derived[{index}].provider", section.parameters):
            inputs, label = VariableInputs(bands, grid, view, catalog), derived_label(index, len(sections))
            derived.append(builder.build(Kind.VARIABLES, section.provider, inputs, section.parameters, label))
    return tuple(derived)


def sensor_bands(bands: Sequence[SpectralBand]) -> tuple[SensorBand, ...]:
    """Return the bands in the form of the provider API."""
    return tuple(SensorBand(band.name, band.wavelength_um, band.response) for band in bands)


def _motion(scenario: Scenario) -> Motion:
    motion = scenario.motion
    # Wind direction is where the wind comes from; x points east and y north.
    bearing = math.radians(motion.wind_from + 180.0)
    velocity = (motion.wind_speed * math.sin(bearing), motion.wind_speed * math.cos(bearing))
    evolution = math.inf if motion.evolution_time == "frozen" else float(motion.evolution_time)
    return Motion(float(motion.platform_speed), velocity, evolution, scenario.frames.interval)


def _require_bands_inside(bands: list[SpectralBand], ranges: Mapping[str, tuple[float, float]], owner: str) -> None:
    valid = ranges.get("wavenumber_cm1")
    if valid is None:
        return
    shortest, longest = 1e4 / valid[1], 1e4 / valid[0]
    # Wavelength limits computed from round wavenumbers do not convert back exactly.
    slack = 1e-9
    problems = [
        Problem(
            f"bands[{index}]",
            f"'{band.name}', {band.lower_um:g} to {band.upper_um:g} um, is outside what the {owner} "
            f"covers; allowed: {shortest:.5g} to {longest:.5g} um",
        )
        for index, band in enumerate(bands)
        if band.lower_um < shortest * (1 - slack) or band.upper_um > longest * (1 + slack)
    ]
    if problems:
        raise ScenarioError(problems)


def _require_view_inside(scenario: Scenario, declares: AtmosphereDeclaration, owner: str) -> None:
    valid = declares.valid.get("view_zenith")
    if valid is not None and not valid[0] <= scenario.view.zenith <= valid[1]:
        low, high = valid
        raise ScenarioError(
            [
                Problem(
                    "view.zenith",
                    f"{scenario.view.zenith:g} deg; the {owner} allows {low:g} to {high:g}; "
                    f"closest valid choice is {min(max(scenario.view.zenith, low), high):g}",
                )
            ]
        )
