"""The page "Fast and accurate": run time against error, stability, and what skipping saves, with one figure.

    python benchmarks/fast_and_accurate.py --write   # times six scenes (minutes); rewrites numbers and figure
    python benchmarks/fast_and_accurate.py           # prints the numbers of what was timed last

Run time and error are those of ``pareto.py``, stability those of the campaigns in ``campaigns``: this script
counts the lines of their tables and measures only what skipping saves.
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from hcss_bench.stages import private_cache
from page import put
from pareto import RESULTS, processor_seconds
from pareto_tables import COLOURS, MARKERS, PEERS

from hcss_twin import Scenario
from hcss_twin.engine.simulate import run
from hcss_twin.plan.make_plan import make_plan

ROOT = Path(__file__).parents[1]
PAGE, PICTURE = ROOT / "docs" / "fast-and-accurate.md", ROOT / "docs" / "images" / "fast-and-accurate.png"
SKIPPING, CAMPAIGNS = Path(__file__).with_name("skipping.json"), ROOT / "campaigns"
ROUNDS = 3

FLAT = {"slant.shadows": "off", "slant.parallax": "off"}
NIGHT = {"time": "2024-04-20T00:30:00+10:00"}
SCENES: dict[str, tuple[str, dict[str, Any], dict[str, Any]]] = {
    "sunlight, by night": ("stratus", NIGHT, {}),
    "two of three bands": ("stratus", {"bands": ["lwir"]}, {}),
    "clouds, under clear sky": ("cumulus", {"clouds.coverage": 0.0}, {}),
    "radiance, for truth layers alone": ("cumulus", {"output.variables": ["cloud_mask", "cloud_thickness"]}, {}),
    "shadows and parallax": ("cumulus", FLAT, {"slant.shadows": "on", "slant.parallax": "on"}),
    "waves as shapes, in pixels of 20 m": ("stratus", {"sea.waves": "off"}, {"sea.waves": "on", "frames.count": 2}),
}
"""What a scene does not need: shipped scenario, the scene without it, and the same with it."""
SIZE = {"image.rows": 400, "image.columns": 400, "frames.count": 4, "output.certificate": 0}


def measure_skipping() -> dict[str, list[float]]:
    """Return the least processor time of whole runs with an empty cache, s: with what is not needed, and without."""
    found = {}
    for what, (name, without, with_it) in SCENES.items():
        seconds = []
        for changes in (with_it, without):
            frames = {"frames.count": with_it.get("frames.count", SIZE["frames.count"])}
            scene = Scenario.load(name, SIZE | frames | changes)
            seconds.append(min(_seconds(scene) for _ in range(ROUNDS)))
        found[what] = seconds
        print(f"{what}: {seconds[0]:.2f} s, {seconds[1]:.2f} s without", flush=True)
    return found


def _seconds(scene: Scenario) -> float:
    with tempfile.TemporaryDirectory() as folder, private_cache(Path(folder) / "cache"):
        before = processor_seconds()
        run(make_plan(scene), Path(folder) / "cube.nc")
        return processor_seconds() - before


TRIED = {
    "random scenes, tables against columns": ("random_scenarios/table.csv", "accuracy "),
    "the same against the finest level": ("random_scenarios/table-finest.csv", "accuracy "),
    "scenarios at the bounds of all keys": ("unbreakable/table.csv", "scenarios"),
    "numbers at their limits and beyond": ("unbreakable/table.csv", "limits"),
    "damaged files": ("unbreakable/table.csv", "files"),
    "wrong arguments": ("arguments/table.csv", ""),
}
"""What was tried: table of a campaign, and how the names of its lines begin."""


def tried() -> Iterator[tuple[str, int, int]]:
    """Yield what was tried, how often, and how often it failed."""
    for what, (path, beginning) in TRIED.items():
        with (CAMPAIGNS / path).open(newline="", encoding="utf-8") as file:
            lines = [each for each in csv.DictReader(file) if each["what"].startswith(beginning)]
        yield what, sum(int(each["tried"]) for each in lines), sum(int(each["failed"]) for each in lines)


def cost_and_error(found: dict[str, Any]) -> Iterator[str]:
    """Yield rows of a table: processor time and error of the default model over all scenes, by accuracy."""
    for accuracy in ("0.01", "0.001", "0.0001"):
        scenes = [scene for scene in found.values() if accuracy in scene["ways"]["physical"]]
        runs = [scene["ways"]["physical"][accuracy] for scene in scenes]
        seconds = [each["new"] for each in runs]
        errors = [max(each["by_band"].values()) for each in runs]
        peers = [_cheapest(scene["fewer wavenumbers"], 0.01)["seconds"] for scene in scenes]
        share = [other / own for other, own in zip(peers, seconds, strict=True)]
        yield (
            f"| {float(accuracy):g} | {min(seconds):.2g} to {max(seconds):.2g} s |"
            f" {min(errors):.1e} to {max(errors):.1e} | {min(share):,.0f} to {max(share):,.0f} |"
        )


def _cheapest(points: list[dict[str, Any]], error: float) -> dict[str, Any]:
    return min(
        (each for each in points if max(each["by_band"].values()) <= error), key=lambda each: float(each["seconds"])
    )


def draw(found: dict[str, Any], saved: dict[str, list[float]]) -> None:
    """Draw the three panels."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    figure = Figure(figsize=(15.0, 5.6), layout="constrained")
    speed, stability, skipping = figure.subplots(1, 3)
    ways = [(way, scene, result["ways"][way]) for scene, result in found.items() for way in result["ways"]]
    for way, scene, runs in ways:
        cost, error = zip(*((each["new"], max(each["by_band"].values())) for each in runs.values()), strict=True)
        speed.plot(cost, error, "-", color=COLOURS[way], marker=MARKERS[scene], mec="white", ms=6, lw=0.9)
    for key, (colour, _) in PEERS.items():
        for scene, result in found.items():
            points = result.get(key, [])
            cost, error = ([each["seconds"] for each in points], [max(each["by_band"].values()) for each in points])
            speed.plot(cost, error, ":", color=colour, marker=MARKERS[scene], mec="white", ms=6, lw=0.9)
    speed.set(xscale="log", yscale="log", xlabel="processor time of a run, s", ylabel="largest error in any band")
    speed.set_title("run time against error", loc="left")
    names = {colour: way for way, colour in COLOURS.items()} | dict(PEERS.values())
    handles = [Line2D([], [], color=colour, lw=4, label=name) for colour, name in names.items()]
    handles += [Line2D([], [], color="k", marker=mark, ls="", label=scene) for scene, mark in MARKERS.items()]
    speed.legend(handles=handles, fontsize=7, loc="upper left", bbox_to_anchor=(0.0, -0.13), ncols=2, frameon=False)
    labels, counts, failed = zip(*reversed(list(tried())), strict=True)
    stability.barh(range(len(labels)), counts, 0.4, color="#79b4dd")
    stability.barh(range(len(labels)), np.maximum(failed, 0.5), 0.4, color="#d1495b")
    for place, (label, count, bad) in enumerate(zip(labels, counts, failed, strict=True)):
        stability.text(0.6, place + 0.24, f"{label}: {count}, {bad} failed", fontsize=8, va="bottom")
    stability.set(xscale="log", xlim=(0.5, None), yticks=[], ylim=(-0.5, len(labels)), xlabel="number tried")
    stability.set_title("stability", loc="left")
    names_of = list(reversed(saved))
    stage = np.arange(len(names_of))
    skipping.barh(stage + 0.0, [saved[name][0] for name in names_of], 0.32, color="#bbbbbb", label="computed")
    skipping.barh(stage - 0.32, [saved[name][1] for name in names_of], 0.32, color="#1b4fa8", label="skipped")
    for place, name in enumerate(names_of):
        skipping.text(0.0, place + 0.2, name, fontsize=8, va="bottom")
    skipping.set(yticks=[], ylim=(-0.6, len(names_of)), xlabel="processor time of a run, s")
    skipping.set_title("what a scene does not need", loc="left")
    skipping.legend(fontsize=8, frameon=False)
    figure.savefig(PICTURE, dpi=100)


