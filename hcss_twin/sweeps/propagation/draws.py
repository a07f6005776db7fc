"""A scenario with uncertain keys, and the scenarios of all draws, checked before the first is computed."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ScenarioError, choose_from, closest, count, shown
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.providers.registry.registry import OWN_DISTRIBUTION
from hcss_twin.scenario.models import ScenarioModel
from hcss_twin.scenario.scenario import UNCERTAIN, Scenario, read_scenario_file
from hcss_twin.sweeps.design import keys_overlap
from hcss_twin.sweeps.points import ranges, value_at
from hcss_twin.sweeps.propagation.draw_statistics import VARIABLES
from hcss_twin.sweeps.propagation.joint_sample import OTHER_SEED, SEED, A, B, JointSample, Mixture, UncertainKey

_SUMMED_UP: Mapping[str, Any] = {"output.variables": list(VARIABLES), "output.certificate": 0}
"""Of the scenes that are summed up; cubes of draws hold what the user asked for."""


@dataclass(frozen=True)
class UncertainScenario:
    """A scenario before its uncertain keys have values.

    Attributes
    ----------
    raw : mapping
        Keys of the file without ``[uncertain]``.
    overrides : mapping
        Keys replaced in all draws.
    uncertain : mapping
        What the section holds.
    cache : ResultCache
        What all draws share.
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
        """Read a scenario file by name or path, or take its keys; raises :class:`ScenarioError`."""
        if isinstance(source, Scenario):
            raw, base, origin = json.loads(source.to_json()), source.base, source.origin
        elif isinstance(source, Mapping):
            raw, base, origin = dict(source), Path.cwd(), "scenario"
        else:
            (raw, base), origin = read_scenario_file(source), str(source)
        if not isinstance(raw, Mapping):
            raise ScenarioError([Problem("scenario", f"{shown(raw)} is not a table of keys")], origin)
        raw = dict(raw)
        section = raw.pop(UNCERTAIN, {})
        if not isinstance(section, Mapping):
            told = f"{shown(section)} is not a table; allowed: keys of a scenario, each with a distribution"
            raise ScenarioError([Problem(UNCERTAIN, told)], origin)
        return cls(raw, dict(overrides or {}), section, base, origin, ResultCache())

    def scenario(self, changes: Mapping[str, Any] | None = None) -> Scenario:
        """Return the scenario with more keys replaced; raises :class:`ScenarioError`."""
        overrides = {**self.overrides, **(changes or {})}
        return Scenario.from_dict(self.raw, overrides, base=self.base, origin=self.origin, shelf=self.cache)


SHORT_FORMS = {
    "uniform": ("from", "to"),
    "log-uniform": ("from", "to"),
    "normal": ("mean", "standard_deviation", "from", "to"),
}
"""What the numbers of ``NAME:NUMBER:NUMBER`` mean."""

_ALLOWED = (
    'allowed: {distribution = "normal", mean = 291, standard_deviation = 0.5}, "uniform" or "log-uniform" with from '
    "and to, or in short normal:291:0.5, normal:291:0.5:271:305 (cut off), uniform:3:9, log-uniform:1:10"
)

_KEYS = 'allowed: keys of a scenario, for example "sea.temperature"'


def uncertain_keys(given: Mapping[str, Any], section: str = UNCERTAIN) -> tuple[UncertainKey, ...]:
    """Check what stands in ``[uncertain]`` or behind ``--uncertain``.

    Raises ScenarioError with everything that is wrong.

    Parameters
    ----------
    given : mapping
        Key, dotted or in nested tables, to a distribution: a table, or text in the short form.
    """
    problems: list[Problem] = []
    found: list[UncertainKey] = []
    for key, each in _flat(given).items():
        try:
            found.append(UncertainKey(key, _table(each)))
            found[-1].values(1, 0)
        except ValueError as error:
            problems.append(Problem(f"{section}.{key}", str(error)))
    problems += _key_problems([each.key for each in found], section)
    if problems:
        raise ScenarioError(problems, section)
    return tuple(found)


