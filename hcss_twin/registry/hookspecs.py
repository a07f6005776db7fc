"""The hooks a plugin can implement: each returns a sequence of provider specs, nothing is computed.

A plugin is a module (or object) with functions of these names, marked with ``hookimpl``, and named
by an entry point of the group ``hcss_twin``. A hook is called once per run, without arguments.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import pluggy

from hcss_twin.registry.specs import ProviderSpec

PROJECT = "hcss_twin"
"""Name that ties markers, manager and the entry point group together."""

_Function = TypeVar("_Function", bound=Callable[..., Any])

hookspec: Callable[[_Function], _Function] = pluggy.HookspecMarker(PROJECT)
hookimpl: Callable[[_Function], _Function] = pluggy.HookimplMarker(PROJECT)


@hookspec
def hcss_register_cloud_generators() -> Sequence[ProviderSpec]:
    """Return specs of cloud generators (``providers.CloudGenerator``): fields of cloud thickness."""
    raise NotImplementedError


@hookspec
def hcss_register_sea_models() -> Sequence[ProviderSpec]:
    """Return specs of sea models (``providers.SeaModel``): emissivity and BRDF of the sea surface."""
    raise NotImplementedError


@hookspec
def hcss_register_optics() -> Sequence[ProviderSpec]:
    """Return specs of optics providers (``providers.Optics``): single scattering of cloud particles."""
    raise NotImplementedError


@hookspec
def hcss_register_transmittance_providers() -> Sequence[ProviderSpec]:
    """Return specs of transmittance providers (``providers.TransmittanceProvider``): gas on whole paths."""
    raise NotImplementedError


@hookspec
def hcss_register_radiance_models() -> Sequence[ProviderSpec]:
    """Return specs of radiance models (``providers.RadianceModel``): assembly of the radiance of a column."""
    raise NotImplementedError


@hookspec
def hcss_register_sensors() -> Sequence[ProviderSpec]:
    """Return specs of sensor models (``providers.Sensor``): radiance as a sensor measures it."""
    raise NotImplementedError
