"""Few calls of a transmittance provider that knows paths only: all paths of many columns in one call.

Which paths a column needs depends on its geometry alone. A rehearsal at one wavenumber, with a gas that takes note of
the paths it is asked for, finds them; one call then computes them, and the columns find their values ready. A provider
with ``absorber_amounts`` is called so rarely that this would not pay.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.air import Air
from hcss_twin.models.radiance.physical.columns import SceneColumns
from hcss_twin.physics.paths import Path
from hcss_twin.providers import TransmittanceProvider

GATHERS = True
"""Whether paths are gathered; benchmarks compare with one call for each leg."""

MOST_VALUES = 2**23
"""Transmittances in memory (64 MB)."""

BLOCKS = 4
"""Blocks of wavenumbers that a thread-safe provider is asked for at once; the same for any number of processors."""

_T = TypeVar("_T")


def gathers(provider: TransmittanceProvider) -> bool:
    """Whether a provider is asked for the paths of many columns at once."""
    return GATHERS and not hasattr(provider, "absorber_amounts") and provider.declares.legs == "any"


class GatheredGas:
    """A transmittance provider that remembers paths.

    Parameters
    ----------
    provider : TransmittanceProvider
        May declare ``thread_safe = True``: then blocks of wavenumbers are computed by several threads.
    """

    def __init__(self, provider: TransmittanceProvider) -> None:
        self.declares = provider.declares
        self._provider = provider
        self._threads = getattr(provider, "thread_safe", False)
        self._known: dict[bytes, dict[Path, Array]] = {}

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V), remembered or computed."""
        known = self._known.get(wavenumber_cm1.tobytes(), {})
        missing = [path for path in dict.fromkeys(paths) if path not in known]
        if missing:
            known = known | dict(zip(missing, self._ask(wavenumber_cm1, missing), strict=True))
        return np.stack([known[path] for path in paths]) if paths else np.empty((0, wavenumber_cm1.size))

    def learn(self, wavenumber_cm1: Array, paths: Iterable[Path]) -> None:
        """Compute and remember paths, in one call; others are forgotten if memory would be short."""
        key = wavenumber_cm1.tobytes()
        known = self._known.get(key, {})
        missing = [path for path in paths if path not in known]
        if not missing:
            return
        held = sum(len(of_path) * len(spectrum) // 8 for spectrum, of_path in self._known.items())
        if held + len(missing) * wavenumber_cm1.size > MOST_VALUES:
            self._known.clear()
            missing = list(paths)
        values = self._ask(wavenumber_cm1, missing)
        self._known.setdefault(key, {}).update(zip(missing, values, strict=True))

    def _ask(self, wavenumber_cm1: Array, paths: list[Path]) -> Array:
        if not self._threads or wavenumber_cm1.size < BLOCKS:
            return self._provider.transmittance(wavenumber_cm1, paths)
        blocks = np.array_split(wavenumber_cm1, BLOCKS)
        with ThreadPoolExecutor(min(os.cpu_count() or 1, BLOCKS)) as pool:
            return np.concatenate(
                list(pool.map(lambda block: self._provider.transmittance(block, paths), blocks)), axis=1
            )


class Rehearsal:
    """A gas that takes note of the paths it is asked for, in place of ``provider``, at the first wavenumber."""

    def __init__(self, provider: TransmittanceProvider, air: Air) -> None:
        self.declares = provider.declares
        self._own = air.with_gas(self)
        self.paths: dict[Path, None] = {}

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return any values that decrease with the number of legs."""
        self.paths.update(dict.fromkeys(paths))
        legs = np.array([len(path.legs) for path in paths], dtype=np.float64)
        return np.repeat(0.9 ** legs[:, None], wavenumber_cm1.size, axis=1)

    def columns(self, columns: SceneColumns) -> SceneColumns:
        """Return columns in this gas at their first wavenumber."""
        count = columns.count
        return replace(
            columns,
            air=self._own,
            slabs=tuple(first_wavenumber(slab, count) for slab in columns.slabs),
            sea=first_wavenumber(columns.sea, count),
            sea_source=_first(columns.sea_source, count),
            space=_first(columns.space, count),
            received=_first(columns.received, count),
        )


def first_wavenumber(properties: _T, columns: int) -> _T:
    """Return a dataclass whose arrays (..., S) are cut to the first wavenumber of each of C columns, (..., C)."""
    values = {field.name: getattr(properties, field.name) for field in fields(properties)}  # type: ignore[arg-type]
    arrays = {name: _first(value, columns) for name, value in values.items() if isinstance(value, np.ndarray)}
    return replace(properties, **arrays)  # type: ignore[type-var]


def _first(values: Any, columns: int) -> Array:
    result: Array = values[..., :: max(values.shape[-1] // columns, 1)]
    return result
