"""Providers that a scenario may list: elements in the scene, and derived output variables."""

from __future__ import annotations

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.physics.planck import planck
from hcss_twin.plan.builder import Builder, numbered
from hcss_twin.providers import ElementInputs, ElementProvider, Grid, SensorBand, VariableInputs, VariableProvider, View
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.section_types import selected


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
                own = f"elements[{index}].parameters"
                raise ScenarioError(
                    [Problem(f"{own}.{each.field}", each.message) for each in error.problems]
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
