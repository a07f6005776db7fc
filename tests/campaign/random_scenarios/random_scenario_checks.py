"""Run a random scenario, and compute pixels of its cube again with code that shares nothing with the certificate's."""

from __future__ import annotations

import json
import os
import shutil
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from random_scenario_draws import scenario
from random_scenario_rows import Row

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.core.errors import CertificateWarning
from hcss_twin.engine.compile import tables_of
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.plan.plan import Plan

PIXELS = {"as-printed": 300, "physical-two-stream": 300, "physical": 60}
"""Pixels computed again, by radiance model: fewer where a column takes long."""


@dataclass(frozen=True)
class Pixels:
    """Random pixels of the frames, and their band radiance without tables.

    ``place`` holds frame, row and column of each, (N, 3); ``radiance`` is (N, B).
    """

    place: np.ndarray
    thickness_m: np.ndarray
    radiance: np.ndarray


def columns_of(cube: Any, layers: int) -> np.ndarray:
    """Thickness of each layer at each pixel, (frames, rows, columns, L)."""
    if layers == 0:
        return np.zeros((*cube.cloud_mask.shape, 0))
    return np.moveaxis(cube.cloud_layer_thickness.transpose("layer", "time", "y", "x").values, 0, -1)


def recompute(plan: Plan, thickness: np.ndarray, wanted: int, seed: int, finest: bool) -> Pixels:
    """Draw pixels and compute each from its own column, at all wavenumbers, with a rule of our own.

    At the finest numerical level and with another wavenumber between any two, or at those of the plan.
    """
    assembly, grid = plan.assembly, plan.spectral_grid
    if finest:
        assembly = assembly.at_level(assembly.model.declares.numerical_levels - 1)
        grid = assembly.refined_grid(max(plan.grid_refinement.refinement + 1, 1))
    model = assembly.model
    random = np.random.default_rng([77, seed])
    total = int(np.prod(thickness.shape[:3]))
    first = 0
    if finest:  # one frame, because 64 streams are solved anew for each sun
        total //= thickness.shape[0]
        first = total * int(random.integers(thickness.shape[0]))
    flat = first + random.choice(total, min(wanted, total), replace=False)
    place = np.stack(np.unravel_index(flat, thickness.shape[:3]), axis=1)
    place = place[np.argsort(place[:, 0], kind="stable")]
    metres = thickness[tuple(place.T)].astype(np.float64)
    for own, layer in zip(metres.T, plan.layers, strict=True):
        # The cube is in single precision, which may lie beyond a limit that is not.
        cloudy = own > 0
        own[cloudy] = np.minimum(np.maximum(own[cloudy], layer.thickness_min_m), layer.thickness_max_m)
    radiance = np.empty((len(place), len(plan.bands)))
    for frame in np.unique(place[:, 0]):
        here = np.flatnonzero(place[:, 0] == frame)
        # The real sun, also where its light is too faint for the accuracy to be computed with.
        sun = plan.sun_up_at(float(plan.frame_times_s[frame]))
        clear = here[~np.any(metres[here] > 0, axis=1)]
        cloudy = np.setdiff1d(here, clear)
        if clear.size:
            radiance[clear] = _over_bands(plan, grid, model.clear(grid.wavenumber_cm1, sun))
        for start in range(0, cloudy.size, 16):
            part = cloudy[start : start + 16]
            terms = model.cloudy(grid.wavenumber_cm1, metres[part], sun)
            radiance[part] = _over_bands(plan, grid, terms)
    return Pixels(place, metres, radiance)


