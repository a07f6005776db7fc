"""Defaults of former versions, for keys whose default has changed since."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from hcss_twin.providers.registry.registry import OWN_DISTRIBUTION

BAND_MODEL = ("band-model", f"{OWN_DISTRIBUTION}/band-model")
BULK = ("bulk", f"{OWN_DISTRIBUTION}/bulk")
RADIOMETER = ("radiometer", f"{OWN_DISTRIBUTION}/radiometer", None)
OF_IMAGES = tuple(f"{prefix}{name}" for name in ("imagery", "surrogate") for prefix in ("", f"{OWN_DISTRIBUTION}/"))

FORMER: Mapping[str, Mapping[str, str | float]] = MappingProxyType(
    {
        "0.1": {
            "atmosphere.coefficients": "lowtran7",
            "atmosphere.gases.others": "profile",
            "clouds.coverage_mode": "frame",
            "clouds.parameters.method": "otsu",
            "motion.evolution_time": 1800.0,
            "sea.temperature_texture": 0.0,
            "optics.parameters.ice_phase_function": "henyey-greenstein",
            "sensor.parameters.method": "frames",
        }
    }
)
"""By version: dotted key and its default. Keys of ``optics`` also apply to the optics of individual layers, those of
``sensor`` and ``clouds`` to each stage or layer, if there is one."""

_PARTS: Mapping[str, str] = MappingProxyType({"clouds": "layers", "sensor": "stages"})


def with_former_defaults(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return a raw scenario with the defaults that its key ``defaults`` names, where it has no value of its own."""
    filled = dict(data)
    if isinstance(filled.get("defaults"), float):  # without quotes, as on a command line
        filled["defaults"] = str(filled["defaults"])
    version = filled.get("defaults")
    for key, value in (FORMER.get(version, {}) if isinstance(version, str) else {}).items():
        section, *others = key.split(".")
        given, clouds = filled.get(section, {}), filled.get("clouds")
        parts = given.get(_PARTS.get(section)) if isinstance(given, Mapping) else None
        if isinstance(parts, list):
            filled[section] = {**given, _PARTS[section]: [_with_default(one, key, others, value) for one in parts]}
        elif bool(given) if section == "clouds" else section != "sensor" or section in filled:  # not for a clear sky
            filled[section] = _with_default(given, key, others, value)
        if section == "optics" and isinstance(clouds, Mapping) and isinstance(clouds.get("layers"), list):
            layers = [
                {**layer, section: _with_default(layer[section], key, others, value)}
                if isinstance(layer, Mapping) and section in layer
                else layer
                for layer in clouds["layers"]
            ]
            filled["clouds"] = {**clouds, "layers": layers}
    return filled


def _with_default(given: Any, key: str, keys: Sequence[str], value: str | float) -> Any:
    """Return a section with the value of one of its keys, where it has none and can have it."""
    if not isinstance(given, Mapping) or not applies(key, given):
        return given  # what is no table is reported as a wrong type
    return _filled(given, keys, value)


def _filled(given: Any, keys: Sequence[str], value: str | float) -> Any:
    if not isinstance(given, Mapping):
        return given
    key, *deeper = keys
    return {**given, key: _filled(given.get(key, {}), deeper, value) if deeper else given.get(key, value)}


def applies(key: str, section: Mapping[str, Any]) -> bool:
    """Return whether a key applies: some belong to one provider, and coefficients exclude a file of your own."""
    if key == "atmosphere.coefficients":
        return section.get("provider", "band-model") in BAND_MODEL and "file" not in section.get("parameters", {})
    if key == "clouds.coverage_mode":
        return True
    if key.startswith("clouds."):
        parameters = section.get("parameters", {})
        return section.get("generator") in OF_IMAGES and isinstance(parameters, Mapping) and "entry" not in parameters
    if key.startswith("sensor."):
        return section.get("model") in RADIOMETER
    return not key.startswith("optics.") or section.get("provider", "bulk") in BULK
