"""Run time against error: every radiance model and provider at tolerances 1e-1 to 1e-5, with peers as points.

    python benchmarks/pareto.py --write             # measures into benchmarks/pareto.json (long); page and picture anew
    python benchmarks/pareto.py --ways as-printed   # measures some anew and keeps the rest
    python benchmarks/pareto.py --keep --write      # measures nothing: table of the page, and picture

The scene is that of the baseline, with one provider changed. Peers: every pixel integrated by itself, one column for
each class of pixels (with LOWTRAN7 itself where the plugin ``hcss-lowtran7`` is installed), other cloud fields (PyPI
packages ``pyfastnoiselite`` and ``gstools``) and xarray; what is not installed is named and left out.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from baseline_ratios import SCENE, scenario
from page import put
from pareto_peers import cloud_fields, has_lowtran, pixel_classes, wavelengths, writing
from pareto_tables import DRAWN, draw, fronts, tables

from hcss_twin.plan.make_plan import make_plan
from hcss_twin.reports.benchmark import bench, private_cache

RESULTS = Path(__file__).with_name("pareto.json")
PICTURE = Path(__file__).parents[1] / "docs" / "images" / "pareto.png"

PAPER = {"radiance.model": "as-printed"}
# In single precision, as it was written, its noise keeps tables of 1e-4 from converging.
LOWTRAN = PAPER | {
    "atmosphere.provider": "lowtran7",
    "atmosphere.parameters": {"aerosol": "none", "precision": "double"},
    "sea.model": "cox-munk",
    "optics.provider": "mie",
}
WAYS: dict[str, dict[str, Any]] = {
    "physical": {},
    "physical-two-stream": {"radiance.model": "physical-two-stream"},
    "as-printed": PAPER,
    "as-printed, atmosphere table": PAPER | {"atmosphere.provider": "table"},
    "as-printed, sea cox-munk": PAPER | {"sea.model": "cox-munk"},
    "as-printed, optics mie": PAPER | {"optics.provider": "mie"},
    "as-printed, clouds surrogate": PAPER | {"clouds.generator": "surrogate", "clouds.parameters": {}},
    "as-printed, clouds imagery": PAPER | {"clouds.generator": "imagery", "clouds.parameters": {}},
    "as-printed, LOWTRAN7 itself, cox-munk, mie": LOWTRAN,
}


def measure_way(name: str, rounds: int, pixels: int, folder: Path) -> dict[str, Any]:
    """Time one way at all accuracies; the seconds of its table are medians."""
    changes = dict(WAYS[name])
    if "clouds.parameters" in changes:
        changes["clouds.parameters"] = {"image": str(folder / "image.npy"), "method": "coverage"}
    return bench(scenario(changes), rounds=rounds, pixels=pixels, folder=folder).as_dict()


def measure_peers(rounds: int, pixels: int, folder: Path) -> dict[str, Any]:
    """Time the peers."""
    plan = make_plan(scenario({"radiance.model": "as-printed"}))
    found: dict[str, Any] = {
        "1000 wavelengths": wavelengths(plan, 1000, pixels),
        "classes": pixel_classes(plan),
        "writing": writing(folder, rounds),
    }
    found["clouds"], found["missing"] = cloud_fields(rounds)
    if has_lowtran():
        found["classes, LOWTRAN7"] = pixel_classes(make_plan(scenario(LOWTRAN)))
    else:
        found["missing"].append("LOWTRAN7: plugin hcss-lowtran7 is not installed")
    return found


def made_image(path: Path) -> None:
    """Save a field with a power law, for generators that imitate an image."""
    random = np.random.default_rng(1)
    frequency = np.hypot(np.fft.fftfreq(2048)[:, None], np.fft.rfftfreq(2048)[None, :])
    frequency[0, 0] = np.inf
    np.save(path, np.fft.irfft2(np.fft.rfft2(random.normal(size=(2048, 2048))) * frequency**-1.6))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ways", nargs="*", choices=[*WAYS, "peers"], help="default: all")
    parser.add_argument("--keep", action="store_true", help="measure nothing")
    parser.add_argument("--write", action="store_true", help="draw, and put the tables into the page")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--pixels", type=int, default=24)
    parser.add_argument("--folder", type=Path, default=Path("."), help="where cubes are written for a moment")
    given = parser.parse_args()
    found = json.loads(RESULTS.read_text()) if RESULTS.exists() else {"scene": SCENE, "ways": {}, "peers": {}}
    names = [] if given.keep else given.ways if given.ways is not None else [*WAYS, "peers"]
    with tempfile.TemporaryDirectory(prefix=".hcss-pareto-", dir=given.folder.resolve()) as name:
        folder = Path(name)
        made_image(folder / "image.npy")
        for way in names:
            print(way, flush=True)
            if way == "peers":
                with private_cache(folder / "cache"):
                    found["peers"] = measure_peers(given.rounds, given.pixels, folder)
            elif "LOWTRAN7" in way and not has_lowtran():
                print("skipped: plugin hcss-lowtran7 is not installed")
                continue
            else:
                found["ways"][way] = measure_way(way, given.rounds, given.pixels, folder)
            RESULTS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    found["ways"] = {way: found["ways"][way] for way in WAYS if way in found["ways"]}
    for text in tables(found).values():
        print(f"\n{text}")
    if given.write:
        put("fronts", fronts(found, DRAWN))
        draw(found, PICTURE)


if __name__ == "__main__":
    main()
