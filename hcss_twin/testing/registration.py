"""Check that an installed plugin can be discovered, selected and configured."""

from __future__ import annotations

from typing import Any

from hcss_twin import providers
from hcss_twin.core.catalog import Catalog
from hcss_twin.providers.registry import Entry, Kind, Registry


def assert_registered(kind: Kind | str, name: str, distribution: str) -> Entry:
    """Assert that a provider is discovered, its class and parameter model import, and the model is sound.

    Parameters
    ----------
    kind : Kind or str
        ``"clouds"``, ``"sea"``, ``"optics"``, ``"atmosphere"``, ``"radiance"``, ``"elements"``, ``"surfaces"``,
        ``"variables"`` or ``"sensors"``.
    name, distribution : str
        The provider's name and that of the installed distribution.

    Returns
    -------
    Entry
        For further tests, for example with ``Registry.create``.
    """
    registry = Registry.discover()
    broken = [str(each) for each in registry.broken if each.distribution == distribution]
    assert not broken, f"the plugin is broken: {broken}"
    remarks = [each for each in registry.remarks if each.origin.distribution == distribution]
    unknown = [str(each) for each in remarks if each.topic == "unknown hook"]
    assert not unknown, f"the plugin has unknown hooks: {unknown}"
    entry = registry.resolve(kind, f"{distribution}/{name}")
    _assert_has_methods(registry.provider_class(entry), entry)
    model = registry.parameters_model(entry)
    needs_parameters = model is not None and any(each.is_required() for each in model.model_fields.values())
    if entry.kind is Kind.ATMOSPHERE and not needs_parameters:
        registry.bound_profile(entry, None, Catalog())  # where it has one, it must be a profile
    if model is not None:
        assert model.model_config.get("extra") == "forbid", "parameters: misspelt keys must be refused"
        assert model.model_config.get("frozen"), "parameters: must be immutable"
        bare = [key for key, field in model.model_fields.items() if not field.description]
        assert not bare, f"parameters without description: {bare}"
    return entry


def _assert_has_methods(provider: Any, entry: Entry) -> None:
    protocol = vars(getattr(providers, entry.kind.protocol))
    wanted = [name for name, value in protocol.items() if callable(value) and not name.startswith("_")]
    missing = [name for name in wanted if not callable(getattr(provider, name, None))]
    assert not missing, f"{entry.spec.target} lacks {missing}"
