"""Construction of all providers of a scenario, and of the radiance model that uses them."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.gases import with_factors
from hcss_twin.models.radiance.spectral_grid import SolarSpectrum, SpectralBand, SpectralGrid
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.plan.air_over_field import AirOverField, Climate
from hcss_twin.plan.assemble_air import (
    AIRS,
    air_with_provider,
    build_air_over_field,
    build_atmosphere,
    require_bands_inside,
)
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.brightness_inversion import LayerBrightness
from hcss_twin.plan.builder import Builder, attribute_to_field, build_derived
from hcss_twin.plan.clouds import assemble_layers, build_generators, wind_velocity_m_s
from hcss_twin.plan.drawing import Drawing
from hcss_twin.plan.lines_of_sight import lines_of_sight
from hcss_twin.plan.optics import default_optics, particle_optics
from hcss_twin.plan.slant_paths import GridSight, SlantPaths
from hcss_twin.plan.surroundings import Surroundings, surroundings
from hcss_twin.providers import ColumnSetting, Grid, Motion, RadianceInputs, RadianceModel, SeaInputs, SeaModel, View
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.bands import sensor_bands, spectral_band
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.section_types import selected

if TYPE_CHECKING:
    from hcss_twin.plan.scene_family import SceneFamily
    from hcss_twin.plan.surface_classes import SceneSurfaces

MODELS = 8
"""Radiance models of one scene that are kept, one for each numerical level."""

CELL_LIFETIME_S_PER_M = 0.33
"""Time cell of a lattice per size of its cells, with which bands of 8 to 96 km wavelength have the coherence after 15
to 45 min, within 0.15, of 10.8 um images of clouds over sea from a geostationary orbit: near exp(-t / 2 min per km)."""

BY_SCALE_S = 1800.0
"""Evolution time, with lifetimes by scale, for generators without them."""

PLACEHOLDER_SEA_K, PLACEHOLDER_WIND_M_S = 290.0, 5.0
"""Stand-in for missing surroundings: the sea is built only for its checks, because the scene is rejected anyway."""


def assemble(
    scenario: Scenario,
    catalog: Catalog,
    slant: SlantPaths,
    climate: Climate | None = None,
    family: SceneFamily | None = None,
    image: Grid | None = None,
) -> Assembly:
    """Build all providers of a scenario, with clouds over the whole area of its slant paths.

    Parameters
    ----------
    climate : Climate, optional
        Of rays whose places have air and sea of their own.
    family : SceneFamily, optional
        Of scenes that share columns.
    image : Grid, optional
        Of rays that form no grid on the ground.

    Raises
    ------
    ScenarioError
        With every value that is inconsistent with the selected data or provider.
    """
    registry = catalog.shelf.get_or_compute("registry", Registry.discover)
    builder = Builder(registry, scenario)
    # Models have a builder of their own, because clouds, which the other one records, may refer to them: a cycle would
    # keep all arrays of the models in memory until the garbage collector runs.
    of_models = Builder(registry, scenario)
    sight: LinesOfSight | None = None
    with builder.collect_problems("platform.altitude"):
        sight = lines_of_sight(scenario)
    bands = _bands(builder, scenario, catalog)
    around, transmittance = build_atmosphere(builder, scenario, catalog, bands)
    sea = _sea(builder, scenario, catalog, bands, around)
    optics = default_optics(builder, scenario, catalog)
    sea_of = partial(_sea_model, builder, scenario, catalog, around)
    grid = Grid(scenario.image.rows, scenario.image.columns, scenario.image.pixel_size)
    if sight is not None:
        slant = replace(slant, sight=GridSight(sight, grid))
    motion = _motion(scenario)
    clouds = assemble_layers(builder, scenario, catalog, around)
    particles = particle_optics(builder, scenario, catalog, clouds, optics)
    for provider, name in {} if particles is None else particles.names.items():
        with builder.collect_problems("bands"):
            require_bands_inside(bands, provider.declares.valid, f"optics provider '{name}'")
    if builder.has_problems:
        # for their problems
        build_generators(builder, scenario, catalog, clouds, motion, slant, [None] * len(clouds))
        builder.raise_problems()
    if around is None or transmittance is None or sea is None or particles is None:
        raise AssertionError("a provider is missing, and no problem was collected")
    layers = tuple(cloud.layer for cloud in clouds)
    solar_irradiance = SolarSpectrum(catalog)
    with attribute_to_field("atmosphere.profile"):
        over_field = build_air_over_field(builder, scenario, catalog, around, transmittance)
    setting = ColumnSetting(
        view=slant.view,
        sun=None,
        sea=sea,
        sea_temperature_K=around.sea_temperature_K,
        profile=around.profile,
        transmittance=transmittance,
        layers=layers,
        air_memory=over_field.of(slant.view).memory,
    )
    inputs = RadianceInputs(
        setting, particles.optics, solar_irradiance, scenario.sea.wind_from, memory=catalog.shelf.arrays
    )
    if climate is not None:
        air_of_place = partial(air_with_provider, builder, scenario, catalog, around)
        over_field = climate(lambda profile: air_of_place(around.finished(profile)), sea_of)

    @lru_cache(maxsize=AIRS)
    def moister(air: AirOverField.Air, factor: float) -> AirOverField.Air:
        profile = with_factors(air.profile, {"h2o": factor})
        moist = air_with_provider(of_models, scenario, catalog, around, profile)
        return replace(air, profile=profile, transmittance=moist.transmittance, memory=None)

    def air_of(view: View, vapour_factor: float) -> AirOverField.Air:
        air = over_field.of(view)
        return air if vapour_factor == 1.0 else moister(air, vapour_factor)

    @lru_cache(maxsize=MODELS)
    def model_at(level: int, sunlight_steps: int) -> RadianceModel:
        of_level = replace(inputs, numerical_level=level, sunlight_steps=sunlight_steps)
        model: RadianceModel = of_models.build(
            Kind.RADIANCE, selected(radiance, "model"), of_level, radiance.parameters
        )
        if family is None:
            return model
        sea_of_model = partial(_sea_model, of_models, scenario, catalog, around)  # as above: no cycle
        return family.sharing(model, (level, sunlight_steps), setting, sea_of_model)

    def climate_at(latitude_deg: float, longitude_deg: float) -> AirOverField.Air:
        place = scenario.place.model_copy(update={"latitude": latitude_deg, "longitude": longitude_deg})
        there = surroundings(scenario.model_copy(update={"place": place}), catalog, None)
        air = air_with_provider(of_models, scenario, catalog, there, there.profile)
        kelvin = there.sea_temperature_K
        return replace(air, sea=_sea_model(of_models, scenario, catalog, around, kelvin), sea_temperature_K=kelvin)

    given = scenario.atmosphere.profile is not None and scenario.sea.temperature is not None
    by_place = climate is None and not (over_field.varies or around.is_bound or given)
    radiance = scenario.radiance
    inversions = [LayerBrightness(model_at, setting, index) for index in range(len(layers))]
    spectral_grid = SpectralGrid.dense(bands, transmittance.declares.native_grid_cm1)
    drawing = Drawing(clouds, motion, slant, inversions, bands, grid, spectral_grid)
    drawn = drawing.drawn(builder, scenario, catalog)
    slant = drawn.slant
    derived = build_derived(builder, scenario, catalog, sensor_bands(bands), image or grid, slant.view)
    surfaces = _surfaces(builder, scenario, catalog, bands, around, grid)
    builder.raise_problems()
    with attribute_to_field("radiance.model", radiance.parameters):
        model_at(0, 0)
    label = str(Kind.RADIANCE)
    entries = builder.entries | {label: of_models.entries[label]}
    built = builder.built | {label: of_models.built[label]}
    return Assembly(
        entries=entries,
        bands=tuple(bands),
        spectral_grid=spectral_grid,
        profile=around.profile,
        grid=grid,
        samples_per_pixel=scenario.image.samples_per_pixel,
        motion=motion,
        layers=layers,
        generators=drawn.generators,
        particle_fields=tuple(cloud.particle_field for cloud in clouds),
        optics_fields=particles.fields,
        transmittance=transmittance,
        sea=sea,
        optics=particles.optics,
        optics_of_layers=particles.of_layers,
        model_at=model_at,
        air_of=air_of,
        sea_of=sea_of,
        solar_irradiance=solar_irradiance,
        sea_temperature_K=around.sea_temperature_K,
        sea_wind_speed_m_s=around.sea_wind_speed_m_s,
        cloud_notes=tuple(note for cloud in clouds for note in cloud.notes),
        filled_in=(*around.filled_in, *(item for cloud in clouds for item in cloud.filled_in)),
        slant=slant,
        code={name: one.code(catalog.shelf) for name, one in built.items()},
        lines_of_sight=sight,
        elements=drawn.elements,
        derived=derived,
        surfaces=surfaces,
        air_over_field=over_field,
        drawing=drawing,
        family=family,
        built=built,
        has_bound_air=around.is_bound,
        climate_at=climate_at if by_place else None,
    )


# Each of these returns None where it collects a problem, so that all problems of a scenario are found at once.


def _bands(builder: Builder, scenario: Scenario, catalog: Catalog) -> list[SpectralBand]:
    bands: list[SpectralBand] = []
    for index, band in enumerate(scenario.bands):
        with builder.collect_problems(f"bands[{index}]"):
            bands.append(spectral_band(band, catalog))
    return bands


def _sea(
    builder: Builder, scenario: Scenario, catalog: Catalog, bands: list[SpectralBand], around: Surroundings | None
) -> SeaModel | None:
    # The sea is built even if the surroundings have problems, to find its own problems.
    temperature = PLACEHOLDER_SEA_K if around is None else around.sea_temperature_K
    sea: SeaModel | None = None
    with builder.collect_problems("sea.model", scenario.sea.parameters):
        sea = _sea_model(builder, scenario, catalog, around, temperature)
        require_bands_inside(bands, sea.declares.valid, f"sea model '{selected(scenario.sea, 'model')}'")
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
) -> tuple[SceneSurfaces, ...]:
    section, found = scenario.surfaces, []
    if section is None:
        return ()
    from hcss_twin.plan.surface_classes import build_surfaces  # not for scenes of sea alone

    with builder.collect_problems("surfaces.provider", section.parameters):
        surfaces = build_surfaces(builder, scenario, section, catalog, around, grid)
        for class_ in surfaces.classes:
            if class_.boundary is not None:
                require_bands_inside(bands, class_.boundary.declares.valid, f"surface class '{class_.name}'")
        found.append(surfaces)
    return tuple(found)


def _motion(scenario: Scenario) -> Motion:
    motion = scenario.motion
    evolution, lifetime = motion.evolution_time, None
    if evolution == "by-scale":
        evolution, lifetime = BY_SCALE_S, CELL_LIFETIME_S_PER_M
    seconds = math.inf if evolution == "frozen" else float(evolution)
    velocity = wind_velocity_m_s(motion.wind_speed, motion.wind_from)
    return Motion(float(motion.platform_speed), velocity, seconds, scenario.frames.interval, lifetime)
