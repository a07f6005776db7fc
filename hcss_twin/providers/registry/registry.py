"""The registry of one run: installed providers, selection by name, construction and checks."""

from __future__ import annotations

import importlib
import importlib.metadata
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from hcss_twin.core.errors import HcssError, ProviderError, choose_from
from hcss_twin.core.own_packages import PROVIDERS, comes_with
from hcss_twin.core.plugins import (
    FAILURES,
    OWN_DISTRIBUTION,
    BrokenPlugin,
    Origin,
    Remark,
    describe,
    installed,
    normalised,
    slow_import,
)
from hcss_twin.providers.registry import defaults
from hcss_twin.providers.registry.discovery import Collection, Entry
from hcss_twin.providers.registry.specs import PROJECT, Kind
from hcss_twin.version import __version__

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hcss_twin.core.catalog import Catalog
    from hcss_twin.physics.profile import Profile
    from hcss_twin.providers.scene import SceneInfo


__all__ = ["Registry"]


class Registry:
    """Providers that can be selected, and broken plugins.

    Each run has its own; there is no global registry. A plugin is registered completely or not at all; its exceptions
    are stored in :attr:`broken` and not propagated. Only metadata of an installed plugin is read until a provider is
    selected by a name that it may have: qualified names, such as those of all defaults, import no other distribution.
    """

    def __init__(self) -> None:
        self._entries: list[Entry] = []
        self._broken: list[BrokenPlugin] = []
        self._remarks: list[Remark] = []
        self._waiting: list[tuple[Origin, importlib.metadata.EntryPoint | BaseException]] = []
        self._lock = threading.RLock()

    @classmethod
    def discover(cls) -> Registry:
        """Return a registry of the defaults and of every installed entry point of group ``hcss_twin``."""
        registry = cls.defaults_only()
        registry._waiting += installed(PROJECT)
        return registry

    @classmethod
    def defaults_only(cls) -> Registry:
        """Return a registry of the defaults alone."""
        registry = cls()
        registry.add(defaults, Origin("defaults", OWN_DISTRIBUTION, __version__))
        return registry

    @staticmethod
    def answers(group: str, *given: Any) -> Iterator[tuple[Origin, tuple[Any, ...], str]]:
        """Call the functions of all packages in an entry point group, none of which is needed.

        Parameters
        ----------
        group : str
            Name of the group.
        *given
            Arguments of each function, which returns an iterable.

        Yields
        ------
        tuple
            Package, what its function returned, and the error if it failed, else empty text.
        """
        for origin, source in installed(group):
            try:
                if isinstance(source, BaseException):
                    raise source
                answer = origin, tuple(source.load()(*given)), ""
            except FAILURES as error:
                answer = origin, (), describe(error)
            yield answer

    def add(self, plugin: object, origin: Origin) -> None:
        """Register an imported plugin module or object."""
        self._register(origin, lambda: plugin)

    def _import_waiting(self, distribution: str = "") -> None:
        """Import the installed plugins of a distribution, by default of all, that have not been imported."""
        with self._lock:
            waiting, self._waiting = self._waiting, []
            for origin, source in waiting:
                if distribution and normalised(origin.distribution) != normalised(distribution):
                    self._waiting.append((origin, source))
                else:
                    begin = time.perf_counter()
                    where = "" if isinstance(source, BaseException) else source.value
                    self._register(origin, _loader(source), where)
                    if not isinstance(source, BaseException):
                        self._remarks += slow_import(origin, source.value, time.perf_counter() - begin)

    def _register(self, origin: Origin, load: Callable[[], object], where: str = "") -> None:
        """Register the plugin that ``load`` returns; a failure is recorded and does not affect others."""
        collection = Collection(origin)
        try:
            collection.take(load())
            self._check_own_duplicates(collection, origin)
        except FAILURES as error:
            text = str(error) if isinstance(error, ProviderError) else describe(error, where)
            offered = tuple((kind, spec.name) for kind, spec in collection.specs)
            self._broken.append(
                BrokenPlugin(origin.entry_point, origin.distribution, origin.version, text, offered, error)
            )
        else:
            self._entries += [Entry(kind, spec, origin) for kind, spec in collection.specs]
            self._remarks += collection.remarks

    def _check_own_duplicates(self, collection: Collection, origin: Origin) -> None:
        taken = {
            (entry.kind, entry.name): entry.origin.entry_point
            for entry in self._entries
            if normalised(entry.distribution) == normalised(origin.distribution)
        }
        for kind, spec in collection.specs:
            if (kind, spec.name) in taken:
                raise ProviderError(
                    f"{kind.human} '{spec.name}' is also registered by the entry point "
                    f"'{taken[kind, spec.name]}' of the same distribution"
                )

    @property
    def broken(self) -> tuple[BrokenPlugin, ...]:
        """Plugins that could not be registered, with their errors."""
        self._import_waiting()
        return tuple(self._broken)

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """Ignored hooks and slow imports of plugins."""
        self._import_waiting()
        return tuple(self._remarks)

    def entries(self, kind: Kind | str | None = None) -> tuple[Entry, ...]:
        """Return every provider, or those of one kind, in the order of kinds, names and distributions."""
        self._import_waiting()
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
        self._import_waiting(distribution)
        matches = [
            entry
            for entry in sorted(self._entries, key=lambda entry: entry.distribution)
            if (entry.kind, entry.name) == (kind, plain)
            and (not separator or normalised(entry.distribution) == normalised(distribution))
        ]
        if len(matches) == 1:
            return matches[0]
        if matches:
            who = " and ".join(str(entry.origin) for entry in matches)
            how = " or ".join(f'"{entry.qualified_name}"' for entry in matches)
            raise ProviderError(
                f"{kind.human} '{name}' is provided by {who}; select one of them by its qualified name: {how}"
            )
        raise self._unknown(kind, name)

    def _unknown(self, kind: Kind, name: str) -> ProviderError:
        distribution, _, plain = name.rpartition("/")
        choices = [entry.qualified_name for entry in self.entries(kind)] if distribution else self.names(kind)
        text = f"no {kind.human} is called '{name}'; {choose_from(name, choices)}"
        suspects = [plugin for plugin in self._broken if (kind, plain) in plugin.offered]
        verb = "It would come from"
        if not suspects:
            suspects = list(self._broken)
            verb = "It might come from"
        ignored = [str(remark) for remark in self._remarks if remark.topic != "slow import"]
        if suspects:
            listed = "; ".join(str(suspect) for suspect in suspects)
            text += f". {verb} an installed plugin that is broken: {listed}"
        if ignored:
            text += f". It might come from a hook that is not used: {'; '.join(ignored)}"
        if not suspects and not ignored:
            text += ". " + (
                comes_with(PROVIDERS, plain)
                or "If it is part of a separate package, install that package into this environment "
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
            If it cannot be imported or is not a pydantic model.
        """
        if entry.spec.parameters is None:
            return None
        from pydantic import BaseModel

        model = _load(entry, entry.spec.parameters)
        if not (isinstance(model, type) and issubclass(model, BaseModel)):
            raise ProviderError(f"{entry.label}: '{entry.spec.parameters}' is no pydantic model")
        return model

    def provider_class(self, entry: Entry) -> Any:
        """Import a provider's class without constructing it; raises ``ProviderError``."""
        return _load(entry, entry.spec.target)

    def bound_profile(self, entry: Entry, parameters: BaseModel | None, catalog: Catalog) -> Profile | None:
        """Return the only profile that a transmittance provider supports; None if it supports any.

        Raises
        ------
        ProviderError
            If its class cannot be imported, or its ``bound_profile`` fails or returns no profile.
        """
        from hcss_twin.physics.profile import Profile

        method = getattr(self.provider_class(entry), "bound_profile", None)
        if method is None:
            return None
        model = self.parameters_model(entry)
        try:
            profile = method(model() if model is not None and parameters is None else parameters, catalog)
        except HcssError:
            raise
        except FAILURES as error:
            raise ProviderError(
                f"{entry.label}: bound_profile() raised {describe(error, entry.spec.target)}"
            ) from error
        if not isinstance(profile, Profile):
            raise ProviderError(f"{entry.label}: bound_profile() returned {type(profile).__name__}; expected Profile")
        return profile

    def create(
        self,
        entry: Entry,
        inputs: Any,
        parameters: BaseModel | Mapping[str, Any] | None = None,
        scene: SceneInfo | None = None,
    ) -> Any:
        """Import a provider's class and construct it as ``Class(inputs, parameters)``.

        Parameters
        ----------
        entry : Entry
            From :meth:`resolve`.
        inputs
            The input dataclass of its kind (``hcss_twin.providers``).
        parameters : BaseModel or mapping, optional
            Instance of its parameter model, or values by name; by default the model's defaults. A provider without a
            parameter model gets None.
        scene : SceneInfo, optional
            For a class with the parameter ``scene``; its logger is replaced by that of the provider.

        Raises
        ------
        ProviderError
            If the class cannot be imported or constructed, or the object is not a provider of its kind. A deliberate
            error (``HcssError``) of its constructor passes unchanged.
        """
        model = self.parameters_model(entry)
        if model is None and parameters is not None:
            raise ProviderError(f"{entry.label} accepts no parameters; got {parameters!r}")
        factory = self.provider_class(entry)
        try:
            if model is not None and (parameters is None or isinstance(parameters, Mapping)):
                parameters = model(**(parameters or {}))
            if model is not None and not isinstance(parameters, model):
                raise ProviderError(
                    f"{entry.label}: parameters are {type(parameters).__name__}; expected {model.__name__}"
                )
            provider = factory(inputs, parameters, **_scene_for(entry, factory, scene))
        except HcssError:
            raise
        except FAILURES as error:
            raise ProviderError(f"{entry.label} cannot be constructed: {describe(error, entry.spec.target)}") from error
        return _checked(entry, provider)

    @staticmethod
    def check_declared(kind: Kind, provider: Any) -> None:
        """Check what a provider declares, as :meth:`create` does: names, ranges, types and variables.

        Raises
        ------
        ValueError
            If a value is not allowed; names it, and what is.
        """
        from hcss_twin.providers import common, declaration_checks, variables

        declaration_checks.check_declaration(provider.declares)
        common.check_options(provider)
        match kind:
            case Kind.SENSORS:
                common.check_measured(provider.variables)
            case Kind.ELEMENTS:
                common.check_element_variables(provider.variables)
            case Kind.SURFACES:
                common.check_surface_classes(provider.classes)
            case Kind.VARIABLES:
                variables.check_output_variables(provider.variables, provider.needs)

    @staticmethod
    def guarded(kind: Kind, provider: Any, inputs: Any, label: str = "the provider") -> Any:
        """Return a provider whose results are checked as in a run: shapes, types, finite values, ranges.

        Its methods raise :class:`ProviderDefect` with ``label`` where a result breaks the contract.

        Parameters
        ----------
        inputs
            Of which the provider was made.
        """
        from hcss_twin.providers.registry.guard import guarded

        return guarded(kind, provider, inputs, label)

    @staticmethod
    def keep_check(entry: Entry, parameters: Any, count: dict[str, int]) -> None:
        """Keep the number of laws of each outcome for the cubes made with this version and parameters of a provider."""
        from hcss_twin.providers.registry.checks import keep_check

        keep_check(entry, parameters, count)

    @staticmethod
    def extensions(group: str) -> dict[str, Any]:
        """Return what packages add besides providers, by name; nothing of a command is imported.

        Parameters
        ----------
        group : str
            Entry point group: ``hcss_twin.sections``, ``hcss_twin.commands`` or ``hcss_twin.light``.

        Returns
        -------
        dict of str to object
            Each has ``origin``, whose ``distribution`` is that of the package, and ``load``; sections and commands have
            their ``spec``.
        """
        from hcss_twin.core.commands import collect
        from hcss_twin.core.plugins import PluginObject
        from hcss_twin.core.sections import plugin_sections

        if group == "hcss_twin.sections":
            return dict(plugin_sections())
        found = installed(group)
        if group == "hcss_twin.commands":
            return dict(collect(found, (), ("atmosphere",))[0])
        entries = [(origin, entry) for origin, entry in found if not isinstance(entry, BaseException)]
        return {entry.name: PluginObject(origin, entry) for origin, entry in entries}


def _scene_for(entry: Entry, factory: Any, scene: SceneInfo | None) -> dict[str, Any]:
    """Return the scene as a keyword argument, if the class of a provider takes it."""
    from hcss_twin.providers.scene import logger_of, takes_scene

    if not takes_scene(factory):
        return {}
    if scene is None:
        raise ProviderError(f"{entry.label} takes the scene (date, place, sun), which is not known here")
    return {"scene": replace(scene, log=logger_of(str(entry.kind), entry.name))}


def _load(entry: Entry, target: str) -> Any:
    module, _, attribute = target.partition(":")
    try:
        return getattr(importlib.import_module(module), attribute)
    except FAILURES as error:
        raise ProviderError(f"{entry.label}: cannot import '{target}': {describe(error, target)}") from error


def _loader(source: importlib.metadata.EntryPoint | BaseException) -> Callable[[], object]:
    def load() -> object:
        if isinstance(source, BaseException):
            raise source
        try:
            return source.load()
        except FAILURES as error:
            raise ProviderError(f"import of '{source.value}' failed: {describe(error, source.value)}") from error

    return load


def _checked(entry: Entry, provider: Any) -> Any:
    """Return a provider after checking that it has the members of its kind."""
    import hcss_twin.providers as providers

    protocol = getattr(providers, entry.kind.protocol)
    expected = getattr(providers, protocol.__annotations__["declares"])
    attributes = set(protocol.__annotations__)
    methods = {name for name, value in vars(protocol).items() if callable(value) and not name.startswith("_")}
    try:
        missing = [name for name in attributes | methods if not hasattr(provider, name)]
        missing += [f"{name}()" for name in methods - set(missing) if not callable(getattr(provider, name))]
        declares = getattr(provider, "declares", None)
    except FAILURES as error:
        raise ProviderError(
            f"{entry.label}: reading its attributes failed: {describe(error, entry.spec.target)}"
        ) from error
    if missing:
        raise ProviderError(
            f"{entry.label}: {type(provider).__name__} lacks {', '.join(sorted(missing))} "
            f"of hcss_twin.providers.{entry.kind.protocol}"
        )
    if not isinstance(declares, expected):
        raise ProviderError(
            f"{entry.label}: declares is {type(declares).__name__}; expected hcss_twin.providers.{expected.__name__}"
        )
    try:
        Registry.check_declared(entry.kind, provider)
    except FAILURES as error:
        raise ProviderError(f"{entry.label}: {error}") from error
    return provider
