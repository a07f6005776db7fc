"""Checks of provider results before the engine uses them.

Without them an error in a plugin would cause wrong radiance, or an exception far from its cause. Each wrapper has the
methods of its Protocol. A result of another shape, of a type that is no real number, not finite or out of range, and
any exception that is not deliberate (``HcssError``), becomes a ProviderDefect that names provider, distribution, method
and arguments; deliberate errors of plugins get these names, too. Values are converted to the contract's dtype; rounding
errors at the limits of optical properties are removed. All other attributes are delegated to the provider.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from hcss_twin import providers as api
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError, HcssError, ProviderDefect, ProviderError
from hcss_twin.core.plugins import FAILURES, describe
from hcss_twin.providers.common import FRACTION_TOLERANCE
from hcss_twin.providers.declarations import attributed

ANY = (-float("inf"), float("inf"))
POSITIVE = (0.0, float("inf"))
ABOVE_ZERO = (float(np.nextafter(0.0, 1.0)), float("inf"))
FRACTION = (-FRACTION_TOLERANCE, 1.0 + FRACTION_TOLERANCE)


def _shown(value: Any) -> str:
    """Describe an argument: shapes of arrays, types of objects, numbers as they are."""
    if isinstance(value, np.ndarray):
        return f"of shape {value.shape}"
    if value is None or isinstance(value, int | float | str | slice):
        return f"= {value!r}"
    if isinstance(value, Mapping):
        return f"with {', '.join(f'{name} {_shown(item)}' for name, item in value.items())}"
    if isinstance(value, Sequence):
        return f"of length {len(value)}"
    return f"a {type(value).__name__}"


def _attributing(method: Callable[..., Any]) -> Callable[..., Any]:
    """Add the provider, its member and the arguments to errors of a guarded method."""
    signature, member = inspect.signature(method), method.__name__.removeprefix("_checked_")

    @functools.wraps(method)
    def attributed_call(self: Guard, *arguments: Any, **keywords: Any) -> Any:
        try:
            return method(self, *arguments, **keywords)
        except HcssError as error:
            if error.provider:  # of this provider, or of another one that it uses
                raise
            if type(error) not in (ProviderDefect, ProviderError, CatalogError) or (
                self._own and not isinstance(error, ProviderDefect)
            ):
                error.provider = self._label
                raise
            values = list(signature.bind(self, *arguments, **keywords).arguments.items())[1:]
            given = ", ".join(f"{name} {_shown(value)}" for name, value in values) or "none"
            text = str(error) if isinstance(error, ProviderDefect) else f"{self._label}: {member}(): {error}"
            named = type(error)(f"{text}; arguments: {given}")
            named.provider = self._label
            raise named from (error.__cause__ or error)

    return attributed_call


class Guard:
    """Guarded calls and array checks common to the wrappers of all kinds.

    A method ``_checked_NAME`` replaces the optional method ``NAME`` of the provider. Errors begin with ``label``, and
    notes of the declaration with ``speaker``, unless that is empty.
    """

    def __init__(self, provider: Any, label: str, speaker: str = "") -> None:
        self._provider, self._label, self._speaker = provider, label, speaker
        self._called: set[str] = set()

    def __init_subclass__(cls) -> None:
        for name, member in list(vars(cls).items()):
            if inspect.isfunction(member) and (not name.startswith("_") or name.startswith("_checked_")):
                setattr(cls, name, _attributing(member))

    @property
    def _own(self) -> bool:
        """Whether the provider is of this package: its messages already say whose they are."""
        return not self._speaker

    @property
    def declares(self) -> Any:
        declares: api.Declaration = self._read("declares")
        return attributed(declares, self._speaker) if self._speaker else declares

    def _checked_model_errors(self) -> tuple[api.ModelError, ...]:
        errors = tuple(self._call("model_errors"))
        for error in errors:
            if not isinstance(error, api.ModelError):
                raise self._refuse("model_errors()", "a sequence of ModelError", f"a {type(error).__name__} in it")
        return errors

    def __getattr__(self, name: str) -> Any:
        # copying and unpickling look up attributes before there is a provider
        if name.startswith("__") or name in ("_provider", "_label", "_speaker", "_called"):
            raise AttributeError(name)
        # first, so that hasattr() reflects whether the provider has an optional method
        provided = self._read(name)
        checked = f"_checked_{name}"
        return object.__getattribute__(self, checked) if hasattr(type(self), checked) else provided

    def _read(self, name: str) -> Any:
        try:
            return getattr(self._provider, name)
        except (AttributeError, HcssError):
            raise
        except FAILURES as error:
            raise ProviderDefect(
                f"{self._label}: reading {name} raised {describe(error, type(self._provider).__module__)}"
            ) from error

    def _call(self, name: str, *arguments: Any, **keywords: Any) -> Any:
        self._called.add(name)
        try:
            return getattr(self._provider, name)(*arguments, **keywords)
        except HcssError:
            raise
        except FAILURES as error:
            raise ProviderDefect(
                f"{self._label}: {name}() raised {describe(error, type(self._provider).__module__)}"
            ) from error

    def _refuse(self, what: str, expected: str, got: str) -> ProviderDefect:
        return ProviderDefect(f"{self._label}: {what} broke its contract: expected {expected}, got {got}")

    def _array(
        self,
        what: str,
        value: Any,
        shape: tuple[int, ...],
        limits: tuple[float, float] = ANY,
        dtype: DTypeLike = np.float64,
        kinds: str = "fiu",
    ) -> NDArray[Any]:
        """Return ``value`` as an array of ``dtype`` after checking shape, type, finiteness and range."""
        if isinstance(value, np.ma.MaskedArray):
            raise self._refuse(what, f"a plain array of shape {shape}", "a masked array")
        try:
            array = np.asarray(value)
        except FAILURES as error:
            raise self._refuse(what, f"an array of shape {shape}", describe(error)) from error
        if array.dtype.kind not in kinds:
            numbers = "real" if "f" in kinds else "whole"
            raise self._refuse(what, f"{numbers} numbers of shape {shape}", f"{type(value).__name__} of {array.dtype}")
        if array.shape != shape:
            raise self._refuse(what, f"shape {shape}", f"shape {array.shape}")
        if array.size:
            # minimum and maximum propagate NaN and infinity: two passes and no temporary array
            least, most = float(array.min()), float(array.max())
            if not (np.isfinite(least) and np.isfinite(most)):
                bad = int(np.count_nonzero(~np.isfinite(array)))
                raise self._refuse(what, "finite values", f"{bad} of {array.size} not finite")
            if least < limits[0] or most > limits[1]:
                raise self._refuse(what, f"values in [{limits[0]:g}, {limits[1]:g}]", f"{least:.9g} to {most:.9g}")
        return array.astype(dtype, copy=False)

    def _spectral(
        self,
        name: str,
        shape: tuple[int, ...],
        limits: tuple[float, float],
        wavenumber_cm1: Array,
        *arguments: Any,
        **keywords: Any,
    ) -> Array:
        """Call a method inside its declared spectral range and check its result (*shape, V)."""
        self._check_wavenumbers(name, wavenumber_cm1)
        value = self._call(name, wavenumber_cm1, *arguments, **keywords)
        return self._array(f"{name}()", value, (*shape, wavenumber_cm1.size), limits)

    def _check_wavenumbers(self, name: str, wavenumber_cm1: Array) -> None:
        """Reject wavenumbers outside the declared range: results are never extrapolated."""
        valid = self._provider.declares.valid.get("wavenumber_cm1")
        if valid is None or wavenumber_cm1.size == 0:
            return
        lowest, highest = float(wavenumber_cm1.min()), float(wavenumber_cm1.max())
        if lowest < valid[0] or highest > valid[1]:
            raise ProviderError(
                f"{self._label}: {name}() was asked for {lowest:.6g} to {highest:.6g} cm-1; "
                f"valid are {valid[0]:.6g} to {valid[1]:.6g} cm-1"
            )
