"""Check the names a scenario refers to: catalog entries, providers and their parameters."""

from __future__ import annotations

import contextlib
import copy
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError
from pydantic_core import PydanticCustomError

from hcss_twin.catalog import Catalog
from hcss_twin.errors import CatalogError, HcssError, Problem, choose_from
from hcss_twin.registry.kinds import Kind
from hcss_twin.registry.registry import Registry
from hcss_twin.scenario.bands import named_bands
from hcss_twin.scenario.models import Atmosphere, Layer, Optics, Radiance, Sea, Section, own, single_layer
from hcss_twin.scenario.problems import problems_from


def normalise(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Copy a raw scenario with the single-layer shorthand of ``[clouds]`` spelled out."""
    data = copy.deepcopy(dict(raw))
    if "clouds" in data:
        with contextlib.suppress(PydanticCustomError):  # left as it is: validation reports it
            data["clouds"] = single_layer(data["clouds"])
    return data


def name_problems(data: Mapping[str, Any], registry: Registry, catalog: Catalog) -> Iterator[Problem]:
    """Yield a problem for every name that leads nowhere and every parameter its provider refuses.

    Works on raw data, so that names are checked even where other keys are wrong.
    """
    sections: list[tuple[str, Any, str, Kind]] = [
        ("atmosphere", data.get("atmosphere", {}), "provider", Kind.ATMOSPHERE),
        ("sea", data.get("sea", {}), "model", Kind.SEA),
        ("optics", data.get("optics", {}), "provider", Kind.OPTICS),
        ("radiance", data.get("radiance", {}), "model", Kind.RADIANCE),
    ]
    clouds = data.get("clouds", {})
    layers = clouds.get("layers", []) if isinstance(clouds, dict) else []
    for index, layer in enumerate(layers if isinstance(layers, list) else []):
        sections.append((f"clouds.layers[{index}]", layer, "generator", Kind.CLOUDS))
    for path, section, key, kind in sections:
        if isinstance(section, Mapping):
            yield from _provider_problems(path, section, key, kind, registry)
    yield from _catalog_problems(data, layers, catalog)


def _provider_problems(
    path: str, section: Mapping[str, Any], key: str, kind: Kind, registry: Registry
) -> Iterator[Problem]:
    name = section.get(key, own(_default(key, kind)))
    if not isinstance(name, str):
        return
    parameters = section.get("parameters", {})
    try:
        entry = registry.resolve(kind, name)
        model = registry.parameters_model(entry)
    except HcssError as error:
        yield Problem(f"{path}.{key}", str(error))
        return
    if not isinstance(parameters, Mapping):
        return
    if model is None:
        if parameters:
            yield Problem(f"{path}.parameters", f"'{name}' takes no parameters; allowed: none")
        return
    try:
        model.model_validate(dict(parameters))
    except ValidationError as error:
        yield from problems_from(error, model, prefix=f"{path}.parameters")


def _catalog_problems(data: Mapping[str, Any], layers: Any, catalog: Catalog) -> Iterator[Problem]:
    bands = data.get("bands", [])
    known = named_bands(catalog)
    for index, band in enumerate(bands if isinstance(bands, list | tuple) else []):
        if isinstance(band, str) and band not in known:
            yield Problem(f"bands[{index}]", f"no band named '{band}'; {choose_from(band, known)}")
        elif isinstance(band, Mapping) and isinstance(band.get("response"), str):
            yield from _missing(f"bands[{index}].response", lambda name=band["response"]: catalog.file(name))
    for index, layer in enumerate(layers if isinstance(layers, list) else []):
        name = layer.get("type", "stratus") if isinstance(layer, Mapping) else None
        if isinstance(name, str):
            yield from _missing(
                f"clouds.layers[{index}].type", lambda name=name: catalog.find(name, "cloud_types", ".toml")
            )
    atmosphere = data.get("atmosphere", {})
    profile = atmosphere.get("profile", "us-standard-1976") if isinstance(atmosphere, Mapping) else None
    if isinstance(profile, str):
        yield from _missing("atmosphere.profile", lambda: catalog.find(profile, "atmospheres", ".csv"))


def _missing(field: str, look_up: Any) -> Iterator[Problem]:
    try:
        look_up()
    except CatalogError as error:
        yield Problem(field, str(error))


def _default(key: str, kind: Kind) -> str:
    """Name of the provider a section gets where it names none."""
    models: dict[Kind, type[Section]] = {
        Kind.ATMOSPHERE: Atmosphere,
        Kind.SEA: Sea,
        Kind.OPTICS: Optics,
        Kind.RADIANCE: Radiance,
        Kind.CLOUDS: Layer,
    }
    default: str = models[kind].model_fields[key].default
    return default
