"""Checks of what a variable provider returns before it is written; imported only for scenes with such a provider."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin import providers as api
from hcss_twin.providers.registry.guard import _Guard


class GuardedVariables(_Guard):
    """A variable provider whose values are checked, once per part: names, shapes, types, limits."""

    def __init__(self, provider: Any, label: str, speaker: str, inputs: api.VariableInputs) -> None:
        super().__init__(provider, label, speaker)
        self._bands = len(inputs.bands)

    def values(self, fields: Mapping[str, NDArray[Any]], time_s: float) -> dict[str, NDArray[Any]]:
        """Return each variable in its declared type."""
        value = self._call("values", fields, time_s)
        declared: Mapping[str, api.OutputVariable] = self._read("variables")
        if not isinstance(value, Mapping) or set(value) != set(declared):
            got = ", ".join(map(str, value)) or "none" if isinstance(value, Mapping) else type(value).__name__
            raise self._refuse("values()", f"a mapping with the variables {', '.join(declared)}", got)
        shape = next(iter(fields.values())).shape[-2:]
        return {name: self._checked(name, value[name], about, shape) for name, about in declared.items()}

    def _checked(self, name: str, value: Any, about: api.OutputVariable, shape: tuple[int, ...]) -> NDArray[Any]:
        what, shape = f"'{name}' of values()", (self._bands, *shape) if about.per_band else shape
        kinds = "fiu" if about.dtype.startswith("float") else "iub"
        missing = None
        if about.may_be_missing and type(value) is np.ndarray and value.dtype.kind == "f":
            missing = np.isnan(value)
            value = np.where(missing, about.limits[0], value)
        array = self._array(what, value, shape, about.limits, about.dtype, kinds)
        return array if missing is None else np.where(missing, array.dtype.type(np.nan), array)
