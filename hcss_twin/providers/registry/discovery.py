"""Discovery of plugins one at a time, so that the errors of one do not affect the others."""

from __future__ import annotations

import importlib.metadata
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import pluggy

from hcss_twin.core.errors import ProviderError, closest
from hcss_twin.providers.registry import specs
from hcss_twin.providers.registry.specs import API_VERSION, Kind, ProviderSpec
from hcss_twin.version import __version__

OWN_DISTRIBUTION = "hcss-twin"
"""Distribution that brings the defaults."""

FAILURES = (Exception, SystemExit)
"""Exceptions of a plugin that are reported and not propagated; a user's interrupt is not among them."""


@dataclass(frozen=True)
class Origin:
    """Where a plugin comes from."""

    entry_point: str
    distribution: str
    version: str

    def __str__(self) -> str:
        return f"{self.distribution} {self.version}".strip()


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
        """Name that selects this provider even if another distribution uses the plain one."""
        return f"{self.origin.distribution}/{self.spec.name}"

    @property
    def distribution(self) -> str:
        """Distribution that brings it."""
        return self.origin.distribution

    @property
    def version(self) -> str:
        """Version of the distribution."""
        return self.origin.version

    @property
    def summary(self) -> str:
        """One line about it."""
        return self.spec.summary

    @property
    def references(self) -> tuple[str, ...]:
        """Where the model comes from."""
        return self.spec.references

    @property
    def label(self) -> str:
        """How messages call it."""
        return f"{self.kind.human} '{self.name}' of {self.origin}"


@dataclass(frozen=True)
class BrokenPlugin:
    """A plugin that could not be registered.

    Attributes
    ----------
    entry_point, distribution, version : str
        Where it comes from.
    error : str
        What went wrong.
    offered : tuple of (Kind, str)
        Names of its providers, as far as they are known.
    cause : BaseException or None
        The error itself, to raise from.
    """

    entry_point: str
    distribution: str
    version: str
    error: str
    offered: tuple[tuple[Kind, str], ...] = ()
    cause: BaseException | None = field(default=None, compare=False, repr=False)

    def __str__(self) -> str:
        return f"{self.distribution} {self.version} (entry point '{self.entry_point}'): {self.error}"


def describe(error: BaseException) -> str:
    """Name an exception in one line."""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def normalised(distribution: str) -> str:
    """Return the form in which distribution names are compared (PEP 503)."""
    return re.sub(r"[-_.]+", "-", distribution).lower()


def installed() -> Iterator[tuple[Origin, importlib.metadata.EntryPoint | BaseException]]:
    """Yield each entry point of the group ``hcss_twin``, or the error of reading it.

    Distributions are read one by one, because a single malformed ``entry_points.txt`` makes
    ``importlib.metadata.entry_points()`` fail for all. Of a distribution that lies twice on the
    path the first counts, as for imports.
    """
    seen: set[str] = set()
    for distribution in importlib.metadata.distributions():
        try:
            text = distribution.read_text("entry_points.txt")
        except FAILURES:
            continue  # unreadable metadata of a package that may have nothing to do with this one
        if not text or specs.PROJECT not in text:
            continue
        name, version = _identity(distribution)
        if normalised(name) in seen:
            continue
        seen.add(normalised(name))
        try:
            selected = distribution.entry_points.select(group=specs.PROJECT)
            entry_points = sorted(selected, key=lambda each: each.name)
        except FAILURES as error:
            yield Origin("entry_points.txt", name, version), error
            continue
        for entry_point in entry_points:
            yield Origin(entry_point.name, name, version), entry_point


def _identity(distribution: importlib.metadata.Distribution) -> tuple[str, str]:
    try:
        metadata = distribution.metadata
        return str(metadata["Name"] or "unnamed-distribution"), str(metadata["Version"] or "(no version)")
    except FAILURES:
        return "unnamed-distribution", "(no version)"


@dataclass
class Collection:
    """Specs of one plugin, filled hook by hook, so that after a failure it is known what came before."""

    specs: list[tuple[Kind, ProviderSpec]] = field(default_factory=list)

    def take(self, plugin: Any) -> None:
        """Collect the specs of all hooks of a plugin.

        A manager of its own for every plugin means that no plugin can wrap, reorder or break the
        hook calls of another.

        Raises
        ------
        ProviderError
            If the plugin has no hook, a misspelt one, or returns something else than specs.
        """
        manager = pluggy.PluginManager(specs.PROJECT)
        manager.add_hookspecs(specs)
        manager.register(plugin)
        _check_names(manager, plugin)
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


def _other_version(spec: ProviderSpec) -> str:
    """Say whose turn it is when plugin and engine speak different versions."""
    newer = spec.api_version > API_VERSION
    remedy = (
        f"upgrade hcss-twin, or install a release of the plugin for version {API_VERSION}"
        if newer
        else f"install a newer release of the plugin; its author runs the conformance kit (hcss_twin.testing), mends "
        f"what it finds, and writes api_version={API_VERSION} (docs/provider-api.md)"
    )
    draft = ", the draft before version 1," if spec.api_version == 0 else ""
    return (
        f"'{spec.name}' is written for version {spec.api_version} of the provider API{draft} and this hcss_twin "
        f"{__version__} speaks version {API_VERSION}: {remedy}"
    )


def _check_names(manager: pluggy.PluginManager, plugin: object) -> None:
    known = [kind.hook for kind in Kind]
    implemented = [name for name in dir(plugin) if manager.parse_hookimpl_opts(plugin, name) is not None]
    try:
        manager.check_pending()
    except pluggy.PluginValidationError as error:
        wrong = [name for name in implemented if name not in known]
        guesses = {name: closest(name, known) for name in wrong}
        hints = [f"'{name}'" + (f" (did you mean '{guess}'?)" if guess else "") for name, guess in guesses.items()]
        raise ProviderError(f"unknown hook {', '.join(hints)}; hooks are {', '.join(known)}") from error
    if not implemented:
        bare = [name for name in dir(plugin) if name.startswith("hcss_register")]
        why = f"; {', '.join(bare)} lacks the @hookimpl mark" if bare else ""
        raise ProviderError(f"no hook found in {plugin!r}{why}; hooks are {', '.join(known)}")
