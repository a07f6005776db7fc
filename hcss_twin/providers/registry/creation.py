"""From a spec to a living provider: lazy import, construction, and a check of what came out."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from hcss_twin.core.errors import HcssError, ProviderError
from hcss_twin.core.plugins import FAILURES, describe
from hcss_twin.providers.registry.declared import check_declares, check_measured, check_options
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.specs import Kind

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hcss_twin.core.catalog import Catalog
    from hcss_twin.physics.profile import Profile


def parameters_model(entry: Entry) -> type[BaseModel] | None:
    """Import the parameter model of a provider; None where it accepts no parameters.

    Raises
    ------
    ProviderError
        If it cannot be imported or is no pydantic model.
    """
    if entry.spec.parameters is None:
        return None
    from pydantic import BaseModel

    model = _load(entry, entry.spec.parameters)
    if not (isinstance(model, type) and issubclass(model, BaseModel)):
        raise ProviderError(f"{entry.label}: '{entry.spec.parameters}' is no pydantic model")
    return model


def provider_class(entry: Entry) -> Any:
    """Import what a provider is made with, without making it.

    Raises
    ------
    ProviderError
        If it cannot be imported.
    """
    return _load(entry, entry.spec.target)


def bound_profile(entry: Entry, parameters: BaseModel | None, catalog: Catalog) -> Profile | None:
    """Ask a transmittance provider's class for the one profile it belongs to; None if it takes any.

    Raises
    ------
    ProviderError
        If the class cannot be imported, or its ``bound_profile`` fails or returns no profile.
    """
    from hcss_twin.physics.profile import Profile

    ask = getattr(_load(entry, entry.spec.target), "bound_profile", None)
    if ask is None:
        return None
    model = parameters_model(entry)
    try:
        if model is not None and parameters is None:
            parameters = model()
        found = ask(parameters, catalog)
    except HcssError:
        raise
    except FAILURES as error:
        raise ProviderError(f"{entry.label}: bound_profile() raised {describe(error)}") from error
    if not isinstance(found, Profile):
        raise ProviderError(f"{entry.label}: bound_profile() returned {type(found).__name__}; expected Profile")
    return found


def create(entry: Entry, inputs: Any, parameters: BaseModel | None) -> Any:
    """Construct a provider as ``Class(inputs, parameters)`` and check that it is one.

    Raises
    ------
    ProviderError
        As described at :meth:`hcss_twin.providers.registry.Registry.create`.
    """
    model = parameters_model(entry)
    if model is None and parameters is not None:
        raise ProviderError(f"{entry.label} accepts no parameters; got {parameters!r}")
    factory = _load(entry, entry.spec.target)
    try:
        if model is not None and parameters is None:
            parameters = model()
        if model is not None and not isinstance(parameters, model):
            raise ProviderError(f"{entry.label}: parameters are {type(parameters).__name__}; expected {model.__name__}")
        provider = factory(inputs, parameters)
    except HcssError:
        raise
    except FAILURES as error:
        raise ProviderError(f"{entry.label} cannot be constructed: {describe(error)}") from error
    _check(entry, provider)
    return provider


def _load(entry: Entry, target: str) -> Any:
    module, _, attribute = target.partition(":")
    try:
        return getattr(importlib.import_module(module), attribute)
    except FAILURES as error:
        raise ProviderError(f"{entry.label}: cannot import '{target}': {describe(error)}") from error


def _check(entry: Entry, provider: Any) -> None:
    import hcss_twin.providers as providers

    protocol = getattr(providers, entry.kind.protocol)
    attributes = set(protocol.__annotations__)
    methods = {name for name, value in vars(protocol).items() if callable(value) and not name.startswith("_")}
    try:
        missing = [name for name in attributes | methods if not hasattr(provider, name)]
        missing += [f"{name}()" for name in methods - set(missing) if not callable(getattr(provider, name))]
        declares = getattr(provider, "declares", None)
    except FAILURES as error:
        raise ProviderError(f"{entry.label}: reading its attributes failed: {describe(error)}") from error
    if missing:
        raise ProviderError(
            f"{entry.label}: {type(provider).__name__} lacks {', '.join(sorted(missing))} "
            f"of hcss_twin.providers.{entry.kind.protocol}"
        )
    if not isinstance(declares, providers.Declares):
        raise ProviderError(
            f"{entry.label}: declares is {type(declares).__name__}; expected hcss_twin.providers.Declares"
        )
    try:
        check_declares(declares)
        check_options(provider)
        if entry.kind is Kind.SENSORS:
            check_measured(provider.variables)
    except FAILURES as error:
        raise ProviderError(f"{entry.label}: {error}") from error
