"""Predicted against measured processor time of random small scenes, cold and warm; and the constants behind them.

    python benchmarks/predicted_time.py [--scenes 20] [--first 0] [--rows FILE] [--fit]

Each scene is planned by ``hcss plan`` and run twice by ``hcss run``, each command a process of its own, in a cache of
its own that begins empty but for the stage times of the scenes before. ``cold``: the plan is in the cache, tables are
not; ``warm``: both are. A scene that compiles kernels is measured again. Times are of whole processes of ``hcss run``.
``--fit`` prints the constants of ``hcss_twin/engine/predicted_time.py`` by least squares over the rows of FILE, as JSON
lines. Scenes 400 to 412, 600 to 630, 700 to 711, 900 to 904 and 1000 to 1024 gave the present ones: judge them by
others.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin import Scenario, make_plan
from hcss_twin.engine.predicted_time import (
    CERTIFICATE_LAW,
    FILE,
    FLOOR_S,
    PLANNING_S,
    TABLES_LAW,
    points,
    reference_columns,
    work,
)

os.environ.setdefault("OMP_NUM_THREADS", "1")

WITHIN = 1.5
SCENARIOS = ("trade-cumulus", "cumulus", "stratus", "cirrus", "cirrus-over-cumulus", "degraded-cirrus", "simulated")
BANDS = ("swir-2.7-3.0", "mwir", "lwir", "mwir-3.7", "mwir-4.5-4.8", "lwir-8.5", "lwir-10.8", "lwir-12.0")


def scene(number: int) -> tuple[str, dict[str, Any]]:
    """Draw a scene: name of a scenario, and its changes."""
    random = np.random.default_rng([49, number])
    name = str(random.choice(SCENARIOS))
    side = int(random.choice([64, 128, 256, 400]))
    changes: dict[str, Any] = {
        "time": f"2023-{random.integers(1, 13):02d}-{random.integers(1, 28):02d}T{random.integers(0, 24):02d}:00:00Z",
        "view.zenith": float(np.round(random.uniform(0, 60))),
        "image.rows": side,
        "image.columns": side,
        "image.pixel_size": float(random.choice([20, 50, 100, 300])),
        "frames.count": int(random.choice([1, 2, 4, 8])),
        "frames.interval": float(random.choice([1, 10, 600])),
        "bands": [str(band) for band in random.choice(BANDS, size=int(random.integers(1, 4)), replace=False)],
        "accuracy": float(random.choice([1e-3, 1e-3, 1e-2])),
    }
    if name == "trade-cumulus":
        changes["place.latitude"] = float(np.round(random.uniform(-55, 55), 1))
    if name != "cirrus-over-cumulus" and random.random() < 0.2:
        changes["image.samples_per_pixel"] = 2
    if random.random() < 0.25:
        changes["platform.altitude"] = 500e3
    if random.random() < 0.2:
        changes["output.certificate"] = 0
    return name, changes


def hcss(*words: str) -> tuple[float, dict[str, Any], str]:
    """Return processor time, answer in JSON and messages of a command; raises CalledProcessError."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "hcss_twin", *words, "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    taken = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return taken, json.loads(done.stdout), done.stderr


def measured(name: str, changes: dict[str, Any], folder: Path) -> list[dict[str, Any]]:
    """Plan and run a scene twice; return both rows, or none if it is refused."""
    os.environ["HCSS_CACHE_DIR"] = str(folder)
    options = [word for key, value in changes.items() for word in ("--set", f"{key}={json.dumps(value)}")]
    rows = []
    try:
        for kind in ("cold", "warm"):
            plan_s, planned, _ = hcss("plan", name, *options)
            taken, done, messages = hcss("run", name, *options, "-o", str(folder / "cube.nc"), "--force")
            plan = make_plan(Scenario.load(name, changes))
            rows.append({
                "kind": kind, "scenario": name, "process_s": taken, "plan_s": plan_s,
                "compiled": "compiling" in messages, "stages": done["processor_s"],
                "predicted": planned["predicted"]["processor_s"], "work": work(plan),
                "certificate": reference_columns(plan), "points": points(plan),
            })  # fmt: skip
    except subprocess.CalledProcessError as error:
        print(f"{name}: {str(error.stderr).strip().splitlines()[-1][:160]}", file=sys.stderr)
        return []
    return rows


