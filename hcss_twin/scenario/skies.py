"""Skies of cloud types: the generator of a package in place of the fractal one, where it is installed."""

from __future__ import annotations

from typing import TypeVar

from pydantic import ValidationError

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import HcssError, Problem, ScenarioError
from hcss_twin.core.own_packages import how_to_install
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.cloud_types import TypeSky, load_cloud_type
from hcss_twin.scenario.models import ScenarioModel
from hcss_twin.scenario.problems import problems_from

_Scenario = TypeVar("_Scenario", bound=ScenarioModel)

_OF_FRACTAL = {"generator", "parameters", "edge_taper"}
"""Keys of a layer whose user has chosen the generator, or means the fractal one."""


def with_skies(
    scenario: _Scenario, catalog: Catalog, registry: Registry, origin: str
) -> tuple[_Scenario, tuple[str, ...]]:
    """Return a valid scenario whose layers have the generators that their types name, and notes of missing packages.

    The type of a layer decides, unless the layer states a generator or what belongs to the fractal one. Without the
    package the fractal generator stays: a scene of the core alone runs everywhere.

    Raises
    ------
    ScenarioError
        If a package is installed and has no such generator, or that refuses the parameters of the type.
    """
    layers, notes = [], []
    point_m = scenario.image.pixel_size / scenario.image.samples_per_pixel
    for number, layer in enumerate(scenario.clouds.layers):
        cloud_type = None if _OF_FRACTAL & layer.model_fields_set else load_cloud_type(layer.type, catalog)
        sky = None if cloud_type is None else cloud_type.sky_of(point_m)
        if cloud_type is None or sky is None:
            layers.append(layer)
            of_pixel = None if cloud_type is None else cloud_type.sky_of(scenario.image.pixel_size)
            if of_pixel is not None:
                notes.append(
                    f"clouds of the type '{layer.type}' are fractal at the {point_m:g} m between the points of "
                    f"image.samples_per_pixel; with fewer points they are those of {of_pixel.package}/"
                    f"{of_pixel.generator}, from {of_pixel.pixel_size_min:g} m on, if that package is installed"
                )
            continue
        name = f"{sky.package}/{sky.generator}"
        if not any(entry.distribution == sky.package for entry in registry.entries(Kind.CLOUDS)):
            layers.append(layer)
            if layer.coverage:
                notes.append(
                    f"clouds of the type '{layer.type}' look more like measured ones with the package {sky.package} "
                    f"({how_to_install(sky.package)}); without it they are fractal"
                )
            continue
        if sky.own_coverage and "coverage" in layer.model_fields_set:
            layers.append(layer)
            notes.append(
                f"clouds of the type '{layer.type}' look more like measured ones without clouds.coverage: those of "
                f"{name} have their own; with it they are fractal"
            )
            continue
        _require_valid(registry, name, sky, f"clouds.layers[{number}].type", f"'{layer.type}'", origin)
        chosen: dict[str, object] = {"generator": name, "parameters": dict(sky.parameters)}
        for key in {"coverage", "thickness_min"} - layer.model_fields_set:
            if (usual := getattr(sky, key)) is not None:
                chosen[key] = usual
        layers.append(layer.model_copy(update=chosen))
    clouds = scenario.clouds.model_copy(update={"layers": tuple(layers)})
    return scenario.model_copy(update={"clouds": clouds}), tuple(dict.fromkeys(notes))


def _require_valid(registry: Registry, name: str, sky: TypeSky, field: str, of_type: str, origin: str) -> None:
    """Raise ScenarioError unless the installed package has the generator, and that takes the parameters."""
    try:
        model = registry.parameters_model(registry.resolve(Kind.CLOUDS, name))
    except HcssError as error:
        raise ScenarioError([Problem(field, f"{of_type}: {error}")], origin) from error
    if model is None:
        return
    try:
        model.model_validate(sky.parameters)
    except ValidationError as error:
        problems = problems_from(error, model, prefix="sky.parameters", raw=sky.parameters)
        raise ScenarioError([Problem(field, f"{of_type}: {problem}") for problem in problems], origin) from error
