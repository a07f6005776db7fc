"""Scenes of a draw, computed here or in a worker process with the same bits, and the tables that scenes share."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from numpy.typing import NDArray

from hcss_twin import Scenario, make_plan
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.parts import Workers
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Problem, ScenarioError
from hcss_uncertainty.draw_statistics import DrawStatistics, class_names, statistics_of
from hcss_uncertainty.sea_family import SeaTemperatures

_HELD = 4
"""Maximum number of sets of tables in memory: those of the current and the previous draw."""

_PAIR = 2
"""Mixtures whose pixels are mapped: the draws, with either seed."""


@dataclass
class TableCount:
    """Numbers of scenes, of different sets of tables that they needed, and of sets compiled for them.

    The other sets came from the cache of earlier runs.
    """

    scenes: int = 0
    sets: int = 0
    compiled: int = 0


class SharedTables:
    """Provides the tables of successive plans."""

    def __init__(self) -> None:
        self._held: OrderedDict[str, RadianceTables] = OrderedDict()
        self._temperatures: OrderedDict[bytes, BrightnessTemperature] = OrderedDict()

    def of(self, plan: Plan) -> tuple[RadianceTables, str, bool]:
        """Return the tables of a plan, bit-identical to those of a separate run, their key, and if they are new."""
        key = f"{RadianceTables.key_of(plan)} {plan.views} {plan.grid if plan.views.varies else None}"
        compiled: list[Plan] = []  # one per view, if the view varies over pixels
        if key not in self._held:
            self._held[key] = tables_of(plan, compiled.append)
            while len(self._held) > _HELD:
                self._held.popitem(last=False)
        self._held.move_to_end(key)
        return self._held[key], key, bool(compiled)

    def temperature(self, plan: Plan) -> BrightnessTemperature:
        """Return the cached conversion of radiance to brightness temperature, whose table is slow to compute."""
        grid = plan.spectral_grid
        key = grid.wavenumber_cm1.tobytes() + grid.weights_cm1.tobytes()
        if key not in self._temperatures:
            self._temperatures.clear()
            self._temperatures[key] = BrightnessTemperature(grid, [band.name for band in plan.bands])
        return self._temperatures[key]


@dataclass(frozen=True)
class DrawTask:
    """The scenes of one draw, one for each mixture, for any process with this package.

    ``with_pixels`` asks for the pixels of the scenes with either seed, for maps; ``temperatures`` are those of the sea
    between which the columns of each scene are interpolated.
    """

    scenarios: tuple[Scenario, ...]
    with_pixels: bool
    temperatures: tuple[SeaTemperatures | None, ...]


@dataclass(frozen=True)
class DrawResult:
    """Results of the scenes of one draw.

    Attributes
    ----------
    statistics : tuple of DrawStatistics
        One for each mixture; the first has quantiles over pixels.
    pixels : tuple of mapping
        Values of all pixels with either seed, as :func:`statistics_of` returns them; empty if not requested.
    names : frozenset of tuple
        Names of bands and pixel classes, one pair for all scenes unless they differ.
    tables : frozenset of str
        Keys of the sets of tables that the scenes needed.
    compiled : int
        Number of sets compiled.
    problem : tuple or None
        Number of the mixture whose scenario is invalid, with its problems and origin.
    """

    statistics: tuple[DrawStatistics, ...] = ()
    pixels: tuple[dict[str, NDArray[Any]], ...] = ()
    names: frozenset[tuple[tuple[str, ...], tuple[str, ...]]] = frozenset()
    tables: frozenset[str] = frozenset()
    compiled: int = 0
    problem: tuple[int, tuple[Problem, ...], str] | None = None


class DrawMaker:
    """Computes draws one after the other; all share ``cache``."""

    def __init__(self, cache: ResultCache) -> None:
        self._cache, self._tables = cache, SharedTables()

    def __call__(self, task: DrawTask) -> DrawResult:
        """Return the results of one draw; an error that only planning detects is part of it.

        Raises ProviderError if a provider violates its contract.
        """
        statistics, pixels, names, keys, compiled = [], [], set(), set(), 0
        for mixture_number, (scenario, sea) in enumerate(zip(task.scenarios, task.temperatures, strict=True)):
            family = None if sea is None else sea.family(self._cache)
            try:
                plan = make_plan(scenario, shelf=self._cache, family=family)
                tables, key, is_new = self._tables.of(plan)
                temperature = self._tables.temperature(plan)
                of_scene, values = statistics_of(plan, tables, temperature, with_levels=mixture_number == 0)
            except ScenarioError as error:
                return DrawResult(problem=(mixture_number, error.problems, error.origin))
            statistics.append(of_scene)
            if task.with_pixels and mixture_number < _PAIR:
                pixels.append(values)
            names.add((tuple(band.name for band in plan.bands), class_names(len(plan.layers))))
            keys.add(key)
            compiled += is_new
        return DrawResult(tuple(statistics), tuple(pixels), frozenset(names), frozenset(keys), compiled)


@lru_cache(maxsize=1)
def _maker() -> DrawMaker:
    return DrawMaker(ResultCache(several=True))


def _made_by_worker(task: DrawTask) -> DrawResult:
    """Compute a draw in a process that computes nothing else."""
    return _maker()(task)


def draws_made(tasks: Sequence[DrawTask], cache: ResultCache, workers: Workers) -> Iterator[DrawResult]:
    """Yield the results of all draws in order; workers, if any, begin after the first draw has its tables compiled."""
    if workers.executor is None:
        yield from map(DrawMaker(cache), tasks)
        return
    for some in (tasks[:1], tasks[1:]):
        yield from (result for _, result in workers.in_order(_made_by_worker, iter(some)))