def tables(found: dict[str, Any], saved: dict[str, list[float]]) -> dict[str, str]:
    """Return the tables of the page, by their markers."""
    heads = "| accuracy asked for | processor time of a run | largest error | times faster than every pixel alone |"
    speed = [heads, "|---|---|---|---|", *cost_and_error(found)]
    stability = ["| tried | number | failed |", "|---|---|---|"]
    stability += [f"| {what} | {count} | {bad} |" for what, count, bad in tried()]
    skipping = ["| not needed | with it, s | without, s | saved |", "|---|---|---|---|"]
    for what, (full, part) in saved.items():
        skipping.append(f"| {what} | {full:.2f} | {part:.2f} | {full - part:.2f} s, {1.0 - part / full:.0%} |")
    return {name: "\n".join(rows) for name, rows in (("speed", speed), ("tried", stability), ("skipped", skipping))}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="time the scenes; write numbers and figure of the page")
    arguments = parser.parse_args()
    found = json.loads(RESULTS.read_text(encoding="utf-8"))
    if arguments.write:
        _seconds(Scenario.load("cumulus", SIZE | {"slant.shadows": "on", "slant.parallax": "on"}))  # compiles kernels
        SKIPPING.write_text(json.dumps(measure_skipping(), indent=1) + "\n", encoding="utf-8")
    saved = json.loads(SKIPPING.read_text(encoding="utf-8"))
    for name, text in tables(found, saved).items():
        print(f"{text}\n")
        if arguments.write:
            put(name, text, PAGE)
    if arguments.write:
        draw(found, saved)
    return 0


if __name__ == "__main__":
    sys.exit(main())
