"""A sweep of 200 points: its own cost, two workers against one, and what kills do to it.

    python benchmarks/sweep.py [--points 200] [--rounds 3] [--write]

"overhead": the sweep against a loop that calls ``simulate`` for the same scenarios, and what is not the computing of
points, in one process and turn by turn. "kills": on two worker processes one is killed in the middle, then all of the
sweep, which is run again; its cubes are compared with those of the serial run. "speed": points in a second of
a sweep on two workers and of one on one, which run side by side, because others on the machine take their share of
each process alike.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import psutil

from hcss_twin import Scenario, simulate, sweep
from hcss_twin.core.cache import private_cache

HCSS = [sys.executable, "-m", "hcss_twin"]
MODELS: dict[str, Any] = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie"}
TINY = MODELS | {"image.rows": 16, "image.columns": 16, "frames.count": 1}
MANY = 200
"""More points than are finished in the time."""
LARGER = MODELS | {"image.rows": 400, "image.columns": 400, "frames.count": 16}


def over(points: int) -> dict[str, Any]:
    """Return two view angles, two coverages, and the rest seeds."""
    return {"view.zenith": [0, 30], "clouds.coverage": [0.3, 0.7], "seed": {"count": points // 4}}


def overhead(points: int, rounds: int, folder: Path) -> str:
    """Time the sweep against a loop over the same scenarios."""
    found: dict[str, list[tuple[float, float]]] = {"loop": [], "sweep": [], "own": []}
    for number in range(rounds + 1):  # the first compiles and keeps tables
        loop = folder / f"loop-{number}"
        loop.mkdir()
        started = clock()
        for point, values in enumerate(combinations(points)):
            simulate(Scenario.load("stratus", TINY | values), loop / f"{point}.nc").close()
        taken = since(started)
        started = clock()
        result = sweep("stratus", folder / f"sweep-{number}", over=over(points), overrides=TINY)
        whole = since(started)
        if number:
            computing = sum(record.seconds or 0.0 for record in result.points)
            found["loop"].append(taken)
            found["sweep"].append(whole)
            found["own"].append((whole[0] - computing, 0.0))
    ms = {
        name: [1e3 * statistics.median(each) / points for each in zip(*times, strict=True)]
        for name, times in found.items()
    }
    (loop, loop_cpu), (swept, swept_cpu) = ms["loop"], ms["sweep"]
    return "\n".join(
        [
            f"| {points} points of 16 x 16 pixels, median of {rounds} rounds | ms per point | processor, ms a point |",
            "|---|---|---|",
            f"| `simulate` in a loop | {loop:.0f} | {loop_cpu:.0f} |",
            f"| `hcss_twin.sweep`, one worker | {swept:.0f} | {swept_cpu:.0f} |",
            f"| the same less the loop | {swept - loop:+.1f} | {swept_cpu - loop_cpu:+.1f} |",
            f"| of it not the computing of points | {ms['own'][0]:.1f} | |",
        ]
    )


def combinations(points: int) -> Iterator[dict[str, Any]]:
    """Yield the values of each point, in the order of the sweep."""
    for zenith in (0, 30):
        for coverage in (0.3, 0.7):
            for seed in range(points // 4):
                yield {"view.zenith": zenith, "clouds.coverage": coverage, "seed": seed}


def clock() -> tuple[float, float]:
    return time.perf_counter(), time.process_time()


def since(start: tuple[float, float]) -> tuple[float, float]:
    now = clock()
    return now[0] - start[0], now[1] - start[1]


def command(folder: Path, points: int, scene: dict[str, Any], *more: str) -> list[str]:
    settings = [word for key, value in scene.items() for word in ("--set", f"{key}={json.dumps(value)}")]
    swept = [word for key, value in over(points).items() for word in ("--over", f"{key} = {as_toml(value)}")]
    return [*HCSS, "sweep", "stratus", *settings, *swept, "-o", str(folder), *more]


def as_toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {each}" for key, each in value.items()) + "}"
    return json.dumps(value)


def logged(folder: Path) -> list[str]:
    log = folder / "points.jsonl"
    return [line for line in log.read_text().splitlines(keepends=True) if line.endswith("\n")] if log.exists() else []


def kills(points: int, folder: Path) -> str:
    """Kill a worker, then everything; run again; compare with the serial run."""
    os.environ["SOURCE_DATE_EPOCH"] = "1700000000"
    serial, cluster = folder / "serial", folder / "cluster"
    subprocess.run(command(serial, points, TINY), check=True, stdout=subprocess.DEVNULL)
    process = subprocess.Popen(command(cluster, points, TINY, "--workers", "2"), stderr=subprocess.DEVNULL)
    waited(cluster, points // 4, process)
    workers = psutil.Process(process.pid).children()
    workers[0].kill()
    waited(cluster, points // 2, process)
    process.kill()
    process.wait()
    psutil.wait_procs(workers, timeout=60)
    finished = {path.name: path.stat().st_ino for path in cluster.glob("point-*.nc")}
    done = subprocess.run(
        command(cluster, points, TINY, "--workers", "2", "--json"), check=True, capture_output=True, text=True
    )
    answer = json.loads(done.stdout)
    counts = Counter(json.loads(line)["point"] for line in logged(cluster))
    cubes = sorted(serial.glob("point-*.nc"))
    same = sum((cluster / path.name).read_bytes() == path.read_bytes() for path in cubes)
    kept = sum((cluster / name).stat().st_ino == node for name, node in finished.items())
    return "\n".join(
        [
            f"| {points} points on two worker processes | |",
            "|---|---|",
            f"| one worker killed after | {points // 4} points |",
            f"| all killed after | {len(finished)} cubes |",
            f"| of these still the same files in the end | {kept} |",
            f"| computed by the second run | {len(answer['computed'])} |",
            f"| points in the log: none, once, more often | {points - len(counts)}, "
            f"{sum(each == 1 for each in counts.values())}, {sum(each > 1 for each in counts.values())} |",
            f"| cubes with the bytes of the serial run | {same} of {len(cubes)} |",
        ]
    )


def waited(folder: Path, count: int, process: subprocess.Popen[Any]) -> None:
    while len(logged(folder)) < count:
        if process.poll() is not None:
            raise RuntimeError(f"the sweep ended with {process.returncode} after {len(logged(folder))} points")
        time.sleep(0.01)


def speed(seconds: float, rounds: int, folder: Path) -> str:
    """Let a sweep on two workers and one on one run side by side: the same others disturb both."""
    subprocess.run(command(folder / "speed", 4, LARGER), check=True, stdout=subprocess.DEVNULL)  # tables
    rates: dict[int, list[float]] = {1: [], 2: []}
    for number in range(rounds):
        folders = {workers: folder / f"speed-{number}-{workers}" for workers in rates}
        with ExitStack() as stack:
            sweeps = {
                workers: stack.enter_context(ended(command(each, MANY, LARGER, "--workers", str(workers))))
                for workers, each in folders.items()
            }
            for workers, each in folders.items():
                waited(each, 4, sweeps[workers])
            before = {workers: len(logged(each)) for workers, each in folders.items()}
            time.sleep(seconds)
            for workers, each in folders.items():
                rates[workers].append((len(logged(each)) - before[workers]) / seconds)
    ratios = [two / one for one, two in zip(rates[1], rates[2], strict=True)]
    one, two = (statistics.median(rates[workers]) for workers in (1, 2))
    return "\n".join(
        [
            f"| points of 400 x 400 x 16 in {seconds:g} s, median of {rounds} rounds | one worker | two | ratio |",
            "|---|---|---|---|",
            f"| points in a second, once they run | {one:.2f} | {two:.2f} | "
            f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f}) |",
            "",
            f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.0f} at the end (these and others).",
        ]
    )


@contextmanager
def ended(arguments: list[str]) -> Iterator[subprocess.Popen[Any]]:
    """Run a sweep and interrupt it at the end of the block."""
    process = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        process.wait()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=200, help="a multiple of 4")
    parser.add_argument("--seconds", type=float, default=40.0, help="that the sweeps are compared")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument(
        "--parts", nargs="+", choices=["overhead", "kills", "speed"], default=["overhead", "kills", "speed"]
    )
    parser.add_argument("--folder", type=Path, default=None, help="where cubes are written for a moment")
    given = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    with tempfile.TemporaryDirectory(prefix="hcss-sweep-", dir=given.folder) as name:
        folder = Path(name)
        with private_cache(folder / "cache"):
            for part in given.parts:
                text = {
                    "overhead": lambda: overhead(given.points, given.rounds, folder),
                    "kills": lambda: kills(given.points, folder),
                    "speed": lambda: speed(given.seconds, given.rounds, folder),
                }[part]()
                print(f"\n{text}", flush=True)


if __name__ == "__main__":
    main()
