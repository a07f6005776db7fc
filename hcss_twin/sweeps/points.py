"""The points of a sweep: scenarios, all of them checked before the first is computed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.scenario.overrides import key_parts
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.wording import shown
from hcss_twin.shelf import Shelf
from hcss_twin.sweeps.design import Design

_MOST_TOLD = 5


@dataclass(frozen=True)
class Point:
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


def points_of(design: Design) -> tuple[Point, ...]:
    """Make and check every point.

    Raises
    ------
    ScenarioError
        With the problems of all points, each told once, with the points that have it.
    """
    points: list[Point] = []
    wrong: dict[Problem, list[int]] = {}
    typed: list[Mapping[str, Any]] = []
    shelf = Shelf()
    for number, values in enumerate(design.values()):
        typed.append(values)
        try:
            scenario = Scenario.from_dict(
                design.scenario,
                {**design.overrides, **values},
                base=design.base,
                origin=design.origin,
                shelf=shelf,
            )
        except ScenarioError as error:
            for problem in error.problems:
                wrong.setdefault(problem, []).append(number)
        else:
            plain = json.loads(scenario.to_json())
            points.append(Point(number, {key: value_at(plain, key) for key in values}, scenario))
    if wrong:
        raise ScenarioError(_told(wrong, typed), design.origin)
    return tuple(points)


def value_at(plain: Mapping[str, Any], key: str) -> Any:
    """Return what stands at a dotted key of a scenario as JSON holds it; None where there is nothing."""
    found: Any = plain
    for part in key_parts(key):
        if isinstance(found, list):
            found = found[int(part)] if part.isdecimal() and int(part) < len(found) else None
        else:
            found = found.get(part) if isinstance(found, Mapping) else None
    return found


def digest_of(points: Iterable[Point]) -> str:
    """Return a hash of what a sweep computes: the keys and the whole scenario of each point, in order."""
    digest = hashlib.sha256()
    for point in points:
        digest.update(json.dumps([point.number, [*point.values]]).encode())
        digest.update(point.scenario.to_json().encode())
    return digest.hexdigest()


def _told(wrong: Mapping[Problem, list[int]], typed: list[Mapping[str, Any]]) -> Iterator[Problem]:
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
    for _, run in groupby(enumerate(numbers), key=lambda each: each[1] - each[0]):
        members = [number for _, number in run]
        texts.append(f"{members[0]}" if len(members) == 1 else f"{members[0]} to {members[-1]}")
    more = f" and {len(texts) - _MOST_TOLD} more" if len(texts) > _MOST_TOLD else ""
    return ", ".join(texts[:_MOST_TOLD]) + more
