"""Defaults of former versions, for keys whose default has changed since."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from hcss_twin.providers.registry.registry import OWN_DISTRIBUTION

BAND_MODEL = ("band-model", f"{OWN_DISTRIBUTION}/band-model")

FORMER: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {"0.1": {"atmosphere.coefficients": "lowtran7", "atmosphere.gases.others": "profile"}}
)
"""By version: dotted key and its default."""


def with_former_defaults(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return a raw scenario with the defaults that its key ``defaults`` names, where it has no value of its own."""
    version = data.get("defaults")
    filled = dict(data)
    for key, value in (FORMER.get(version, {}) if isinstance(version, str) else {}).items():
        *sections, last = key.split(".")
        place = filled
        for name in sections:
            inner = place.get(name, {})
            if not isinstance(inner, Mapping):  # reported as a wrong type
                break
            place[name] = place = dict(inner)
        else:
            if applies(key, filled.get("atmosphere", {})):
                place.setdefault(last, value)
    return filled


def applies(key: str, atmosphere: Mapping[str, Any]) -> bool:
    """Whether a key can be given: coefficients belong to ``band-model`` without a file of its own."""
    if key != "atmosphere.coefficients":
        return True
    return atmosphere.get("provider", "band-model") in BAND_MODEL and "file" not in atmosphere.get("parameters", {})
