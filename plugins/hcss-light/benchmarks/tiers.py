"""Errors of columns and tiers against Monte Carlo, by cloud type, view and sun; writes the table that the tiers state.

    python plugins/hcss-light/benchmarks/tiers.py
    python plugins/hcss-light/benchmarks/tiers.py --table grazing.csv --views 60 --types cumulus --cases grazing
    python plugins/hcss-light/benchmarks/tiers.py --table 50m.csv --views 0 60 --pixel-size 50
    python plugins/hcss-light/benchmarks/tiers.py --table 20m.csv --views 0 45 60 --pixel-size 20 --pixels 10
        (with --photons 600 --types paper-stratus stratocumulus paper-cumulus)
    python plugins/hcss-light/benchmarks/tiers.py --table h2o.csv --views 0 60 --bands h2o
    python plugins/hcss-light/benchmarks/tiers.py --layers --views 0 45 60 --pixels 16 --photons 400

Each case is a scene of 96 x 96 pixels of 100 m at 20 N, seen from azimuth 20, coverage .45; with ``--layers`` a second
one of coverage .5 stands above. Cases that the table already has are not computed again; delete it to start afresh.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from itertools import product
from pathlib import Path

from hcss_light.comparison import compare

from hcss_twin import Scenario

TABLE = Path(__file__).parent.parent / "src" / "hcss_light" / "errors.csv"
TABLE_OF_LAYERS = Path(__file__).parent / "errors-layers.csv"
KINDS = ["stratocumulus", "cumulus", "cirrus"]
PAIRS = ["cumulus+cirrus", "stratocumulus+cirrus", "stratocumulus+altocumulus"]
"""Types of one layer, and of the lower and the upper of two."""

TIMES = {"night": "2024-04-20T23:30:00+10:00", "day": "2024-04-20T14:30:00+10:00"}
GRAZING = "2024-04-20T16:00:00+10:00"
"""The sun is at 60 deg, opposite to views from east-southeast."""

BANDS = {"lwir": [10.3, 11.3], "mwir": [3.6, 3.9], "h2o": [2.7, 3.0]}
COLUMNS = ["view_deg", "sun", "band", "tier", "bias", "rms", "bias_K", "rms_K", "noise"]


def scene(
    kind: str, view: float, sun: str, pixel_m: float = 100.0, bands: Sequence[str] = ("lwir", "mwir")
) -> Scenario:
    """Return the scenario of a case, of one type or of two joined by a plus."""
    layers = [{"type": each, "coverage": cover} for each, cover in zip(kind.split("+"), (0.45, 0.5), strict=False)]
    azimuth, time = (97.0, GRAZING) if sun == "grazing" else (20.0, TIMES[sun])
    return Scenario.from_dict(
        {
            "time": time,
            "place": {"latitude": 20.0, "longitude": 150.0},
            "view": {"zenith": view, "azimuth": azimuth},
            "image": {"rows": 96, "columns": 96, "pixel_size": pixel_m},
            "frames": {"count": 1},
            "accuracy": 0.01,
            "sea": {"waves": "off", "temperature_texture": 0.0},
            "atmosphere": {"water_vapour_texture": 0.0},
            "bands": [BANDS[name] for name in bands],
            "clouds": {"layers": layers},
            "output": {"variables": ["radiance"], "certificate": 0},
        }
    )


def main() -> None:
    """Compute the cases that the table lacks."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--layers", action="store_true", help="scenes with two layers")
    options.add_argument("--types", nargs="+", help="pairs joined by a plus for two layers")
    options.add_argument("--views", nargs="+", type=float, default=[0.0, 45.0, 60.0, 75.0])
    options.add_argument("--cases", nargs="+", default=list(TIMES), choices=[*TIMES, "grazing"])
    options.add_argument("--pixel-size", type=float, default=100.0)
    options.add_argument("--bands", nargs="+", default=["lwir", "mwir"], choices=list(BANDS))
    options.add_argument("--seed", type=int, default=1, help="of the pixels and photons")
    options.add_argument("--pixels", type=int, default=48)
    options.add_argument("--photons", type=int, default=2000)
    options.add_argument("--table", type=Path)
    given = options.parse_args()
    names, tiers, table, kinds = ["type"], ("columns", "slant", "source"), TABLE, KINDS
    if given.layers:
        names, tiers, table, kinds = ["lower", "upper"], ("columns", "source"), TABLE_OF_LAYERS, PAIRS
    table, known = given.table or table, set()
    more = [given.pixels] if given.layers else []
    if table.exists():
        with table.open(encoding="utf-8") as file:
            known = {
                ("+".join(row[name] for name in names), float(row["view_deg"]), row["sun"])
                for row in csv.DictReader(file)
            }
    else:
        table.write_text(",".join([*names, *COLUMNS, *(["pixels"] if more else [])]) + "\n", encoding="utf-8")
    for view, kind, sun in product(given.views, given.types or kinds, given.cases):
        if (kind, view, sun) in known:
            continue
        own_scene = scene(kind, view, sun, given.pixel_size, given.bands)
        found = compare(own_scene, given.pixels, given.photons, 0, given.seed, tiers[1:])
        with table.open("a", encoding="utf-8") as file:
            for name, band in zip(given.bands, found["bands"], strict=True):
                for tier in tiers:
                    own = band["errors"][tier]
                    figures = (own["bias"], own["rms"], own["bias_K"], own["rms_K"], band["noise"])
                    text = [f"{each:.3g}" for each in figures]
                    print(*kind.split("+"), f"{view:g}", sun, name, tier, *text, *more, sep=",", file=file)


if __name__ == "__main__":
    main()