def compare(rows: Sequence[dict[str, Any]]) -> None:
    """Print predicted and measured times, and how many are within the factor."""
    for kind in ("cold", "warm"):
        ratios = []
        for row in rows:
            if row["kind"] == kind and not row["compiled"]:
                predicted, taken = row["predicted"]["total"], row["process_s"]
                ratios.append(predicted / taken)
                times = f"{predicted:6.1f} s predicted {taken:6.1f} s measured"
                print(f"{kind}  {row['scenario']:<20}{times}  x {ratios[-1]:.2f}")
        if ratios:
            good = sum(1 / WITHIN <= ratio <= WITHIN for ratio in ratios)
            print(
                f"{kind}: {good} of {len(ratios)} within a factor of {WITHIN}, median {statistics.median(ratios):.2f}"
            )


def fit(rows: Sequence[dict[str, Any]], weight: float = 2.0) -> None:
    """Print the law of each stage, by least squares of logarithms with a ``weight`` on changes of the present law.

    Times are relative to start and planning of the same run, which other work of the machine slows as well; with
    clouds of another package, whose start takes longer, to those of the reference machine.
    """

    def speed(row: dict[str, Any]) -> float:
        return 1.0 if row["scenario"] == "trade-cumulus" else PLANNING_S / row["stages"]["planning"]

    cold = [row for row in rows if row["kind"] == "cold" and not row["compiled"]]
    for stage, known in (("tables", TABLES_LAW), ("certificate", CERTIFICATE_LAW)):
        used = [row for row in cold if row["stages"].get(stage)]
        names = list(known)
        matrix = np.array([[{"constant": 1.0, **row["work"]}[name] for name in names] for row in used])
        of_24 = [max(row["certificate"] / 24.0, 0.5) if stage == "certificate" else 1.0 for row in used]
        taken = np.array([
            row["stages"][stage] / pixels * speed(row)
            for row, pixels in zip(used, of_24, strict=True)
        ])  # fmt: skip
        values = np.log(np.maximum(taken - FLOOR_S[stage], 0.15))
        before = np.array([known[name] for name in names])
        penalty = weight * np.diag([float(name != "constant") for name in names])
        change, *_ = np.linalg.lstsq(
            np.vstack((matrix, penalty)), np.concatenate((values - matrix @ before, np.zeros(len(names)))), rcond=None
        )
        for title, law in (("before", before), ("after", before + change)):
            left = np.exp(np.abs(np.log((FLOOR_S[stage] + np.exp(matrix @ law)) / taken)))
            print(f"{stage}, {title}: {len(used)} scenes, within {WITHIN}: {np.sum(left <= WITHIN)}, "
                  f"largest factor {left.max():.2f}")  # fmt: skip
        print({name: round(float(value), 2) for name, value in zip(names, before + change, strict=True)})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--rows", type=Path, help="JSON lines: written, or with --fit read")
    parser.add_argument("--fit", action="store_true")
    given = parser.parse_args()
    if given.fit:
        fit([json.loads(line) for line in given.rows.read_text().splitlines()])
        return
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory(prefix="hcss-predicted-") as parent:
        times = Path(parent) / FILE
        for number in range(given.first, given.first + given.scenes):
            for _ in range(2):  # again if kernels were compiled, once on a machine
                folder = Path(parent) / str(number)
                folder.mkdir(mode=0o700)
                if times.exists():
                    shutil.copy2(times, folder)
                found = measured(*scene(number), folder)
                if (folder / times.name).exists():
                    shutil.copy2(folder / times.name, times)
                shutil.rmtree(folder)
                if not any(row["compiled"] for row in found):
                    break
            rows += found
            if given.rows:
                with given.rows.open("a") as file:
                    file.writelines(json.dumps({"number": number, **row}) + "\n" for row in found)
    compare(rows)


if __name__ == "__main__":
    main()
