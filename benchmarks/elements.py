"""What elements cost: milliseconds for each source and frame, and the time of a scene that has none.

    python benchmarks/elements.py [--rounds 5] [--sources 1 10]
    python benchmarks/elements.py --against ../before     # and a scene without elements, against another checkout

The scene is ``stratus`` with 8 frames of 200 x 200 pixels, seen along one line of sight or, 200 km wide, along one for
each pixel. Frames with and without sources take turns; the least processor time of each counts, as others may use the
machine. The other checkout, for example of a commit before elements, runs the same scene in processes of its own, which
take turns with those of this one; both print the processor time of whole runs with tables kept.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin import Scenario, make_plan
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import stream
from hcss_twin.plan.plan import Plan

HERE = Path(__file__).parents[1]
SMALL = {"image.rows": 200, "image.columns": 200, "output.certificate": 0, "radiance.model": "as-printed"}
WIDE = {"image.pixel_size": 1000.0, "platform.altitude": "800 km"}

PLAIN = """
import sys, time
from hcss_twin import Scenario, make_plan
from hcss_twin.engine.simulate import run
plan = make_plan(Scenario.load("stratus", {"output.certificate": 0}))
run(plan, sys.argv[1])
times = []
for _ in range(int(sys.argv[2])):
    start = time.process_time()
    run(make_plan(Scenario.load("stratus", {"output.certificate": 0})), sys.argv[1])
    times.append(time.process_time() - start)
print(min(times))
"""


def planned(sources: int, changes: Mapping[str, Any]) -> Plan:
    """Return the plan of the scene with sources at random places, each over four to nine pixels."""
    plan = make_plan(Scenario.load("stratus", {**SMALL, **changes}))
    if not sources:
        return plan
    random, pixel = np.random.default_rng(1), plan.grid.pixel_size_m
    places = random.uniform(-90.0 * pixel, 90.0 * pixel, (sources, 2)).tolist()
    tracks = [
        {"x": x, "y": y, "altitude": 500.0 * (n % 4), "velocity": [1e3, 0, 0], "intensity": 1e3}
        for n, (x, y) in enumerate(places)
    ]
    section = {"parameters": {"tracks": tracks, "footprint": 2.0 * pixel}}
    return make_plan(Scenario.load("stratus", {**SMALL, **changes, "elements": [section]}))


def seconds(plan: Plan) -> float:
    """Return the processor time of all frames."""
    tables = tables_of(plan)
    start = time.process_time()
    for _ in stream(plan, tables):
        pass
    return time.process_time() - start


def cost_of_sources(counts: list[int], rounds: int) -> None:
    """Print milliseconds for each source and frame."""
    for name, changes in {"one view": {}, "a view for each pixel": WIDE}.items():
        plans = {count: planned(count, changes) for count in (0, *counts)}
        shortest = dict.fromkeys(plans, np.inf)
        for _ in range(rounds):
            for count, plan in plans.items():
                shortest[count] = min(shortest[count], seconds(plan))
        for count in counts:
            frames = plans[count].frame_times_s.size
            each = (shortest[count] - shortest[0]) / count / frames * 1e3
            print(f"{name}: {count} sources, {each:.2f} ms for each and frame; {frames} frames {shortest[count]:.2f} s")


def cost_of_none(other: Path, rounds: int) -> None:
    """Print the time of a scene without elements here over that of another checkout."""
    times: dict[Path, list[float]] = {HERE: [], other: []}
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(rounds):
            for checkout in (HERE, other) if turn % 2 else (other, HERE):
                cache = Path(folder) / f"cache-{checkout == HERE}"
                environment = {**os.environ, "PYTHONPATH": str(checkout), "HCSS_CACHE_DIR": str(cache)}
                command = [sys.executable, "-c", PLAIN, f"{folder}/cube.nc", "4"]
                done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, check=True)
                times[checkout].append(float(done.stdout))
    here, there = (min(times[each]) for each in (HERE, other))
    medians = [float(np.median(times[each])) for each in (HERE, other)]
    print(f"without elements: {here:.3f} s here, {there:.3f} s there, ratio {here / there:.3f}", end=" ")
    print(f"(of medians {medians[0] / medians[1]:.3f})")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--sources", type=int, nargs="+", default=[1, 10])
    parser.add_argument("--against", type=Path)
    given = parser.parse_args()
    if given.against:
        cost_of_none(given.against.resolve(), given.rounds)
    cost_of_sources(given.sources, given.rounds)


if __name__ == "__main__":
    main()
