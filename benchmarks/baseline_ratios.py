"""What the baseline measures: ratios of things that take turns in one run, and the aims they stand beside."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from hcss_bench.benchmark import even_wavelengths, random_columns
from hcss_bench.reference import column_radiance
from hcss_bench.stages import Rounds, write_raw
from regression import Ratio

from hcss_twin import Scenario, make_plan
from hcss_twin.engine.compile import compile_tables, tables_of
from hcss_twin.engine.simulate import run
from hcss_twin.engine.stream import stream
from hcss_twin.engine.tables.look_up import LookUp
from hcss_twin.plan.plan import Plan

SCENE = "stratus"
COLUMNS = {"output.certificate": 0, "slant.shadows": "off", "slant.parallax": "off", "sea.waves": "off"}
"""What a loop over the pixels computes, too."""
POINTS = 24
IMPORTS = "import numpy, xarray"
NIGHT = "2024-04-20T00:30:00+10:00"
MANY_FRAMES, MAX_FRAMES = 512, 2000

Measured = Iterator[tuple[Ratio, str]]


def scenario(changes: Mapping[str, Any] | None = None) -> Scenario:
    """Return the baseline scene with changes, without certificate unless they ask for it."""
    return Scenario.load(SCENE, COLUMNS | (changes or {}))


def look_up(rounds: int, folder: Path) -> Measured:
    """(a) A pixel by look-up against the integration of its spectrum."""
    for model, together in (("physical", 1), ("as-printed", POINTS)):
        plan = make_plan(scenario({"radiance.model": model}))
        whole = slice(0, plan.grid.rows), slice(0, plan.grid.columns)
        thickness = [generator.thickness_m(0.0, *whole) for generator in plan.assembly.generators]
        dense = LookUp(tables_of(plan).at(0.0))
        radiance = np.empty((len(plan.bands), plan.grid.rows, plan.grid.columns), dtype=np.float32)
        columns = random_columns(plan, POINTS)
        grids = {"native grid": plan.spectral_grid, "1000 wavelengths a band": even_wavelengths(plan, 1000)}
        calls: dict[str, Callable[[], object]] = {"look-up": partial(dense.fill, radiance, thickness)}
        calls |= {name: partial(column_radiance, plan, grid, columns, together) for name, grid in grids.items()}
        times = in_turn(calls, rounds)
        points = plan.grid.rows * plan.grid.columns
        look = times.shortest("look-up") / points / len(plan.bands) * 1e9
        for (name, grid), aim in zip(grids.items(), (1500.0, 1e4), strict=True):
            brute = times.shortest(name) / POINTS / len(plan.bands) * 1e6
            way = "one pixel at a time" if together == 1 else f"{together} pixels at a time"
            yield (
                Ratio(
                    f"a: look-up, {model}, {name}",
                    times.shortest_ratio(name, "look-up") * points / POINTS,
                    "higher",
                    aim,
                    f"spectrum at {grid.wavenumber_cm1.size} wavenumbers, {way}, over look-up of a pixel",
                ),
                f"{look:.2f} ns against {brute:.0f} us a pixel and band",
            )


def whole_run(rounds: int, folder: Path) -> Measured:
    """(b) Plan, frames and writing, tables kept, against writing the same bytes raw."""
    for frames, certificate, aim, turns in (
        (8, 0, 6.0, rounds),
        (8, 24, 6.0, rounds),
        (MANY_FRAMES, 0, 5.0, min(rounds, 2)),
    ):
        plan = make_plan(scenario({"frames.count": frames, "output.certificate": certificate}))
        plane = last_frame(plan)
        calls = {
            "run": lambda plan=plan: run(make_plan(plan.scenario), folder / "cube.nc"),
            "raw": lambda plane=plane, frames=frames: write_raw(folder / "raw.bin", plane, frames),
        }
        times = in_turn(calls, turns)
        yield (
            Ratio(
                f"b: whole run, {frames} frames" + (", with certificate" if certificate else ""),
                times.shortest_ratio("run", "raw"),
                "lower",
                aim,
                "plan, frames and writing over writing the same bytes raw",
            ),
            f"{times.shortest('run'):.2f} s against {times.shortest('raw'):.3f} s",
        )


def compiling(rounds: int, folder: Path) -> Measured:
    """(c) Compiling a scene, and taking its tables from the cache, against starting Python with numpy and xarray."""
    tables_of(make_plan(scenario()))
    plans = {name: [make_plan(scenario()) for _ in range(rounds + 1)] for name in ("new", "kept")}
    calls = {
        "new": lambda: compile_tables(plans["new"].pop()),
        "kept": lambda: tables_of(plans["kept"].pop()),
        "import": lambda: python(IMPORTS),
    }
    times = in_turn(calls, rounds)
    for name, words, aim_s in (("new", "compiling the scene", 0.5), ("kept", "tables from the cache", 0.03)):
        yield (
            Ratio(
                f"c: {words}",
                times.shortest_ratio(name, "import"),
                "lower",
                aim_s / times.shortest("import"),
                f"over python -c '{IMPORTS}'; aim {aim_s:g} s",
            ),
            f"{times.shortest(name):.3f} s against {times.shortest('import'):.2f} s",
        )


def process(rounds: int, folder: Path) -> Measured:
    """(d) What ``hcss run`` takes beyond the run in a process that is warm."""
    cube = folder / "cube.nc"
    command = ["-m", "hcss_twin", "run", SCENE, "--set", "output.certificate=0", "-o", str(cube), "--force"]
    calls = {
        "hcss run": lambda: subprocess.run([sys.executable, *command], check=True, capture_output=True),
        "scene": lambda: run(make_plan(scenario()), cube),
        "import": lambda: python(IMPORTS),
    }
    times = in_turn(calls, rounds)
    beyond = times.shortest_ratio("hcss run", "import") - times.shortest_ratio("scene", "import")
    yield (
        Ratio(
            "d: hcss run beyond the scene",
            beyond,
            "lower",
            2.0 / times.shortest("import"),
            f"process minus the same run in a warm process, over python -c '{IMPORTS}'; aim 2 s",
        ),
        f"{times.shortest('hcss run') - times.shortest('scene'):.2f} s against {times.shortest('import'):.2f} s",
    )


def memory(rounds: int, folder: Path) -> Measured:
    """(e) Peak memory for many frames against few: with tables that both compile, and with kept ones."""
    peaks = {(frames, kept): peak_mb(frames, folder, kept) for frames in (8, MAX_FRAMES) for kept in (False, True)}
    for kept in (False, True):
        few, many = peaks[8, kept], peaks[MAX_FRAMES, kept]
        yield (
            Ratio(
                f"e: memory, {MAX_FRAMES} frames, {'kept' if kept else 'new'} tables",
                many / few,
                "lower",
                (few + 100.0) / few,
                "peak memory over that of 8 frames; aim 100 MB more",
            ),
            f"{many:.0f} MB against {few:.0f} MB",
        )


def lighter_scenes(rounds: int, folder: Path) -> Measured:
    """(f) Night and clear skies against the day's three bands."""
    day, night = scenario(), scenario({"time": NIGHT, "bands": ["lwir"]})
    clear = scenario({"clouds.coverage": 0.0})

    calls = {"day": lambda: compute(day), "clear": lambda: compute(clear), "night": lambda: compute(night)}
    times = in_turn(calls, rounds)
    for name, words, aim in (("night", "a night's LWIR", 0.5), ("clear", "a clear scene", 0.1)):
        yield (
            Ratio(
                f"f: {words}",
                times.shortest_ratio(name, "day"),
                "lower",
                aim,
                "plan, compiling and frames, without writing, over the same for three bands by day",
            ),
            f"{times.shortest(name):.2f} s against {times.shortest('day'):.2f} s",
        )


