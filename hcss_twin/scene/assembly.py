"""Build the providers a scenario names and hand them to the radiance model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hcss_twin.atmosphere.profile import Profile
from hcss_twin.catalog import Catalog
from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.providers import (
    AtmosphereInputs,
    CloudGenerator,
    CloudInputs,
    CloudLayer,
    Declares,
    Grid,
    Motion,
    Optics,
    OpticsInputs,
    RadianceInputs,
    RadianceModel,
    SeaInputs,
    SeaModel,
    TransmittanceProvider,
    View,
)
from hcss_twin.radiance.solar_spectrum import SolarSpectrum
from hcss_twin.radiance.spectral_band import SpectralBand
from hcss_twin.radiance.spectral_grid import SpectralGrid, dense_grid
from hcss_twin.registry.discovery import Entry
from hcss_twin.registry.guard import guard
from hcss_twin.registry.kinds import Kind
from hcss_twin.registry.registry import Registry
from hcss_twin.scenario.bands import spectral_band
from hcss_twin.scenario.cloud_types import resolve_layer
from hcss_twin.scenario.models import selected
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scene.blame import blamed_on
from hcss_twin.scene.surroundings import FilledIn, surroundings


@dataclass(frozen=True)
class Assembly:
    """The providers of one scene, built and guarded, and the states they share."""

    entries: Mapping[str, Entry]
    bands: tuple[SpectralBand, ...]
    spectral_grid: SpectralGrid
    profile: Profile
    view: View
    grid: Grid
    motion: Motion
    layers: tuple[CloudLayer, ...]
    generators: tuple[CloudGenerator, ...]
    transmittance: TransmittanceProvider
    sea: SeaModel
    optics: Optics
    model: RadianceModel
    sea_temperature_K: float
    filled_in: tuple[FilledIn, ...]

    @property
    def declarations(self) -> tuple[Declares, ...]:
        """What each provider declares."""
        clouds = (*(generator.declares for generator in self.generators), self.optics.declares)
        return (
            *(clouds if self.generators else ()),
            self.transmittance.declares,
            self.sea.declares,
            self.model.declares,
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """What users should know about profile and providers, in order, each once."""
        notes = (note for declares in self.declarations for note in declares.notes)
        return tuple(dict.fromkeys((*self.profile.notes, *notes)))

    @property
    def coverage_is_exact(self) -> bool:
        """Whether the generator makes exactly the coverage asked for."""
        return all(getattr(generator, "image_coverage", None) is None for generator in self.generators)


def assemble(scenario: Scenario, catalog: Catalog) -> Assembly:
    """Build every provider of a scenario.

    Raises
    ------
    ScenarioError
        If a value does not fit the data or provider it selects.
    ProviderError
        If a provider is broken.
    """
    builder = _Builder(Registry.discover())
    provider = selected(scenario.atmosphere, "provider")
    with blamed_on("atmosphere.provider"):
        bound = builder.bound_profile(provider, scenario.atmosphere.parameters, catalog)
    around = surroundings(scenario, catalog, bound)
    profile, temperature = around.profile, around.sea_temperature_K
    bands = []
    for index, band in enumerate(scenario.bands):
        with blamed_on(f"bands[{index}]"):
            bands.append(spectral_band(band, catalog))
    with blamed_on("atmosphere.provider"):
        transmittance = builder.build(
            Kind.ATMOSPHERE,
            provider,
            AtmosphereInputs(profile, catalog),
            scenario.atmosphere.parameters,
        )
    _require_bands_inside(bands, transmittance.declares, "atmosphere")
    _require_view_inside(scenario, transmittance.declares)
    with blamed_on("sea.model"):
        sea = builder.build(
            Kind.SEA,
            selected(scenario.sea, "model"),
            SeaInputs(around.sea_wind_speed_m_s, scenario.sea.wind_from, temperature, catalog),
            scenario.sea.parameters,
        )
    _require_bands_inside(bands, sea.declares, "sea")
    with blamed_on("optics.provider"):
        optics = builder.build(
            Kind.OPTICS,
            selected(scenario.optics, "provider"),
            OpticsInputs(catalog),
            scenario.optics.parameters,
        )
    if scenario.clouds.layers:
        _require_bands_inside(bands, optics.declares, "optics")
    grid = Grid(scenario.image.rows, scenario.image.columns, scenario.image.pixel_size)
    motion = _motion(scenario)
    layers, generators = [], []
    for index, section in enumerate(scenario.clouds.layers):
        field = f"clouds.layers[{index}]"
        with blamed_on(f"{field}.type"):
            resolved = resolve_layer(section, catalog, field)
        inputs = CloudInputs(resolved.layer, grid, motion, scenario.seed, catalog, resolved.type_parameters)
        with blamed_on(f"{field}.generator"):
            generators.append(
                builder.build(Kind.CLOUDS, selected(section, "generator"), inputs, section.parameters)
            )
        layers.append(resolved.layer)
    view = View(scenario.view.zenith, scenario.view.azimuth)
    radiance_inputs = RadianceInputs(
        profile=profile,
        transmittance=transmittance,
        sea=sea,
        optics=optics,
        layers=tuple(layers),
        sea_temperature_K=temperature,
        view=view,
        solar_irradiance=SolarSpectrum(catalog),
    )
    with blamed_on("radiance.model"):
        model = builder.build(
            Kind.RADIANCE, selected(scenario.radiance, "model"), radiance_inputs, scenario.radiance.parameters
        )
    return Assembly(
        entries=builder.entries,
        bands=tuple(bands),
        spectral_grid=dense_grid(bands, transmittance.declares.native_grid_cm1),
        profile=profile,
        view=view,
        grid=grid,
        motion=motion,
        layers=tuple(layers),
        generators=tuple(generators),
        transmittance=transmittance,
        sea=sea,
        optics=optics,
        model=model,
        sea_temperature_K=temperature,
        filled_in=around.filled_in,
    )


class _Builder:
    """Resolves, constructs and guards providers, and remembers which were used."""

    def __init__(self, registry: Registry) -> None:
        self._registry = registry
        self.entries: dict[str, Entry] = {}

    def build(self, kind: Kind, name: str, inputs: Any, parameters: Mapping[str, Any]) -> Any:
        entry, values = self._resolved(kind, name, parameters)
        provider = guard(entry, self._registry.create(entry, inputs, values), inputs)
        self.entries[str(kind)] = entry
        return provider

    def bound_profile(self, name: str, parameters: Mapping[str, Any], catalog: Catalog) -> Profile | None:
        entry, values = self._resolved(Kind.ATMOSPHERE, name, parameters)
        return self._registry.bound_profile(entry, values, catalog)

    def _resolved(self, kind: Kind, name: str, parameters: Mapping[str, Any]) -> tuple[Entry, Any]:
        entry = self._registry.resolve(kind, name)
        model = self._registry.parameters_model(entry)
        return entry, None if model is None else model.model_validate(dict(parameters))


def _motion(scenario: Scenario) -> Motion:
    motion = scenario.motion
    # Wind is named after where it comes from; x points east and y north.
    bearing = math.radians(motion.wind_from + 180.0)
    velocity = (motion.wind_speed * math.sin(bearing), motion.wind_speed * math.cos(bearing))
    evolution = math.inf if motion.evolution_time == "frozen" else float(motion.evolution_time)
    return Motion(motion.platform_speed, velocity, evolution, scenario.frames.interval)


def _require_bands_inside(bands: list[SpectralBand], declares: Declares, owner: str) -> None:
    valid = declares.valid.get("wavenumber_cm1")
    if valid is None:
        return
    shortest, longest = 1e4 / valid[1], 1e4 / valid[0]
    # Wavelength limits that come from round wavenumbers do not survive the conversion to the last bit.
    slack = 1e-9
    problems = [
        Problem(
            f"bands[{index}]",
            f"'{band.name}', {band.lower_um:g} to {band.upper_um:g} um, is outside what the {owner} provider "
            f"covers; allowed: {shortest:.5g} to {longest:.5g} um",
        )
        for index, band in enumerate(bands)
        if band.lower_um < shortest * (1 - slack) or band.upper_um > longest * (1 + slack)
    ]
    if problems:
        raise ScenarioError(problems)


def _require_view_inside(scenario: Scenario, declares: Declares) -> None:
    valid = declares.valid.get("view_zenith")
    if valid is not None and not valid[0] <= scenario.view.zenith <= valid[1]:
        low, high = valid
        raise ScenarioError(
            [
                Problem(
                    "view.zenith",
                    f"{scenario.view.zenith:g} deg; the atmosphere provider allows {low:g} to {high:g}; "
                    f"closest valid choice is {min(max(scenario.view.zenith, low), high):g}",
                )
            ]
        )
