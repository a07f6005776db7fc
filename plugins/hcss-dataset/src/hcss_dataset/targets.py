"""Targets of a draw: how many, where, how they move and how strong they are, as tracks of the scenario.

Their physics is that of the provider ``point-sources``: a plume of an intensity, or a body of a temperature and an
area, and further parts that go with it. With a strength by SCR, the intensity follows from the image
(:mod:`hcss_dataset.rendering`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count as count_from
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_dataset.errors import DatasetError
from hcss_dataset.families import (
    FAMILIES,
    REFERENCES,
    family_names,
    gas_intensity,
    glint_intensity,
    reference_K,
    with_family,
)
from hcss_dataset.tracks import TRACKS, Track, great_circle_path, position_at, read_tracks, table_path, velocity_at
from hcss_dataset.words import drawn
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Problem, ScenarioError, choose_from

if TYPE_CHECKING:
    from hcss_dataset.distribution import Check, Distribution

MOTION = ("altitude", "speed", "heading", "climb")
KEYS = ("count", "empty", "margin", "separation", "family", "track", *MOTION, "strength", "parts")
STRENGTHS = {
    "scr": ("scr", "by_band", "intensity_max"),
    "intensity": ("intensity", "by_band"),
    "temperature": ("temperature", "area", "emissivity"),
    "reference": ("reference", "difference", "area", "emissivity"),
    "gas_temperature": ("gas_temperature", "gas_area", "gas_bands"),
    "facet_radius": ("facet_radius",),
}
NEEDED = {"temperature": ("area",), "reference": ("difference", "area"), "gas_temperature": ("gas_area", "gas_bands")}
"""Further keys that a strength needs."""

OF_PART = ("name", "labelled", "behind", "below", "count", "spacing", "strength")
MAX_TARGETS = 10_000
_PLACES = 1000
"""Places that may be tried for the targets of a draw until they are far enough apart."""
DIGITS = 12
EMPTY_BLOCK = 20
"""Consecutive draws that have the wanted share of draws without targets."""


@dataclass(frozen=True)
class Target:
    """A target on its track, and its strength.

    Attributes
    ----------
    track : int
        Number in its sequence, from 1, which is that of its source; parts have those after all targets.
    row, column : float
        Place in the image in the first frame; pixel n extends from n to n + 1.
    position_m, velocity_m_s : (float, float, float)
        East and north of the image centre and altitude at the start, and their change.
    intensity : mapping of str to float, optional
        Of a plume, W sr-1 by band; with ``scr`` for one W sr-1 in the band with the largest share.
    scr : float, optional
        Wanted in the first frame, in the label band.
    family : str, optional
        Family that it is of.
    path : tuple
        Points of a curved track, in place of position and velocity at the start.
    parts : tuple of Target
        What goes with it: in its own image if ``labelled``, otherwise beside it and without a label.
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
    family: str | None = None
    path: Track = ()
    parts: tuple[Target, ...] = ()
    labelled: bool = True

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
        if self.path:
            return position_at(self.path, time_s)
        x, y, z = (at + time_s * speed for at, speed in zip(self.position_m, self.velocity_m_s, strict=True))
        return x, y, z

    def velocity_at(self, time_s: float) -> tuple[float, float, float]:
        """Return its velocity at a time."""
        return velocity_at(self.path, time_s) if self.path else self.velocity_m_s

    def as_track(self) -> dict[str, Any]:
        """Return the keys of the track in a scenario."""
        x, y, altitude = self.position_m
        keys: dict[str, Any] = {"x": x, "y": y, "altitude": altitude, "velocity": list(self.velocity_m_s)}
        if self.path:
            keys = {"path": [[rounded(each) for each in point] for point in self.path]}
        if self.intensity is not None:
            return keys | {"intensity": dict(self.intensity)}
        return keys | {"temperature": self.temperature_K, "area": self.area_m2, "emissivity": self.emissivity}

    def moved(self, behind_m: float, below_m: float) -> Target:
        """Return it farther behind and lower."""
        east, north, _ = self.velocity_at(self.path[0][0] if self.path else 0.0)
        speed = math.hypot(east, north)
        back = (east / speed, north / speed) if speed > 0.0 else (0.0, 1.0)

        def place(x: float, y: float, z: float) -> tuple[float, float, float]:
            return rounded(x - behind_m * back[0]), rounded(y - behind_m * back[1]), rounded(max(z - below_m, 0.0))

        path = tuple((time, *place(x, y, z)) for time, x, y, z in self.path)
        return replace(self, position_m=place(*self.position_m), path=path)