PARTS: dict[str, Callable[[int, Path], Measured]] = {
    "a": look_up,
    "b": whole_run,
    "c": compiling,
    "d": process,
    "e": memory,
    "f": lighter_scenes,
}


def in_turn(calls: dict[str, Callable[[], object]], rounds: int) -> Rounds:
    """Time calls in turn, once more than is counted."""
    times = Rounds()
    for call in calls.values():
        call()
    for _ in range(rounds):
        for name, call in calls.items():
            times.time(name, call)
    return times


def compute(scene: Scenario) -> None:
    """Do all but write, with nothing kept from earlier runs."""
    plan = make_plan(scene, keeps_results=False)
    for _ in stream(plan, compile_tables(plan)):
        pass


def last_frame(plan: Plan) -> np.ndarray:
    """Return the bytes of one frame, those that raw writing writes."""
    frames = stream(plan, tables_of(plan), frames=[0])
    return np.concatenate([np.ravel(each).view(np.uint8) for frame in frames for each in frame.values()])


def python(code: str) -> None:
    subprocess.run([sys.executable, "-c", code], check=True)


def peak_mb(frames: int, folder: Path, kept: bool) -> float:
    """Peak memory of a process that runs the scene with so many frames.

    It compiles its tables, or finds those that an earlier one has ``kept``.
    """
    code = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from hcss_twin import Scenario, make_plan\n"
        "from regression import peak_memory_mb\n"
        "from hcss_twin.engine.simulate import run\n"
        f"changes = {COLUMNS!r} | {{'frames.count': int(sys.argv[1])}}\n"
        f"run(make_plan(Scenario.load({SCENE!r}, changes)), sys.argv[2])\n"
        "print(peak_memory_mb())\n"
    )
    cube = folder / "long.nc"
    arguments = [sys.executable, "-c", code, str(frames), str(cube)]
    if not kept:
        for kind in ("tables", "plans", "references"):
            shutil.rmtree(Path(os.environ["HCSS_CACHE_DIR"]) / kind, ignore_errors=True)
    done = subprocess.run(arguments, check=True, capture_output=True, text=True)
    cube.unlink()
    return float(done.stdout)
