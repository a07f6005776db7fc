"""Run time versus error for one scene, compared with brute force: spectral integration of every pixel, at all
wavenumbers or at fewer.
"""

from __future__ import annotations

import statistics
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from hcss_bench.reference import (
    MODELS,
    REFERENCE_STEPS,
    Reference,
    changed,
    column_radiance,
    reference_of,
    table_radiance,
)
from hcss_bench.stages import CERTIFICATE, RAW, RUNS, STAGES, Rounds, private_cache, time_certificate, time_stages
from hcss_twin import Scenario, make_plan
from hcss_twin.core.units import QuantityParser
from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.engine.compile import tables_of
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, Problem, ScenarioError

_SEED = 20_240_420


def random_columns(plan: Plan, count: int) -> Array:
    """Thickness (N, L) at random points of the first frame, clear and cloudy."""
    random = np.random.default_rng(_SEED)
    samples, time_s = plan.samples_per_pixel, float(plan.frame_times_s[0])
    size = plan.grid.rows * samples, plan.grid.columns * samples
    rows, across = (random.integers(0, side, count).tolist() for side in size)
    columns = np.zeros((count, len(plan.layers)))
    for index, (layer, generator) in enumerate(zip(plan.layers, plan.assembly.generators, strict=True)):
        whole = None
        if not generator.declares.tileable:
            whole = generator.thickness_m(time_s, slice(0, size[0]), slice(0, size[1]))
        for point, (y, x) in enumerate(zip(rows, across, strict=True)):
            one = generator.thickness_m(time_s, slice(y, y + 1), slice(x, x + 1)) if whole is None else whole[y:, x:]
            value = float(one[0, 0])
            if value > 0:
                # Values outside the limits due to single precision are clipped, as in the look-up.
                columns[point, index] = min(max(value, layer.thickness_min_m), layer.thickness_max_m)
    return columns


def every_nth(plan: Plan, step: int) -> SpectralGrid:
    """Return every ``step``-th wavenumber of the provider's grid, plus the band edges."""
    return SpectralGrid.dense(plan.bands, plan.spectral_grid.wavenumber_cm1[::step])


def even_wavelengths(plan: Plan, count: int) -> SpectralGrid:
    """Return a grid with ``count`` evenly spaced wavelengths per band."""
    inside = [1e4 / np.linspace(band.lower_um, band.upper_um, count) for band in plan.bands]
    return SpectralGrid.dense(plan.bands, np.unique(np.concatenate(inside)))


def points_of_scene(plan: Plan) -> int:
    """Number of points in all frames for which a column is computed."""
    return plan.frame_times_s.size * plan.grid.rows * plan.grid.columns * plan.samples_per_pixel**2


ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
BRUTE_FORCE = ((1, False), (1, True), (4, True), (16, True))
"""Brute-force variants: every n-th wavenumber of the provider, and whether the model computes all pixels at once."""

_BRUTE = "brute force, every {}, together {}"


@dataclass(frozen=True)
class AccuracyResult:
    """One accuracy; its errors relative to the run's own model, and relative to the reference of all models.

    Attributes
    ----------
    asked : str
        The requested accuracy: a fraction of the radiance, or kelvin of brightness temperature.
    own : bool
        Whether it is the accuracy of the scenario.
    accuracy, estimated : float
        The requested accuracy as a fraction of the radiance, and the error estimated during table compilation.
    achieved : float or None
        Largest error of the checked pixels in any band, relative to the run's own radiance model; None if none could be
        checked.
    achieved_K : float or None
        The same in kelvin, if requested in kelvin.
    by_band : dict of str to float
        Largest error of any column in each band, relative to the reference of all models; empty if tables depend on the
        place in the image.
    checked, exceeding : int
        Number of certificate pixels, and of those that exceed the accuracy.
    seconds : dict of str to float
        Median time of each stage over rounds.
    over_raw : dict of str to float
        For each whole run, ``stages.RUNS``: its time divided by that of a raw write of the same bytes.
    over_brute_force : dict of str to float
        For each whole run: the time of integrating every pixel at every wavenumber divided by that of the run.
    """

    asked: str
    own: bool
    accuracy: float
    estimated: float
    achieved: float | None
    achieved_K: float | None
    by_band: dict[str, float]
    checked: int
    exceeding: int
    seconds: dict[str, float]
    over_raw: dict[str, float]
    over_brute_force: dict[str, float]

    @property
    def error(self) -> float | None:
        """Largest error in any band, relative to the reference of all models."""
        return max(self.by_band.values(), default=None)


