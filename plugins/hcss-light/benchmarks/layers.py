"""Errors of columns and of the tier source in scenes of two cloud layers, against Monte Carlo of both.

    python plugins/hcss-light/benchmarks/layers.py
    python plugins/hcss-light/benchmarks/layers.py --views 60 --cases day --pixels 24

Scenes are those of ``tiers.py`` with a second layer of coverage .5 above the first of .45. Cases that the table already
has are not computed again.
"""

from __future__ import annotations

import argparse
import csv
import json
from pathlib import Path

from hcss_light.comparison import compare
from tiers import BANDS, TIMES, scene

from hcss_twin import Scenario

TABLE = Path(__file__).parent / "errors-layers.csv"
COLUMNS = ["lower", "upper", "view_deg", "sun", "band", "tier", "bias", "rms", "bias_K", "rms_K", "noise", "pixels"]
PAIRS = [("cumulus", "cirrus"), ("stratocumulus", "cirrus"), ("stratocumulus", "altocumulus")]


def layered(lower: str, upper: str, view: float, sun: str) -> Scenario:
    """Return the scenario of a case."""
    values = json.loads(scene(lower, view, sun).to_json())
    values["clouds"] = {"layers": [{"type": lower, "coverage": 0.45}, {"type": upper, "coverage": 0.5}]}
    return Scenario.from_dict(values | {"radiance": {"light": "source"}})


def main() -> None:
    """Compute the cases that the table lacks."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--pairs", nargs="+", default=["-".join(each) for each in PAIRS])
    options.add_argument("--views", nargs="+", type=float, default=[0.0, 45.0, 60.0])
    options.add_argument("--cases", nargs="+", default=list(TIMES), choices=list(TIMES))
    options.add_argument("--pixels", type=int, default=24)
    options.add_argument("--photons", type=int, default=1000)
    options.add_argument("--table", type=Path, default=TABLE)
    given = options.parse_args()
    known = set()
    if given.table.exists():
        with given.table.open(encoding="utf-8") as file:
            known = {(row["lower"], row["upper"], float(row["view_deg"]), row["sun"]) for row in csv.DictReader(file)}
    else:
        given.table.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")
    for view in given.views:
        for pair in given.pairs:
            lower, upper = pair.split("-")
            for sun in given.cases:
                if (lower, upper, view, sun) in known:
                    continue
                found = compare(layered(lower, upper, view, sun), given.pixels, given.photons, 0, 1)
                with given.table.open("a", encoding="utf-8") as file:
                    for name, band in zip(BANDS, found["bands"], strict=True):
                        for tier, own in (("columns", "columns"), ("source", "cube")):
                            errors = band["errors"][own]
                            figures = (errors["bias"], errors["rms"], errors["bias_K"], errors["rms_K"], band["noise"])
                            text = [f"{each:.3g}" for each in figures]
                            print(lower, upper, f"{view:g}", sun, name, tier, *text, given.pixels, sep=",", file=file)


if __name__ == "__main__":
    main()
