"""Parameters of providers that stand in a section itself instead of its ``parameters``."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from hcss_twin.errors import HcssError, Problem, closest
from hcss_twin.registry.discovery import Entry
from hcss_twin.registry.kinds import Kind
from hcss_twin.registry.registry import Registry
from hcss_twin.scenario.models import Atmosphere, Layer, Optics, Radiance, ScenarioModel, Sea, own
from hcss_twin.scenario.problems import homes
from hcss_twin.scenario.section import Section
from hcss_twin.scenario.sensor import DEFAULT_MODEL, Sensor

SECTIONS: Mapping[Kind, tuple[type[Section], str]] = {
    Kind.ATMOSPHERE: (Atmosphere, "provider"),
    Kind.SEA: (Sea, "model"),
    Kind.OPTICS: (Optics, "provider"),
    Kind.RADIANCE: (Radiance, "model"),
    Kind.CLOUDS: (Layer, "generator"),
    Kind.SENSORS: (Sensor, "model"),
}
"""Section of each kind of provider, and its key that selects one."""


def provider_sections(data: Mapping[str, Any]) -> list[tuple[str, Any, Kind]]:
    """Return path and content of each section of a raw scenario that selects a provider."""
    single = ((Kind.ATMOSPHERE, "atmosphere"), (Kind.SEA, "sea"), (Kind.OPTICS, "optics"))
    sections = [(path, data.get(path, {}), kind) for kind, path in (*single, (Kind.RADIANCE, "radiance"))]
    clouds = data.get("clouds", {})
    layers = clouds.get("layers", []) if isinstance(clouds, dict) else []
    for index, layer in enumerate(layers if isinstance(layers, list) else []):
        sections.append((f"clouds.layers[{index}]", layer, Kind.CLOUDS))
    if "sensor" in data:
        sections.append(("sensor", data["sensor"], Kind.SENSORS))
    return sections


def default_provider(kind: Kind) -> str:
    """Name of the provider a section gets where it names none."""
    section, key = SECTIONS[kind]
    # A sensor's model may also come from a named sensor.
    default: str = section.model_fields[key].default or DEFAULT_MODEL
    return default


def misplaced_parameters(
    data: Mapping[str, Any], registry: Registry, typed: Callable[[str], str]
) -> Iterator[Problem]:
    """Yield a problem for every unknown key of a section that is, or is spelt like, a provider's parameter.

    Parameters
    ----------
    data : mapping
        A raw scenario.
    typed : callable
        Writes the path of a field as the user did.
    """
    for path, content, kind in provider_sections(data):
        section, selector = SECTIONS[kind]
        for key in content if isinstance(content, Mapping) else ():
            if not isinstance(key, str) or key in section.model_fields:
                continue
            name = content.get(selector, own(default_provider(kind)))
            found = _owner(key, name, kind, registry, _has_home(key, content[key]))
            if found is not None:
                parameter, entry, is_selected = found
                field = f"{path}.{key}"
                place = typed(field).removesuffix(key)
                whose = f"a parameter of {kind.human} '{entry.name}'"
                whose += "" if is_selected else f', with {place}{selector} = "{entry.name}"'
                yield Problem(field, f"unknown key; closest is '{place}parameters.{parameter}', {whose}")


def _has_home(key: str, value: object) -> bool:
    """Whether a key is one of another section; what is no table is no section itself."""
    annotation = getattr(ScenarioModel.model_fields.get(key), "annotation", None)
    is_section = isinstance(annotation, type) and issubclass(annotation, Section)
    return any(homes(ScenarioModel, key)) and not (is_section and not isinstance(value, Mapping))


def _owner(
    key: str, name: object, kind: Kind, registry: Registry, has_home: bool
) -> tuple[str, Entry, bool] | None:
    """Return the parameter that a key may be, whose it is, and whether that provider is selected."""
    section = SECTIONS[kind][0]
    selected: Entry | None = None
    with contextlib.suppress(HcssError):  # told at the key that selects it
        selected = registry.resolve(kind, name) if isinstance(name, str) else None
    if selected is not None:
        parameters = _parameters(registry, selected)
        if key in parameters:
            return key, selected, True
        alike = closest(key, (*parameters, *section.model_fields))
        if not has_home and alike in parameters and alike not in section.model_fields:
            return alike, selected, True
    for entry in () if has_home else registry.entries(kind):
        if key in _parameters(registry, entry):
            return key, entry, False
    return None


def _parameters(registry: Registry, entry: Entry) -> tuple[str, ...]:
    try:
        model = registry.parameters_model(entry)
    except HcssError:  # of a plugin that is broken, and told where it is selected
        return ()
    return () if model is None else tuple(model.model_fields)
