"""Scenario sections of plugins, and the image geometry that they may bring: the hook, and its discovery.

A plugin names a module in the entry point group ``hcss_twin.sections``. Its function ``hcss_sections``, marked with
``hookimpl``, is called when a scenario has a section unknown to this package; it should import nothing but this module.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import pluggy

from hcss_twin.core.commands import PROJECT, hookspec
from hcss_twin.core.errors import ProviderError
from hcss_twin.core.plugins import FAILURES, Origin, describe, installed, naming_plugin


@dataclass(frozen=True)
class SectionSpec:
    """One top-level section of scenarios.

    Attributes
    ----------
    name : str
        Key in scenarios: an identifier.
    model : str
        ``"package.module:Model"`` of the pydantic model of its keys, imported when a scenario has the section.
    summary : str
        One line for the JSON schema.
    rays : str or None
        ``"package.module:function"`` if the section brings another image geometry than the grid on the ground: a
        function of scenario and catalog that returns :class:`hcss_twin.plan.rays.Rays`.
    effect : str or None
        ``"package.module:function"`` if the section lets columns differ from place to place: a function of scenario
        and catalog that returns a :class:`hcss_twin.providers.PointEffect`.
    """

    name: str
    model: str
    summary: str
    rays: str | None = None
    effect: str | None = None


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
            raise ProviderError(f"section '{self.spec.name}' of {self.origin}: {describe(error, target)}") from error

    def make(self, target: str, *given: Any) -> Any:
        """Call the function of a target; an accident in it is a :class:`ProviderDefect`."""
        function = self.load(target)
        with naming_plugin(f"section '{self.spec.name}' of {self.origin}: {target.partition(':')[2]}()", target):
            return function(*given)


def plugin_sections() -> dict[str, PluginSection]:
    """Return the sections of all installed plugins by name; raises :class:`ProviderError` if they cannot be used."""
    known: dict[str, PluginSection] = {}
    for origin, entry_point in installed("hcss_twin.sections"):
        manager = pluggy.PluginManager(PROJECT)  # of its own, so that no plugin can wrap the hook of another
        manager.add_hookspecs(sys.modules[__name__])
        try:
            if isinstance(entry_point, BaseException):
                raise entry_point
            manager.register(entry_point.load())
            for spec in (spec for result in manager.hook.hcss_sections() for spec in result):
                if spec.name in known:
                    raise ProviderError(f"'{spec.name}' is also a section of {known[spec.name].origin}")
                known[spec.name] = PluginSection(spec, origin)
        except FAILURES as error:
            where = "" if isinstance(entry_point, BaseException) else entry_point.value
            raise ProviderError(f"the sections of {origin} cannot be used: {describe(error, where)}") from error
    return known