def _over_bands(plan: Plan, grid: SpectralGrid, terms: Any) -> np.ndarray:
    """Sum of the terms (..., V) times the response, by trapezoids between the grid's wavenumbers within each band.

    On a refined grid by parabolas: Richardson's extrapolation of the trapezoids with every and every second wavenumber.
    """
    wavenumber = grid.wavenumber_cm1
    spectrum = sum(np.asarray(term, dtype=np.float64) for term in terms.values())
    sums = []
    for band, own in zip(plan.bands, grid.nodes, strict=True):
        # Nodes of other bands lie between; from one of its own to the next the integrand is straight, as documented.
        x = wavenumber[own]
        if not np.allclose(1e4 / x[[-1, 0]], band.wavelength_um[[0, -1]], rtol=1e-12, atol=0.0):
            raise RuntimeError(f"{band.name}: the grid does not reach the edges of the band")
        y = spectrum[..., own] * np.interp(1e4 / x, band.wavelength_um, band.response)
        sum_ = _trapezoids(x, y)
        if grid.wavenumber_cm1.size != plan.spectral_grid.wavenumber_cm1.size or plan.grid_refinement.refinement > 0:
            sum_ = (4.0 * sum_ - _trapezoids(x[::2], y[..., ::2])) / 3.0
        sums.append(sum_)
    return np.stack(sums, axis=-1)


def _trapezoids(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.asarray(np.sum(0.5 * (y[..., 1:] + y[..., :-1]) * np.diff(x), axis=-1))


def check(
    number: int,
    accuracies: Sequence[float],
    folder: Path,
    most_pixels: int = 300,
    model: str | None = None,
    finest: bool = False,
) -> list[Row]:
    """Run a scenario at each accuracy, and compare its pixels with the independent ones."""
    rows, pixels = [], None
    for accuracy in accuracies:
        made = scenario(number, accuracy, folder, model)
        _forget_tables()
        plan = make_plan(made)
        if pixels is None:
            _warm(plan)
        start = time.process_time()
        tables = tables_of(plan)
        seconds = time.process_time() - start
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", CertificateWarning)  # its verdict is what is compared
            cube = simulate(made)
        thickness = columns_of(cube, len(plan.layers))
        if pixels is None:
            pixels = recompute(
                make_plan(made), thickness, min(PIXELS[made.radiance.model], most_pixels), number, finest
            )
        else:
            here = thickness[tuple(pixels.place.T)]
            same = np.where(pixels.thickness_m > 0, np.isclose(here, pixels.thickness_m, rtol=1e-6), here == 0)
            if not np.all(same):
                raise RuntimeError(f"scenario {number}: clouds depend on the accuracy")
        frame, row, column = pixels.place.T
        found = cube.radiance.transpose("time", "y", "x", "band").values[frame, row, column].astype(np.float64)
        rows.append(_row(number, made, plan, tables, cube, found, pixels, seconds))
    return rows


def _row(
    number: int, made: Scenario, plan: Plan, tables: Any, cube: Any, found: Any, pixels: Pixels, seconds: float
) -> Row:
    exact = pixels.radiance
    if not (np.all(np.isfinite(found)) and np.all(np.isfinite(exact)) and np.all(exact > 0.0)):
        raise RuntimeError(f"scenario {number}: radiance that is not finite or not positive")
    away = np.abs(found - exact)
    step = np.spacing(exact.astype(np.float32)).astype(np.float64)
    error = away / exact
    attributes = cube.attrs
    achieved = json.loads(attributes["hcss_accuracy_achieved"])
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
        certificate=max(achieved.values()),
        certificate_passed=str(attributes["hcss_certificate"]).startswith("PASSED"),
        estimated=float(f"{tables.estimated_error:.3g}"),
        wavenumbers=int(tables.spectrum.nodes.wavenumber_cm1.size),
        dense=int(plan.spectral_grid.wavenumber_cm1.size),
        compile_cpu_s=float(f"{seconds:.3g}"),
        level=plan.numerics.level,
    )


def _warm(plan: Plan) -> None:
    """Have read and computed what is kept, so that the first accuracy does not pay for the others."""
    wavenumber = plan.spectral_grid.wavenumber_cm1
    sun = plan.sun_at(float(plan.frame_times_s[0]))
    other = make_plan(plan.scenario)
    other.assembly.model.clear(wavenumber, sun)
    if plan.assembly.has_cloud:
        other.assembly.model.cloudy(wavenumber, plan.assembly.extreme_thicknesses_m[:1], sun)


def _forget_tables() -> None:
    shutil.rmtree(Path(os.environ["HCSS_CACHE_DIR"]) / "tables", ignore_errors=True)
