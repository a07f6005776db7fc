"""Description of providers that is read before they are imported: kinds, specs and hooks.

A plugin is a module (or object) with functions named like the hooks and marked with ``hookimpl``; an entry point of
the group ``hcss_twin`` names it. Each hook returns a sequence of specs; it is called once per run, without arguments.
Commands for ``hcss`` have a hook and an entry point group of their own (:mod:`hcss_twin.core.commands`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from hcss_twin.core.commands import PROJECT, check_name, check_summary, check_target, hcss_commands, hookimpl, hookspec

__all__ = ["API_VERSION", "PROJECT", "Kind", "ProviderSpec", "hcss_commands", "hookimpl"]


class Kind(StrEnum):
    """A kind of provider.

    Attributes
    ----------
    hook : str
        Name of the hook through which providers of this kind are registered.
    human : str
        Name in messages.
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
    ELEMENTS = "elements", "hcss_register_elements", "element provider", "ElementProvider"
    SURFACES = "surfaces", "hcss_register_surfaces", "surface provider", "SurfaceProvider"
    VARIABLES = "variables", "hcss_register_variables", "variable provider", "VariableProvider"
    SENSORS = "sensors", "hcss_register_sensors", "sensor model", "Sensor"

    def __new__(cls, value: str, hook: str = "", human: str = "", protocol: str = "") -> Kind:
        """Create a member with string value ``value`` and the other three as attributes."""
        member = str.__new__(cls, value)
        member._value_ = value
        member.hook = hook
        member.human = human
        member.protocol = protocol
        return member


API_VERSION = 3
"""Version of the provider API: the only one that the engine accepts."""


@dataclass(frozen=True)
class ProviderSpec:
    """Name and location of one provider.

    Attributes
    ----------
    name : str
        Name in scenarios: lower-case letters, digits and hyphens.
    target : str
        ``"package.module:Class"``; imported only when a scenario selects the provider.
    parameters : str or None
        ``"package.module:Model"`` of its pydantic parameter model, imported as late as ``target``; None if the
        provider accepts no parameters.
    api_version : int
        Version of the provider contract it was written for, as a literal number.
    summary : str
        One line for ``hcss plugins``.
    references : tuple of str
        References of the model.

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
        check_name(self.name)
        check_target("target", self.name, self.target)
        if self.parameters is not None:
            check_target("parameters", self.name, self.parameters)
        if not isinstance(self.api_version, int) or isinstance(self.api_version, bool) or self.api_version < 0:
            raise ValueError(f"api_version {self.api_version!r} of '{self.name}': must be a whole number")
        check_summary(self.name, self.summary)
        references = self.references
        if not isinstance(references, tuple) or not all(isinstance(reference, str) for reference in references):
            raise ValueError(f"references {references!r} of '{self.name}': must be a tuple of strings")


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
def hcss_register_elements() -> Sequence[ProviderSpec]:
    """Return specs of element providers (``providers.ElementProvider``): things besides clouds and sea."""
    raise NotImplementedError


@hookspec
def hcss_register_surfaces() -> Sequence[ProviderSpec]:
    """Return specs of surface providers (``providers.SurfaceProvider``): maps of sea, land and ice."""
    raise NotImplementedError


@hookspec
def hcss_register_variables() -> Sequence[ProviderSpec]:
    """Return specs of variable providers (``providers.VariableProvider``): derived output variables."""
    raise NotImplementedError


@hookspec
def hcss_register_sensors() -> Sequence[ProviderSpec]:
    """Return specs of sensor models (``providers.Sensor``): radiance as a sensor measures it."""
    raise NotImplementedError
