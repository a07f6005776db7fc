"""Whether an installed plugin can be found, selected and configured."""

from __future__ import annotations

from hcss_twin import providers
from hcss_twin.catalog import Catalog
from hcss_twin.registry import Entry, Kind, Registry


def assert_registered(kind: Kind | str, name: str, distribution: str) -> Entry:
    """Assert that a provider is discovered, its class and parameter model import, and the model is sound.

    Parameters
    ----------
    kind : Kind or str
        ``"clouds"``, ``"sea"``, ``"optics"``, ``"atmosphere"`` or ``"radiance"``.
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
    entry = registry.resolve(kind, f"{distribution}/{name}")
    made = registry.provider_class(entry)
    methods = [
        name for name, value in vars(getattr(providers, entry.kind.protocol)).items() if callable(value)
    ]
    missing = [
        name for name in methods if not name.startswith("_") and not callable(getattr(made, name, None))
    ]
    assert not missing, f"{entry.spec.target} lacks {missing}"
    model = registry.parameters_model(entry)
    if entry.kind is Kind.ATMOSPHERE and (
        model is None or not any(f.is_required() for f in model.model_fields.values())
    ):
        registry.bound_profile(entry, None, Catalog())  # where it has one, it must be a profile
    if model is not None:
        assert model.model_config.get("extra") == "forbid", "parameters: misspelt keys must be refused"
        assert model.model_config.get("frozen"), "parameters: must be immutable"
        bare = [key for key, field in model.model_fields.items() if not field.description]
        assert not bare, f"parameters without description: {bare}"
    return entry
