"""The scenarios of all draws, checked before the first is computed.

Radiance tables of draws: made once for all that they are the same for.
"""

from __future__ import annotations

import json
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ScenarioError, shown
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.engine.compile import compile_tables, table_key, tables_of
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.models.radiance.spectral_grid import BrightnessTemperature
from hcss_twin.plan.plan import Plan
from hcss_twin.scenario.scenario import UNCERTAIN, Scenario, read_scenario_file
from hcss_twin.sweeps.design import keys_overlap
from hcss_twin.sweeps.points import ranges, value_at
from hcss_twin.sweeps.propagation.draw_statistics import VARIABLES
from hcss_twin.sweeps.propagation.joint_sample import OTHER_SEED, SEED, A, B, JointSample, Mixture

_SUMMED_UP: Mapping[str, Any] = {"output.variables": list(VARIABLES), "output.certificate": 0}
"""Of the scenes that are summed up; cubes of draws hold what the user asked for."""


@dataclass(frozen=True)
class Source:
    """A scenario before its uncertain keys have values.

    Attributes
    ----------
    raw : mapping
        Keys of the file without ``[uncertain]``.
    overrides : mapping
        Keys replaced in all draws.
    uncertain : mapping
        What the section holds.
    base : Path
    origin : str
    shelf : ResultCache
        What all draws share.
    """

    raw: Mapping[str, Any]
    overrides: Mapping[str, Any]
    uncertain: Mapping[str, Any]
    base: Path
    origin: str
    shelf: ResultCache

    @classmethod
    def load(
        cls, source: str | Path | Mapping[str, Any] | Scenario, overrides: Mapping[str, Any] | None = None
    ) -> Source:
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
        return Scenario.from_dict(self.raw, overrides, base=self.base, origin=self.origin, shelf=self.shelf)


def overlap_problems(source: Source, sample_keys: Sequence[str], posterior_keys: Sequence[str]) -> Iterator[Problem]:
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


def scenarios_of(source: Source, sample: JointSample) -> dict[str, tuple[Scenario, ...]]:
    """Make and check the scenarios of all draws of all mixtures.

    Returns
    -------
    dict of str to tuple of Scenario
        By the name of the mixture.

    Raises
    ------
    ScenarioError
        With all problems, each told once, with the draws that have it and their values.
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


_HELD = 4
"""Tables in memory: all that one draw and the last need."""


@dataclass
class TableCount:
    """How often tables were made.

    Attributes
    ----------
    scenes : int
        Scenes that asked for tables.
    sets : int
        Different tables that they needed, if no more than a few different ones come in a row.
    compiled : int
        Those of them that were compiled; the others were kept from earlier runs.
    """

    scenes: int = 0
    sets: int = 0
    compiled: int = 0


class SharedTables:
    """Gives the tables of one plan after the other.

    Attributes
    ----------
    count : TableCount
    """

    def __init__(self) -> None:
        self.count = TableCount()
        self._held: OrderedDict[str, RadianceTables] = OrderedDict()
        self._temperatures: OrderedDict[bytes, BrightnessTemperature] = OrderedDict()

    def of(self, plan: Plan) -> RadianceTables:
        """Return the tables of a plan, the same to the bit as those of a run of its own."""
        self.count.scenes += 1
        key = f"{table_key(plan)} {plan.views} {plan.grid if plan.views is not None else None}"
        if key not in self._held:
            self.count.sets += 1
            compiled: list[Plan] = []  # of several views, where pixels have views of their own
            self._held[key] = tables_of(plan, partial(_noted, compiled))
            self.count.compiled += bool(compiled)
            while len(self._held) > _HELD:
                self._held.popitem(last=False)
        self._held.move_to_end(key)
        return self._held[key]

    def temperature(self, plan: Plan) -> BrightnessTemperature:
        """Return what turns radiance into brightness temperature; its table takes longer than a small frame."""
        grid = plan.spectral_grid
        key = grid.wavenumber_cm1.tobytes() + grid.weights_cm1.tobytes()
        if key not in self._temperatures:
            self._temperatures.clear()
            self._temperatures[key] = BrightnessTemperature(grid, [band.name for band in plan.bands])
        return self._temperatures[key]


def _noted(compiled: list[Plan], plan: Plan) -> RadianceTables:
    compiled.append(plan)
    return compile_tables(plan)
