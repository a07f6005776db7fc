"""Targets of a draw: how many, where, how they move and how strong they are, as tracks of the scenario.

Their physics is that of the provider ``point-sources``: a plume of an intensity, or a body of a temperature and an
area. With a strength by SCR, the intensity follows from the image (:mod:`hcss_dataset.rendering`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_dataset.words import drawn
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Problem, ScenarioError

if TYPE_CHECKING:
    from hcss_dataset.distribution import Check, Distribution

KEYS = ("count", "empty", "margin", "separation", "altitude", "speed", "heading", "climb", "strength")
STRENGTHS = {
    "scr": ("scr", "by_band", "intensity_max"),
    "intensity": ("intensity", "by_band"),
    "temperature": ("temperature", "area", "emissivity"),
}
MAX_TARGETS = 10_000
_PLACES = 1000
"""Places that may be tried for the targets of a draw until they are far enough apart."""
DIGITS = 12
EMPTY_BLOCK = 20
"""Consecutive draws that have the wanted share of draws without targets."""


@dataclass(frozen=True)
class Target:
    """A target on a straight track, and its strength.

    Attributes
    ----------
    track : int
        Number in its sequence, from 1.
    row, column : float
        Place in the image in the first frame; pixel n extends from n to n + 1.
    position_m, velocity_m_s : (float, float, float)
        East and north of the image centre and altitude at the start, and their change.
    intensity : mapping of str to float, optional
        Of a plume, W sr-1 by band; with ``scr`` for one W sr-1 in the band with the largest share.
    scr : float, optional
        Wanted in the first frame, in the label band.
    """

    track: int
    row: float
    column: float
    position_m: tuple[float, float, float]
    velocity_m_s: tuple[float, float, float]
    intensity: Mapping[str, float] | None = None
    scr: float | None = None
    intensity_max: float = math.inf
    temperature_K: float | None = None
    area_m2: float | None = None
    emissivity: float = 1.0

    @property
    def kind(self) -> str:
        """``plume`` or ``body``."""
        return "plume" if self.temperature_K is None else "body"

    def brighter(self, factor: float) -> Target:
        """Return the same plume with another intensity, rounded as it is written."""
        assert self.intensity is not None
        return replace(self, intensity={band: rounded(factor * value) for band, value in self.intensity.items()})

    def at(self, time_s: float) -> tuple[float, float, float]:
        """Return its position at a time."""
        x, y, z = (at + time_s * speed for at, speed in zip(self.position_m, self.velocity_m_s, strict=True))
        return x, y, z

    def as_track(self) -> dict[str, Any]:
        """Return the keys of the track in a scenario."""
        x, y, altitude = self.position_m
        keys: dict[str, Any] = {"x": x, "y": y, "altitude": altitude, "velocity": list(self.velocity_m_s)}
        if self.intensity is not None:
            return keys | {"intensity": dict(self.intensity)}
        return keys | {"temperature": self.temperature_K, "area": self.area_m2, "emissivity": self.emissivity}


def rounded(number: float) -> float:
    """Return a number with the digits that scenarios are written with."""
    return float(f"{number:.{DIGITS}g}")


def check_targets(given: Mapping[str, Any], check: Check) -> None:
    """Collect what is wrong with ``[targets]``."""
    if not given:
        return
    check.names("targets", given, KEYS)
    for name in ("count", "altitude", "strength"):
        if name not in given:
            check.add(f"targets.{name}", "is missing; allowed: a value or what it is drawn from")
    if "empty" in given:
        check.number("targets.empty", given["empty"], 0.0, 1.0)
    for name in ("margin", "separation"):
        check.number(f"targets.{name}", given.get(name, 0.0), 0.0, 1e4)
    strength = check.table("targets.strength", given.get("strength", {}))
    by = [name for name in STRENGTHS if name in strength]
    if len(by) != 1:
        both = " and ".join(by) or "none"
        check.add("targets.strength", f"{both} given; allowed: one of scr, intensity, and temperature with area")
        return
    check.names("targets.strength", strength, STRENGTHS[by[0]])
    if by[0] == "temperature" and "area" not in strength:
        check.add("targets.strength.area", "is missing; a body has a temperature and an area across the line of sight")
    by_band = strength.get("by_band", {})
    if not isinstance(by_band, Mapping) or not all(_positive(each) for each in by_band.values()):
        check.add("targets.strength.by_band", f"{Problem.shown(by_band)}; allowed: a table of numbers above 0 by band")


def draw_targets(distribution: Distribution, draw: int, attempt: int, plan: Plan) -> tuple[Target, ...]:
    """Return the targets of a draw in the image of a plan.

    Raises
    ------
    ScenarioError
        If a description of a draw is wrong, a value is unphysical, or there is no room for them.
    """
    given, random = distribution.targets, distribution.random("targets", draw, attempt)
    if not given:
        return ()
    try:
        count = _count(given, _is_empty(distribution, draw), random)
        places = _places(given, count, plan, random)
        return tuple(_target(given, n, place, plan, random) for n, place in enumerate(places, start=1))
    except ValueError as error:
        raise ScenarioError([Problem("targets", str(error))], distribution.origin) from error


def _is_empty(distribution: Distribution, draw: int) -> bool | None:
    """Whether a draw has no targets; None where nothing is said of it.

    Each block of consecutive draws has the wanted share, at places that tell nothing. The answer does not depend on the
    attempt: draws with targets are refused more often than those without, whose share would grow.
    """
    if "empty" not in distribution.targets:
        return None
    share, (block, place) = float(distribution.targets["empty"]), divmod(draw, EMPTY_BLOCK)
    before, after = (math.floor(share * EMPTY_BLOCK * blocks + 0.5) for blocks in (block, block + 1))
    order = distribution.random("empty", block).permutation(EMPTY_BLOCK)
    return place in order[: after - before].tolist()


def _count(given: Mapping[str, Any], empty: bool | None, random: np.random.Generator) -> int:
    if empty is None:
        return _whole(drawn("count", given["count"], random))
    if empty:
        return 0
    for _ in range(_PLACES):  # frames that are not empty have the distribution of the count beyond 0
        count = _whole(drawn("count", given["count"], random))
        if count > 0:
            return count
    raise ValueError(
        f"count = {Problem.shown(given['count'])} is never above 0; allowed: with empty, some number above 0"
    )


def _whole(count: Any) -> int:
    if isinstance(count, bool) or not isinstance(count, int) or not 0 <= count <= MAX_TARGETS:
        raise ValueError(
            f"count = {Problem.shown(count)}; allowed: whole numbers from 0 to {MAX_TARGETS}, for example "
            "{distribution = 'poisson', mu = 2}"
        )
    return count


def _places(given: Mapping[str, Any], count: int, plan: Plan, random: np.random.Generator) -> list[tuple[float, float]]:
    """Return row and column of each target, evenly over the image, none too close to an edge or another one."""
    rows, columns = plan.extent
    margin, apart = float(given.get("margin", 4.0)), float(given.get("separation", 12.0))
    places: list[tuple[float, float]] = []
    low = rows.start + margin, columns.start + margin
    high = rows.stop - margin, columns.stop - margin
    if not (low[0] < high[0] and low[1] < high[1]):
        raise ValueError(f"margin = {margin:g} leaves no pixel of the image; allowed: less than half of its sides")
    for _ in range(_PLACES + 10 * count):
        if len(places) == count:
            return places
        row, column = (float(random.uniform(a, b)) for a, b in zip(low, high, strict=True))
        if all(math.hypot(row - y, column - x) >= apart for y, x in places):
            places.append((row, column))
    raise ValueError(f"{count} targets at least separation = {apart:g} pixels apart do not fit into the image")


def _target(
    given: Mapping[str, Any], track: int, place: tuple[float, float], plan: Plan, random: np.random.Generator
) -> Target:
    altitude = _number("altitude", given["altitude"], random, 0.0, 1e5)
    speed = _number("speed", given.get("speed", 0.0), random, 0.0, 1e4)
    heading = _number(
        "heading", given.get("heading", {"distribution": "uniform", "from": 0.0, "to": 360.0}), random, -360.0, 360.0
    )
    climb = _number("climb", given.get("climb", 0.0), random, -1e4, 1e4)
    east, north = speed * math.sin(math.radians(heading)), speed * math.cos(math.radians(heading))
    velocity = rounded(east), rounded(north), climb
    first_s, there = float(plan.frame_times_s[0]), _ground_of(plan, *place, altitude)
    x, y, z = (rounded(at - first_s * by) for at, by in zip(there, velocity, strict=True))
    if z < 0.0:
        raise ValueError(f"climb = {climb:g} m/s begins below the sea at altitude {altitude:g} m; allowed: a lower one")
    target = Target(track, *place, (x, y, z), velocity)
    strength = given["strength"]
    bands = [band.name for band in plan.bands]
    if "temperature" in strength:
        kelvin = _number("temperature", strength["temperature"], random, 1.0, 1e4)
        area = _number("area", strength["area"], random, 1e-6, 1e8)
        emissivity = _number("emissivity", strength.get("emissivity", 1.0), random, 1e-6, 1.0)
        return replace(target, temperature_K=kelvin, area_m2=area, emissivity=emissivity)
    by_band = strength.get("by_band", {})
    for name in by_band:
        if name not in bands:
            raise ValueError(f"strength.by_band: '{name}' is no band of the scene; allowed: {', '.join(bands)}")
    shares = {name: float(by_band.get(name, 1.0)) for name in bands}
    if "intensity" in strength:
        watts = _number("intensity", strength["intensity"], random, 0.0, 1e12)
        return replace(target, intensity={name: rounded(share * watts) for name, share in shares.items()})
    scr = _number("scr", strength["scr"], random, 0.0, 1e6)
    most = _number("intensity_max", strength.get("intensity_max", 1e6), random, 1e-9, 1e12)
    return replace(target, intensity=shares, scr=scr, intensity_max=most)


def _ground_of(plan: Plan, row: float, column: float, altitude_m: float) -> tuple[float, float, float]:
    """Return the position of a target that appears at a place in the image in the first frame."""
    time_s, size_m = float(plan.frame_times_s[0]), plan.grid.pixel_size_m
    east, north = (column - 0.5 * plan.grid.columns) * size_m, (row - 0.5 * plan.grid.rows) * size_m
    for _ in range(3):  # the projection is a shift
        there = seen_at(plan, (east, north, altitude_m), time_s)
        east, north = east + (column - there[1]) * size_m, north + (row - there[0]) * size_m
    return east, north, altitude_m


def seen_at(plan: Plan, position_m: tuple[float, float, float], time_s: float) -> tuple[float, float]:
    """Return row and column at which a point of the scene appears."""
    x_m, y_m, altitude_m = (np.array([each]) for each in position_m)
    row, column = plan.rays.project(x_m, y_m, altitude_m, time_s)
    return float(row[0]), float(column[0])


def _number(name: str, given: Any, random: np.random.Generator, low: float, high: float) -> float:
    value = drawn(name, given, random)
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ValueError(f"{name} = {Problem.shown(value)}; allowed: a number from {low:g} to {high:g} in SI units")
    return rounded(float(value))


def _positive(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < math.inf
