"""Checks of the names in a scenario: catalog entries, providers and their parameters."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from functools import partial
from typing import Any

from pydantic import ValidationError
from pydantic_core import PydanticCustomError

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, HcssError, Problem, ScenarioError
from hcss_twin.cube.requested_variables import expand
from hcss_twin.models.atmosphere.profile_file import STANDARD, load_profile, load_profiles
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.atmosphere import Atmosphere
from hcss_twin.scenario.bands import ResponseBand, named_bands, unknown_band, written_limits
from hcss_twin.scenario.cloud_types import (
    CloudType,
    Extent,
    altitude_problems,
    extent_of,
    load_cloud_type,
    overlap_problems,
)
from hcss_twin.scenario.clouds import Layer, OpticsSection, single_layer
from hcss_twin.scenario.instrument import DEFAULT_MODEL, load_instrument
from hcss_twin.scenario.key_paths import homes
from hcss_twin.scenario.models import DerivedSection, ElementSection, Radiance, ScenarioModel, Sea, SurfaceSection
from hcss_twin.scenario.particles import MICROPHYSICAL, layer_particles
from hcss_twin.scenario.problems import problems_from
from hcss_twin.scenario.response_file import read_response
from hcss_twin.scenario.section_types import ScenarioSection, own, parse_instant
from hcss_twin.scenario.sensor import SensorSection, StageSection, choose_sensor, raw_stages

SECTIONS: Mapping[Kind, tuple[type[ScenarioSection], str]] = {
    Kind.ATMOSPHERE: (Atmosphere, "provider"),
    Kind.SEA: (Sea, "model"),
    Kind.OPTICS: (OpticsSection, "provider"),
    Kind.RADIANCE: (Radiance, "model"),
    Kind.CLOUDS: (Layer, "generator"),
    Kind.ELEMENTS: (ElementSection, "provider"),
    Kind.SURFACES: (SurfaceSection, "provider"),
    Kind.VARIABLES: (DerivedSection, "provider"),
    Kind.SENSORS: (SensorSection, "model"),
}
"""Section and selecting key of each kind of provider."""


def provider_sections(data: Mapping[str, Any]) -> list[tuple[str, Any, Kind]]:
    """Return path and content of each section of a raw scenario that selects a provider."""
    single = ((Kind.ATMOSPHERE, "atmosphere"), (Kind.SEA, "sea"), (Kind.OPTICS, "optics"))
    sections = [(path, data.get(path, {}), kind) for kind, path in (*single, (Kind.RADIANCE, "radiance"))]
    clouds = data.get("clouds", {})
    layers = clouds.get("layers", []) if isinstance(clouds, dict) else []
    for index, layer in enumerate(layers if isinstance(layers, list) else []):
        sections.append((f"clouds.layers[{index}]", layer, Kind.CLOUDS))
        if isinstance(layer, dict) and isinstance(layer.get("optics"), dict):
            sections.append((f"clouds.layers[{index}].optics", layer["optics"], Kind.OPTICS))
    elements = data.get("elements", [])
    for index, element in enumerate(elements if isinstance(elements, list) else []):
        sections.append((f"elements[{index}]", element, Kind.ELEMENTS))
    output = data.get("output", {})
    derived = output.get("derived", []) if isinstance(output, dict) else []
    for index, variables in enumerate(derived if isinstance(derived, list) else []):
        sections.append((f"output.derived[{index}]", variables, Kind.VARIABLES))
    if "surfaces" in data:
        sections.append(("surfaces", data["surfaces"], Kind.SURFACES))
    sections += [(path, stage, Kind.SENSORS) for path, stage in raw_stages(data)]
    return sections


def default_provider(kind: Kind) -> str:
    """Default provider name of a section; empty if it must be given."""
    section, key = SECTIONS[kind]
    if section.model_fields[key].is_required():
        return ""
    # A sensor's model may also come from a named instrument.
    default: str = section.model_fields[key].default or DEFAULT_MODEL
    return default


def misplaced_parameters(data: Mapping[str, Any], registry: Registry, typed: Callable[[str], str]) -> Iterator[Problem]:
    """Yield a problem for every unknown key of a section that matches or resembles a provider parameter.

    Parameters
    ----------
    data : mapping
        A raw scenario.
    typed : callable
        Converts a field path to the user's notation.
    """
    for path, content, kind in provider_sections(data):
        section, selector = SECTIONS[kind]
        for key in content if isinstance(content, Mapping) else ():
            if not isinstance(key, str) or key in section.model_fields:
                continue
            name = content.get(selector, own(default_provider(kind)))
            home = _owner(key, name, kind, registry, _has_home(key, content[key]))
            if home is not None:
                parameter, entry, is_selected = home
                field = f"{path}.{key}"
                prefix = typed(field).removesuffix(key)
                whose = f"a parameter of {kind.human} '{entry.name}'"
                whose += "" if is_selected else f', with {prefix}{selector} = "{entry.name}"'
                yield Problem(field, f"unknown key; closest is '{prefix}parameters.{parameter}', {whose}")


def _has_home(key: str, value: object) -> bool:
    """Whether a key belongs to another section; only a table can be a section."""
    annotation = getattr(ScenarioModel.model_fields.get(key), "annotation", None)
    is_section = isinstance(annotation, type) and issubclass(annotation, ScenarioSection)
    return any(homes(ScenarioModel, key)) and not (is_section and not isinstance(value, Mapping))


def _owner(key: str, name: object, kind: Kind, registry: Registry, has_home: bool) -> tuple[str, Entry, bool] | None:
    """Return the parameter that a key may refer to, its provider, and whether that provider is selected."""
    section = SECTIONS[kind][0]
    selected: Entry | None = None
    with contextlib.suppress(HcssError):  # reported at the key that selects it
        selected = registry.resolve(kind, name) if isinstance(name, str) else None
    if selected is not None:
        parameters = _parameters(registry, selected)
        if key in parameters:
            return key, selected, True
        alike = Problem.closest(key, (*parameters, *section.model_fields))
        if not has_home and alike in parameters and alike not in section.model_fields:
            return alike, selected, True
    for entry in () if has_home else registry.entries(kind):
        if key in _parameters(registry, entry):
            return key, entry, False
    return None


def _parameters(registry: Registry, entry: Entry) -> tuple[str, ...]:
    try:
        model = registry.parameters_model(entry)
    except HcssError:  # raised for a broken plugin; reported where it is selected
        return ()
    return () if model is None else tuple(model.model_fields)


DEEPEST = 32
"""Maximum nesting of tables and lists: far above any real scenario, far below Python's recursion limit."""


