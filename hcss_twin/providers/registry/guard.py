"""Choice of the wrapper that checks the results of a provider before the engine uses them."""

from __future__ import annotations

from typing import Any

from hcss_twin.core.plugins import OWN_DISTRIBUTION
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.guards.images import GuardedClouds, GuardedElements, GuardedSensor, GuardedVariables
from hcss_twin.providers.registry.guards.spectra import (
    GuardedOptics,
    GuardedRadiance,
    GuardedSea,
    GuardedSurfaces,
    GuardedTransmittance,
)
from hcss_twin.providers.registry.specs import Kind


def was_called(guarded: Any, name: str) -> bool:
    """Whether a checked member of a provider made by :func:`guard` has been called."""
    return name in guarded._called


def guard(entry: Entry, provider: Any, inputs: Any) -> Any:
    """Wrap a provider made by ``Registry.create`` from ``entry`` and ``inputs`` in the wrapper of its kind."""
    # notes of this package's providers already begin with their names
    speaker = "" if entry.distribution == OWN_DISTRIBUTION else f"{entry.kind.human} {entry.name}"
    if entry.kind is Kind.CLOUDS:
        return GuardedClouds(provider, entry.label, speaker, inputs.layer, inputs.grid)
    if entry.kind is Kind.SENSORS:
        return GuardedSensor(provider, entry.label, speaker, inputs)
    if entry.kind is Kind.ELEMENTS:
        return GuardedElements(provider, entry.label, speaker, inputs)
    if entry.kind is Kind.VARIABLES:
        return GuardedVariables(provider, entry.label, speaker, inputs)
    others = {
        Kind.SEA: GuardedSea,
        Kind.OPTICS: GuardedOptics,
        Kind.ATMOSPHERE: GuardedTransmittance,
        Kind.RADIANCE: GuardedRadiance,
        Kind.SURFACES: GuardedSurfaces,
    }
    return others[entry.kind](provider, entry.label, speaker)