def all_tracks(targets: Sequence[Target]) -> list[dict[str, Any]]:
    """Return the tracks of targets, then those of their parts: the number of a target is that of its source."""
    parts = (part for target in targets for part in target.parts)
    return [each.as_track() for each in (*targets, *parts)]


def rounded(number: float) -> float:
    """Return a number with the digits that scenarios are written with."""
    return float(f"{number:.{DIGITS}g}")


def check_targets(given: Mapping[str, Any], check: Check, base: Path) -> None:
    """Collect what is wrong with ``[targets]``."""
    if not given:
        return
    check.names("targets", given, KEYS)
    if "count" not in given:
        check.add("targets.count", "is missing; allowed: a value or what it is drawn from")
    if "empty" in given:
        check.number("targets.empty", given["empty"], 0.0, 1.0)
    for name in ("margin", "separation"):
        check.number(f"targets.{name}", given.get(name, 0.0), 0.0, 1e4)
    names = family_names(given)
    unknown = [name for name in names if name not in FAMILIES]
    for name in unknown:
        check.add("targets.family", f"{Problem.shown(name)}; {choose_from(str(name), FAMILIES)}")
    table = _check_track(given, check, base)
    for name in names or [None]:
        if not unknown:
            whole = with_family(given, name)
            if "altitude" not in whole and not table:
                check.add("targets.altitude", "is missing; allowed: a value or what it is drawn from")
            _check_strength("targets.strength", whole.get("strength"), check)
            if "parts" in whole and "scr" in (whole.get("strength") or {}):
                check.add(
                    "targets.parts", "with a strength by SCR, which is that of one part; allowed: other strengths"
                )
            for number, part in enumerate(whole.get("parts", ())):
                where = f"targets.parts[{number}]"
                check.names(where, part, OF_PART)
                _check_strength(f"{where}.strength", part.get("strength"), check, ("scr",))


def _check_track(given: Mapping[str, Any], check: Check, base: Path) -> bool:
    """Return whether tracks are those of a table, and collect what is wrong with them."""
    track = given.get("track", TRACKS[0])
    if isinstance(track, Mapping):
        check.names("targets.track", track, ("file",))
        for name in MOTION:
            if name in given:
                check.add(f"targets.{name}", "with the tracks of a table, which has them; allowed: one of them")
        try:
            read_tracks(base / str(track.get("file")))
        except DatasetError as error:
            check.add("targets.track.file", str(error))
        return True
    if track not in TRACKS:
        check.add("targets.track", f"{Problem.shown(track)}; {choose_from(str(track), TRACKS)}, or {{file = NAME}}")
    if track == "great-circle" and given.get("climb", 0.0) != 0.0:
        check.add("targets.climb", "with track = 'great-circle', which keeps its altitude; allowed: one of them")
    return False


def _check_strength(where: str, given: Any, check: Check, refused: tuple[str, ...] = ()) -> None:
    if given is None:
        check.add(where, "is missing; allowed: a table with one of scr, intensity, or temperature with area")
        return
    strength = check.table(where, given)
    allowed = [name for name in STRENGTHS if name not in refused]
    by = [name for name in allowed if name in strength]
    if len(by) != 1:
        both = " and ".join(by) or "none"
        check.add(where, f"{both} given; allowed: one of {', '.join(allowed)}")
        return
    check.names(where, strength, STRENGTHS[by[0]])
    for name in NEEDED.get(by[0], ()):
        if name not in strength:
            check.add(f"{where}.{name}", f"is missing; it goes with {by[0]}")
    if strength.get("reference", REFERENCES[0]) not in REFERENCES:
        check.add(f"{where}.reference", choose_from(str(strength["reference"]), REFERENCES))
    by_band = strength.get("by_band", {})
    if not isinstance(by_band, Mapping) or not all(_positive(each) for each in by_band.values()):
        check.add(f"{where}.by_band", f"{Problem.shown(by_band)}; allowed: a table of numbers above 0 by band")


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
        targets = [_of_family(distribution, n, place, plan, random) for n, place in enumerate(places, start=1)]
    except ValueError as error:
        raise ScenarioError([Problem("targets", str(error))], distribution.origin) from error
    numbers = count_from(len(targets) + 1)  # of their sources, as in all_tracks
    return tuple(
        replace(target, parts=tuple(replace(part, track=next(numbers)) for part in target.parts)) for target in targets
    )


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


