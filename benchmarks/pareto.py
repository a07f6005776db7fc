"""Processor time against error of every radiance model and of peers, on several scenes, relative to one reference.

    python benchmarks/pareto.py --write             # measures into benchmarks/pareto.json (an hour); page and picture
    python benchmarks/pareto.py --scenes cirrus --ways as-printed   # measures some anew and keeps the rest
    python benchmarks/pareto.py --missing           # measures what a run that was stopped has not measured
    python benchmarks/pareto.py --keep --write      # measures nothing: table of the page, and picture

The reference of a scene (:mod:`hcss_bench.reference`) is the finest that the engine offers, for the
atmosphere, sea and particles of the scene; it is the same for all models and peers. Peers: fewer wavenumbers, classes
of pixels in place of tables, and LOWTRAN7 itself where the plugin ``hcss-lowtran7`` is installed. What costs least is
measured first, and everything is kept at once.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from hcss_bench.benchmark import random_columns
from hcss_bench.reference import MODELS, Reference, changed, reference_of, table_radiance, with_streams
from hcss_bench.stages import private_cache
from page import put
from pareto_peers import fewer_wavenumbers, has_lowtran, pixel_classes
from pareto_tables import draw, fronts

from hcss_twin import Scenario
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.simulate import run
from hcss_twin.plan.make_plan import make_plan

RESULTS = Path(__file__).with_name("pareto.json")
PICTURE = Path(__file__).parents[1] / "docs" / "images" / "pareto.png"
SCENES = ("stratus", "cumulus", "cirrus", "cirrus-over-cumulus")
PIXELS = 24

LOWTRAN, PEERS = "as-printed, LOWTRAN7 itself", "peers"
WAYS: dict[str, dict[str, Any]] = MODELS | {
    # In single precision, as it was written, its noise keeps tables from converging.
    LOWTRAN: MODELS["as-printed"]
    | {"atmosphere.provider": "lowtran7", "atmosphere.parameters": {"aerosol": "none", "precision": "double"}},
    "physical, 16 streams": with_streams(16),
    "physical, 32 streams": with_streams(32),
}
ORDER = (
    ("as-printed", 1e-3), ("physical-two-stream", 1e-3), ("physical, 8 streams", 1e-3), ("physical", 1e-2),
    ("physical", 1e-3), (PEERS, 1e-2), (LOWTRAN, 1e-3), ("physical, 16 streams", 1e-3), ("physical", 1e-4),
    ("physical, 32 streams", 1e-3),
)  # fmt: skip
"""What is measured, and the accuracy asked for, which governs tables only, except with ``physical``."""


def measure_reference(scene: Scenario) -> dict[str, Any]:
    """Compute the reference of random columns, for JSON."""
    found = reference_of(scene, random_columns(make_plan(scene), PIXELS))
    return {name: each.tolist() if isinstance(each, np.ndarray) else each for name, each in vars(found).items()}


def processor_seconds() -> float:
    """Return the processor time of this process and of its children, such as LOWTRAN7."""
    return sum(os.times()[:4])


def measure_way(scene: Scenario, reference: Reference, folder: Path) -> dict[str, Any]:
    """Time a whole run with new tables and one with kept tables, and measure the error of what the tables hold."""
    seconds = []
    for _ in range(2):
        start = processor_seconds()
        plan = make_plan(scene)
        run(plan, folder / "cube.nc")
        seconds.append(processor_seconds() - start)
    compiled = tables_of(plan)
    radiance = table_radiance(plan, compiled, reference.columns)
    assert radiance is not None  # these scenes have one view and no surfaces
    return {
        "by_band": reference.errors(radiance),
        "clear": reference.errors(radiance, ~np.any(reference.columns > 0.0, axis=1)),
        "wavenumbers": int(compiled.spectrum.nodes.wavenumber_cm1.size),
        "new": seconds[0],
        "kept": seconds[1],
    }


def measure(scene: Scenario, way: str, accuracy: float, known: dict[str, Any], folder: Path, is_warm: bool) -> None:
    """Measure one way on a scene into ``known``, which has its reference."""
    arrays = {key: np.array(known["reference"][key]) for key in ("columns", "radiance", "level_change")}
    reference = Reference(**known["reference"] | arrays)
    asked = changed(scene, {"accuracy": accuracy})
    if way == PEERS:
        known["fewer wavenumbers"] = fewer_wavenumbers(make_plan(asked), reference)
        if reference.columns.shape[1] == 1:
            known["classes"] = pixel_classes(make_plan(changed(asked, MODELS["as-printed"])), reference)
    elif way == LOWTRAN and not has_lowtran():
        print("skipped: plugin hcss-lowtran7 is not installed")
    else:
        asked = changed(asked, WAYS[way])
        if not is_warm:  # kernels are compiled before anything counts
            run(
                make_plan(changed(asked, {"accuracy": 1e-1, "image.rows": 16, "image.columns": 16})), folder / "cube.nc"
            )
        found = measure_way(asked, reference, folder)
        known.setdefault("ways", {}).setdefault(way, {})[f"{accuracy:g}"] = found
        print({name: f"{value:.1e}" for name, value in found["by_band"].items()}, f"{found['new']:.1f} s", flush=True)


def is_measured(known: dict[str, Any], way: str, accuracy: float) -> bool:
    """Whether results of a scene hold a way at an accuracy."""
    return "fewer wavenumbers" in known if way == PEERS else f"{accuracy:g}" in known.get("ways", {}).get(way, {})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="*", choices=SCENES, default=list(SCENES))
    parser.add_argument("--ways", nargs="*", choices=[*WAYS, PEERS], help="default: all, with new references")
    parser.add_argument("--missing", action="store_true", help="measure only what has not been measured")
    parser.add_argument("--keep", action="store_true", help="measure nothing")
    parser.add_argument("--write", action="store_true", help="draw, and put the table into the page")
    parser.add_argument("--folder", type=Path, default=Path("."), help="where cubes are written for a moment")
    given = parser.parse_args()
    keeps = given.keep or given.missing or given.ways
    found, warm = json.loads(RESULTS.read_text()) if RESULTS.exists() and keeps else {}, set()
    with tempfile.TemporaryDirectory(prefix=".hcss-pareto-", dir=given.folder.resolve()) as name:
        folder = Path(name)
        with private_cache(folder / "cache"):
            for way, accuracy in () if given.keep else ORDER:
                for title in given.scenes:
                    scene, known = Scenario.load(title, {"output.certificate": 0}), found.setdefault(title, {})
                    if given.ways is not None and way not in given.ways:
                        continue
                    if given.missing and is_measured(known, way, accuracy):
                        continue
                    if "reference" not in known:
                        print(f"{title}: reference", flush=True)
                        known["reference"] = measure_reference(scene)
                    print(f"{title}: {way}, {accuracy:g}", flush=True)
                    measure(scene, way, accuracy, known, folder, way in warm)
                    warm.add(way)
                    RESULTS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(fronts(found))
    if given.write:
        put("fronts", fronts(found))
        draw(found, PICTURE)


if __name__ == "__main__":
    main()
