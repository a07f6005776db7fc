"""Check of arguments at the public boundary, from the annotations of a function."""

from __future__ import annotations

import builtins
import collections.abc
import inspect
import math
import numbers
import os
import sys
import types
import typing
from collections.abc import Callable, Mapping
from functools import lru_cache, wraps
from typing import Any, TypeVar, cast

from hcss_twin.core.errors import LONGEST, OptionError

__all__ = ["checked"]

_F = TypeVar("_F", bound=Callable[..., Any])


def checked(function: _F) -> _F:
    """Refuse arguments of types that the annotations of a function, or of the fields of a class, do not allow.

    Otherwise a wrong argument fails somewhere inside, with an exception that names neither it nor what is allowed, or
    it is taken for a fault of a file. Numbers of numpy count as numbers, arrays with one axis as sequences; ``bool`` is
    no number. Raises :class:`OptionError`; a missing or unknown argument is a TypeError, as everywhere in Python.
    """
    if isinstance(function, type):
        of_class: Any = function
        of_class.__init__ = _checked(of_class.__init__)
        return function
    return cast("_F", _checked(function))


def _checked(function: Callable[..., Any]) -> Callable[..., Any]:
    label = function.__qualname__.rpartition("<locals>.")[2].removesuffix(".__init__")
    signature, names = inspect.signature(function), inspect.unwrap(function).__globals__

    @lru_cache(2)
    def hints(loaded: bool) -> dict[str, Any]:
        return typing.get_type_hints(function, localns=_Names(names))

    @wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        given = signature.bind(*args, **kwargs).arguments
        allowed = hints("xarray" in sys.modules)
        for name, value in given.items():
            kind = signature.parameters[name].kind
            several = kind in (kind.VAR_POSITIONAL, kind.VAR_KEYWORD)
            if name in allowed and not several and not _fits(value, allowed[name]):
                what = f"{_shown(value)} ({type(value).__name__})"
                raise OptionError(f"{label}: {name}: {what}; allowed: {_words(allowed[name])}")
        return function(*args, **kwargs)

    return call


class _Names(dict[str, Any]):
    """Names in annotations. Those imported for types only may be anything, but for xarray, if others have loaded it."""

    def __init__(self, known: Mapping[str, Any]) -> None:
        super().__init__()
        self._known = known

    def __missing__(self, name: str) -> Any:
        if name in self._known:
            return self._known[name]
        if name == "xr":
            return sys.modules.get("xarray", _NotLoaded)
        return getattr(builtins, name, Any)


class _NotLoaded:
    """In place of xarray: no value can be of its types."""

    class Dataset:
        """As in xarray."""

    class DataArray:
        """As in xarray."""


def _fits(value: Any, hint: Any) -> bool:
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if hint is Any or isinstance(hint, TypeVar | str):
        return True
    if hint is None or hint is type(None):
        return value is None
    if origin in (typing.Union, types.UnionType):
        names_file = isinstance(value, str) and any(map(_is_path, inner))
        return not (names_file and "\0" in value) and any(_fits(value, choice) for choice in inner)
    if origin is typing.Literal:
        return any(type(value) is type(choice) for choice in inner)  # the function knows the closest choice
    if origin is typing.Annotated:
        return _fits(value, inner[0])
    if origin is tuple:
        same = len(inner) == 2 and inner[1] is Ellipsis
        kinds = [inner[0]] * len(value) if same and _is_sequence(value) else inner
        return _is_sequence(value) and len(value) == len(kinds) and all(map(_fits, value, kinds))
    if origin is not None and issubclass(origin, collections.abc.Mapping):
        return isinstance(value, dict if origin is dict else Mapping) and all(
            _fits(name, inner[0]) and _fits(item, inner[1]) for name, item in value.items()
        )
    if origin is not None and issubclass(origin, collections.abc.Iterable) and not _is_array(origin):
        if issubclass(origin, collections.abc.Sequence) or _is_sequence(value):
            return _is_sequence(value) and all(_fits(item, inner[0]) for item in value)
        return isinstance(value, collections.abc.Iterable) and not isinstance(value, str | bytes)
    return _is_of(value, origin or hint)


def _is_of(value: Any, kind: Any) -> bool:
    """Whether a value is of a class, or can take its place."""
    if kind in (int, float):
        number = numbers.Integral if kind is int else numbers.Real
        return not isinstance(value, bool) and isinstance(value, number) and _is_finite(value)
    if kind is bool:
        return isinstance(value, bool) or type(value).__name__ in ("bool", "bool_")
    if _is_array(kind):
        return _is_array(type(value)) or _is_sequence(value) or _is_of(value, float)
    if getattr(kind, "_is_protocol", False):
        return all(hasattr(value, name) for name in vars(kind) if not name.startswith("_"))
    return isinstance(value, kind) if isinstance(kind, type) else True


def _is_finite(value: Any) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number beyond all others
        return False


def _is_sequence(value: Any) -> bool:
    if _is_array(type(value)):
        return bool(value.ndim == 1)
    return isinstance(value, collections.abc.Sequence) and not isinstance(value, str | bytes)


def _is_path(hint: Any) -> bool:
    kind = typing.get_origin(hint) or hint
    return isinstance(kind, type) and issubclass(kind, os.PathLike)


def _is_array(kind: Any) -> bool:
    return getattr(kind, "__module__", "") == "numpy" and kind.__name__ == "ndarray"


_WORDS = {
    str: "text",
    os.PathLike: "a path",
    int: "a whole number",
    float: "a finite number",
    bool: "true or false",
    type(None): "None",
    collections.abc.Callable: "a function",
}


def _words(hint: Any) -> str:
    """Return what an annotation allows, in words."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return " or ".join(dict.fromkeys(map(_words, inner)))
    if origin is typing.Literal:
        return ", ".join(map(repr, inner))
    if origin is typing.Annotated:
        return _words(inner[0])
    kind = origin or hint
    if kind in _WORDS:
        return _WORDS[kind]
    if kind is tuple and inner and inner[-1] is not Ellipsis:
        return f"({', '.join(map(_words, inner))})"
    name = getattr(kind, "__name__", str(kind))
    if isinstance(kind, type) and issubclass(kind, collections.abc.Mapping):
        return "a mapping by name"
    if isinstance(kind, type) and issubclass(kind, collections.abc.Iterable) and inner and not _is_array(kind):
        return f"a sequence of {_words(inner[0])}"
    return f"a {name}"


def _shown(value: Any) -> str:
    try:
        text = " ".join(repr(value).split())
    except Exception:  # of a class of the caller
        text = "a value that cannot be shown"
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
