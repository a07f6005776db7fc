"""The points of a sweep: made and checked, ordered so that tables are compiled once, and computed."""

from __future__ import annotations

import hashlib
import heapq
import json
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any, Generic, TypeVar

from hcss_twin.core.errors import HcssError, Problem, ScenarioError, shown
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.engine.simulate import run
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.scenario.overrides import key_parts
from hcss_twin.scenario.scenario import SWEEP, Scenario
from hcss_twin.sweeps.design import Design

_MAX_RANGES = 5


@dataclass(frozen=True)
class SweepPoint:
    """One scenario of a sweep.

    Attributes
    ----------
    number : int
        From 0, in the order of the design.
    values : mapping
        The swept keys with their values as the scenario has them: SI numbers, text, or what JSON has for others.
    """

    number: int
    values: Mapping[str, Any]
    scenario: Scenario


def points_of(design: Design) -> tuple[SweepPoint, ...]:
    """Make and check every point.

    Raises ScenarioError with the problems of all points, each once, with the points that have it.
    """
    points: list[SweepPoint] = []
    wrong: dict[Problem, list[int]] = {}
    typed: list[Mapping[str, Any]] = []
    cache = ResultCache()
    for number, values in enumerate(design.values()):
        typed.append(values)
        try:
            scenario = Scenario.from_dict(
                design.scenario, {**design.overrides, **values}, base=design.base, origin=design.origin, shelf=cache
            )
        except ScenarioError as error:
            for problem in error.problems:
                wrong.setdefault(problem, []).append(number)
        else:
            plain = json.loads(scenario.to_json())
            points.append(SweepPoint(number, {key: value_at(plain, key) for key in values}, scenario))
    if wrong:
        raise ScenarioError(_described(wrong, typed), design.origin)
    return tuple(points)


def value_at(plain: Mapping[str, Any], key: str) -> Any:
    """Return the value at a dotted key of a scenario in its JSON form; None where there is none."""
    value: Any = plain
    for part in key_parts(key):
        if isinstance(value, list):
            value = value[int(part)] if part.isdecimal() and int(part) < len(value) else None
        else:
            value = value.get(part) if isinstance(value, Mapping) else None
    return value


def digest_of(points: Iterable[SweepPoint]) -> str:
    """Return a hash of what a sweep computes: the keys and the whole scenario of each point, in order."""
    digest = hashlib.sha256()
    for point in points:
        digest.update(json.dumps([point.number, [*point.values]]).encode())
        digest.update(point.scenario.to_json().encode())
    return digest.hexdigest()


def _described(wrong: Mapping[Problem, list[int]], typed: list[Mapping[str, Any]]) -> Iterator[Problem]:
    for problem, numbers in wrong.items():
        if len(numbers) == len(typed):
            yield problem  # of the scenario itself, whatever is swept
            continue
        shared = [
            f"{key} = {shown(value)}"
            for key, value in typed[numbers[0]].items()
            if all(typed[number][key] == value for number in numbers)
        ]
        which = f"point{'s' if len(numbers) > 1 else ''} {ranges(numbers)}"
        yield Problem(problem.field, f"{problem.message} ({', '.join([which, *shared])})")


def ranges(numbers: Iterable[int]) -> str:
    """Write increasing numbers as ``0, 3 to 7, 9``, and not more than a few of them."""
    texts = []
    for _, group in groupby(enumerate(numbers), key=lambda each: each[1] - each[0]):
        members = [number for _, number in group]
        texts.append(f"{members[0]}" if len(members) == 1 else f"{members[0]} to {members[-1]}")
    more = f" and {len(texts) - _MAX_RANGES} more" if len(texts) > _MAX_RANGES else ""
    return ", ".join(texts[:_MAX_RANGES]) + more


OF_ALL_POINTS = ("image.rows", "image.columns", "image.pixel_size", "frames", "bands", "output.variables")
"""Keys that points of one dataset have in common, because its dimensions and coordinates come from them."""


def require_one_layout(design: Design, points: Sequence[SweepPoint]) -> None:
    """Check, before any point is computed, that all of them fit into one dataset.

    Raises ScenarioError naming the key that separates them.
    """
    if design.combine != "product":
        message = "a dataset needs a dimension for each key; allowed: combine = 'product', or no dataset"
        raise ScenarioError([Problem(f"{SWEEP}.combine", message)], design.origin)
    plain = (json.loads(point.scenario.to_json()) for point in points)
    first = next(plain)
    for number, other in enumerate(plain, start=1):
        for key in OF_ALL_POINTS:
            if value_at(other, key) != value_at(first, key):
                message = f"differs between points 0 and {number}; a dataset needs it in common, allowed: no dataset"
                raise ScenarioError([Problem(f"{SWEEP}: {key}", message)], design.origin)