@dataclass(frozen=True)
class BruteForceResult:
    """Spectral integration of every pixel, timed on a few pixels and scaled to all.

    Attributes
    ----------
    every, wavenumbers : int
        Step in the provider's wavenumbers, and the number of wavenumbers used.
    together : int
        Number of pixels that the model computes at once.
    seconds_per_point : float
    seconds : float
        Time for all points of the scene, without one-time computations of the model.
    over_raw : float
        This time divided by that of a raw write of the cube's bytes.
    error : float
        Largest error of any pixel and band, relative to the reference of all models; with all wavenumbers it is that of
        the radiance model alone.
    """

    every: int
    wavenumbers: int
    together: int
    seconds_per_point: float
    seconds: float
    over_raw: float
    error: float


@dataclass(frozen=True)
class BenchResult:
    """Result of one run of the benchmark.

    Attributes
    ----------
    scene, reference : str
        Short descriptions of the scene, and of the reference.
    rounds, points, timed_points : int
        Number of rounds, of points in all frames, and of points used to time brute force.
    accuracies : tuple of AccuracyResult
    brute_force : tuple of BruteForceResult
    """

    scene: str
    reference: str
    rounds: int
    points: int
    timed_points: int
    accuracies: tuple[AccuracyResult, ...]
    brute_force: tuple[BruteForceResult, ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            **vars(self),
            "accuracies": [vars(accuracy) for accuracy in self.accuracies],
            "brute_force": [vars(run) for run in self.brute_force],
        }


def bench(
    scenario: Scenario,
    accuracies: Sequence[float | str] | None = None,
    rounds: int = 3,
    pixels: int = 24,
    folder: Path | None = None,
    tell: Callable[[str], None] | None = None,
    every_model: bool = False,
    reference_level: int | None = None,
) -> dict[str, BenchResult]:
    """Time a scene at several accuracies, stage by stage, and measure its error relative to one reference.

    Parameters
    ----------
    accuracies : sequence of float or str, optional
        Replace the scenario's accuracy: fractions of the radiance, or kelvin such as ``"0.1 K"``. Default:
        ``ACCURACIES`` and the scenario's.
    rounds : int
        Number of rounds of all measurements; tables and certificates are computed in the first one only.
    pixels : int
        Number of certificate pixels at each accuracy, and of pixels used to time brute force.
    folder : Path, optional
        Folder of temporary cubes; default: the system's folder for temporary files.
    tell : callable, optional
        Called with a short description of the next step.
    every_model : bool
        Whether to measure all ``MODELS`` in place of the scenario's own.
    reference_level : int, optional
        Numerical level of the reference; default: the finest.

    Returns
    -------
    dict of str to BenchResult
        By radiance model.

    Raises
    ------
    ScenarioError
        If the scenario is invalid, computes no radiance, or does not support one of the accuracies.
    """
    models = {scenario.radiance.model: scenario}
    if every_model:
        models = {name: changed(scenario, overrides) for name, overrides in MODELS.items()}
    asked = asked_for(scenario, accuracies)
    say = _numbered(tell or (lambda text: None), len(asked) + REFERENCE_STEPS + len(models) * _steps(asked, rounds))
    with tempfile.TemporaryDirectory(prefix=".hcss-bench-", dir=folder) as name, private_cache(Path(name) / "cache"):
        plan = _checked_plan(scenario, asked, say)
        columns = random_columns(plan, pixels)
        reference = reference_of(scenario, columns, reference_level, lambda text: say(f"reference, {text}"))
        return {
            model: measured(
                assembly,
                asked,
                rounds,
                reference,
                Path(name),
                partial(_say_of, say, f"{model}: " if every_model else ""),
            )
            for model, assembly in models.items()
        }