def _flat(section: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    """Join keys of nested tables by dots; a table with the name of a distribution is one."""
    found: dict[str, Any] = {}
    for name, each in section.items():
        if isinstance(each, Mapping) and each and "distribution" not in each:
            found.update(_flat(each, f"{path}{name}."))
        else:
            found[f"{path}{name}"] = each
    return found


def _table(given: Any) -> Mapping[str, Any]:
    if isinstance(given, str):
        return _parsed(given)
    if not isinstance(given, Mapping) or "distribution" not in given:
        raise ValueError(f"{shown(given)} is no distribution; {_ALLOWED}")
    for name in ("samples", "seed"):
        if name in given:
            raise ValueError(f"{name}: the number of draws and their seed are those of all inputs; {_ALLOWED}")
    return dict(given)


def _parsed(text: str) -> Mapping[str, Any]:
    name, *numbers = (part.strip() for part in text.split(":"))
    if name not in SHORT_FORMS:
        raise ValueError(f"{shown(text)}: distribution '{name}'; {choose_from(name, SHORT_FORMS)}")
    meaning = SHORT_FORMS[name]
    if not 2 <= len(numbers) <= len(meaning):
        raise ValueError(f"{shown(text)} has {count(len(numbers), 'number', 'numbers')}; {_ALLOWED}")
    values = dict(zip(meaning, map(_read_number, numbers), strict=False))
    return {"distribution": name, **values}


def _read_number(text: str) -> float | str:
    """Read a number; text with a unit stays as it is."""
    try:
        value = float(text)
    except ValueError:
        return text
    if not np.isfinite(value):
        raise ValueError(f"{text}: allowed: finite numbers")
    return value


def _key_problems(keys: list[str], section: str) -> Iterator[Problem]:
    for place, key in enumerate(keys):
        for other in keys[:place]:
            if keys_overlap(key, other):
                yield Problem(f"{section}.{key}", f"overlaps {other}, which is uncertain, too; allowed: one of both")
        first = key.partition(".")[0]
        if first not in ScenarioModel.model_fields:
            guess = closest(first, ScenarioModel.model_fields)
            hint = f"; closest is '{guess}'" if guess else ""
            yield Problem(f"{section}.{key}", f"no key of a scenario; {_KEYS}{hint}")
        elif first in ("seed", "output", "bands", "frames", "title"):
            yield Problem(
                f"{section}.{key}",
                "must be the same in all draws, whose results are put together; allowed: any other key",
            )


def layer_of(scenario: ScenarioModel, layer: int | None, origin: str) -> str:
    """Return the part of a scenario that the parameters of clouds belong to.

    Raises ScenarioError if there is no such layer, or its clouds are not those that a posterior is of.

    Parameters
    ----------
    layer : int or None
        Number of the layer; needed where there are several.
    """
    layers = scenario.clouds.layers
    if layer is None and len(layers) != 1:
        told = f"{len(layers)} layers; say which the posterior is of, allowed: layer 0 to {len(layers) - 1}"
        if not layers:
            told = "the scenario has no clouds; allowed: a cloud layer"
        raise ScenarioError([Problem("clouds.layers", told)], origin)
    number = layer or 0
    if not 0 <= number < len(layers):
        told = f"layer {number} given; allowed: 0 to {len(layers) - 1}"
        raise ScenarioError([Problem("clouds.layers", told)], origin)
    path = "clouds" if len(layers) == 1 else f"clouds.layers.{number}"
    if layers[number].generator not in ("fractal", f"{OWN_DISTRIBUTION}/fractal"):
        told = f"{shown(layers[number].generator)}; a posterior is of clouds of the generator, allowed: 'fractal'"
        raise ScenarioError([Problem(f"{path}.generator", told)], origin)
    return path


def overlap_problems(
    source: UncertainScenario, sample_keys: Sequence[str], posterior_keys: Sequence[str]
) -> Iterator[Problem]:
    """Yield what is both uncertain and given otherwise: by the posterior, or by ``--set``."""
    for key in sample_keys:
        for other in posterior_keys:
            if keys_overlap(key, other):
                yield Problem(
                    f"{UNCERTAIN}.{key}", f"overlaps {other}, which the posterior has values for; allowed: one of both"
                )
        for other in source.overrides:
            if keys_overlap(key, other):
                yield Problem(
                    f"{UNCERTAIN}.{key}", f"is uncertain, but {other} is set to one value; allowed: one of both"
                )


def scenarios_of(source: UncertainScenario, sample: JointSample) -> dict[str, tuple[Scenario, ...]]:
    """Make and check the scenarios of all draws of all mixtures.

    Raises ScenarioError with all problems, each told once, with the draws that have it and their values.

    Returns
    -------
    dict of str to tuple of Scenario
        By the name of the mixture.
    """
    found: dict[str, tuple[Scenario, ...]] = {}
    wrong: dict[Problem, list[tuple[Mixture, int]]] = {}
    for mixture in sample.mixtures:
        if mixture.name == OTHER_SEED:
            continue  # the same but for a number
        made = []
        for draw in range(sample.count):
            try:
                made.append(source.scenario({**sample.overrides(mixture, draw), **_SUMMED_UP}))
            except ScenarioError as error:
                for problem in error.problems:
                    wrong.setdefault(problem, []).append((mixture, draw))
        found[mixture.name] = tuple(made)
    if wrong:
        raise ScenarioError(_told(wrong, sample), source.origin)
    same = found[sample.mixtures[0].name]
    found[OTHER_SEED] = tuple(
        each.model_copy(update={SEED: int(seed)}) for each, seed in zip(same, sample.seeds[B], strict=True)
    )
    return found


def with_draw(error: ScenarioError, sample: JointSample, mixture: Mixture, draw: int) -> ScenarioError:
    """Return an error that only the plan of a draw finds, naming the draw and its values."""
    wrong = {problem: [(mixture, draw)] for problem in error.problems}
    return ScenarioError(_told(wrong, sample), error.origin)


def numbers_of(sample: JointSample, scenarios: Sequence[Scenario]) -> Array:
    """Return the inputs of the first sample as numbers (draw, input): SI, instants in seconds since 1970.

    Parameters
    ----------
    scenarios : sequence of Scenario
        Of the draws.
    """
    columns = [sample.rows[A].T]
    for each in sample.keys:
        values = [value_at(json.loads(scenario.to_json()), each.key) for scenario in scenarios]
        columns.append(np.array([list(map(_number, values))]))
    return np.concatenate(columns).T


def _number(value: Any) -> float:
    if isinstance(value, str):
        return datetime.fromisoformat(value).timestamp()
    return float(value)


def _told(wrong: Mapping[Problem, list[tuple[Mixture, int]]], sample: JointSample) -> Iterator[Problem]:
    """Name the first draw for each key that is wrong, and count the others: messages differ by their values."""
    fields: dict[str, list[tuple[Problem, Mixture, int]]] = {}
    for problem, places in wrong.items():
        fields.setdefault(problem.field, []).extend((problem, *place) for place in places)
    for field, each in fields.items():
        problem, mixture, draw = each[0]
        values = sample.overrides(mixture, draw)
        values.pop(SEED)
        own = {key: value for key, value in values.items() if _is_about(field, key)}
        told = ", ".join(f"{key} = {shown(value)}" for key, value in (own or values).items())
        others = sorted({number for _, _, number in each} - {draw})
        more = f"; also wrong: {_plural('draw', len(others))} {ranges(others)}" if others else ""
        which = "" if mixture.name == sample.mixtures[0].name else f" with {mixture.name}"
        yield Problem(field, f"{problem.message} (draw {draw}{which}: {told}{more})")


def _plural(noun: str, number: int) -> str:
    return noun if number == 1 else f"{noun}s"


def _is_about(field: str, key: str) -> bool:
    plain = field.replace("[", ".").replace("]", "")
    return keys_overlap(plain, key)
