"""A scenario with uncertain keys, and the scenarios of all draws, which are checked before the computation."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from hcss_sweep.axis import DISTRIBUTIONS
from hcss_sweep.design import joined_keys, key_problems, keys_overlap, read_keys
from hcss_sweep.points import ranges, value_at

from hcss_twin import Scenario
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.providers import Array, Problem, ScenarioError, choose_from
from hcss_uncertainty.draw_statistics import VARIABLES
from hcss_uncertainty.joint_sample import OTHER_SEED, SEED, A, B, JointSample, Mixture, UncertainKey

UNCERTAIN = "uncertain"
"""Section that assigns distributions to keys."""

_SUMMED_UP: Mapping[str, Any] = {"output.variables": list(VARIABLES), "output.derived": [], "output.certificate": 0}
"""Output settings of the summarised scenes; cubes of draws contain the variables that the user requested."""


@dataclass(frozen=True)
class UncertainScenario:
    """A scenario file without ``[uncertain]``, the keys replaced in all draws, and the contents of that section.

    All draws share ``cache``.
    """

    raw: Mapping[str, Any]
    overrides: Mapping[str, Any]
    uncertain: Mapping[str, Any]
    base: Path
    origin: str
    cache: ResultCache

    @classmethod
    def load(
        cls, source: str | Path | Mapping[str, Any] | Scenario, overrides: Mapping[str, Any] | None = None
    ) -> UncertainScenario:
        """Read a scenario from a name, a path or a mapping of keys; raises :class:`ScenarioError`."""
        raw, base, origin = read_keys(source, "scenario")
        section = raw.pop(UNCERTAIN, {})
        if not isinstance(section, Mapping):
            message = f"{Problem.shown(section)} is not a table; allowed: keys of a scenario, each with a distribution"
            raise ScenarioError([Problem(UNCERTAIN, message)], origin)
        return cls(raw, dict(overrides or {}), section, base, origin, ResultCache(several=True))

    def scenario(self, changes: Mapping[str, Any] | None = None) -> Scenario:
        """Return the scenario with more keys replaced; raises :class:`ScenarioError`."""
        overrides = {**self.overrides, **(changes or {})}
        return Scenario.from_dict(self.raw, overrides, base=self.base, origin=self.origin, shelf=self.cache)


_ALLOWED = (
    'allowed: {distribution = "normal", mean = 291, standard_deviation = 0.5}, "uniform" or "log-uniform" with from '
    "and to, or in short normal:291:0.5, normal:291:0.5:271:305 (truncated), uniform:3:9, log-uniform:1:10"
)

_KEYS = 'allowed: keys of a scenario, for example "sea.temperature"'


def uncertain_keys(given: Mapping[str, Any], section: str = UNCERTAIN) -> tuple[UncertainKey, ...]:
    """Check ``[uncertain]`` or ``--uncertain``: keys, dotted or in nested tables, and their distributions.

    A distribution is a table, or text in the short form. Raises ScenarioError with all errors.
    """
    problems: list[Problem] = []
    keys: list[UncertainKey] = []
    for key, given_table in joined_keys(given, lambda table: "distribution" not in table).items():
        try:
            keys.append(UncertainKey(key, _table(given_table)))
            keys[-1].values(1, 0)
        except ValueError as error:
            problems.append(Problem(f"{section}.{key}", str(error)))
    problems += key_problems(section, [uncertain.key for uncertain in keys], "uncertain", _KEYS)
    problems += [
        Problem(
            f"{section}.{uncertain.key}",
            "must be the same in all draws, whose results are combined; any other key may vary",
        )
        for uncertain in keys
        if uncertain.key.partition(".")[0] in ("seed", "output", "bands", "frames", "title")
    ]
    if problems:
        raise ScenarioError(problems, section)
    return tuple(keys)


def _table(given: Any) -> Mapping[str, Any]:
    if isinstance(given, str):
        return _parsed(given)
    if not isinstance(given, Mapping) or "distribution" not in given:
        raise ValueError(f"{Problem.shown(given)} is not a distribution; {_ALLOWED}")
    for name in ("samples", "seed"):
        if name in given:
            raise ValueError(f"{name}: all inputs share the number of draws and the seed; {_ALLOWED}")
    return dict(given)


def _parsed(text: str) -> Mapping[str, Any]:
    name, *numbers = (part.strip() for part in text.split(":"))
    if name not in DISTRIBUTIONS:
        raise ValueError(f"{Problem.shown(text)}: distribution '{name}'; {choose_from(name, DISTRIBUTIONS)}")
    meaning = DISTRIBUTIONS[name]
    if not 2 <= len(numbers) <= len(meaning):
        raise ValueError(
            f"{Problem.shown(text)} has {len(numbers)} {'number' if len(numbers) == 1 else 'numbers'}; {_ALLOWED}"
        )
    values = dict(zip(meaning, map(_read_number, numbers), strict=False))
    return {"distribution": name, **values}


def _read_number(text: str) -> float | str:
    """Parse a number; text with a unit is returned unchanged."""
    try:
        value = float(text)
    except ValueError:
        return text
    if not np.isfinite(value):
        raise ValueError(f"{text}: allowed: finite numbers")
    return value


def layer_of(scenario: Scenario, layer: int | None, origin: str) -> str:
    """Return the part of a scenario to which the cloud parameters belong.

    ``layer`` is the number of the layer, required if there are several. Raises ScenarioError if there is no such layer,
    or its generator is not that of a posterior.
    """
    layers, number = scenario.clouds.layers, layer or 0
    path = "clouds" if len(layers) == 1 else f"clouds.layers.{number}"
    if not layers:
        problem = Problem("clouds.layers", "the scenario has no clouds; allowed: a cloud layer")
    elif layer is None and len(layers) > 1:
        problem = Problem(
            "clouds.layers",
            f"{len(layers)} layers; name the layer of the posterior; allowed: layer 0 to {len(layers) - 1}",
        )
    elif not 0 <= number < len(layers):
        problem = Problem("clouds.layers", f"layer {number} given; allowed: 0 to {len(layers) - 1}")
    elif layers[number].generator not in ("fractal", "hcss-twin/fractal"):
        message = f"{Problem.shown(layers[number].generator)}; a posterior describes clouds of the generator 'fractal'"
        problem = Problem(f"{path}.generator", message)
    else:
        return path
    raise ScenarioError([problem], origin)


def overlap_problems(
    source: UncertainScenario, sample_keys: Sequence[str], posterior_keys: Sequence[str]
) -> Iterator[Problem]:
    """Yield an error for each uncertain key that is also set by the posterior or by ``--set``."""
    for key, other in product(sample_keys, posterior_keys):
        if keys_overlap(key, other):
            message = f"overlaps {other}, which the posterior determines; allowed: one of them"
            yield Problem(f"{UNCERTAIN}.{key}", message)
    yield from key_problems(UNCERTAIN, sample_keys, "uncertain", _KEYS, source.overrides)


def scenarios_of(source: UncertainScenario, sample: JointSample) -> dict[str, tuple[Scenario, ...]]:
    """Create and check the scenarios of all draws of all mixtures.

    Scenarios are returned by mixture name. Raises ScenarioError with each problem listed once, with its draws and their
    values; a wrong key, of which no draw can be valid, is refused before the other draws are checked.
    """
    _require_keys(source, sample)
    scenarios: dict[str, tuple[Scenario, ...]] = {}
    wrong: dict[Problem, list[tuple[Mixture, int]]] = {}
    for mixture in sample.mixtures:
        if mixture.name == OTHER_SEED:
            continue  # differs only in the seed
        drawn = []
        for draw in range(sample.count):
            try:
                drawn.append(source.scenario({**sample.overrides(mixture, draw), **_SUMMED_UP}))
            except ScenarioError as error:
                for problem in error.problems:
                    wrong.setdefault(problem, []).append((mixture, draw))
        scenarios[mixture.name] = tuple(drawn)
    if wrong:
        raise ScenarioError(_told(wrong, sample), source.origin)
    same = scenarios[sample.mixtures[0].name]
    scenarios[OTHER_SEED] = tuple(
        scenario.model_copy(update={SEED: int(seed)}) for scenario, seed in zip(same, sample.seeds[B], strict=True)
    )
    return scenarios


def _require_keys(source: UncertainScenario, sample: JointSample) -> None:
    """Raise ScenarioError with what the first two draws have in common: problems that do not depend on drawn values."""
    problems: list[tuple[Problem, ...]] = []
    for draw in range(2):
        try:
            source.scenario({**sample.overrides(sample.mixtures[0], draw), **_SUMMED_UP})
        except ScenarioError as error:
            problems.append(error.problems)
    common = [problem for problem in problems[0] if problem in problems[1]] if len(problems) == 2 else []
    if common:
        raise ScenarioError(common, source.origin)


def with_draw(error: ScenarioError, sample: JointSample, mixture: Mixture, draw: int) -> ScenarioError:
    """Return an error that only the planning of a draw detects, with the draw and its values."""
    wrong = {problem: [(mixture, draw)] for problem in error.problems}
    return ScenarioError(_told(wrong, sample), error.origin)


def numbers_of(sample: JointSample, scenarios: Sequence[Scenario]) -> Array:
    """Return the inputs of the first sample, read from its scenarios, as numbers (draw, input).

    Numbers are in SI units, dates and times in seconds since 1970.
    """
    columns = [sample.rows[A].T[: len(sample.inputs) - len(sample.keys)]]
    for key in sample.keys:
        values = [value_at(json.loads(scenario.to_json()), key.key) for scenario in scenarios]
        columns.append(np.array([list(map(_number, values))]))
    return np.concatenate(columns).T


def _number(value: Any) -> float:
    if isinstance(value, str):
        return datetime.fromisoformat(value).timestamp()
    return float(value)


def _told(wrong: Mapping[Problem, list[tuple[Mixture, int]]], sample: JointSample) -> Iterator[Problem]:
    """Report the first draw for each invalid key and list the others: their messages differ only in values."""
    fields: dict[str, list[tuple[Problem, Mixture, int]]] = {}
    for problem, places in wrong.items():
        fields.setdefault(problem.field, []).extend((problem, *mixture_and_draw) for mixture_and_draw in places)
    for field, wrong_draws in fields.items():
        problem, mixture, draw = wrong_draws[0]
        values = sample.overrides(mixture, draw)
        values.pop(SEED)
        dotted = field.replace("[", ".").replace("]", "")
        overlapping = {key: value for key, value in values.items() if keys_overlap(dotted, key)}
        listed = ", ".join(f"{key} = {Problem.shown(value)}" for key, value in (overlapping or values).items())
        others = sorted({number for _, _, number in wrong_draws} - {draw})
        more = f"; also wrong: draw{'s' if len(others) > 1 else ''} {ranges(others)}" if others else ""
        which = "" if mixture.name == sample.mixtures[0].name else f" with {mixture.name}"
        yield Problem(field, f"{problem.message} (draw {draw}{which}: {listed}{more})")
