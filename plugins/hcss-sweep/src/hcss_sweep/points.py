"""The points of a sweep: create and check them, order them so that tables are compiled once, and compute them."""

from __future__ import annotations

import hashlib
import heapq
import json
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any, Generic, TypeVar

from hcss_sweep.design import SWEEP, Design, key_parts
from hcss_sweep.sensors import SENSORS, samples_for_one_sky, with_one_sky
from hcss_twin import Scenario, make_plan
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.engine.simulate import run
from hcss_twin.providers import HcssError, Problem, ProviderError, ScenarioError
from hcss_twin.providers.registry.registry import Registry

__all__ = ["ranges", "value_at"]

_MAX_RANGES = 5


@dataclass(frozen=True)
class SweepPoint:
    """One scenario of a sweep, numbered from 0 in the order of the design.

    ``values`` are the swept keys with their values in the scenario: SI numbers, text, or JSON values.
    """

    number: int
    values: Mapping[str, Any]
    scenario: Scenario


def points_of(design: Design) -> tuple[SweepPoint, ...]:
    """Create and check all points; ScenarioError lists each problem once, with its points."""
    scenarios: list[Scenario] = []
    wrong: dict[Problem, list[int]] = {}
    typed: list[Mapping[str, Any]] = []
    cache = ResultCache()
    for number, values in enumerate(design.values()):
        typed.append(values)
        keys, changed = design.keys_of(values)
        where: dict[str, Any] = {"base": design.base, "origin": design.origin, "shelf": cache}
        try:
            scenario = Scenario.from_dict(keys, changed, **where)
            if design.sensors and (samples := samples_for_one_sky(scenario, keys)):
                scenario = Scenario.from_dict(keys, {**changed, **samples}, **where)
            scenarios.append(scenario)
        except ScenarioError as error:
            for problem in error.problems:
                wrong.setdefault(problem, []).append(number)
    if wrong:
        raise ScenarioError(_described(wrong, typed), design.origin)
    if sensors := len(design.sensors):
        groups = (slice(start, start + sensors) for start in range(0, len(scenarios), sensors))
        scenarios = [one for group in groups for one in with_one_sky(scenarios[group])]
    return tuple(
        SweepPoint(number, _values_in(scenario, values), scenario)
        for number, (scenario, values) in enumerate(zip(scenarios, typed, strict=True))
    )


