"""The file of a data set: a scenario, what is drawn, targets, and how frames are shared out."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np
from hcss_sweep.design import key_problems, keys_overlap, read_keys

from hcss_dataset.images import SUFFIXES
from hcss_dataset.words import drawn, is_draw
from hcss_twin import Scenario
from hcss_twin.providers import Problem, ScenarioError, choose_from

SECTIONS = ("title", "licence", "seed", "base", "draw", "targets", "reuse", "split", "image", "labels", "shards")
SPLITS = ("train", "val", "test")
MAX_ATTEMPTS = 50
"""Draws of one number that may be refused before the distribution is."""

STREAMS = {"values": 0, "states": 1, "sky": 2, "noise": 3, "targets": 4, "empty": 5}
"""Independent random numbers of each draw."""

OF_ALL = ("frames", "image", "output", "bands", "sensor", "instrument")
"""Sections of a scenario that are the same in all draws."""

OF_SKY = ("coverage", "coverage_mode", "edge_taper")
"""Keys of cloud layers that no table of radiance depends on."""

SHARED_SKY = {"coverage": 0.5, "edge_taper": 0.0}
"""Those of them that the plan of a scene does not depend on either, with values that every scene can have."""


@dataclass(frozen=True)
class Labels:
    """What labels state.

    Attributes
    ----------
    mask_share : float
        Pixels of a mask have at least this share of the highest pixel of the target's own image.
    window : int
        Side of the square in pixels around a target whose clean image gives the clutter.
    """

    mask_share: float = 0.5
    window: int = 31


@dataclass(frozen=True)
class Distribution:
    """A checked file of a data set; its draws are not checked yet.

    Attributes
    ----------
    scenario, overrides : mapping
        Keys of the scenario, and dotted keys that replace some of them, the same in all draws.
    draw : mapping of str to object
        What each dotted key is drawn from.
    targets : mapping
        ``[targets]`` as given; none without targets.
    draws_per_sky : int
        Consecutive draws that see the same clouds.
    states : int or None
        Number of states that draws take the keys from that tables depend on; None: each draw has its own.
    shares : mapping of str to float
        Share of the skies in each split.
    step_K : float
        Step of the numbers of images without a converter, as a difference of black bodies at 300 K.
    form : str
        Format of the images, of :data:`hcss_dataset.images.SUFFIXES`.
    shard : int
        Frames in a shard, about.
    raw : mapping
        The file.
    """

    title: str
    licence: str
    seed: int
    scenario: Mapping[str, Any]
    overrides: Mapping[str, Any]
    draw: Mapping[str, Any]
    targets: Mapping[str, Any]
    base: Path
    origin: str
    draws_per_sky: int = 1
    states: int | None = None
    shares: Mapping[str, float] = field(default_factory=lambda: {"train": 0.8, "val": 0.1, "test": 0.1})
    labels: Labels = Labels()
    step_K: float = 0.005
    form: str = "png"
    shard: int = 200
    raw: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def load(cls, source: str | Path | Mapping[str, Any]) -> Self:
        """Read the ``.toml`` or ``.json`` file of a data set, or its keys.

        Raises
        ------
        ScenarioError
            With all problems of the file; draws are not checked.
        """
        raw, base, origin = read_keys(source, "dataset")
        check = Check(origin)
        check.names("", raw, SECTIONS)
        sections = {name: check.table(name, raw.get(name, {})) for name in ("base", "draw", "targets", "reuse")}
        sections |= {name: check.table(name, raw.get(name, {})) for name in ("split", "image", "labels", "shards")}
        scenario, overrides = _base(sections["base"], base, check)
        draw = dict(_leaves(sections["draw"]))
        check.problems += key_problems("draw", [*draw], "drawn", "allowed: keys of a scenario", overrides)
        # The seed of the file of a scenario is one sky of many: it is replaced.
        own = [key for key in scenario if key != "seed" or "scenario" not in sections["base"]]
        for where, keys in (("base", [*own, *overrides]), ("draw", [*draw])):
            for key in keys:
                if keys_overlap(key, "elements"):
                    check.add(f"{where}.{key}", "elements of a data set are its targets; allowed: [targets]")
                if keys_overlap(key, "seed"):
                    check.add(f"{where}.{key}", "seeds follow from that of the data set; allowed: seed, above [base]")
                if where == "draw" and key.partition(".")[0] in OF_ALL:
                    message = "all frames have the same size, number, bands and sensor; allowed: in [base]"
                    check.add(f"{where}.{key}", message)
        if "base" not in raw:
            message = "is missing; allowed: the keys of a scenario, or scenario = NAME or FILE and keys to change"
            check.add("base", message)
        reuse, split = sections["reuse"], sections["split"]
        check.names("reuse", reuse, ("draws_per_sky", "states"))
        check.names("split", split, ("by", *SPLITS))
        check.names("image", sections["image"], ("step_temperature", "format"))
        check.names("labels", sections["labels"], ("mask_share", "window"))
        check.names("shards", sections["shards"], ("frames",))
        if split.get("by", "sky") != "sky":
            check.add("split.by", f"{Problem.shown(split['by'])}; allowed: 'sky'")
        shares = {name: check.number(f"split.{name}", split.get(name, 0.0), 0.0, 1.0) for name in SPLITS}
        if not set(SPLITS) & set(split):
            shares = {"train": 0.8, "val": 0.1, "test": 0.1}
        if abs(sum(shares.values()) - 1.0) > 1e-9:
            check.add("split", f"shares sum to {sum(shares.values()):g}; allowed: 1")
        found = cls(
            title=check.text("title", raw.get("title", "Infrared clouds over sea with small targets")),
            licence=check.text("licence", raw.get("licence", "not stated")),
            seed=check.whole("seed", raw.get("seed", 0), 0, 2**63 - 1),
            scenario=scenario,
            overrides=overrides,
            draw=draw,
            targets=sections["targets"],
            base=base,
            origin=origin,
            draws_per_sky=check.whole("reuse.draws_per_sky", reuse.get("draws_per_sky", 1), 1, 10**6),
            states=check.whole("reuse.states", reuse["states"], 1, 10**6) if "states" in reuse else None,
            shares=shares,
            labels=Labels(
                check.number("labels.mask_share", sections["labels"].get("mask_share", 0.5), 0.01, 1.0),
                check.whole("labels.window", sections["labels"].get("window", 31), 5, 1001),
            ),
            step_K=check.number("image.step_temperature", sections["image"].get("step_temperature", 0.005), 1e-4, 10.0),
            form=check.choice("image.format", sections["image"].get("format", "png"), tuple(SUFFIXES)),
            shard=check.whole("shards.frames", sections["shards"].get("frames", 200), 1, 10**6),
            raw=json.loads(json.dumps(raw, default=str)),
        )
        from hcss_dataset.targets import check_targets

        check_targets(found.targets, check, found.base)
        check.raise_problems()
        return found

    @property
    def digest(self) -> str:
        """Hash of all that the frames depend on besides the code; the licence and the title change no frame."""
        text = {key: value for key, value in self.raw.items() if key not in ("title", "licence")}
        return hashlib.sha256(json.dumps(text, sort_keys=True).encode()).hexdigest()

    def random(self, stream: str, number: int, attempt: int = 0) -> np.random.Generator:
        """Return the random numbers of a stream of :data:`STREAMS` for a draw, sky or state, and an attempt."""
        key = STREAMS[stream], number, attempt
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=key))

    def sky_of(self, draw: int) -> int:
        """Return the number of the sky that a draw sees."""
        return draw // self.draws_per_sky

    def sky_seed(self, sky: int) -> int:
        """Return the seed of a sky, below 2^53, which JSON readers keep exactly."""
        return int(self.random("sky", sky).integers(2**53))

    def noise_seed(self, draw: int) -> int:
        """Return the seed of the sensor: draws of one sky have other noise."""
        return int(self.random("noise", draw).integers(2**53))

    def split_of(self, sky: int) -> str:
        """Return the split of a sky, by a hash: it depends on nothing but the seed and the number of the sky."""
        digest = hashlib.sha256(f"{self.seed} {sky}".encode()).digest()
        place, low = int.from_bytes(digest[:8], "big") / 2.0**64, 0.0
        for name in SPLITS:
            low += self.shares[name]
            if place < low:
                return name
        return next(name for name in reversed(SPLITS) if self.shares[name] > 0.0)

    def is_constant(self, problem: Problem) -> bool:
        """Whether a problem of targets, or of a description of draws, is that of a key that is not drawn.

        Problems of all targets begin with the name of their key.
        """
        section, _, path = problem.field.partition(".")
        if section == "draw":
            return path in self.draw
        first = problem.message.partition(" ")[0]
        paths = [path] if path else [first, f"strength.{first}"]
        return any(key in paths and not is_draw(value) for key, value in _leaves(self.targets))

    def values(self, draw: int, attempt: int) -> tuple[dict[str, Any], int]:
        """Return the drawn keys with their values, and the number of the state.

        Raises
        ------
        ScenarioError
            If a description of a draw is wrong.
        """
        state = draw if self.states is None else draw % self.states
        of_state, of_draw = self.random("states", state, attempt), self.random("values", draw, attempt)
        values, problems = dict[str, Any](), list[Problem]()
        for key, given in self.draw.items():
            own = self.states is None or (key.startswith("clouds") and key.rpartition(".")[2] in OF_SKY)
            try:
                values[key] = drawn(key, given, of_draw if own else of_state)
            except ValueError as error:
                problems.append(Problem(f"draw.{key}", str(error)))
        if problems:
            raise ScenarioError(problems, self.origin)
        return values, state


class Check:
    """Collects the problems of a file."""

    def __init__(self, origin: str) -> None:
        self.origin, self.problems = origin, list[Problem]()

    def add(self, key: str, message: str) -> None:
        """Add a problem."""
        self.problems.append(Problem(key, message))

    def raise_problems(self) -> None:
        """Raise ScenarioError if there are problems."""
        if self.problems:
            raise ScenarioError(self.problems, self.origin)

    def names(self, section: str, given: Iterable[str], allowed: tuple[str, ...]) -> None:
        """Check that a section has no unknown keys."""
        for name in given:
            if name not in allowed:
                self.add(f"{section}.{name}".lstrip("."), f"unknown key; {choose_from(str(name), allowed)}")

    def table(self, name: str, given: Any) -> dict[str, Any]:
        """Return a table; an empty one in place of anything else."""
        if isinstance(given, Mapping):
            return dict(given)
        self.add(name, f"{Problem.shown(given)} is not a table of keys")
        return {}

    def text(self, key: str, given: Any) -> str:
        """Return text."""
        if not isinstance(given, str):
            self.add(key, f"{Problem.shown(given)}; allowed: text")
        return str(given)

    def choice(self, key: str, given: Any, allowed: tuple[str, ...]) -> str:
        """Return one of some words."""
        if given not in allowed:
            self.add(key, f"{Problem.shown(given)}; {choose_from(str(given), allowed)}")
        return str(given)

    def number(self, key: str, given: Any, low: float, high: float) -> float:
        """Return a number within limits; ``low`` in place of anything else."""
        if isinstance(given, bool) or not isinstance(given, int | float) or not low <= given <= high:
            self.add(key, f"{Problem.shown(given)}; allowed: a number from {low:g} to {high:g}")
            return low
        return float(given)

    def whole(self, key: str, given: Any, low: int, high: int) -> int:
        """Return a whole number within limits; ``low`` in place of anything else."""
        if isinstance(given, bool) or not isinstance(given, int) or not low <= given <= high:
            self.add(key, f"{Problem.shown(given)}; allowed: a whole number from {low} to {high}")
            return low
        return given


def _base(given: Mapping[str, Any], base: Path, check: Check) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the keys of the scenario and those that replace some of them."""
    if "scenario" not in given:
        return dict(given), {}
    name = given["scenario"]
    if not isinstance(name, str):
        check.add("base.scenario", f"{Problem.shown(name)}; allowed: the name of a scenario or of its file")
        return {}, {}
    beside = base / name
    raw, _ = Scenario.read_file(beside if beside.is_file() else name)
    return raw, dict(_leaves({key: value for key, value in given.items() if key != "scenario"}))