def normalise(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Copy a raw scenario with the single-layer shorthand of ``[clouds]`` spelled out.

    Raises
    ------
    ScenarioError
        If tables or lists are nested more than 32 deep.
    """
    data: dict[str, Any] = _copy(raw, DEEPEST)
    if "clouds" in data:
        with contextlib.suppress(PydanticCustomError):  # unchanged: validation reports it
            data["clouds"] = single_layer(data["clouds"])
    return data


def _copy(value: Any, levels: int) -> Any:
    """Copy tables and lists; their values are immutable or rejected by validation."""
    if not isinstance(value, Mapping | list | tuple):
        return value
    if levels == 0:
        raise ScenarioError([Problem("scenario", f"nested too deeply; allowed: {DEEPEST} levels")])
    if isinstance(value, Mapping):
        return {key: _copy(item, levels - 1) for key, item in value.items()}
    return [_copy(item, levels - 1) for item in value]


def name_problems(data: Mapping[str, Any], registry: Registry, catalog: Catalog) -> Iterator[Problem]:
    """Yield a problem for every unknown name and every parameter that its provider rejects.

    Works on raw data, so that names are checked even where other keys are wrong.
    """
    clouds = data.get("clouds", {})
    layers = clouds.get("layers", []) if isinstance(clouds, dict) else []
    for path, section, kind in provider_sections(data):
        if isinstance(section, Mapping) and kind is not Kind.SENSORS:
            yield from _provider_problems(path, section, SECTIONS[kind][1], kind, registry)
    yield from _sensor_problems(data, registry, catalog)
    yield from _catalog_problems(data, layers, catalog)
    yield from _variable_problems(data, registry, len(layers) if isinstance(layers, list) else 0)


def _provider_problems(
    path: str, section: Mapping[str, Any], key: str, kind: Kind, registry: Registry
) -> Iterator[Problem]:
    name = section[key] if key in section else own(default_provider(kind))
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
        yield from problems_from(error, model, prefix=f"{path}.parameters", raw=parameters)


def _sensor_problems(data: Mapping[str, Any], registry: Registry, catalog: Catalog) -> Iterator[Problem]:
    for path, section in raw_stages(data):
        if not isinstance(section, Mapping):
            continue
        name, parameters = section.get("name"), section.get("parameters", {})
        try:
            given = StageSection.model_validate({"name": name, "model": section.get("model"), "parameters": parameters})
        except ValidationError:  # reported with the other keys
            continue
        problems = [] if name is None else list(_file_problems(f"{path}.name", partial(load_instrument, name, catalog)))
        yield from problems
        if not problems:
            choice = choose_sensor(given, catalog)
            merged = {"model": choice.model, "parameters": choice.parameters}
            yield from _provider_problems(path, merged, "model", Kind.SENSORS, registry)


def _catalog_problems(data: Mapping[str, Any], layers: Any, catalog: Catalog) -> Iterator[Problem]:
    bands = data.get("bands", [])
    known = named_bands(catalog)
    for index, band in enumerate(bands if isinstance(bands, list) else []):
        if isinstance(band, str) and band not in known and written_limits(band) is None:
            yield Problem(f"bands[{index}]", unknown_band(band, known))
        elif isinstance(band, Mapping) and isinstance(band.get("response"), str):
            try:
                given = ResponseBand.model_validate(band)
            except ValidationError:  # reported with the other keys
                given = ResponseBand(name="any", response=band["response"])
            read = partial(read_response, given.response, catalog, given.name, given.column, given.unit)
            yield from _file_problems(f"bands[{index}].response", read)
    sound: dict[str, tuple[Layer, Extent]] = {}
    for index, layer in enumerate(layers if isinstance(layers, list) else []):
        if isinstance(layer, Mapping):
            yield from _layer_problems(f"clouds.layers[{index}]", layer, catalog, sound)
    yield from overlap_problems(sound)
    atmosphere = data.get("atmosphere", {})
    if isinstance(atmosphere, Mapping):
        yield from _profile_problems(atmosphere, data.get("time"), catalog)


def _profile_problems(atmosphere: Mapping[str, Any], time: object, catalog: Catalog) -> Iterator[Problem]:
    above = atmosphere.get("profile_above", STANDARD)
    if not isinstance(above, str):
        return
    problems = list(_file_problems("atmosphere.profile_above", partial(load_profile, above, catalog)))
    yield from problems
    profile = atmosphere.get("profile")
    if profile is None and above != STANDARD:
        yield Problem(
            "atmosphere.profile_above", "without atmosphere.profile; allowed: with the file that it completes"
        )
    if isinstance(profile, str) and not problems:
        try:
            instant = parse_instant(time).astimezone(UTC)
        except PydanticCustomError:  # reported with the other keys
            instant = datetime(2000, 1, 1, tzinfo=UTC)
        yield from _file_problems("atmosphere.profile", partial(load_profiles, profile, catalog, above, instant))


def _variable_problems(data: Mapping[str, Any], registry: Registry, layer_count: int) -> Iterator[Problem]:
    """Check the names of output variables against the terms of the radiance model and the cloud layers."""
    output, radiance, slant = (data.get(key, {}) for key in ("output", "radiance", "slant"))
    names = output.get("variables") if isinstance(output, Mapping) else None
    model = radiance.get("model", own(default_provider(Kind.RADIANCE))) if isinstance(radiance, Mapping) else None
    if not isinstance(names, list) or not isinstance(model, str) or not all(isinstance(n, str) for n in names):
        return
    try:
        terms = registry.provider_class(registry.resolve(Kind.RADIANCE, model)).terms
        # Also true if the value is not a boolean, which is reported separately.
        shadows = isinstance(slant, Mapping) and slant.get("shadows", "auto") != "off"
        platform = data.get("platform", {})
        known = ("altitude", "longitude")  # of a geostationary sensor
        altitude = isinstance(platform, Mapping) and any(platform.get(name) is not None for name in known)
        elements, derived = (_variables_of(kind, data, registry) for kind in (Kind.ELEMENTS, Kind.VARIABLES))
        surfaces = ("",) if data.get("surfaces") is not None else ()
        expand(
            names,
            terms,
            layer_count,
            shadows,
            altitude=altitude,
            elements=elements,
            derived=derived,
            surfaces=surfaces,
            light=True,
        )
    except (HcssError, AttributeError):  # reported at radiance.model
        return
    except ValueError as error:
        yield Problem("output.variables", str(error))


def _variables_of(wanted: Kind, data: Mapping[str, Any], registry: Registry) -> list[Mapping[str, Any]]:
    """Return the variables of each element or variable provider of a raw scenario."""
    return [
        registry.provider_class(registry.resolve(kind, section.get("provider", own(default_provider(kind))))).variables
        for _, section, kind in provider_sections(data)
        if kind is wanted and isinstance(section, Mapping)
    ]


_GEOMETRY = ("base", "top", "thickness_min")


def _layer_problems(
    field: str, layer: Mapping[str, Any], catalog: Catalog, sound: dict[str, tuple[Layer, Extent]]
) -> Iterator[Problem]:
    """Check type, altitudes and particles of a layer, and add it to ``sound`` if its altitudes are valid.

    The layer's own altitudes are checked even if the type is invalid.
    """
    name = layer.get("type", Layer.model_fields["type"].default)
    cloud_type: CloudType | None = None
    if isinstance(name, str):
        problems = list(_file_problems(f"{field}.type", partial(load_cloud_type, name, catalog)))
        yield from problems
        cloud_type = None if problems else load_cloud_type(name, catalog)
    named = {"type": name} if isinstance(name, str) else {}
    section = _part(layer, _GEOMETRY, named)
    if section is not None:
        problems = list(altitude_problems(section, cloud_type, field))
        yield from problems
        extent = extent_of(section, cloud_type, levels=None)
        if not problems and extent is not None:
            sound[field] = section, extent
    section = _part(layer, MICROPHYSICAL, named)
    if section is not None and cloud_type is not None:
        try:
            layer_particles(section, cloud_type.microphysics, cloud_type.layer.material, field)
        except ScenarioError as error:
            yield from error.problems


def _part(layer: Mapping[str, Any], keys: tuple[str, ...], named: Mapping[str, str]) -> Layer | None:
    """Read some keys of a layer; None if one is malformed, which is reported with the other keys."""
    try:
        return Layer.model_validate({**{key: layer[key] for key in keys if key in layer}, **named})
    except ValidationError:
        return None


def _file_problems(field: str, read: Callable[[], object]) -> Iterator[Problem]:
    try:
        read()
    except ScenarioError as error:
        yield from (Problem(field, f"{error.origin}: {problem}") for problem in error.problems)
    except CatalogError as error:
        yield Problem(field, str(error))
    except (OSError, RuntimeError, ValueError) as error:  # impossible file names, unreadable files
        yield Problem(field, f"cannot be read: {getattr(error, 'strerror', error)}")