def bench_text_before(
    scenario: Scenario, accuracies: Sequence[float | str] | None, rounds: int, pixels: int, every_model: bool
) -> str:
    """Return what :func:`bench` is about to measure, for a user who waits for it."""
    asked = asked_for(scenario, accuracies)
    image = scenario.image
    return (
        f"{scenario.origin}: {scenario.frames.count} frames of {image.rows} x {image.columns} pixels, "
        f"{len(scenario.bands)} bands; radiance {', '.join(MODELS) if every_model else scenario.radiance.model}; "
        f"accuracies {', '.join(map(_text, asked))}; {rounds} round{'s' * (rounds > 1)}; errors of {pixels} pixels"
    )


def _numbered(tell: Callable[[str], None], total: int) -> Callable[[str], None]:
    """Return a function that tells the next of ``total`` steps with its number."""
    number = count(1)
    return lambda text: tell(f"step {next(number)} of {total}: {text}")


def _say_of(say: Callable[[str], None], prefix: str, text: str) -> None:
    say(prefix + text)


def _steps(accuracies: tuple[float | str, ...], rounds: int) -> int:
    """Number of steps of :func:`measured`."""
    return 2 + rounds * (len(accuracies) + 1) + len(accuracies)


def _checked_plan(scenario: Scenario, accuracies: tuple[float | str, ...], say: Callable[[str], None]) -> Plan:
    """Make the plans of all accuracies, so that an unsupported one is rejected before any measurement."""
    plans: list[Plan] = []
    for accuracy in accuracies:
        say(f"plan at accuracy {_text(accuracy)}" + ("" if plans else ", compiling kernels"))
        plans.append(make_plan(_at(scenario, accuracy, 0)))
    plan = plans[0]
    if not plan.needs_radiance:
        message = "none of these needs radiance, so there is nothing to measure; add radiance"
        raise ScenarioError([Problem("output.variables", message)], scenario.origin)
    if plan.texture.varies:
        textures = {
            "sea.temperature_texture": scenario.sea.temperature_texture or 0.0,
            "atmosphere.water_vapour_texture": scenario.atmosphere.water_vapour_texture or 0.0,
        }
        message = "given, but reference columns have no texture: errors would be those of another scene; allowed: 0"
        problems = [Problem(key, f"{value:g} {message}") for key, value in textures.items() if value > 0.0]
        raise ScenarioError(problems, scenario.origin)
    return plan


def asked_for(scenario: Scenario, accuracies: Sequence[float | str] | None) -> tuple[float | str, ...]:
    """Return the accuracies to measure: those given, or the default ones and the scenario's own."""
    if accuracies is not None:
        return tuple(QuantityParser.parse_accuracy(accuracy) for accuracy in accuracies)
    if scenario.accuracy in ACCURACIES:
        return ACCURACIES
    if isinstance(scenario.accuracy, str):
        return (*ACCURACIES, scenario.accuracy)
    return tuple(sorted((*ACCURACIES, scenario.accuracy), reverse=True))


