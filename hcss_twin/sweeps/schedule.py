"""The order of points: one of those that share tables goes first, so that the tables are compiled once."""

from __future__ import annotations

import heapq
import json
from collections.abc import Callable, Iterable, Sequence
from hashlib import sha256
from typing import Generic, TypeVar

from hcss_twin.scenario.scenario import Scenario

_T = TypeVar("_T")

_OF_THE_FIELD = ("coverage", "coverage_mode", "edge_taper", "generator", "parameters")
"""Keys of a cloud layer that say where clouds are, which tables do not know; whether there are any they do."""


def shared_tables(scenario: Scenario) -> str:
    """Return a name that points with the same tables have in common.

    It knows the scenario only and decides nothing but the order of points: where it separates scenes with the same
    tables, or joins others, tables are found or missed by their own key all the same.
    """
    plain = json.loads(scenario.to_json())
    drawn = scenario.sea.waves != "averaged" or scenario.slant.shadows
    for name in ("title", "seed", "output", *(() if drawn else ("image",))):
        del plain[name]
    for layer in plain["clouds"]["layers"]:
        layer["is_there"] = layer["coverage"] > 0.0
        for name in _OF_THE_FIELD:
            del layer[name]
    return sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


class Schedule(Generic[_T]):
    """Things to do, the first of each group before its others.

    Parameters
    ----------
    things : iterable
        In the order wanted.
    group_of : callable
        Name of the group of a thing.
    open_groups : iterable of str
        Groups none of which needs to go first.
    """

    def __init__(
        self, things: Sequence[_T], group_of: Callable[[_T], str], open_groups: Iterable[str] = ()
    ) -> None:
        self._things = things
        self._groups = [group_of(each) for each in things]
        self._open = set(open_groups)
        self._ready: list[int] = []
        self._waiting: dict[str, list[int]] = {}
        for index, group in enumerate(self._groups):
            if group in self._open or group not in self._waiting:
                heapq.heappush(self._ready, index)
                self._waiting.setdefault(group, [])
            else:
                self._waiting[group].append(index)

    def next(self) -> tuple[int, _T] | None:
        """Return the next thing that can be done now, with its index; None if none can."""
        if not self._ready:
            return None
        index = heapq.heappop(self._ready)
        return index, self._things[index]

    def finished(self, index: int, succeeded: bool) -> None:
        """Take note that a thing was done: its group follows, or, if it failed, the next of its group goes first."""
        group = self._groups[index]
        waiting = self._waiting.get(group, [])
        if succeeded:
            self._open.add(group)
        count = len(waiting) if group in self._open else 1
        for follower in waiting[:count]:
            heapq.heappush(self._ready, follower)
        del waiting[:count]