_T = TypeVar("_T")

_OF_THE_FIELD = ("coverage", "coverage_mode", "edge_taper", "generator", "parameters")
"""Keys of a cloud layer that say where clouds are, which tables do not know; whether there are any they do."""


def shared_tables(scenario: Scenario) -> str:
    """Return a name that points with the same tables have in common.

    It uses the scenario only and decides nothing but the order of points: each table has a key of its own.
    """
    plain = json.loads(scenario.to_json())
    drawn = scenario.sea.waves != "averaged" or scenario.slant.shadows
    for name in ("title", "seed", "output", *(() if drawn else ("image",))):
        del plain[name]
    for layer in plain["clouds"]["layers"]:
        layer["is_there"] = layer["coverage"] > 0.0
        for name in _OF_THE_FIELD:
            del layer[name]
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


class Schedule(Generic[_T]):
    """Things to do, in the order given, but the first of each group before its others.

    ``group_of`` names the group of a thing; of ``open_groups`` none needs to go first.
    """

    def __init__(self, things: Sequence[_T], group_of: Callable[[_T], str], open_groups: Iterable[str] = ()) -> None:
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
        """Record that a thing was done: its group follows, or, if it failed, the next of its group goes first."""
        group = self._groups[index]
        waiting = self._waiting.get(group, [])
        if succeeded:
            self._open.add(group)
        count = len(waiting) if group in self._open else 1
        for follower in waiting[:count]:
            heapq.heappush(self._ready, follower)
        del waiting[:count]


@dataclass(frozen=True)
class PointOutcome:
    """What came of computing one point; fields as in :class:`PointRecord`."""

    point: int
    file: str | None = None
    bytes: int | None = None
    sha256: str | None = None
    seconds: float | None = None
    error: str | None = None


def sha256_of(path: Path) -> str:
    """Return the hash of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


DATE = "SOURCE_DATE_EPOCH"
"""Environment variable that fixes the date of creation, and with it every byte of a cube."""


@dataclass(frozen=True)
class PointTask:
    """What a worker needs to know; it is sent to other processes and machines.

    ``path`` is the absolute path of the cube, ``date`` the ``SOURCE_DATE_EPOCH`` of the process that the sweep was
    started in.
    """

    point: int
    scenario: Scenario
    path: str
    date: str | None


def compute(task: PointTask, cache: ResultCache) -> PointOutcome:
    """Compute a point and write its cube; whatever is wrong with the point becomes its error, interrupts excepted.

    The points of one process share ``cache``.
    """
    start, path = time.perf_counter(), Path(task.path)
    certificates: list[Certificate] = []
    outcome = PointOutcome(task.point)
    try:
        with _date(task.date):
            run(make_plan(task.scenario, shelf=cache), path, report=certificates.append)
        failed = [f"certificate {each.lines[0]}" for each in certificates if not each.passed]
        size, digest = path.stat().st_size, sha256_of(path)
        outcome = PointOutcome(task.point, path.name, size, digest, error=failed[-1] if failed else None)
    except ScenarioError as cause:  # what only the plan finds out
        outcome = replace(outcome, error="; ".join(map(str, cause.problems)))
    except HcssError as cause:
        outcome = replace(outcome, error=str(cause))
    except Exception as cause:  # a fault of one point must not end the others
        outcome = replace(outcome, error=f"{type(cause).__name__}: {cause}")
    return replace(outcome, seconds=round(time.perf_counter() - start, 4))


@contextmanager
def _date(fixed: str | None) -> Iterator[None]:
    """Let the process have the date of creation that the sweep was started with."""
    before = os.environ.get(DATE)
    if fixed is not None:
        os.environ[DATE] = fixed
    try:
        yield
    finally:
        if fixed is not None and before is None:
            del os.environ[DATE]
        elif before is not None:
            os.environ[DATE] = before


def compute_here(schedule: Schedule[PointTask]) -> Iterator[PointOutcome]:
    """Yield the outcome of each point."""
    cache = ResultCache()
    while (following := schedule.next()) is not None:
        index, task = following
        outcome = compute(task, cache)
        schedule.finished(index, outcome.error is None)
        yield outcome