def measured(
    scenario: Scenario,
    accuracies: tuple[float | str, ...],
    rounds: int,
    reference: Reference,
    folder: Path,
    say: Callable[[str], None],
) -> BenchResult:
    """Measure a scenario at all accuracies and by brute force, relative to a reference; as for :func:`bench`."""
    times, columns = Rounds(), reference.columns
    pixels = columns.shape[0]
    say("first run, which is not timed")
    plan = make_plan(_at(scenario, accuracies[0], 0))
    with private_cache(folder / "first"):  # the tables of the first round are new
        time_stages(Rounds(), "", plan.scenario, folder, True)
    say("integrating some pixels, at all wavenumbers and at fewer")
    grids = {step: every_nth(plan, step) for step, _ in BRUTE_FORCE}
    known = {step: reference.errors(column_radiance(plan, grid, columns)) for step, grid in grids.items()}
    by_band: dict[float | str, dict[str, float]] = {}
    checks: dict[float | str, Certificate] = {}
    for number in range(rounds):
        raw = []
        for accuracy in accuracies:
            what = "new tables, stages and whole run" if number == 0 else "stages and whole run"
            say(f"round {number + 1} of {rounds}, accuracy {_text(accuracy)}: {what}")
            # Tables and certificates take longest and are the same in every round, so they are made once.
            time_stages(times, _name(accuracy), _at(scenario, accuracy, 0), folder, number == 0)
            raw.append(times.last(_name(accuracy) + RAW))
            if number == 0:
                run = make_plan(_at(scenario, accuracy, 0))
                looked_up = table_radiance(run, tables_of(run), columns)
                by_band[accuracy] = {} if looked_up is None else reference.errors(looked_up)
                say(f"round 1 of {rounds}, accuracy {_text(accuracy)}: certificate")
                checked = _at(scenario, accuracy, pixels)
                checks[accuracy] = time_certificate(times, _name(accuracy), checked, folder)
        # The number of bytes is the same at all accuracies, and disk speed varies.
        times.add(RAW, statistics.median(raw))
        say(f"round {number + 1} of {rounds}, brute force")
        for step, together in BRUTE_FORCE:
            call = partial(column_radiance, plan, grids[step], columns, pixels if together else 1)
            times.time(_BRUTE.format(step, together), call)
    scale = points_of_scene(plan) / pixels
    return BenchResult(
        scene=_scene(plan),
        reference=reference.text,
        rounds=rounds,
        points=points_of_scene(plan),
        timed_points=pixels,
        accuracies=tuple(
            _accuracy(times, accuracy, accuracy == scenario.accuracy, check, by_band[accuracy], scale)
            for accuracy, check in checks.items()
        ),
        brute_force=tuple(
            BruteForceResult(
                every=step,
                wavenumbers=int(grids[step].wavenumber_cm1.size),
                together=pixels if together else 1,
                seconds_per_point=times.seconds(_BRUTE.format(step, together)) / pixels,
                seconds=scale * times.seconds(_BRUTE.format(step, together)),
                over_raw=scale * times.ratio(_BRUTE.format(step, together), RAW),
                error=max(known[step].values()),
            )
            for step, together in BRUTE_FORCE
        ),
    )


def _accuracy(
    times: Rounds, accuracy: float | str, is_own: bool, check: Certificate, by_band: dict[str, float], scale: float
) -> AccuracyResult:
    prefix, every = _name(accuracy), _BRUTE.format(1, False)
    return AccuracyResult(
        asked=_text(accuracy),
        own=is_own,
        accuracy=check.requested.relative,
        estimated=check.estimated,
        achieved=max(check.achieved.values(), default=None),
        achieved_K=max(check.achieved_K.values(), default=None),
        by_band=by_band,
        checked=check.checked,
        exceeding=check.exceeding,
        seconds={stage: times.seconds(prefix + stage) for stage in (*STAGES, CERTIFICATE, *RUNS, RAW)},
        over_raw={run: times.ratio(prefix + run, RAW) for run in RUNS},
        over_brute_force={run: scale * times.ratio(every, prefix + run) for run in RUNS},
    )


def _text(accuracy: float | str) -> str:
    """Format an accuracy as in a scenario."""
    return accuracy if isinstance(accuracy, str) else f"{accuracy:g}"


def _at(scenario: Scenario, accuracy: float | str, pixels: int) -> Scenario:
    values = {"accuracy": accuracy, "output.certificate": pixels}
    # reference columns have no texture
    values["sea.temperature_texture"] = scenario.sea.temperature_texture or 0.0
    values["atmosphere.water_vapour_texture"] = scenario.atmosphere.water_vapour_texture or 0.0
    return changed(scenario, values)


def _name(accuracy: float | str) -> str:
    return f"{_text(accuracy)}, "


def _scene(plan: Plan) -> str:
    providers = {kind: entry.name for kind, entry in plan.assembly.entries.items()}
    named = ", ".join(f"{kind} {name}" for kind, name in providers.items())
    return (
        f"{plan.scenario.origin}: {plan.frame_times_s.size} frames of {plan.grid.rows} x {plan.grid.columns} pixels, "
        f"{len(plan.bands)} bands; {named}"
    )
