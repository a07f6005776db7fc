"""Discovery of plugins one at a time, so that the errors of one do not affect the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pluggy

from hcss_twin.core.errors import Problem, ProviderError
from hcss_twin.core.plugins import OWN_DISTRIBUTION, Origin, Remark
from hcss_twin.providers.registry import specs
from hcss_twin.providers.registry.specs import API_VERSION, Kind, ProviderSpec
from hcss_twin.version import __version__

if TYPE_CHECKING:
    from hcss_twin.core.result_cache import ResultCache  # imports numpy

__all__ = ["Entry"]


@dataclass(frozen=True)
class Entry:
    """One provider that can be selected."""

    kind: Kind
    spec: ProviderSpec
    origin: Origin

    @property
    def name(self) -> str:
        """Plain name."""
        return self.spec.name

    @property
    def qualified_name(self) -> str:
        """Name that selects this provider even if another distribution uses the same plain name."""
        return f"{self.origin.distribution}/{self.spec.name}"

    @property
    def distribution(self) -> str:
        """Distribution that contains the provider."""
        return self.origin.distribution

    @property
    def version(self) -> str:
        """Version of the distribution."""
        return self.origin.version

    @property
    def is_own(self) -> bool:
        """Whether the provider is of this package."""
        return self.distribution == OWN_DISTRIBUTION

    def code(self, shelf: ResultCache, provider: Any = None) -> tuple[str, ...]:
        """Return what names a provider's code, and the ``cache_token`` of a made one, in keys of cached results."""
        target, parameters = self.spec.target, self.spec.parameters
        targets = (target,) if parameters is None else (target, parameters)
        code = shelf.fingerprint(self.distribution, targets)
        token = getattr(provider, "cache_token", None)
        return (self.qualified_name, self.version, target, code, *(() if token is None else (token,)))

    @property
    def summary(self) -> str:
        """One-line summary."""
        return self.spec.summary

    @property
    def references(self) -> tuple[str, ...]:
        """References of the model."""
        return self.spec.references

    @property
    def label(self) -> str:
        """Label in messages."""
        return f"{self.kind.human} '{self.name}' of {self.origin}"


@dataclass
class Collection:
    """Specs of one plugin, filled hook by hook, so that specs collected before a failure are known."""

    origin: Origin
    specs: list[tuple[Kind, ProviderSpec]] = field(default_factory=list)
    remarks: list[Remark] = field(default_factory=list)

    def take(self, plugin: Any) -> None:
        """Collect the specs of all hooks of a plugin.

        Each plugin has a separate manager, so that no plugin can wrap, reorder or break the hook calls of another.
        Unknown hooks are ignored with a remark, as a plugin may have hooks of later versions.

        Raises
        ------
        ProviderError
            If the plugin has no hook that is known or optional, or returns anything but specs.
        """
        manager = pluggy.PluginManager(specs.PROJECT)
        manager.add_hookspecs(specs)
        manager.register(plugin)
        self._check_names(manager, plugin)
        for kind in Kind:
            caller = getattr(manager.hook, kind.hook)
            implementations = caller.get_hookimpls()
            if not implementations:
                continue
            results = caller()
            # pluggy drops a returned None silently
            if len(results) != len(implementations):
                raise ProviderError(f"hook {kind.hook} returned None; expected a list of ProviderSpec")
            for result in results:
                self._extend(kind, result)
        for _, spec in self.specs:
            if spec.api_version != API_VERSION:
                raise ProviderError(_other_version(spec))

    def _extend(self, kind: Kind, result: object) -> None:
        if not isinstance(result, Sequence) or isinstance(result, str | bytes):
            raise ProviderError(f"hook {kind.hook} returned {type(result).__name__}; expected a list of ProviderSpec")
        for item in result:
            if not isinstance(item, ProviderSpec):
                raise ProviderError(
                    f"hook {kind.hook} returned a list with {type(item).__name__}; expected only ProviderSpec"
                )
            if (kind, item.name) in [(other_kind, other.name) for other_kind, other in self.specs]:
                raise ProviderError(f"hook {kind.hook} returned the name '{item.name}' twice")
            self.specs.append((kind, item))

    def _check_names(self, manager: pluggy.PluginManager, plugin: object) -> None:
        known = [kind.hook for kind in Kind]
        marks = {name: manager.parse_hookimpl_opts(plugin, name) for name in dir(plugin)}
        hooks = {mark.get("specname") or name: mark for name, mark in marks.items() if mark is not None}
        unknown = {
            name: mark["optionalhook"] for name, mark in hooks.items() if name not in (*known, *_OF_OTHER_GROUPS)
        }
        guesses = {name: Problem.closest(name, known) for name, optional in unknown.items() if not optional}
        hints = [f"'{name}'" + (f" (did you mean '{guess}'?)" if guess else "") for name, guess in guesses.items()]
        wrong, all_known = f"unknown hook {', '.join(hints)}", f"; hooks are {', '.join(known)}"
        if not hooks:
            bare = [name for name in dir(plugin) if name.startswith("hcss_register")]
            why = f"; {', '.join(bare)} lacks the @hookimpl mark" if bare else ""
            raise ProviderError(f"no hook found in {plugin!r}{why}{all_known}")
        if not set(hooks) & set(known) and not any(unknown.values()):
            only = "its only hook is hcss_commands: declare it in the entry point group hcss_twin.commands"
            raise ProviderError(wrong + all_known if hints else only)
        if hints:
            later = "; mark a hook of other versions with @hookimpl(optionalhook=True)"
            self.remarks.append(Remark(self.origin, "unknown hook", f"{wrong} is ignored{all_known}{later}"))
        for name, optional in unknown.items():
            if optional:
                text = f"optional hook '{name}' is ignored: hcss_twin {__version__} does not have it"
                self.remarks.append(Remark(self.origin, "optional hook", text))


_OF_OTHER_GROUPS = (specs.hcss_commands.__name__, "hcss_sections")
"""Hooks that other entry point groups read; a module may have them, too."""


def _other_version(spec: ProviderSpec) -> str:
    """Return the message for different API versions."""
    return (
        f"'{spec.name}' is written for version {spec.api_version} of the provider API; hcss_twin {__version__} "
        f"supports version {API_VERSION} (docs/reference/provider-api.md)"
    )
