"""Construction of the providers of a scenario, with all errors collected as problems of its keys."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, Problem, ProviderDefect, ProviderError, ScenarioError
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import Profile
from hcss_twin.plan.lines_of_sight import SunTrack
from hcss_twin.providers import ElementInputs, ElementProvider, Grid, SensorBand, VariableInputs, VariableProvider, View
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.guard import guard
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.providers.scene import LOGGER, SceneInfo, takes_scene
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.section_types import selected


@dataclass(frozen=True)
class Built:
    """A guarded provider and how it was made.

    Attributes
    ----------
    parameters : pydantic model or None
    inputs
        The input dataclass of its kind.
    make : callable
        Maps other inputs to another guarded provider with the same parameters.
    scene : str
        The scene that the provider takes, for keys of kept results; empty if it takes none.
    """

    entry: Entry
    parameters: Any
    inputs: Any
    provider: Any
    make: Callable[[Any], Any]
    scene: str = ""

    def code(self, shelf: ResultCache) -> tuple[str, ...]:
        """Return what names code and state of the provider in keys of kept results."""
        return (*self.entry.code(shelf, self.provider), *((self.scene,) if self.scene else ()))


def scene_info(scenario: Scenario) -> SceneInfo:
    """Return what a provider may know of a scenario."""
    place = scenario.place
    return scene_of(SunTrack(scenario.time, place.latitude, place.longitude, float(scenario.motion.platform_speed)))


def scene_of(track: SunTrack) -> SceneInfo:
    """Return what a provider may know of a scene with this sun."""
    return SceneInfo(
        track.start.astimezone(UTC), track.latitude_deg, track.longitude_deg, track.at, logging.getLogger(LOGGER)
    )


@contextmanager
def attribute_to_field(field: str, parameters: Mapping[str, Any] | None = None) -> Iterator[None]:
    """Convert an error of a catalog or provider to a problem of the scenario's field.

    An error that quotes the value of one of the ``parameters`` is attributed to that parameter. A provider that fails
    by accident or breaks its contract is at fault itself, and no field is.
    """
    try:
        yield
    except ProviderDefect:
        raise
    except (CatalogError, ProviderError) as error:
        message = str(error)
        said = message.replace(error.provider, "")  # a parameter may have the value of the provider's name
        section = field.rpartition(".")[0]
        for key, value in (parameters or {}).items():
            if isinstance(value, str) and value and f"'{value}'" in said:
                field = f"{section}.parameters.{key}"
        raise ScenarioError([Problem(field, message)]) from error


def numbered(kind: Kind, index: int, count: int) -> str:
    """Return the label of one of ``count`` providers of a kind in plan and cube; several are numbered."""
    return str(kind) if count == 1 else f"{kind}[{index}]"


class Builder:
    """Resolves, constructs and guards providers, records the used ones, and collects problems."""

    def __init__(self, registry: Registry, scenario: Scenario) -> None:
        self._registry = registry
        self._scene = scene_info(scenario)
        self._problems: list[Problem] = []
        self.entries: dict[str, Entry] = {}
        self.built: dict[str, Built] = {}

    def build(self, kind: Kind, name: str, inputs: Any, parameters: Mapping[str, Any], label: str = "") -> Any:
        """Create and guard a provider, and record it under ``label``, by default its kind."""
        entry, values = self._resolved(kind, name, parameters)
        registry, scene = self._registry, self._scene

        def make(inputs: Any) -> Any:  # stored in this object, so it must not refer to it
            return guard(entry, registry.create(entry, inputs, values, scene), inputs)

        provider = make(inputs)
        self.entries[label or str(kind)] = entry
        of_scene = ""
        if takes_scene(registry.provider_class(entry)):
            # the sun at a later time tells the speed of the platform
            of_scene = repr((scene.time, scene.latitude_deg, scene.longitude_deg, scene.sun_at(0.0), scene.sun_at(1e3)))
        self.built.setdefault(label or str(kind), Built(entry, values, inputs, provider, make, of_scene))
        return provider

    def bound_profile(self, name: str, parameters: Mapping[str, Any], catalog: Catalog) -> Profile | None:
        """Return the only profile that a transmittance provider supports; None if it supports any."""
        entry, values = self._resolved(Kind.ATMOSPHERE, name, parameters)
        return self._registry.bound_profile(entry, values, catalog)

    def _resolved(self, kind: Kind, name: str, parameters: Mapping[str, Any]) -> tuple[Entry, Any]:
        entry = self._registry.resolve(kind, name)
        model = self._registry.parameters_model(entry)
        return entry, None if model is None else model.model_validate(dict(parameters))

    @contextmanager
    def collect_problems(self, field: str, parameters: Mapping[str, Any] | None = None) -> Iterator[None]:
        """Collect errors of catalogs and providers, converted by :func:`attribute_to_field`."""
        try:
            with attribute_to_field(field, parameters):
                yield
        except ScenarioError as error:
            self._problems += error.problems

    def keep(self, problems: Iterable[Problem]) -> None:
        """Add problems found elsewhere."""
        self._problems += problems

    @property
    def has_problems(self) -> bool:
        """Whether any problem is collected."""
        return bool(self._problems)

    def raise_problems(self) -> None:
        """Raise all collected problems."""
        if self._problems:
            raise ScenarioError(self._problems)


def build_elements(
    builder: Builder,
    scenario: Scenario,
    catalog: Catalog,
    bands: tuple[SensorBand, ...],
    grid: Grid,
    view: View,
    spectrum: SpectralGrid,
) -> tuple[ElementProvider, ...]:
    """Build the element providers of a scenario; ``spectrum`` gives them the radiance of black bodies.

    Their problems are collected by the builder.
    """

    def black_body(temperature_K: float) -> Array:
        radiance: Array = np.sum(spectrum.weights_cm1 * planck(spectrum.wavenumber_cm1, temperature_K), axis=1)
        return radiance

    elements: list[ElementProvider] = []
    place = scenario.place
    inputs = ElementInputs(bands, grid, view, black_body, catalog, place.latitude, place.longitude)
    for index, section in enumerate(scenario.elements):
        name = selected(section, "provider")
        with builder.collect_problems(f"elements[{index}].provider", section.parameters):
            label = numbered(Kind.ELEMENTS, index, len(scenario.elements))
            try:
                elements.append(builder.build(Kind.ELEMENTS, name, inputs, section.parameters, label))
            except ScenarioError as error:  # of the provider, which does not know the place of its section
                section_field = f"elements[{index}].parameters"
                raise ScenarioError(
                    [Problem(f"{section_field}.{problem.field}", problem.message) for problem in error.problems]
                ) from error
    return tuple(elements)


def build_derived(
    builder: Builder, scenario: Scenario, catalog: Catalog, bands: tuple[SensorBand, ...], grid: Grid, view: View
) -> tuple[VariableProvider, ...]:
    """Build the providers of derived variables of a scenario; their problems are collected by the builder."""
    sections, derived = scenario.output.derived, list[VariableProvider]()
    for index, section in enumerate(sections):
        with builder.collect_problems(f"output.derived[{index}].provider", section.parameters):
            inputs, label = VariableInputs(bands, grid, view, catalog), numbered(Kind.VARIABLES, index, len(sections))
            derived.append(builder.build(Kind.VARIABLES, section.provider, inputs, section.parameters, label))
    return tuple(derived)
