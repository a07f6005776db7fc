"""Run a random scenario, and compute pixels of its cube again with code that shares nothing with the certificate's."""

from __future__ import annotations

import json
import os
import shutil
import signal
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from random_scenario_draws import scenario
from random_scenario_reference import band_weights, finest_radiance, total_spectra
from random_scenario_rows import Row

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.core.errors import CertificateWarning, ProviderDefect
from hcss_twin.engine.certificate.certificate import DARK_W_M2_SR
from hcss_twin.engine.compile import tables_of
from hcss_twin.models.parameters import PhysicalParameters
from hcss_twin.models.radiance.physical.numerics import levels
from hcss_twin.plan.plan import Plan

PIXELS = {"as-printed": 300, "physical-two-stream": 300, "physical": 60}
"""Pixels computed again, by radiance model: fewer where a column takes long."""


def columns_of(cube: Any, layers: int) -> np.ndarray:
    """Thickness of each layer at each pixel, (frames, rows, columns, L)."""
    if layers == 0:
        return np.zeros((*cube.cloud_mask.shape, 0))
    return np.moveaxis(cube.cloud_layer_thickness.transpose("layer", "time", "y", "x").values, 0, -1)


def draw(plan: Plan, thickness: np.ndarray, wanted: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return frame, row and column of random pixels, (N, 3), by frame, and the thickness of their layers, (N, L)."""
    total = int(np.prod(thickness.shape[:3]))
    flat = np.random.default_rng([77, seed]).choice(total, min(wanted, total), replace=False)
    place = np.stack(np.unravel_index(flat, thickness.shape[:3]), axis=1)
    place = place[np.argsort(place[:, 0], kind="stable")]
    return place, _within_limits(plan, thickness[tuple(place.T)])


def draw_few(plan: Plan, thickness: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the same of a few pixels of one random frame, unlike each other.

    A clear one, the thinnest, median and thickest cloud, and of two layers the median of each alone and of both.
    """
    frame = int(np.random.default_rng([77, seed]).integers(thickness.shape[0]))
    columns = thickness[frame].reshape(-1, max(thickness.shape[3], 1)) if thickness.size else np.zeros((1, 1))
    total = np.sum(columns, axis=1)
    cloudy = columns > 0
    kinds = [np.any(cloudy, axis=1)]
    if cloudy.shape[1] > 1:
        kinds += [cloudy[:, 0] & ~cloudy[:, 1], cloudy[:, 1] & ~cloudy[:, 0], cloudy[:, 0] & cloudy[:, 1]]
    flat = list(np.flatnonzero(total == 0)[:1])
    for kind in kinds:
        ordered = np.flatnonzero(kind)
        ordered = ordered[np.argsort(total[ordered], kind="stable")]
        if ordered.size:
            flat += (
                [ordered[0], ordered[ordered.size // 2], ordered[-1]]
                if kind is kinds[0]
                else [ordered[ordered.size // 2]]
            )
    # Equal columns have equal radiance.
    _, first = np.unique(columns[flat], axis=0, return_index=True)
    row, column = np.unravel_index(np.array(flat)[first], thickness.shape[1:3])
    place = np.stack((np.full(row.size, frame), row, column), axis=1)
    return place, _within_limits(plan, thickness[tuple(place.T)])


def _within_limits(plan: Plan, thickness: np.ndarray) -> np.ndarray:
    metres = thickness.astype(np.float64)
    for own, layer in zip(metres.T, plan.layers, strict=True):
        # The cube is in single precision, which may lie beyond a limit that is not.
        cloudy = own > 0
        own[cloudy] = np.minimum(np.maximum(own[cloudy], layer.thickness_min_m), layer.thickness_max_m)
    return metres


def recompute(plan: Plan, place: np.ndarray, metres: np.ndarray, finer_grid: bool = False) -> np.ndarray:
    """Compute pixels from their own columns, at all wavenumbers of a grid, with a rule of our own: (N, B)."""
    refinement, model = plan.grid_refinement.refinement, plan.assembly.model
    if finer_grid:
        refinement = max(refinement + 1, 1)
    grid = plan.assembly.refined_grid(refinement)
    weights = band_weights(plan, grid, refinement > 0).T
    radiance = np.empty((len(place), len(plan.bands)))
    for frame in np.unique(place[:, 0]):
        here = np.flatnonzero(place[:, 0] == frame)
        # The real sun, also where its light is too faint for the accuracy to be computed with.
        setting = plan.assembly.setting(plan.sun_up_at(float(plan.frame_times_s[frame])))
        for start in range(0, here.size, 16):
            part = here[start : start + 16]
            radiance[part] = total_spectra(model, setting, grid.wavenumber_cm1, metres[part]) @ weights
    return radiance


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """End what takes more processor time with TimeoutError."""

    def end(*_: object) -> None:
        raise TimeoutError(f"more than {seconds:g} s of processor time")

    signal.signal(signal.SIGPROF, end)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


@dataclass(frozen=True)
class Run:
    """A scenario at one accuracy: plan, tables, cube, and the processor time of the tables and of all."""

    plan: Plan
    tables: Any
    cube: Any
    compile_s: float
    whole_s: float


def run(made: Scenario, planned_s: float = 0.0) -> Run:
    """Run a scenario without tables from before; its plan may have been made before, in some seconds."""
    forget("tables")
    start = time.process_time() - planned_s
    plan = make_plan(made)
    planned = time.process_time()
    tables = tables_of(plan)
    compiled = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CertificateWarning)  # its verdict is what is compared
        cube = simulate(made)
    return Run(plan, tables, cube, compiled - planned, time.process_time() - start)


def check(
    number: int,
    accuracies: Sequence[float],
    folder: Path,
    most_pixels: int = 300,
    model: str | None = None,
    finest: bool = False,
    limit_s: float = np.inf,
    finer_grid: bool = False,
) -> tuple[list[Row], dict[str, str]]:
    """Run a scenario at each accuracy, and compare its pixels with the independent ones.

    With ``finest``, the pixels are a few and computed at the finest level, on a grid twice as fine as that of any of
    the runs, and the cubes have no certificate. With ``finer_grid``, all pixels are computed on a finer grid than that
    of the first run, as in certificates.

    Returns
    -------
    rows, unfinished
        The latter says which accuracies, as ``number at accuracy``, took more than ``limit_s`` of processor time.
    """
    runs: dict[float, Run] = {}
    unfinished: dict[str, str] = {}
    start = time.process_time()
    scenarios = [scenario(number, accuracy, folder, model, 0 if finest else None) for accuracy in accuracies]
    planned_s = time.process_time() - start
    _warm(make_plan(scenarios[0]))
    for accuracy, made in zip(accuracies, scenarios, strict=True):
        try:
            with limited(limit_s) if limit_s < np.inf else nullcontext():
                # The draw has made the first plan.
                runs[accuracy] = run(made, 0.0 if runs else planned_s) if finest else run(made)
        except (TimeoutError, ProviderDefect) as error:  # guards of providers wrap the first
            if isinstance(error, ProviderDefect) and not isinstance(error.__cause__, TimeoutError):
                raise
            unfinished[f"{number} at {accuracy:g}"] = str(error)
            break
    if not runs:
        return [], unfinished
    first = next(iter(runs.values()))
    thickness = columns_of(first.cube, len(first.plan.layers))
    if finest:
        place, metres = draw_few(first.plan, thickness, number)
        refinement = 1 + max(max(each.plan.grid_refinement.refinement for each in runs.values()), 0)
        sun = first.plan.sun_up_at(float(first.plan.frame_times_s[place[0, 0]]))
        exact, uncertain = finest_radiance(first.plan, refinement, metres, sun)
    else:
        place, metres = draw(
            first.plan, thickness, min(PIXELS[first.plan.scenario.radiance.model], most_pixels), number
        )
        exact = recompute(make_plan(first.plan.scenario), place, metres, finer_grid)
        uncertain = np.zeros_like(exact)
    for each in runs.values():
        here = columns_of(each.cube, len(each.plan.layers))[tuple(place.T)]
        if not np.all(np.where(metres > 0, np.isclose(here, metres, rtol=1e-6), here == 0)):
            raise RuntimeError(f"scenario {number}: clouds depend on the accuracy")
    return [_row(number, each, place, exact, uncertain) for each in runs.values()], unfinished


def _row(number: int, run: Run, place: np.ndarray, exact: np.ndarray, uncertain: np.ndarray) -> Row:
    plan, tables, cube, made = run.plan, run.tables, run.cube, run.plan.scenario
    frame, row, column = place.T
    found = cube.radiance.transpose("time", "y", "x", "band").values[frame, row, column].astype(np.float64)
    if not (np.all(np.isfinite(found)) and np.all(np.isfinite(exact)) and np.all(exact > 0.0)):
        raise RuntimeError(f"scenario {number}: radiance that is not finite or not positive")
    # As the certificate says of such bands: no detector sees them, and their relative error means little.
    dark = np.max(exact, axis=0) < DARK_W_M2_SR
    away = np.where(dark, 0.0, np.abs(found - exact))
    step = np.spacing(exact.astype(np.float32)).astype(np.float64)
    error = away / exact
    attributes = cube.attrs
    achieved = json.loads(attributes["hcss_accuracy_achieved"]) if made.output.certificate else {}
    numerics = levels(PhysicalParameters())[plan.numerics.level]
    day = np.unique(plan.sun_zenith_deg < 90.0)
    return Row(
        scenario=number,
        accuracy=made.accuracy,
        model=made.radiance.model,
        layers=len(plan.layers),
        bands=len(plan.bands),
        day="both" if day.size == 2 else "day" if day[0] else "night",
        pixels=len(exact),
        achieved=float(f"{np.max(error):.3g}"),
        exceeding=int(np.sum(np.any(away > made.accuracy * exact + step, axis=1))),
        worst_band=plan.bands[int(np.argmax(np.max(error, axis=0)))].name,
        certificate=max(achieved.values()) if achieved else None,
        certificate_passed=str(attributes["hcss_certificate"]).startswith("computed as specified")
        if achieved
        else None,
        estimated=float(f"{tables.estimated_error:.3g}"),
        wavenumbers=int(tables.spectrum.nodes.wavenumber_cm1.size),
        dense=int(plan.spectral_grid.wavenumber_cm1.size),
        compile_cpu_s=float(f"{run.compile_s:.3g}"),
        level=plan.numerics.level,
        sun_streams=numerics.sun_streams if plan.sun_matters and made.radiance.model == "physical" else 0,
        refinement=plan.grid_refinement.refinement,
        enough=plan.numerics.enough,
        reference_error=float(f"{np.max(np.where(dark, 0.0, uncertain / exact)):.2g}"),
        run_cpu_s=float(f"{run.whole_s:.3g}"),
    )


def _warm(plan: Plan) -> None:
    """Have read and computed what is kept, so that the first accuracy does not pay for the others."""
    wavenumber = plan.spectral_grid.wavenumber_cm1
    sun = plan.sun_at(float(plan.frame_times_s[0]))
    other = make_plan(plan.scenario)
    coarse = other.assembly.at_level(0)
    coarse.clear(wavenumber, sun)
    if plan.assembly.has_cloud:
        coarse.cloudy(wavenumber, plan.assembly.extreme_thicknesses_m[:1], sun)


def forget(*kinds: str) -> None:
    """Remove what is kept from run to run."""
    for kind in kinds:
        shutil.rmtree(Path(os.environ["HCSS_CACHE_DIR"]) / kind, ignore_errors=True)
