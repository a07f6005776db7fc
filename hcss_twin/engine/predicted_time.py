"""Processor time and memory that a run will take, from constants of a reference machine and earlier runs on this one.

The work of each stage follows from the plan. Its time on the reference machine was fitted to random scenes
(``benchmarks/predicted_time.py``); what earlier runs on this machine took, relative to that, is kept in the user's
cache and corrects it: the start of processes says how fast the machine is, runs of a stage what is peculiar to it, and
planning of a scene what planning it again takes. All are processor times, and none is part of a cube.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field

from hcss_twin.core.cache import CacheError, cache_root, cached_file, in_use
from hcss_twin.core.files import Writing
from hcss_twin.core.stages import STAGES, Stage, StageTimes, time_text
from hcss_twin.core.trust import make_private, withhold
from hcss_twin.engine.first_kernels import FRACTAL, kernels_of
from hcss_twin.engine.parts import parts_of
from hcss_twin.engine.tables.scene_axes import point_axes
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.provider_cost import ProviderCost
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.scenario import Scenario

__all__ = ["Prediction"]

FILE = "processor-times.json"
"""In the cache folder: what :class:`Earlier` holds."""

LATEST = 9
"""Runs of which the median corrects a stage; of two middle values the lower one: a load slows a machine, no more."""

SCENES = 100
"""Scenes of which the time of planning is kept."""

MACHINE_WEIGHS = 4
"""Runs of a stage that count as much as the speed of the machine: times of scenes scatter about their law twice as
much as stages differ between machines."""

WORTH_MEASURING_S = 0.1
"""Stages that are predicted to take less say nothing of the machine."""

UNLIKE = 10.0
"""Times the reference: no machine is so slow."""

NAMES = {"planning": "start and planning"}

START_S = 1.1
"""Start of a process that plans a scene with clouds of this package."""

PLANNING_S = 1.35
"""The same, with planning of a scene whose analysis is in the cache."""

TABLES_LAW = {
    "constant": -0.34, "wavenumbers": 0.17, "bands": -0.11, "sunlit": 0.77, "level": 0.15, "layers": 1.96, "views": 0.6,
    "axes": 1.0, "waves": 0.59, "hours": 0.24, "accuracy": 0.28,
}  # fmt: skip
CERTIFICATE_LAW = {
    "constant": -0.63, "wavenumbers": 0.15, "bands": 0.02, "sunlit": 0.21, "level": 0.3, "layers": 0.76,
    "own_views": 0.87, "day_views": 0.55, "axes": 0.3, "waves": 0.42, "hours": 0.02, "accuracy": 0.02,
}  # fmt: skip
"""Logarithms of seconds on the reference machine by :func:`work`, of a certificate of 24 columns."""

FLOOR_S = {"tables": 0.5, "certificate": 0.2}
"""Seconds beside these laws that every scene takes: air, particles and sea have optics, however simple the scene."""

KEPT_S: Mapping[Stage, float] = {"tables": 0.01, "certificate": 0.07}
"""The same with tables and reference columns in the cache."""

FRAMES = {"constant": 0.08, "waves": 0.25, "points": 0.06, "effects": 0.03}
"""Seconds of all frames; ``points`` and ``effects``, of each effect, for a million points."""

SENSOR = {"constant": 0.3, "points": 0.3}
"""The same of a sensor."""

MEMORY = {"constant": 220e6, "points": 60e6, "tables": 50e6, "wavenumbers": 0.25e6, "sunlit": 70e6}
"""Bytes: of the program, for a million points of a frame or tile, and of tables for each wavenumber and by day."""


@dataclass
class Earlier:
    """Processor times of earlier runs on this machine.

    Attributes
    ----------
    ratios : dict of str to list of float
        Times of the latest runs over those of the reference machine, by stage; ``start``: of the start of processes.
    new_s : list of float
        Start and planning of the latest scenes that were not known yet.
    scenes_s : dict of str to float
        Start and planning of a scene, by its digest, once its analysis is in the cache.
    """

    ratios: dict[str, list[float]] = field(default_factory=dict)
    new_s: list[float] = field(default_factory=list)
    scenes_s: dict[str, float] = field(default_factory=dict)

    def add(self, name: str, taken: float, expected: float) -> None:
        """Add a stage of a run, unless it is too short or too long to tell anything."""
        if min(expected, taken) >= WORTH_MEASURING_S and taken < UNLIKE * expected:
            self.ratios[name] = [*self.ratios.get(name, []), taken / expected][-LATEST:]

    def machine(self) -> float:
        """Return how much slower this machine is than the reference.

        The reference counts once, so that one start under load changes nothing.
        """
        return statistics.median_low([1.0, *self.ratios.get("start", [])])

    def correction(self, stage: Stage) -> float:
        """Return the time of a stage over that of the reference machine: of its own runs, and of the machine."""
        machine, runs = math.log(self.machine()), self.ratios.get(stage, [])
        if not runs:
            return math.exp(machine)
        own = math.log(statistics.median_low(runs))
        return math.exp((len(runs) * own + MACHINE_WEIGHS * machine) / (len(runs) + MACHINE_WEIGHS))

    def add_planning(self, scenario: Scenario, times: StageTimes) -> None:
        """Add start and planning of a process of its own."""
        again = _planning_again(times)
        if again is None:
            return
        self.scenes_s.pop(digest := _digest(scenario), None)
        self.scenes_s = dict([*self.scenes_s.items(), (digest, again)][-SCENES:])
        if all(layer.generator in FRACTAL for layer in scenario.clouds.layers):  # others may read files before planning
            self.add("start", times.start_s, START_S)
            taken = times.seconds["planning"]
            if again < taken < UNLIKE * PLANNING_S:
                self.new_s = [*self.new_s, taken][-LATEST:]


def _planning_again(times: StageTimes | None) -> float | None:
    """Return what start and planning of the same scene take in the next process, or None if that is not known."""
    taken = None if times is None else times.seconds.get("planning")
    if times is None or taken is None:
        return None
    return taken if in_use(cache_root()) is None else max(taken - times.once_s.get("planning", 0.0), times.start_s)


def _digest(scenario: Scenario) -> str:
    return hashlib.sha256(f"{scenario.base} {scenario.to_json()}".encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Prediction:
    """Time and memory of a run.

    Attributes
    ----------
    seconds : mapping of Stage to float
        Processor time of each stage of the next run but for kernels, with its start, with what the cache holds now.
    again_s : float
        Processor time of a run that finds all in the cache.
    memory_bytes : float
        Largest memory.
    runs : int
        Earlier runs on this machine that corrected the times.
    is_kept : bool
        Whether the tables are in the cache.
    kernels_s : float
        Processor time in which the next run compiles kernels; where other processors are free, they do half of it.
    """

    seconds: Mapping[Stage, float]
    again_s: float
    memory_bytes: float
    runs: int
    is_kept: bool
    kernels_s: float

    @property
    def total_s(self) -> float:
        """Processor time of the next run."""
        return sum(self.seconds.values()) + self.kernels_s

    @property
    def time_text(self) -> str:
        """Both times in words, for a plan."""
        parts = [
            f"{NAMES.get(name, name)} {time_text(taken)}"
            for name, taken in self.seconds.items()
            if taken >= 0.05 * self.total_s
        ]
        if self.kernels_s:
            parts.append(f"compiling kernels once {time_text(self.kernels_s)}")
        text = f"about {time_text(self.total_s)} of processor time ({', '.join(parts)})"
        if self.again_s < 0.8 * self.total_s:
            text += f"; again, from the cache, about {time_text(self.again_s)}"
        return text

    @property
    def memory_text(self) -> str:
        """The memory in words."""
        megabytes = self.memory_bytes / 1e6
        return (
            f"about {megabytes / 1e3:.1f} GB" if megabytes >= 1e3 else f"about {10.0 * round(megabytes / 10.0):.0f} MB"
        )

    def as_dict(self) -> dict[str, object]:
        """Return plain values, for ``--json``."""
        stages = {str(name): taken for name, taken in self.seconds.items()}
        return {
            "processor_s": {**stages, "kernels": self.kernels_s, "total": self.total_s, "again": self.again_s},
            "memory_bytes": self.memory_bytes,
            "earlier_runs": self.runs,
        }


def predict(plan: Plan, costs: Sequence[ProviderCost] = (), times: StageTimes | None = None) -> Prediction:
    """Predict time and memory of the next run of a plan in one process.

    Parameters
    ----------
    costs : sequence of ProviderCost
        Of providers of other packages, of which the constants know nothing.
    times : StageTimes, optional
        Of the process that made the plan, if it was started for that and compiled nothing.
    """
    earlier, planning_s = _read(), _planning_again(times)
    kept = False
    if plan.needs_radiance:
        from hcss_twin.engine.compile import tables_are_kept  # a mask alone needs no radiance

        kept = tables_are_kept(plan)

    def seconds(is_kept: bool) -> dict[Stage, float]:
        taken = {name: taken * earlier.correction(name) for name, taken in _reference_seconds(plan, is_kept).items()}
        if planning_s is not None:
            taken["planning"] = planning_s
        for cost in costs:
            if cost.label.startswith(Kind.CLOUDS):
                taken["frames"] += cost.seconds
            elif not is_kept:
                taken["tables"] += cost.seconds
        return taken

    again_s, runs = sum(seconds(True).values()), max((len(each) for each in earlier.ratios.values()), default=0)
    kernels_s = sum(each.seconds for each in kernels_of(plan.scenario) if not each.is_kept)
    return Prediction(seconds(kept), again_s, _memory_bytes(plan, kept), runs, kept, kernels_s)


def expected_planning(scenario: Scenario) -> dict[Stage, float]:
    """Return what start and planning take: of this scene before, or the median of scenes that were new.

    Nothing of it is in the plan's own prediction, which is made when planning has ended.
    """
    earlier = _read()
    known = earlier.scenes_s.get(_digest(scenario)) or (statistics.median_low(earlier.new_s) if earlier.new_s else None)
    return {} if known is None else {"planning": known}


def learn_planning(plan: Plan, times: StageTimes) -> None:
    """Keep how long start and planning took."""
    if "planning" in times.seconds and plan.needs_radiance:
        earlier = _read()
        earlier.add_planning(plan.scenario, times)
        _write(earlier)


def learn(plan: Plan, was_kept: bool, times: StageTimes) -> None:
    """Keep how long the stages of a run took on this machine; a cache that cannot be written changes nothing.

    Parameters
    ----------
    was_kept : bool
        Whether the tables were in the cache.
    times : StageTimes
        Of a run in one process that compiled no kernels.
    """
    earlier = _read()
    for name, expected in _reference_seconds(plan, was_kept).items():
        if name != "planning" and name in times.seconds:
            earlier.add(name, times.seconds[name], expected)
    if plan.needs_radiance:
        earlier.add_planning(plan.scenario, times)
    _write(earlier)


def work(plan: Plan) -> dict[str, float]:
    """Return what the time of a run depends on, as numbers of which logarithms of times are sums.

    Only ratios matter: the spectral grid, streams by day, cloud layers, nodes of views and other axes, and accuracy,
    by which nodes of cloud thickness are placed. Columns of a certificate have views of their own, however many nodes
    there are.
    """
    assembly, sunlit = plan.assembly, plan.sun_matters
    over = math.prod(len(axis.nodes) for axis in point_axes(plan))
    return {
        "wavenumbers": math.log(assembly.spectral_grid.wavenumber_cm1.size / 100.0),
        "bands": math.log(len(plan.bands)),
        "sunlit": float(sunlit),
        "level": float(assembly.numerical_level + assembly.sunlight_steps) if sunlit else 0.0,
        "layers": float(sum(assembly.cloudy_layers) - 1),
        "views": math.log(len(plan.views.places)) if plan.views.varies else 0.0,
        "own_views": float(plan.views.varies),
        "day_views": float(plan.views.varies and sunlit),
        "axes": math.log(max(over, 1)),
        "waves": float(plan.waves.varies),
        "hours": math.log1p(abs(float(plan.frame_times_s[-1] - plan.frame_times_s[0])) / 600.0) if sunlit else 0.0,
        "accuracy": math.log(1e-3 / plan.accuracy.relative),
    }


def reference_columns(plan: Plan) -> float:
    """Return about how many different columns a certificate solves: one of each pixel, or of its cloudy points."""
    clear = math.prod(1.0 - layer.coverage for layer in plan.layers)
    of_pixel = 1.0 + (1.0 - clear) * (plan.samples_per_pixel**2 - 1.0)
    return plan.scenario.output.certificate * of_pixel


def points(plan: Plan) -> float:
    """Return the number of points of all frames, counted for each cloud layer, in millions."""
    count = math.prod(plan.pixels) * plan.samples_per_pixel**2 * plan.frame_times_s.size
    return count * max(len(plan.layers), 1) / 1e6


def _seconds_of(stage: str, law: Mapping[str, float], of_plan: Mapping[str, float]) -> float:
    return FLOOR_S[stage] + math.exp(sum(number * of_plan.get(name, 1.0) for name, number in law.items()))


def _reference_seconds(plan: Plan, is_kept: bool) -> dict[Stage, float]:
    """Return the processor time of each stage on the reference machine, start of the process included."""
    varied = plan.waves.varies + plan.has_shadows + plan.views.varies + plan.texture.varies
    frames = FRAMES["constant"] + FRAMES["waves"] * plan.waves.varies
    seconds: dict[Stage, float] = {"planning": PLANNING_S}
    if plan.needs_radiance:
        of_plan = work(plan)
        seconds["tables"] = KEPT_S["tables"] if is_kept else _seconds_of("tables", TABLES_LAW, of_plan)
        if plan.scenario.output.certificate:
            one = KEPT_S["certificate"] if is_kept else _seconds_of("certificate", CERTIFICATE_LAW, of_plan)
            seconds["certificate"] = one * (1.0 if is_kept else max(reference_columns(plan) / 24.0, 0.5))
    seconds["frames"] = frames + points(plan) * (FRAMES["points"] + FRAMES["effects"] * varied)
    if plan.sensor.stages:
        seconds["sensor"] = SENSOR["constant"] + SENSOR["points"] * points(plan)
    return {name: seconds[name] for name in STAGES if name in seconds}


def _memory_bytes(plan: Plan, is_kept: bool) -> float:
    """Return the largest memory of a run in one process, which holds one frame, or one tile of a large one."""
    of_part = MEMORY["points"] * points(plan) / parts_of(plan)
    if not plan.needs_radiance or is_kept:
        return MEMORY["constant"] + of_part
    wavenumbers = plan.spectral_grid.wavenumber_cm1.size
    tables = MEMORY["tables"] + MEMORY["wavenumbers"] * wavenumbers + MEMORY["sunlit"] * plan.sun_matters
    return MEMORY["constant"] + of_part + tables


def _read() -> Earlier:
    """Return the times of earlier runs; none where the file is missing or not ours."""
    folder = in_use(cache_root())
    path = None if folder is None else cached_file(folder, FILE)
    if path is None:
        return Earlier()
    with contextlib.suppress(OSError, ValueError, AttributeError, TypeError, KeyError):
        read = json.loads(path.read_text(encoding="utf-8"))
        return Earlier(
            {str(name): _numbers(each, UNLIKE) for name, each in read["ratios"].items()},
            _numbers(read["new_s"], UNLIKE * PLANNING_S),
            {str(name): float(taken) for name, taken in read["scenes_s"].items()},
        )
    return Earlier()


def _numbers(read: Sequence[float], limit: float) -> list[float]:
    return [float(number) for number in read if 0.01 < float(number) < limit]


def _write(earlier: Earlier) -> None:
    folder = in_use(cache_root())
    if folder is None:
        return
    with contextlib.suppress(OSError, CacheError):
        make_private(folder)
        with Writing(folder / FILE, CacheError) as draft:
            draft.write_text(json.dumps(asdict(earlier)), encoding="utf-8")
            withhold(draft)
