"""What a plan draws: clouds and elements of a scenario, from all that does not depend on which are drawn.

Scenes that differ in nothing else share all other parts of their plan, and their radiance tables.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from hcss_twin.core.catalog import Catalog, SecludedCatalog
from hcss_twin.core.errors import OptionError, Problem, ScenarioError
from hcss_twin.plan.builder import Builder, build_elements
from hcss_twin.plan.clouds import AssembledLayer, build_generators
from hcss_twin.plan.scene_analysis import probe_last_frame
from hcss_twin.plan.sensor import make_sensor, require_instants
from hcss_twin.plan.slant_paths import SlantPaths
from hcss_twin.plan.waves import resolve_waves
from hcss_twin.providers import BrightnessInversion, CloudGenerator, ElementProvider, Grid, Motion
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.scenario.bands import sensor_bands
from hcss_twin.scenario.clouds import Layer
from hcss_twin.scenario.problems import problems_from
from hcss_twin.scenario.scenario import Scenario

if TYPE_CHECKING:
    from hcss_twin.models.radiance.spectral_grid import SpectralBand, SpectralGrid
    from hcss_twin.plan.assembly import Assembly
    from hcss_twin.plan.plan import Plan

OF_SKY = ("coverage", "edge_taper")
"""Keys of a cloud layer that neither radiance tables nor the choice of its generator depend on."""


@dataclass(frozen=True)
class Drawing:
    """What the clouds and elements of a scene are made from, besides those sections of its scenario.

    Attributes
    ----------
    clouds : sequence of AssembledLayer (L,)
        From the lowest to the highest.
    slant : SlantPaths
        Those of the scenario, all of which clouds may allow or not.
    inversions : sequence of BrightnessInversion (L,)
    """

    clouds: Sequence[AssembledLayer]
    motion: Motion
    slant: SlantPaths
    inversions: Sequence[BrightnessInversion]
    bands: Sequence[SpectralBand]
    grid: Grid
    spectral_grid: SpectralGrid

    @dataclass(frozen=True)
    class Drawn:
        """Clouds and elements of a scenario, and the slant paths that the clouds allow."""

        generators: tuple[CloudGenerator, ...]
        slant: SlantPaths
        elements: tuple[ElementProvider, ...]

    def of_sections(self, before: Scenario, after: Scenario) -> Drawing:
        """Return what layers with other values of :data:`OF_SKY` are made from."""
        sections = dict(zip(map(id, before.clouds.layers), after.clouds.layers, strict=True))

        def changed(cloud: AssembledLayer) -> AssembledLayer:
            section = sections[id(cloud.section)]
            layer = replace(cloud.layer, coverage=section.coverage, edge_taper=section.edge_taper)
            return replace(cloud, section=section, layer=layer)

        return replace(self, clouds=tuple(map(changed, self.clouds)))

    def drawn(self, builder: Builder, scenario: Scenario, catalog: Catalog) -> Drawn:
        """Return clouds and elements; the builder collects problems of elements.

        Raises
        ------
        ScenarioError
            With all problems of clouds.
        """
        clouds, bands = self.clouds, sensor_bands(self.bands)
        generators, slant = build_generators(
            builder, scenario, catalog, clouds, self.motion, self.slant, self.inversions
        )
        builder.raise_problems()
        elements = build_elements(builder, scenario, catalog, bands, self.grid, slant.view, self.spectral_grid)
        return self.Drawn(generators, slant, elements)


def redrawn(
    plan: Plan,
    seed: int,
    layers: Sequence[Mapping[str, Any]],
    elements: Sequence[Mapping[str, Any]] | None,
    sensor_seed: int | None,
) -> Plan:
    """Return the plan of the same scene with other clouds and elements, as :meth:`Plan.redrawn`."""
    scenario = _with_changes(plan.scenario, seed, layers, elements, sensor_seed)
    catalog, assembly = plan.catalog.branch(), plan.assembly
    drawing = assembly.drawing.of_sections(plan.scenario, scenario)
    builder = Builder(catalog.shelf.get_or_compute("registry", Registry.discover), scenario)
    try:
        drawn = drawing.drawn(builder, scenario, catalog)
        builder.raise_problems()
    except ValidationError:  # of parameters of elements: named as everywhere
        raw = json.loads(scenario.to_json())
        Scenario.from_dict(raw, base=scenario.base, origin=scenario.origin, shelf=catalog.shelf)
        raise
    assembly = replace(
        assembly,
        drawing=drawing,
        layers=tuple(cloud.layer for cloud in drawing.clouds),
        generators=drawn.generators,
        elements=drawn.elements,
        entries={**assembly.entries, **builder.entries},
        built={**assembly.built, **builder.built},
    )
    if not _shares(plan, assembly, drawn.slant):
        from hcss_twin.plan.make_plan import make_plan  # which imports this module

        keeps = not isinstance(catalog, SecludedCatalog)
        return make_plan(scenario, keeps_results=keeps, shelf=catalog.shelf, family=assembly.family)
    first_s, last_s = float(plan.frame_times_s[0]), float(plan.frame_times_s[-1])
    probe_last_frame(assembly, last_s)
    sensor = plan.sensor
    if scenario.sensor is not None:
        inputs = replace(sensor.inputs, seed=scenario.seed, catalog=catalog)
        stages = make_sensor(scenario.sensor, inputs, scene=sensor.scene).stages
        sensor = replace(sensor, section=scenario.sensor, inputs=inputs, stages=stages)
        require_instants(sensor, assembly, first_s, last_s)
    return replace(
        plan,
        scenario=scenario,
        catalog=catalog,
        assembly=assembly,
        layers=assembly.layers,
        waves=resolve_waves(scenario, assembly) if plan.waves.varies else plan.waves,
        sensor=sensor,
        rays=replace(plan.rays, assembly=assembly),  # type: ignore[type-var]
    )


def _with_changes(
    given: Scenario,
    seed: int,
    layers: Sequence[Mapping[str, Any]],
    elements: Sequence[Mapping[str, Any]] | None,
    sensor_seed: int | None,
) -> Scenario:
    """Return a scenario with other keys, of which those of layers are validated, and those of elements are not yet."""
    unknown = {name for keys in layers for name in keys} - {*OF_SKY}
    if unknown:
        raise OptionError(f"layers: keys {', '.join(sorted(unknown))}; allowed: {', '.join(OF_SKY)}")
    sections, problems = list(given.clouds.layers), list[Problem]()
    for name, new, count in (("layers", layers, len(sections)), ("elements", elements or (), len(given.elements))):
        if len(new) > count or (name == "elements" and elements is not None and len(new) < count):
            raise OptionError(f"{name}: {len(new)} given, but the scenario has {count} {name}; allowed: as many")
    for number, keys in enumerate(layers):
        try:
            checked = Layer.model_validate(dict(keys))
        except ValidationError as error:
            field = given.field_as_typed(f"clouds.layers[{number}].type").removesuffix(".type")
            problems += problems_from(error, Layer, prefix=field, raw=keys)
            continue
        sections[number] = sections[number].model_copy(update={name: getattr(checked, name) for name in keys})
    if problems:
        raise ScenarioError(problems, given.origin)
    changes: dict[str, Any] = {"seed": seed, "clouds": given.clouds.model_copy(update={"layers": tuple(sections)})}
    if elements is not None:
        changes["elements"] = tuple(
            section.model_copy(update={"parameters": dict(parameters)})
            for section, parameters in zip(given.elements, elements, strict=True)
        )
    if sensor_seed is not None and given.sensor is not None:
        changes["sensor"] = given.sensor.model_copy(update={"seed": sensor_seed})
    return given.model_copy(update=changes)


def _shares(plan: Plan, drawn: Assembly, slant: SlantPaths) -> bool:
    """Whether a scene with other clouds has all else in common with a plan, as planning it would find out.

    The analysis of a scene knows whether there are clouds and clear sky, not how many. Tops of clouds that vary, and
    images as clouds, are those of each sky; rays of packages, and light between columns, are made for one scene.
    """
    before = plan.assembly
    return (
        plan.is_grid
        and not (plan.light.varies or plan.point_effects)
        and drawn.cloudy_layers == before.cloudy_layers
        and drawn.has_clear_sky == before.has_clear_sky
        and drawn.from_images == before.from_images
        and drawn.met_heights_m == before.met_heights_m
        and drawn.hanging_layers == before.hanging_layers
        and slant.why_not.keys() <= before.slant.why_not.keys()
    )
