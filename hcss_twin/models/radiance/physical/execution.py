"""Caching of results by spectrum."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import TypeVar, TypeVarTuple

import numpy as np

from hcss_twin.core.array_memory import weakly
from hcss_twin.core.arrays import Array

_T = TypeVar("_T")
_Arguments = TypeVarTuple("_Arguments")


def cached_by_spectrum(
    function: Callable[[Array, *_Arguments], _T], maxsize: int
) -> Callable[[Array, *_Arguments], _T]:
    """Remember the last results of a function of wavenumbers (V,) and hashable arguments.

    Arrays have no hash, so their bytes are the key; ``function`` receives a read-only copy.
    """
    weak = weakly(function)

    @lru_cache(maxsize=maxsize)
    def from_bytes(wavenumbers: bytes, *args: *_Arguments) -> _T:
        return weak(np.frombuffer(wavenumbers, dtype=np.float64), *args)

    def remembered(wavenumber_cm1: Array, *args: *_Arguments) -> _T:
        return from_bytes(wavenumber_cm1.tobytes(), *args)

    return remembered
