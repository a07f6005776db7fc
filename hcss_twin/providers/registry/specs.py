"""Kinds of provider, the spec of a provider, and the hooks of plugins.

A plugin is a module (or object) with functions of these names, marked with ``hookimpl``, and named by an entry point of
the group ``hcss_twin``. A hook is called once per run, without arguments, and returns specs: nothing is imported or
computed before a scenario selects a provider.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeVar

import pluggy


class Kind(StrEnum):
    """One swappable kind.

    Attributes
    ----------
    hook : str
        Name of the hook through which providers of this kind are registered.
    human : str
        What people call it, for messages.
    protocol : str
        Name of its Protocol in ``hcss_twin.providers``.
    """

    hook: str
    human: str
    protocol: str

    CLOUDS = "clouds", "hcss_register_cloud_generators", "cloud generator", "CloudGenerator"
    SEA = "sea", "hcss_register_sea_models", "sea model", "SeaModel"
    OPTICS = "optics", "hcss_register_optics", "optics provider", "Optics"
    ATMOSPHERE = (
        "atmosphere",
        "hcss_register_transmittance_providers",
        "transmittance provider",
        "TransmittanceProvider",
    )
    RADIANCE = "radiance", "hcss_register_radiance_models", "radiance model", "RadianceModel"
    SENSORS = "sensors", "hcss_register_sensors", "sensor model", "Sensor"

    def __new__(cls, value: str, hook: str = "", human: str = "", protocol: str = "") -> Kind:
        """Make a member that is the string ``value`` and carries the other three."""
        member = str.__new__(cls, value)
        member._value_ = value
        member.hook = hook
        member.human = human
        member.protocol = protocol
        return member


API_VERSION = 1
"""Version of the provider contract this engine speaks; the same number as ``providers.API_VERSION``."""

_NAME = re.compile(r"[a-z0-9][a-z0-9-]*")
_TARGET = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*", re.ASCII)


@dataclass(frozen=True)
class ProviderSpec:
    """Name and whereabouts of one provider.

    Attributes
    ----------
    name : str
        What a scenario writes to select it: lower-case letters, digits and hyphens.
    target : str
        ``"package.module:Class"``; imported only when a scenario selects the provider.
    parameters : str or None
        ``"package.module:Model"`` of its pydantic parameter model, as lazy as ``target``; None where
        the provider accepts no parameters.
    api_version : int
        Version of the provider contract it was written for, as a literal number.
    summary : str
        One line for ``hcss plugins``.
    references : tuple of str
        Where the model comes from.

    Raises
    ------
    ValueError
        If a field is malformed.
    """

    name: str
    target: str
    parameters: str | None
    api_version: int
    summary: str
    references: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not _NAME.fullmatch(self.name):
            raise ValueError(f"name {self.name!r}: allowed are lower-case letters, digits, and hyphens within")
        _check_target("target", self.name, self.target)
        if self.parameters is not None:
            _check_target("parameters", self.name, self.parameters)
        if not isinstance(self.api_version, int) or isinstance(self.api_version, bool) or self.api_version < 0:
            raise ValueError(f"api_version {self.api_version!r} of '{self.name}': must be a whole number")
        if not isinstance(self.summary, str) or not self.summary.strip() or "\n" in self.summary:
            raise ValueError(f"summary {self.summary!r} of '{self.name}': must be one line of text")
        references = self.references
        if not isinstance(references, tuple) or not all(isinstance(each, str) for each in references):
            raise ValueError(f"references {references!r} of '{self.name}': must be a tuple of strings")


def _check_target(field: str, name: str, value: object) -> None:
    if not isinstance(value, str) or not _TARGET.fullmatch(value):
        raise ValueError(f"{field} {value!r} of '{name}': must look like 'package.module:Class'")


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