def without_sky(values: Mapping[str, Any]) -> tuple[dict[str, Any], dict[int, dict[str, Any]]]:
    """Return drawn keys with :data:`SHARED_SKY`, and what they say in place of it by the number of the layer."""
    layers: dict[int, dict[str, Any]] = {}

    def shared(path: list[str], value: Any) -> Any:
        of_layer = path[:2] == ["clouds", "layers"] and len(path) == 4
        if path[0] != "clouds" or not (of_layer or len(path) < 4):
            return value
        if (of_layer or len(path) == 2) and path[-1] in SHARED_SKY:
            layers.setdefault(int(path[2]) if of_layer else 0, {})[path[-1]] = value
            return SHARED_SKY[path[-1]]
        if isinstance(value, Mapping):
            return {name: shared([*path, name], each) for name, each in value.items()}
        if isinstance(value, list):
            return [shared([*path, str(number)], each) for number, each in enumerate(value)]
        return value

    return {key: shared(key.split("."), value) for key, value in values.items()}, layers


def _leaves(table: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted keys with their values: TOML reads ``view.zenith = ...`` as a table in a table."""
    for name, content in table.items():
        if isinstance(content, Mapping) and content and not is_draw(content):
            yield from _leaves(content, f"{path}{name}.")
        else:
            yield f"{path}{name}", content


def draws_of(frames: int, per_draw: int) -> int:
    """Return the number of draws of a number of frames.

    Raises
    ------
    ValueError
        If the last sequence would be cut.
    """
    if frames % per_draw:
        closest = max(per_draw, round(frames / per_draw) * per_draw)
        raise ValueError(
            f"{frames} frames in sequences of frames.count = {per_draw}; allowed: a multiple; "
            f"closest valid choice is {closest}"
        )
    return math.floor(frames / per_draw)