def _of_family(
    distribution: Distribution, number: int, place: tuple[float, float], plan: Plan, random: np.random.Generator
) -> Target:
    """Return a target with its parts."""
    given = distribution.targets
    name = drawn("family", given["family"], random) if "family" in given else None
    whole = with_family(given, name)
    target = replace(_target(whole, number, place, plan, random, distribution.base), family=name)
    parts = list[Target]()
    for part in whole.get("parts", ()):
        behind, below = (float(part.get(key, 0.0)) for key in ("behind", "below"))
        strong = _strong(target, part["strength"], plan, random)
        apart = float(part.get("spacing", 0.0))
        parts += [
            replace(strong.moved(behind + n * apart, below), labelled=bool(part.get("labelled", True)))
            for n in range(int(part.get("count", 1)))
        ]
    return replace(target, parts=tuple(parts))


def _target(
    given: Mapping[str, Any],
    number: int,
    place: tuple[float, float],
    plan: Plan,
    random: np.random.Generator,
    base: Path,
) -> Target:
    times_s = float(plan.frame_times_s[0]), float(plan.frame_times_s[-1])
    track = given.get("track", TRACKS[0])
    if isinstance(track, Mapping):
        tracks = read_tracks(base / str(track["file"]))
        chosen = tracks[int(random.integers(len(tracks)))]
        x, y, z = (rounded(each) for each in _ground_of(plan, *place, float(chosen[0, 3])))
        path = table_path(chosen, (x, y), times_s)
        target = Target(number, *place, (x, y, z), velocity_at(path, times_s[0]), path=path)
        return _strong(target, given["strength"], plan, random)
    altitude = _number("altitude", given["altitude"], random, 0.0, 1e5)
    speed = _number("speed", given.get("speed", 0.0), random, 0.0, 1e4)
    heading = _number(
        "heading", given.get("heading", {"distribution": "uniform", "from": 0.0, "to": 360.0}), random, -360.0, 360.0
    )
    climb = _number("climb", given.get("climb", 0.0), random, -1e4, 1e4)
    east, north = speed * math.sin(math.radians(heading)), speed * math.cos(math.radians(heading))
    velocity = rounded(east), rounded(north), climb
    there = _ground_of(plan, *place, altitude)
    x, y, z = (rounded(at - times_s[0] * by) for at, by in zip(there, velocity, strict=True))
    if z < 0.0:
        raise ValueError(f"climb = {climb:g} m/s begins below the sea at altitude {altitude:g} m; allowed: a lower one")
    path = great_circle_path(there[:2], altitude, speed, heading, times_s) if track == "great-circle" else ()
    return _strong(Target(number, *place, (x, y, z), velocity, path=path), given["strength"], plan, random)


def _strong(target: Target, strength: Mapping[str, Any], plan: Plan, random: np.random.Generator) -> Target:
    """Return a target with a drawn strength, and no other."""
    bands = [band.name for band in plan.bands]
    target = replace(target, intensity=None, scr=None, temperature_K=None, area_m2=None)
    if "temperature" in strength or "reference" in strength:
        if "temperature" in strength:
            kelvin = _number("temperature", strength["temperature"], random, 1.0, 1e4)
        else:
            time_s = float(plan.frame_times_s[0])
            altitude, (east, north, _) = target.at(time_s)[2], target.velocity_at(time_s)
            warmer = _number("difference", strength["difference"], random, -1e4, 1e4)
            kelvin = rounded(reference_K(strength["reference"], plan, altitude, math.hypot(east, north)) + warmer)
        area = _number("area", strength["area"], random, 1e-6, 1e8)
        emissivity = _number("emissivity", strength.get("emissivity", 1.0), random, 1e-6, 1.0)
        return replace(target, temperature_K=kelvin, area_m2=area, emissivity=emissivity)
    if "gas_temperature" in strength:
        kelvin = _number("gas_temperature", strength["gas_temperature"], random, 1.0, 1e4)
        area = _number("gas_area", strength["gas_area"], random, 1e-6, 1e8)
        watts = gas_intensity(plan, kelvin, area, strength["gas_bands"])
        return replace(target, intensity={name: rounded(value) for name, value in watts.items()})
    if "facet_radius" in strength:
        radius = _number("facet_radius", strength["facet_radius"], random, 1e-3, 1e6)
        watts = glint_intensity(plan, radius, float(plan.frame_times_s[0]), plan.view)
        return replace(target, intensity={name: rounded(value) for name, value in watts.items()})
    by_band = strength.get("by_band", {})
    for name in by_band:
        if name not in bands:
            raise ValueError(f"strength.by_band: '{name}' is no band of the scene; allowed: {', '.join(bands)}")
    shares = {name: float(by_band.get(name, 1.0)) for name in bands}
    if "intensity" in strength:
        power = _number("intensity", strength["intensity"], random, 0.0, 1e12)
        return replace(target, intensity={name: rounded(share * power) for name, share in shares.items()})
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