def _values_in(scenario: Scenario, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the swept keys with their values as the scenario has them, and the name of the sensor."""
    plain = json.loads(scenario.to_json())
    return {key: value if key == SENSORS else value_at(plain, key) for key, value in values.items()}


def value_at(plain: Mapping[str, Any], key: str) -> Any:
    """Return the value at a dotted key of a scenario in JSON form; None if missing."""
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
            yield problem  # of the scenario alone, without swept keys
            continue
        shared = [
            f"{key} = {Problem.shown(value)}"
            for key, value in typed[numbers[0]].items()
            if all(typed[number][key] == value for number in numbers)
        ]
        which = f"point{'s' if len(numbers) > 1 else ''} {ranges(numbers)}"
        yield Problem(problem.field, f"{problem.message} ({', '.join([which, *shared])})")


def ranges(numbers: Iterable[int]) -> str:
    """Format increasing numbers as ``0, 3 to 7, 9``, shortened if there are many."""
    texts = []
    for _, group in groupby(enumerate(numbers), key=lambda numbered: numbered[1] - numbered[0]):
        members = [number for _, number in group]
        texts.append(f"{members[0]}" if len(members) == 1 else f"{members[0]} to {members[-1]}")
    more = f" and {len(texts) - _MAX_RANGES} more" if len(texts) > _MAX_RANGES else ""
    return ", ".join(texts[:_MAX_RANGES]) + more


OF_ALL_POINTS = ("image.rows", "image.columns", "image.pixel_size", "frames", "bands", "output.variables")
"""Keys that must be equal for all points of a dataset, because they define its dimensions and coordinates."""


def require_one_layout(design: Design, points: Sequence[SweepPoint]) -> None:
    """Check that all points fit into one dataset; ScenarioError names the key that prevents it."""
    if design.combine != "product":
        message = "a dataset needs a dimension for each key; allowed: combine = 'product', or no dataset"
        raise ScenarioError([Problem(f"{SWEEP}.combine", message)], design.origin)
    plain = (json.loads(point.scenario.to_json()) for point in points)
    first = next(plain)
    for number, other in enumerate(plain, start=1):
        for key in OF_ALL_POINTS:
            if value_at(other, key) != value_at(first, key):
                message = f"differs between points 0 and {number}; a dataset needs one value; allowed: no dataset"
                raise ScenarioError([Problem(f"{SWEEP}: {key}", message)], design.origin)


_T = TypeVar("_T")

_OF_THE_FIELD = ("coverage", "coverage_mode", "edge_taper", "generator", "parameters")
"""Keys that place the clouds of a layer. Radiance tables depend only on whether there are any."""


def shared_tables(scenario: Scenario) -> str:
    """Return a name that is equal for points with the same tables.

    It depends on the scenario only and affects only the order of points, because each table has its own cache key.
    """
    plain = json.loads(scenario.to_json())
    # What is left to the plan may depend on the image: then points with other images are computed apart.
    drawn = scenario.sea.waves != "off" or scenario.slant.shadows != "off"
    for name in ("title", "seed", "output", *(() if drawn else ("image",))):
        del plain[name]
    for layer in plain["clouds"]["layers"]:
        layer["is_there"] = layer["coverage"] > 0.0
        for name in _OF_THE_FIELD:
            del layer[name]
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


def plugin_code(scenarios: Iterable[Scenario]) -> dict[str, str]:
    """Return what names the code of each provider of another package in some scenarios, by its qualified name."""
    registry, cache, found = Registry.discover(), ResultCache(), {}
    chosen = {named for scenario in scenarios for named in scenario.named_providers()}
    for kind, name in sorted(chosen):
        with suppress(ProviderError):  # the points that need it fail
            entry = registry.resolve(kind, name)
            if not entry.is_own:
                found[entry.qualified_name] = hashlib.sha256(repr(entry.code(cache)).encode()).hexdigest()[:12]
    return found


FEWEST_WITH_CURVES = 4
"""Points with the same tables from which on curves of reference columns cost less than columns for each point."""


def points_with_curves(points: Sequence[SweepPoint], groups: Mapping[int, str]) -> set[int]:
    """Return the points whose certificates read reference columns from curves that points with the same tables share.

    The second point of each group solves its columns one by one.
    """
    chosen: set[int] = set()
    members: dict[str, list[SweepPoint]] = {}
    for point in points:
        members.setdefault(groups[point.number], []).append(point)
    for group in members.values():
        if len(group) >= FEWEST_WITH_CURVES:
            chosen |= {point.number for position, point in enumerate(group) if position != 1}
    return chosen


class Schedule(Generic[_T]):
    """Queue in the given order; the rest of a group waits until its first item is done.

    ``group_of`` returns the group of an item; items of ``open_groups`` never wait.
    """

    def __init__(self, things: Sequence[_T], group_of: Callable[[_T], str], open_groups: Iterable[str] = ()) -> None:
        self._things = things
        self._groups = [group_of(thing) for thing in things]
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
        """Return the next available item with its index; None if there is none."""
        if not self._ready:
            return None
        index = heapq.heappop(self._ready)
        return index, self._things[index]

    @property
    def ready(self) -> int:
        """Number of items that are available now."""
        return len(self._ready)

    @property
    def left(self) -> int:
        """Number of items that :meth:`next` has not returned yet."""
        return len(self._ready) + sum(map(len, self._waiting.values()))

    def finished(self, index: int, succeeded: bool) -> None:
        """Record that an item is done: release its group, or, after a failure, let the group's next item go first."""
        group = self._groups[index]
        waiting = self._waiting.get(group, [])
        if succeeded:
            self._open.add(group)
        count = len(waiting) if group in self._open else 1
        for follower in waiting[:count]:
            heapq.heappush(self._ready, follower)
        del waiting[:count]


DIED_TWICE = "the worker processes of both attempts died: out of memory, or killed"
"""Error of a point that ends its process, and again when it is computed alone."""


@dataclass(frozen=True)
class PointOutcome:
    """Outcome of computing one point; fields as in :class:`PointRecord`."""

    point: int
    file: str | None = None
    bytes: int | None = None
    sha256: str | None = None
    seconds: float | None = None
    error: str | None = None
    certified: float | None = None


def certified_share(*units: tuple[float | None, Mapping[str, float] | None]) -> float | None:
    """Return the largest error of the checked pixels of a cube, relative to its accuracy; None if none was checked.

    Given are accuracy and errors of bands in the first unit that has both.
    """
    for asked, errors in units:
        if asked and errors is not None:
            return max(errors.values(), default=0.0) / asked
    return None


def sha256_of(path: Path) -> str:
    """Return the hash of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


DATE = "SOURCE_DATE_EPOCH"
"""Environment variable that sets the creation date, so that cubes are reproducible byte for byte."""


@dataclass(frozen=True)
class PointTask:
    """Task description for a worker; it is sent to other processes and machines.

    ``path`` is the absolute path of the cube, ``date`` the ``SOURCE_DATE_EPOCH`` of the process that started the sweep,
    ``from_curves`` whether the certificate may read its reference columns from curves that points share.
    """

    point: int
    scenario: Scenario
    path: str
    date: str | None
    from_curves: bool = False


def compute(task: PointTask, cache: ResultCache) -> PointOutcome:
    """Compute a point and write its cube; all exceptions except interrupts are recorded as its error.

    The points of one process share ``cache``.
    """
    start, path = time.perf_counter(), Path(task.path)
    certificates: list[Certificate] = []
    outcome = PointOutcome(task.point)
    try:
        with _date(task.date):
            plan = make_plan(task.scenario, shelf=cache)
            path.unlink(missing_ok=True)  # a damaged cube of this sweep, which is no user's file
            run(plan, path, report=certificates.append, from_curves=task.from_curves)
        failed = [f"certificate {certificate.lines[0]}" for certificate in certificates if not certificate.passed]
        size, digest = path.stat().st_size, sha256_of(path)
        outcome = PointOutcome(task.point, path.name, size, digest, error=failed[-1] if failed else None)
        for one in certificates[-1:]:  # an accuracy in kelvin is judged in kelvin
            kelvin = one.requested.kelvin, one.achieved_K or None
            outcome = replace(outcome, certified=certified_share(kelvin, (one.requested.relative, one.achieved)))
    except ScenarioError as cause:  # problems detected only by planning
        outcome = replace(outcome, error="; ".join(map(str, cause.problems)))
    except HcssError as cause:
        outcome = replace(outcome, error=str(cause))
    except Exception as cause:  # the failure of one point must not stop the others
        outcome = replace(outcome, error=f"{type(cause).__name__}: {cause}")
    return replace(outcome, seconds=round(time.perf_counter() - start, 4))


@contextmanager
def _date(fixed: str | None) -> Iterator[None]:
    """Give the process the creation date of the sweep."""
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
    cache = ResultCache(several=True)
    while (following := schedule.next()) is not None:
        index, task = following
        outcome = compute(task, cache)
        schedule.finished(index, outcome.error is None)
        yield outcome
