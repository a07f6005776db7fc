"""Scenario sections that plugins own, and the image geometry that they may bring: the hook, and its discovery.

A plugin names a module in the entry point group ``hcss_twin.sections``. The module has a function ``hcss_sections``,
marked with ``hookimpl``. It is imported when a scenario has a section that this package does not have, and should
import nothing but this module.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import pluggy

from hcss_twin.core.commands import PROJECT, check_summary, check_target, hookspec
from hcss_twin.core.errors import ProviderError
from hcss_twin.core.plugins import FAILURES, Origin, describe, installed

GROUP = "hcss_twin.sections"

PACKAGES: Mapping[str, str] = {name: "hcss-payload" for name in ("camera", "orbit", "attitude", "jitter")}
"""Packages of this project that own sections, for messages where they are not installed."""


@dataclass(frozen=True)
class SectionSpec:
    """One top-level section of scenarios.

    Attributes
    ----------
    name : str
        Key in scenarios: a Python identifier.
    model : str
        ``"package.module:Model"`` of the pydantic model of its keys; imported only when a scenario has the section.
    summary : str
        One line for the JSON schema.
    imager : str or None
        ``"package.module:function"`` if scenarios with this section have another image geometry than the grid on the
        ground: a function of the scenario and a catalog that returns a :class:`hcss_twin.plan.imager.Imager`.

    Raises
    ------
    ValueError
        If a field is malformed.
    """

    name: str
    model: str
    summary: str
    imager: str | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.isidentifier():
            raise ValueError(f"name {self.name!r}: allowed are letters, digits and underscores")
        check_target("model", self.name, self.model)
        if self.imager is not None:
            check_target("imager", self.name, self.imager)
        check_summary(self.name, self.summary)


@hookspec
def hcss_sections() -> Sequence[SectionSpec]:
    """Return specs of sections that the plugin owns."""
    raise NotImplementedError


@dataclass(frozen=True)
class PluginSection:
    """A section of a plugin."""

    spec: SectionSpec
    origin: Origin

    def load(self, target: str) -> Any:
        """Import the object of a target; raises :class:`ProviderError`."""
        module, _, name = target.partition(":")
        try:
            return getattr(import_module(module), name)
        except FAILURES as error:
            label = f"section '{self.spec.name}' of {self.origin}"
            raise ProviderError(f"{label}: import of '{target}' failed: {describe(error)}") from error


def plugin_sections() -> dict[str, PluginSection]:
    """Return the sections of all installed plugins by name.

    Raises
    ------
    ProviderError
        If a plugin with sections cannot be imported, or two plugins claim the same section.
    """
    known: dict[str, PluginSection] = {}
    for origin, entry_point in installed(GROUP):
        try:
            if isinstance(entry_point, BaseException):
                raise entry_point
            # A manager of its own, so that no plugin can wrap the hook of another.
            manager = pluggy.PluginManager(PROJECT)
            manager.add_hookspecs(sys.modules[__name__])
            manager.register(entry_point.load())
            specs = [spec for result in manager.hook.hcss_sections() for spec in result]
        except FAILURES as error:
            raise ProviderError(f"the sections of {origin} cannot be used: {describe(error)}") from error
        for spec in specs:
            if spec.name in known:
                owners = f"{known[spec.name].origin} and {origin}"
                raise ProviderError(f"section '{spec.name}' is owned by {owners}; allowed: one of them installed")
            known[spec.name] = PluginSection(spec, origin)
    return known


def missing_owner(name: str) -> str | None:
    """Return the message for a section of a package of this project that is not installed; None for other names."""
    package = PACKAGES.get(name)
    if package is None:
        return None
    return f"is a section of {package}, which is not installed; pip install './plugins/{package}' (or pip install {package})"
