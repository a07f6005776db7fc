"""Peers of the whole pipeline and of its stages: pixel classes, cloud fields, and writing with xarray."""

from __future__ import annotations

import importlib
import os
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from cloud_contenders import contenders

from hcss_twin.cube.writer import CubeWriter
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.simulate import cube_header
from hcss_twin.engine.stream import Frame, stream
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.plan import Plan
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.reports.benchmark import every_nth, points_of_scene
from hcss_twin.reports.benchmark_reference import Reference, column_radiance
from hcss_twin.reports.benchmark_stages import Rounds, write_raw

CLASSES = (2, 8, 32, 128)
STEPS = (1, 4, 16)
CLOUDS = {
    "ours, thickness, 1 thread": "fractal clouds, thickness in m",
    "scipy FFT of noise": "scipy FFT of noise, frozen",
    "scipy map_coordinates": "scipy map_coordinates, same octaves",
    "FastNoiseLite ValueCubic 3-D": "FastNoiseLite, same octaves",
    "GSTools SRF, 1000 modes": "GSTools SRF, 1000 modes",
}


def has_lowtran() -> bool:
    """Whether the plugin is installed."""
    return any(entry.name == "lowtran7" for entry in Registry.discover().entries())


def pixel_classes(plan: Plan, reference: Reference) -> list[dict[str, float]]:
    """One column for each class of pixels of one layer, spaced by factors of thickness, in place of tables.

    Cost is that of the calls and of putting the classes' radiance into the frames; making clouds and writing come on
    top as in any other way.
    """
    low, high = plan.layers[0].thickness_min_m, plan.layers[0].thickness_max_m
    frames, whole = plan.frame_times_s.size, (slice(0, plan.grid.rows), slice(0, plan.grid.columns))
    thickness = plan.assembly.generators[0].thickness_m(0.0, *whole)
    found = []
    for count in CLASSES:
        edges = np.geomspace(low, high, count + 1)
        middle = np.concatenate(([0.0], np.sqrt(edges[:-1] * edges[1:])))
        inner = edges[1:-1]

        def classes(values: np.ndarray, inner: np.ndarray = inner) -> np.ndarray:
            return np.where(values > 0, 1 + np.searchsorted(inner, values, side="right"), 0)

        start = time.perf_counter()
        of_class = column_radiance(plan, plan.spectral_grid, middle[:, None])
        called = time.perf_counter() - start
        start = time.perf_counter()
        of_class.T.astype(np.float32)[:, classes(thickness)]
        placed = time.perf_counter() - start
        error = max(reference.errors(of_class[classes(reference.columns[:, 0])]).values())
        found.append({"classes": count, "seconds": called + frames * placed, "error": error})
    return found


def fewer_wavenumbers(plan: Plan, reference: Reference) -> list[dict[str, float]]:
    """Every pixel integrated by itself, at all wavenumbers of the gas and at fewer: seconds of all points, error."""
    found = []
    for step in STEPS:
        grid = every_nth(plan, step)
        error = max(reference.errors(column_radiance(plan, grid, reference.columns)).values())
        start = time.perf_counter()
        column_radiance(plan, grid, reference.columns, 1)
        seconds = (time.perf_counter() - start) / reference.columns.shape[0] * points_of_scene(plan)
        found.append({"wavenumbers": grid.wavenumber_cm1.size, "seconds": seconds, "error": error})
    return found


def cloud_fields(rounds: int) -> tuple[list[dict[str, Any]], list[str]]:
    """Nanoseconds per pixel and frame of each way to a cloud field, and what is not installed."""
    found, missing = contenders("stratus", 800, 8)
    chosen = [each for each in found if each.name in CLOUDS]
    times, pixels = Rounds(), {}
    for each in chosen:
        pixels[each.name] = each.run()
    for _ in range(rounds):
        for each in chosen:
            times.time(each.name, each.run)
    rows = [{"name": CLOUDS[each.name], "ns": times.shortest(each.name) / pixels[each.name] * 1e9} for each in chosen]
    return rows, missing


def writing(folder: Path, rounds: int) -> list[dict[str, Any]]:
    """Milliseconds of each way to write the baseline's radiance, which lies in memory."""
    from baseline_ratios import scenario

    plan = make_plan(scenario({"radiance.model": "as-printed"}))
    tables = tables_of(plan)
    frames = [{name: values.copy() for name, values in frame.items()} for frame in stream(plan, tables)]
    planes = np.concatenate([np.ravel(values).view(np.uint8) for values in frames[0].values()])
    ways: dict[str, Callable[[], object]] = {
        "raw bytes, preallocated": partial(write_raw, folder / "raw.bin", planes, len(frames)),
        "our cube": partial(_cube, folder / "cube.nc", plan, tables, frames),
        "xarray to_netcdf, netCDF4": partial(_xarray, folder / "x.nc", plan, frames, "netcdf4"),
    }
    try:
        importlib.import_module("h5netcdf")
        ways["xarray to_netcdf, h5netcdf"] = partial(_xarray, folder / "h.nc", plan, frames, "h5netcdf")
    except ImportError:
        print("missing: h5netcdf is not installed")
    times = Rounds()
    for call in ways.values():
        call()
    for _ in range(rounds):
        for name, call in ways.items():
            times.time(name, call)
    return [{"name": name, "ms": times.shortest(name) * 1e3} for name in ways]


def _cube(path: Path, plan: Plan, tables: Any, frames: list[Frame]) -> None:
    with CubeWriter(path, cube_header(plan, tables)) as writer:
        for index, frame in enumerate(frames):
            writer.write_frame(index, frame)


def _xarray(path: Path, plan: Plan, frames: list[Frame], engine: Any) -> None:
    """Write as the others do: on the disk when it returns."""
    path.unlink(missing_ok=True)
    variables = {spec.name: (spec.dims, np.stack([frame[spec.name] for frame in frames])) for spec in plan.variables}
    xr.Dataset(variables).to_netcdf(path, engine=engine)
    handle = os.open(path, os.O_RDWR)
    os.fsync(handle)
    os.close(handle)
