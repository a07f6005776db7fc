"""Bases of the test classes of all kinds: laws as tests, and what all providers have in common."""

from __future__ import annotations

import inspect
import types
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, TypeVar
from unittest import SkipTest

import pytest

from hcss_author.samples import sample_wavenumbers
from hcss_twin import providers
from hcss_twin.laws import laws_of
from hcss_twin.providers import Array, Catalog, Kind, choose_from
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.registry import Registry

_Class = TypeVar("_Class", bound=type)


class NoMaker(NotImplementedError):
    """A test class has no ``make_provider``: it may have a fixture ``provider`` instead, for laws of one instance."""


def holds(kind: Kind) -> Callable[[_Class], _Class]:
    """Add a test for each law of a kind to its contract class, but for those that the class states itself.

    Parameters of a law are fixtures; ``make`` is the method ``make_provider``, and a parameter with a default the
    attribute of the class of that name.
    """

    def add(contract: _Class) -> _Class:
        for name, law in laws_of(kind).items():
            if f"test_{name}" not in vars(contract):
                setattr(contract, f"test_{name}", law_test(law))
        return contract

    return add


def law_test(law: Callable[..., None]) -> Callable[..., None]:
    """Return a law as a test method, which skips a provider to which it does not apply."""
    parameters = inspect.signature(law).parameters.values()
    fixtures = [
        parameter.name for parameter in parameters if parameter.default is parameter.empty and parameter.name != "make"
    ]

    def test(self: Any, *arguments: Any, **keywords: Any) -> None:
        values = dict(zip(fixtures, arguments, strict=False)) | keywords
        for parameter in parameters:
            if parameter.name == "make":
                values["make"] = self.make_provider
            elif parameter.default is not parameter.empty:
                values[parameter.name] = getattr(self, parameter.name, parameter.default)
        try:
            law(**values)
        except (SkipTest, NoMaker) as why:
            pytest.skip(str(why))

    test.__name__ = test.__qualname__ = f"test_{law.__name__}"
    test.__doc__ = law.__doc__
    kinds = inspect.Parameter.POSITIONAL_OR_KEYWORD
    signature = inspect.Signature([inspect.Parameter(name, kinds) for name in ("self", *fixtures)])
    vars(test)["__signature__"] = signature
    return test


def expect_failures(contract: type, expected: Mapping[str, str]) -> None:
    """Mark tests of a contract class that fail by the author's knowledge; one that passes is then a failure.

    Parameters
    ----------
    contract : type
        Only this class is changed, not those that it inherits from.
    expected : mapping of str to str
        The reason by the name of the law, with spaces or underscores.

    Raises
    ------
    ValueError
        If there is no such law.
    """
    laws = [name.removeprefix("test_") for name in dir(contract) if name.startswith("test_")]
    for law, reason in expected.items():
        name = law.replace(" ", "_")
        if name not in laws:
            raise ValueError(f"expected_failures names '{law}'; {choose_from(name, laws)}")
        test = getattr(contract, f"test_{name}")
        copy = types.FunctionType(test.__code__, test.__globals__, test.__name__, test.__defaults__, test.__closure__)
        copy.__dict__.update(vars(test))
        copy.__doc__, copy.__kwdefaults__ = test.__doc__, test.__kwdefaults__
        setattr(contract, f"test_{name}", pytest.mark.xfail(reason=reason, strict=True)(copy))


class ProviderContract:
    """Base of the test classes of all kinds.

    Attributes
    ----------
    expected_failures : mapping of str to str
        Laws that the provider is known to break, with the reason: usually that of the provider's own attribute.
    """

    _kind: ClassVar[Kind]
    expected_failures: ClassVar[Mapping[str, str]] = {}

    def __init_subclass__(cls) -> None:
        expect_failures(cls, vars(cls).get("expected_failures", {}))

    def make_provider(self, inputs: Any) -> Any:
        """Return the provider under test."""
        raise NoMaker("define make_provider(self, inputs)")

    @pytest.fixture
    def provider(self, inputs: Any) -> Any:
        """Provider made from ``inputs``."""
        return self.make_provider(inputs)

    @pytest.fixture
    def questions(self) -> tuple[Any, ...]:
        """Calls with two sets of arguments each, for laws of all kinds; those of each kind are its own."""
        return ()

    def test_declaration_is_sound(self, provider: Any) -> None:
        """Names, ranges and optional attributes are known to the engine."""
        Registry.check_declared(self._kind, provider)

    def _guarded(self, provider: Any, inputs: Any = None) -> Any:
        """Return a provider that checks its results as a run does."""
        return Registry.guarded(self._kind, provider, inputs)


class SpectralContract(ProviderContract):
    """Base of the test classes of providers with spectral results."""

    @pytest.fixture
    def wavenumber_cm1(self, provider: Any) -> Array:
        """Wavenumbers of the calls; override to choose others."""
        return sample_wavenumbers(provider.declares)


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
    broken = [str(plugin) for plugin in registry.broken if plugin.distribution == distribution]
    assert not broken, f"the plugin is broken: {broken}"
    remarks = [remark for remark in registry.remarks if remark.origin.distribution == distribution]
    unknown = [str(remark) for remark in remarks if remark.topic == "unknown hook"]
    assert not unknown, f"the plugin has unknown hooks: {unknown}"
    entry = registry.resolve(kind, f"{distribution}/{name}")
    _assert_has_methods(registry.provider_class(entry), entry)
    model = registry.parameters_model(entry)
    needs_parameters = model is not None and any(
        model_field.is_required() for model_field in model.model_fields.values()
    )
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
