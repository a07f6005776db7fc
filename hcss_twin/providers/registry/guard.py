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


def guarded(kind: Kind, provider: Any, inputs: Any, label: str, speaker: str = "") -> Any:
    """Wrap a provider made from ``inputs`` in the wrapper of its kind.

    Errors begin with ``label``, and notes of the declaration with ``speaker``, unless that is empty.
    """
    if kind is Kind.CLOUDS:
        return GuardedClouds(provider, label, speaker, inputs.layer, inputs.grid)
    if kind is Kind.SENSORS:
        return GuardedSensor(provider, label, speaker, inputs)
    if kind is Kind.ELEMENTS:
        return GuardedElements(provider, label, speaker, inputs)
    if kind is Kind.VARIABLES:
        return GuardedVariables(provider, label, speaker, inputs)
    others = {
        Kind.SEA: GuardedSea,
        Kind.OPTICS: GuardedOptics,
        Kind.ATMOSPHERE: GuardedTransmittance,
        Kind.RADIANCE: GuardedRadiance,
        Kind.SURFACES: GuardedSurfaces,
    }
    return others[kind](provider, label, speaker)


def guard(entry: Entry, provider: Any, inputs: Any) -> Any:
    """Wrap a provider made by ``Registry.create`` from ``entry`` and ``inputs``; its messages name it."""
    # notes of this package's providers already begin with their names
    speaker = "" if entry.distribution == OWN_DISTRIBUTION else f"{entry.kind.human} {entry.name}"
    return guarded(entry.kind, provider, inputs, entry.label, speaker)
