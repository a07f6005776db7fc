"""How a run's time goes with pixels, frames, bands and layers.

    python benchmarks/scaling.py                   # radiance model as-printed
    python benchmarks/scaling.py --model physical --write

Each table changes one thing of the baseline scene (``stratus``, 8 frames of 800 x 800 pixels, three bands). All but
"compile" have kept tables. Scenes of a table take turns, and what is told is over its first scene, the shortest times
of all rounds. "points" are pixels x frames x bands: a column below it gains with size. The last column is the whole
run over writing the same bytes raw.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from baseline_ratios import scenario
from hcss_bench.stages import CLOUDS, COMPILE, KEPT_RUN, LOOK_UP, PLAN, RAW, WRITE, Rounds, private_cache, time_stages

from hcss_twin.plan.make_plan import make_plan

STAGES = (PLAN, COMPILE, CLOUDS, LOOK_UP, WRITE, KEPT_RUN, RAW)

_LOW: dict[str, Any] = {"type": "stratus", "coverage": 0.5}
_HIGH: dict[str, Any] = {"type": "cirrus", "coverage": 0.5}

TABLES: dict[str, dict[str, dict[str, Any]]] = {
    "pixels": {f"{side} x {side}": {"image.rows": side, "image.columns": side} for side in (800, 200, 400, 1600)},
    "frames": {str(count): {"frames.count": count} for count in (8, 1, 64, 256)},
    "bands": {
        "3 broad": {},
        "1 broad": {"bands": ["lwir"]},
        "2 broad": {"bands": ["mwir", "lwir"]},
        "1 narrow": {"bands": ["lwir-10.8"]},
    },
    "layers": {"1": {}, "0 (clear)": {"clouds.coverage": 0.0}, "2": {"clouds": {"layers": [_LOW, _HIGH]}}},
}


def table(name: str, base: dict[str, Any], rounds: int, folder: Path) -> str:
    """Measure and return one table in Markdown; its first scene is the baseline."""
    scenes = {label: scenario(base | changes) for label, changes in TABLES[name].items()}
    times = Rounds()
    for number in range(rounds + 1):
        # The first round compiles kernels; its tables are not those of the second.
        with nullcontext() if number else private_cache(folder / "first"):
            for label, scene in scenes.items():
                time_stages(times if number else Rounds(), f"{label}, ", scene, folder, number < 2)
    first = next(iter(scenes))
    lines = [f"| {name} | points | " + " | ".join(STAGES) + " | run over raw |", "|---|" + "---|" * (len(STAGES) + 2)]
    sizes = {label: values(scene) for label, scene in scenes.items()}
    for label in scenes:
        ratios = [times.shortest_ratio(f"{label}, {stage}", f"{first}, {stage}") for stage in STAGES]
        over_raw = times.shortest_ratio(f"{label}, {KEPT_RUN}", f"{label}, {RAW}")
        cells = [sizes[label] / sizes[first], *ratios, over_raw]
        lines.append(f"| {label} | " + " | ".join(f"{cell:.3g}" for cell in cells) + " |")
    told = ", ".join(f"{stage} {times.shortest(f'{first}, {stage}'):.3g}" for stage in STAGES)
    return "\n".join([*lines, "", f"Seconds of {first}, for information: {told}."])


def values(scene: Any) -> int:
    """Numbers of radiance in its cube."""
    plan = make_plan(scene)
    return math.prod((plan.frame_times_s.size, len(plan.bands), plan.grid.rows, plan.grid.columns))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", default="as-printed")
    parser.add_argument("--tables", nargs="+", choices=list(TABLES), default=list(TABLES))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--folder", type=Path, default=Path("."), help="where cubes are written for a moment")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix=".hcss-scaling-", dir=given.folder) as name:
        folder = Path(name)
        with private_cache(folder / "cache"):
            for each in given.tables:
                found = table(each, {"radiance.model": given.model}, given.rounds, folder)
                print("\n" + found, flush=True)


if __name__ == "__main__":
    main()
