"""What a plan draws: clouds and elements of a scenario, from all that does not depend on which are drawn.

Scenes that differ in nothing else share all other parts of their plan, and their radiance tables.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import OptionError, Problem, ScenarioError
from hcss_twin.plan.builder import Builder, build_elements
from hcss_twin.plan.clouds import AssembledLayer, build_generators
from hcss_twin.plan.slant_paths import SlantPaths
from hcss_twin.providers import BrightnessInversion, CloudGenerator, ElementProvider, Grid, Motion
from hcss_twin.scenario.bands import sensor_bands
from hcss_twin.scenario.clouds import Layer
from hcss_twin.scenario.problems import problems_from
from hcss_twin.scenario.scenario import Scenario

if TYPE_CHECKING:
    from hcss_twin.models.radiance.spectral_grid import SpectralBand, SpectralGrid

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


def with_changes(
    given: Scenario,
    seed: int,
    layers: Sequence[Mapping[str, Any]],
    elements: Sequence[Mapping[str, Any]] | None,
    sensor_seed: int | None,
) -> Scenario:
    """Return a scenario with other keys, of which those of layers are validated, and those of elements are not yet.

    Raises
    ------
    OptionError, ScenarioError
        As of :meth:`hcss_twin.plan.plan.Plan.redrawn`.
    """
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
