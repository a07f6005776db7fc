"""A plan whose cloud generators are timed while frames are made."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import CloudGenerator
from hcss_twin.scene.plan import Plan


class Clock:
    """Seconds spent so far."""

    def __init__(self) -> None:
        self.seconds = 0.0


class _Timed:
    """A generator that counts its time; all else is the generator's own."""

    def __init__(self, generator: CloudGenerator, clock: Clock) -> None:
        self._generator, self._clock = generator, clock
        self.declares = generator.declares

    def __getattr__(self, name: str) -> Any:
        return getattr(self._generator, name)

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Thickness of a window, as the generator's."""
        start = time.perf_counter()
        try:
            return self._generator.thickness_m(time_s, rows, columns)
        finally:
            self._clock.seconds += time.perf_counter() - start


def with_timed_clouds(plan: Plan, clock: Clock) -> Plan:
    """Return a plan that makes the same frames and counts the time of its cloud generators."""
    generators = tuple(_Timed(generator, clock) for generator in plan.generators)
    return dataclasses.replace(plan, assembly=dataclasses.replace(plan.assembly, generators=generators))
