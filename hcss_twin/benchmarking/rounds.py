"""Times of several things that take turns, and their ratios within a round."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import TypeVar

_T = TypeVar("_T")


class Rounds:
    """Seconds of named things, round by round.

    The speed of a machine that others use drifts: things that take turns meet the same machine, and a ratio is that
    of one round. What is told of all rounds is the median.
    """

    def __init__(self) -> None:
        self._seconds: dict[str, list[float]] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """What was timed, in the order of its first time."""
        return tuple(self._seconds)

    def time(self, name: str, call: Callable[[], _T]) -> _T:
        """Call, and count the seconds as one round's of ``name``."""
        start = time.perf_counter()
        result = call()
        self.add(name, time.perf_counter() - start)
        return result

    def add(self, name: str, seconds: float) -> None:
        """Count seconds that were taken otherwise."""
        self._seconds.setdefault(name, []).append(seconds)

    def last(self, name: str) -> float:
        """Seconds of its last round."""
        return self._seconds[name][-1]

    def seconds(self, name: str) -> float:
        """Median over rounds."""
        return statistics.median(self._seconds[name])

    def ratio(self, above: str, below: str) -> float:
        """Median of the time of one over that of another, of the rounds that have both.

        What takes long may be timed in the first rounds only.
        """
        pairs = zip(self._seconds[above], self._seconds[below], strict=False)
        return statistics.median(one / other for one, other in pairs)

    def shortest(self, name: str) -> float:
        """Shortest time of all rounds."""
        return min(self._seconds[name])

    def shortest_ratio(self, above: str, below: str) -> float:
        """Shortest time of one over that of another: what is left where others take much of the machine."""
        return self.shortest(above) / self.shortest(below)
