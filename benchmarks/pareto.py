"""Run time against error of every radiance model and of peers, on several scenes, relative to one reference.

    python benchmarks/pareto.py --write             # measures into benchmarks/pareto.json (an hour); page and picture
    python benchmarks/pareto.py --scenes cirrus --ways as-printed   # measures some anew and keeps the rest
    python benchmarks/pareto.py --keep --write      # measures nothing: tables of the page, and picture

The reference of a scene (:mod:`hcss_twin.reports.benchmark_reference`) is the finest that the engine offers, for the
atmosphere, sea and particles of the scene; it is the same for all models and peers. Peers: fewer wavenumbers, classes
of pixels in place of tables (LOWTRAN7 itself where the plugin ``hcss-lowtran7`` is installed), other cloud fields (PyPI
packages ``pyfastnoiselite`` and ``gstools``) and xarray; what is not installed is named and left out.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from page import put
from pareto_peers import cloud_fields, fewer_wavenumbers, has_lowtran, pixel_classes, writing
from pareto_tables import draw, fronts, tables

from hcss_twin import Scenario
from hcss_twin.engine.compile import tables_of
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.reports.benchmark import private_cache, random_columns
from hcss_twin.reports.benchmark_reference import MODELS, Reference, changed, reference_of, table_radiance
from hcss_twin.reports.benchmark_stages import RAW, RUNS, STAGES, Rounds, time_stages

RESULTS = Path(__file__).with_name("pareto.json")
PICTURE = Path(__file__).parents[1] / "docs" / "images" / "pareto.png"
SCENES = ("stratus", "cumulus", "cirrus")
ACCURACIES = (1e-2, 1e-3, 1e-4)
PIXELS = 24

LOWTRAN = "as-printed, LOWTRAN7 itself"
WAYS: dict[str, dict[str, Any]] = MODELS | {
    # In single precision, as it was written, its noise keeps tables of 1e-4 from converging.
    LOWTRAN: MODELS["as-printed"]
    | {"atmosphere.provider": "lowtran7", "atmosphere.parameters": {"aerosol": "none", "precision": "double"}}
}


def measure_reference(scene: Scenario) -> dict[str, Any]:
    """Compute the reference of random columns, for JSON."""
    found = reference_of(scene, random_columns(make_plan(scene), PIXELS))
    return vars(found) | {"columns": found.columns.tolist(), "radiance": found.radiance.tolist()}


def measure_way(scene: Scenario, accuracies: list[float], reference: Reference, folder: Path) -> list[dict[str, Any]]:
    """Time a scene at each accuracy, with new tables, and measure the error of what its tables hold."""
    found: list[dict[str, Any]] = []
    # Kernels are compiled, and the disk is awake, before anything counts.
    time_stages(Rounds(), "", changed(scene, {"accuracy": 1e-1}), folder, True)
    for accuracy in accuracies:
        times, asked = Rounds(), changed(scene, {"accuracy": accuracy})
        time_stages(times, "", asked, folder, True)
        plan = make_plan(asked)
        compiled = tables_of(plan)
        radiance = table_radiance(plan, compiled, reference.columns)
        assert radiance is not None  # these scenes have one view and no surfaces
        one = {
            "accuracy": accuracy,
            "by_band": reference.errors(radiance),
            "wavenumbers": int(compiled.spectrum.nodes.wavenumber_cm1.size),
            "seconds": {stage: times.seconds(stage) for stage in (*STAGES, *RUNS, RAW)},
            "over_raw": {run: times.ratio(run, RAW) for run in RUNS},
        }
        found.append(one)
        print(f"  {accuracy:g}: error {max(one['by_band'].values()):.1e}, {one['over_raw']}", flush=True)
    return found


def measure_scene(name: str, ways: list[str], found: dict[str, Any], folder: Path) -> None:
    """Measure some ways of a scene into ``found``; its reference is computed unless it is there."""
    scene = Scenario.load(name, {"output.certificate": 0})
    if "reference" not in found:
        print(f"{name}: reference", flush=True)
        found["reference"] = measure_reference(scene)
    known = found["reference"]
    arrays = {key: np.array(known[key]) for key in ("columns", "radiance")}
    reference = Reference(**arrays, bands=tuple(known["bands"]), text=known["text"])
    for way in ways:
        print(f"{name}: {way}", flush=True)
        if way == "peers":
            plan = make_plan(changed(scene, MODELS["as-printed"]))
            found["classes"] = pixel_classes(plan, reference)
            found["fewer wavenumbers"] = fewer_wavenumbers(make_plan(scene), reference)
        elif way == LOWTRAN and not has_lowtran():
            print("skipped: plugin hcss-lowtran7 is not installed")
        else:
            accuracies = list(ACCURACIES)
            found.setdefault("ways", {})[way] = measure_way(changed(scene, WAYS[way]), accuracies, reference, folder)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="*", choices=SCENES, default=list(SCENES))
    parser.add_argument(
        "--ways", nargs="*", choices=[*WAYS, "peers", "stages"], help="default: all, with new references"
    )
    parser.add_argument("--keep", action="store_true", help="measure nothing")
    parser.add_argument("--write", action="store_true", help="draw, and put the tables into the page")
    parser.add_argument("--folder", type=Path, default=Path("."), help="where cubes are written for a moment")
    given = parser.parse_args()
    found = json.loads(RESULTS.read_text()) if RESULTS.exists() else {"scenes": {}, "peers": {}}
    ways = [] if given.keep else given.ways if given.ways is not None else [*WAYS, "peers", "stages"]
    with tempfile.TemporaryDirectory(prefix=".hcss-pareto-", dir=given.folder.resolve()) as name:
        folder = Path(name)
        with private_cache(folder / "cache"):
            for scene in given.scenes if ways else ():
                known = found["scenes"].setdefault(scene, {})
                if given.ways is None:
                    known.pop("reference", None)
                measure_scene(scene, [way for way in ways if way != "stages"], known, folder)
                RESULTS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
            if "stages" in ways:
                clouds, missing = cloud_fields(3)
                found["peers"] = {"clouds": clouds, "missing": missing, "writing": writing(folder, 3)}
                RESULTS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    for text in tables(found).values():
        print(f"\n{text}")
    if given.write:
        put("fronts", fronts(found))
        draw(found, PICTURE)


if __name__ == "__main__":
    main()
