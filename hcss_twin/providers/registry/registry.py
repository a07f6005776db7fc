"""The registry of one run: what is installed, what is broken, and who answers to a name."""

from __future__ import annotations

import importlib.metadata
from collections import Counter
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from hcss_twin.core.errors import ProviderError, choose_from
from hcss_twin.core.plugins import FAILURES, OWN_DISTRIBUTION, BrokenPlugin, Origin, describe, installed, normalised
from hcss_twin.providers.registry import creation, defaults
from hcss_twin.providers.registry.discovery import Collection, Entry
from hcss_twin.providers.registry.specs import PROJECT, Kind
from hcss_twin.version import __version__

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hcss_twin.core.catalog import Catalog
    from hcss_twin.physics.profile import Profile


__all__ = ["OWN_DISTRIBUTION", "Kind", "Registry"]


class Registry:
    """Providers that can be selected, and plugins that could not be taken.

    Made anew for each run; there is no global one. A plugin is taken whole or not at all, and
    whatever it raises is kept in :attr:`broken` instead of being propagated.
    """

    def __init__(self) -> None:
        self._entries: list[Entry] = []
        self._broken: list[BrokenPlugin] = []

    @classmethod
    def discover(cls) -> Registry:
        """Return a registry of the defaults and of every installed entry point of group ``hcss_twin``."""
        registry = cls.defaults_only()
        for origin, found in installed(PROJECT):
            registry.add_lazily(origin, _loader(found))
        return registry

    @classmethod
    def defaults_only(cls) -> Registry:
        """Return a registry of the defaults alone."""
        registry = cls()
        registry.add(defaults, Origin("defaults", OWN_DISTRIBUTION, __version__))
        return registry

    def add(self, plugin: object, origin: Origin) -> None:
        """Take a plugin module or object that is imported already."""
        self.add_lazily(origin, lambda: plugin)

    def add_lazily(self, origin: Origin, load: Callable[[], object]) -> None:
        """Take the plugin that ``load`` returns; any failure is recorded and kept from the others."""
        collection = Collection()
        try:
            collection.take(load())
            self._check_own_duplicates(collection, origin)
        except FAILURES as error:
            text = str(error) if isinstance(error, ProviderError) else describe(error)
            offered = tuple((kind, spec.name) for kind, spec in collection.specs)
            self._broken.append(
                BrokenPlugin(origin.entry_point, origin.distribution, origin.version, text, offered, error)
            )
        else:
            self._entries += [Entry(kind, spec, origin) for kind, spec in collection.specs]

    def _check_own_duplicates(self, collection: Collection, origin: Origin) -> None:
        taken = {
            (entry.kind, entry.name): entry.origin.entry_point
            for entry in self._entries
            if normalised(entry.distribution) == normalised(origin.distribution)
        }
        for kind, spec in collection.specs:
            if (kind, spec.name) in taken:
                raise ProviderError(
                    f"{kind.human} '{spec.name}' is also brought by the entry point "
                    f"'{taken[kind, spec.name]}' of the same distribution"
                )

    @property
    def broken(self) -> tuple[BrokenPlugin, ...]:
        """Plugins that could not be taken, with their errors."""
        return tuple(self._broken)

    def entries(self, kind: Kind | str | None = None) -> tuple[Entry, ...]:
        """Return every provider, or those of one kind, in the order of kinds, names and distributions."""
        order = list(Kind)
        wanted = order if kind is None else [Kind(kind)]
        return tuple(
            sorted(
                (entry for entry in self._entries if entry.kind in wanted),
                key=lambda entry: (order.index(entry.kind), entry.name, entry.distribution),
            )
        )

    def names(self, kind: Kind | str) -> tuple[str, ...]:
        """Return the names that select a provider of a kind; qualified where the plain one is ambiguous."""
        entries = self.entries(kind)
        count = Counter(entry.name for entry in entries)
        return tuple(entry.name if count[entry.name] == 1 else entry.qualified_name for entry in entries)

    def resolve(self, kind: Kind | str, name: str) -> Entry:
        """Return the provider of a kind that a plain or qualified (``distribution/name``) name selects.

        Raises
        ------
        ProviderError
            If no provider has the name, or several have it.
        """
        kind = Kind(kind)
        distribution, separator, plain = name.rpartition("/")
        matches = [
            entry
            for entry in self.entries(kind)
            if entry.name == plain and (not separator or normalised(entry.distribution) == normalised(distribution))
        ]
        if len(matches) == 1:
            return matches[0]
        if matches:
            who = " and ".join(str(entry.origin) for entry in matches)
            how = " or ".join(f'"{entry.qualified_name}"' for entry in matches)
            raise ProviderError(
                f"{kind.human} '{name}' is brought by {who}; select one of them by its qualified name: {how}"
            )
        raise self._unknown(kind, name)

    def _unknown(self, kind: Kind, name: str) -> ProviderError:
        distribution, _, plain = name.rpartition("/")
        choices = [entry.qualified_name for entry in self.entries(kind)] if distribution else self.names(kind)
        text = f"no {kind.human} is called '{name}'; {choose_from(name, choices)}"
        suspects = [each for each in self._broken if (kind, plain) in each.offered]
        verb = "It would come from"
        if not suspects:
            suspects = list(self._broken)
            verb = "It might come from"
        if suspects:
            listed = "; ".join(str(each) for each in suspects)
            text += f". {verb} an installed plugin that is broken: {listed}"
        else:
            text += (
                ". If a package of its own brings it, install that package into this environment "
                "(pip install ...); `hcss plugins` shows what is installed"
            )
        error = ProviderError(text)
        error.__cause__ = suspects[0].cause if len(suspects) == 1 else None
        return error

    def parameters_model(self, entry: Entry) -> type[BaseModel] | None:
        """Import the parameter model of a provider; None where it accepts no parameters.

        Raises
        ------
        ProviderError
            If it cannot be imported or is no pydantic model.
        """
        return creation.parameters_model(entry)

    def provider_class(self, entry: Entry) -> Any:
        """Import a provider's class without constructing it; raises ``ProviderError``."""
        return creation.provider_class(entry)

    def bound_profile(self, entry: Entry, parameters: BaseModel | None, catalog: Catalog) -> Profile | None:
        """Return the one profile a transmittance provider belongs to; None if it takes any.

        Raises
        ------
        ProviderError
            If its class cannot be imported or fails to answer.
        """
        return creation.bound_profile(entry, parameters, catalog)

    def create(self, entry: Entry, inputs: Any, parameters: BaseModel | None = None) -> Any:
        """Import a provider's class and construct it as ``Class(inputs, parameters)``.

        Parameters
        ----------
        entry : Entry
            From :meth:`resolve`.
        inputs
            The input dataclass of its kind (``hcss_twin.providers``).
        parameters : BaseModel, optional
            Instance of its parameter model; by default the model's defaults. A provider without a
            parameter model gets None.

        Raises
        ------
        ProviderError
            If the class cannot be imported or constructed, or what it constructs is not a provider of
            its kind. A deliberate error (``HcssError``) of its constructor passes unchanged.
        """
        return creation.create(entry, inputs, parameters)


def _loader(found: importlib.metadata.EntryPoint | BaseException) -> Callable[[], object]:
    def load() -> object:
        if isinstance(found, BaseException):
            raise found
        try:
            return found.load()
        except FAILURES as error:
            raise ProviderError(f"import of '{found.value}' failed: {describe(error)}") from error

    return load
