"""Laws as tests of pytest, and failures that an author expects."""

from __future__ import annotations

import inspect
import types
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import pytest

from hcss_twin.core.errors import choose_from
from hcss_twin.testing.laws.law import Inapplicable, Law

_Class = TypeVar("_Class", bound=type)


def holds(*laws: Law) -> Callable[[_Class], _Class]:
    """Add a test for each law to a contract class.

    Parameters of a law are fixtures; ``make`` is the method ``make_provider``, and a parameter with a default the
    attribute of the class of that name.
    """

    def add(contract: _Class) -> _Class:
        for law in laws:
            setattr(contract, f"test_{law.__name__}", law_test(law))
        return contract

    return add


def law_test(law: Law) -> Callable[..., None]:
    """Return a law as a test method, which skips a provider to which it does not apply."""
    own = inspect.signature(law).parameters.values()
    fixtures = [each.name for each in own if each.default is each.empty and each.name != "make"]

    def test(self: Any, *arguments: Any, **keywords: Any) -> None:
        values = dict(zip(fixtures, arguments, strict=False)) | keywords
        for each in own:
            if each.name == "make":
                values["make"] = self.make_provider
            elif each.default is not each.empty:
                values[each.name] = getattr(self, each.name, each.default)
        try:
            law(**values)
        except Inapplicable as why:
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
