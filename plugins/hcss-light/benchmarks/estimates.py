"""Estimates of the plan against Monte Carlo: random small scenes, what each light states there and what it errs by.

    python plugins/hcss-light/benchmarks/estimates.py --scenes 100    # those that the table lacks
    python plugins/hcss-light/benchmarks/estimates.py --state         # states the errors of its scenes anew
    python plugins/hcss-light/benchmarks/estimates.py                 # summary of the table alone
    python plugins/hcss-light/benchmarks/estimates.py --layers --scenes 40

Scenes have 24 x 24 pixels; type, cover, view, hour, band, pixel size and accuracy are random; with ``--layers`` they
have a second layer. The noise of Monte Carlo is subtracted from the rms and told apart: an error counts as within what
is stated if it would be with two standard errors less. Numbers of the rule (hcss_light.stated) were chosen on scenes
with even numbers; those with odd ones test it.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from typing import Any

import numpy as np
from hcss_light.comparison import compare
from hcss_light.stacked_light import StackedSource
from hcss_light.stated import EMITTED_UM
from hcss_light.transport import SlantLight, SourceLight

from hcss_twin import Scenario
from hcss_twin.core.errors import HcssError
from hcss_twin.models.radiance.spectral_grid import all_nodes
from hcss_twin.plan.choose_light import light_inputs
from hcss_twin.plan.make_plan import make_plan

FOLDER = Path(__file__).parent
TIERS = {1: ("columns", "slant", "source"), 2: ("columns", "source")}
"""Of scenes with so many layers."""

SUNLIT = 5
BANDS = ([10.3, 11.3], [8.3, 9.2], [3.6, 3.9], [3.9, 4.1])
GIVEN = ["seed", "type", "coverage", "view_deg", "azimuth_deg", "hour", "wavelength_um", "pixel_m", "allowed", "sunlit"]


def columns_of(layers: int) -> list[str]:
    """Return the names of the columns of a table."""
    upper = ["upper", "upper_coverage"] if layers == 2 else []
    return [*GIVEN, *upper, *TIERS[layers], "noise", "pixels", *(f"stated_{tier}" for tier in TIERS[layers])]


def scene(seed: int, layers: int = 1) -> tuple[Scenario, dict[str, Any]]:
    """Return a random scenario and its parameters."""
    draw = np.random.default_rng([22, seed])
    band = BANDS[draw.integers(len(BANDS))]
    hour = float(draw.choice([2.0, 9.0, 11.0, 13.0, 15.0, 16.5, 22.0]))
    row = {
        "seed": seed,
        "type": str(draw.choice(["stratocumulus", "cumulus", "stratus"])),
        "coverage": round(float(draw.uniform(0.2, 0.8)), 2),
        "view_deg": round(float(draw.uniform(0.0, 70.0)), 1),
        "azimuth_deg": round(float(draw.uniform(0.0, 360.0))),
        "hour": hour,
        "wavelength_um": sum(band) / 2.0,
        "pixel_m": float(draw.choice([50.0, 100.0, 200.0])),
        "allowed": round(float(np.exp(draw.uniform(np.log(0.005), np.log(0.2)))), 4),
        "sunlit": 8.0 < hour < 17.0,
    }
    clouds: dict[str, Any] = {"type": row["type"], "coverage": row["coverage"], "coverage_mode": "field"}
    if layers == 2:
        row["upper"] = str(draw.choice(["cirrus", "altocumulus", "altostratus"]))
        row["upper_coverage"] = round(float(draw.uniform(0.2, 0.8)), 2)
        clouds = {"layers": [clouds, clouds | {"type": row["upper"], "coverage": row["upper_coverage"]}]}
    values = {
        "time": f"2024-04-20T{int(hour):02d}:{int(60 * (hour % 1)):02d}:00+10:00",
        "place": {"latitude": 20.0, "longitude": 150.0},
        "view": {"zenith": row["view_deg"], "azimuth": row["azimuth_deg"]},
        "image": {"rows": 24, "columns": 24, "pixel_size": row["pixel_m"]},
        "frames": {"count": 1},
        "accuracy": 0.02,
        "seed": seed,
        "bands": [band],
        "clouds": clouds,
        "output": {"variables": ["radiance"], "certificate": 0},
    }
    return Scenario.from_dict(values), row


def measure(table: Path, layers: int, scenes: int, pixels: int, photons: int) -> None:
    """Append those of the first scenes that a table lacks; sunlight gets :data:`SUNLIT` times as many photons."""
    if not table.exists():
        table.write_text(",".join(columns_of(layers)) + "\n", encoding="utf-8")
    known = {int(row["seed"]) for row in read(table)}
    for seed in range(scenes):
        if seed in known:
            continue
        given, row = scene(seed, layers)
        own = photons * (SUNLIT if row["sunlit"] and row["wavelength_um"] < EMITTED_UM else 1)
        try:
            (band,) = compare(given, pixels, own, 0, seed, TIERS[layers][1:])["bands"]
        except HcssError as error:
            print(f"scene {seed} is refused: {error}")
            continue
        row |= {tier: round(band["errors"][tier]["rms"], 5) for tier in TIERS[layers]}
        row |= {"noise": round(band["noise"], 5), "pixels": pixels} | stated(given)
        with table.open("a", encoding="utf-8") as file:
            print(*(row[each] for each in columns_of(layers)), sep=",", file=file)


def read(table: Path) -> list[dict[str, str]]:
    """Return the rows of a table."""
    with table.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def stated(given: Scenario) -> dict[str, float]:
    """Return what the plan would state of each tier."""
    plan = make_plan(given)
    inputs = light_inputs(plan, all_nodes(plan.spectral_grid))
    lights = [StackedSource(inputs)] if inputs.above else [SlantLight(inputs), SourceLight(inputs)]
    errors = {each.tier: each.expected_errors() for each in lights} | {"columns": lights[0].errors_of_columns()}
    return {f"stated_{tier}": round(max(own), 5) for tier, own in errors.items()}


def state_anew(table: Path, layers: int) -> None:
    """Replace what is stated in a table by that of the present rule."""
    rows = [row | stated(scene(int(row["seed"]), layers)[0]) for row in read(table)]
    names = columns_of(layers)
    lines = [",".join(names), *(",".join(str(row[each]) for each in names) for row in rows)]
    table.write_text("\n".join(lines) + "\n", encoding="utf-8")


def summary(table: Path, layers: int) -> str:
    """Return how many estimates hold, by what ratio they are too large, and how often the best light is chosen."""
    rows = read(table)
    halves = {"even": [row for row in rows if int(row["seed"]) % 2 == 0]}
    halves["odd"] = [row for row in rows if int(row["seed"]) % 2]
    return "\n".join(f"{name} numbers: {_summary(own, TIERS[layers])}" for name, own in halves.items() if own)


def _summary(rows: list[dict[str, str]], tiers: tuple[str, ...]) -> str:
    within, ratios, chosen, by_tier = 0, [], 0, dict.fromkeys(tiers, 0)
    for row in rows:
        bounds, found = ({tier: float(row[of + tier]) for tier in tiers} for of in ("stated_", ""))
        noise = 2.0 * float(row["noise"])
        holds = {tier: found[tier] - noise <= bounds[tier] for tier in tiers}
        for tier in tiers:
            by_tier[tier] += holds[tier]
        within += all(holds.values())
        ratios += [bounds[tier] / found[tier] for tier in tiers if found[tier] > noise]
        allowed = float(row["allowed"])
        best = next((tier for tier in tiers if found[tier] <= allowed), "none")
        chosen += next((tier for tier in tiers if bounds[tier] <= allowed), "none") == best
    return (
        f"{len(rows)} scenes: all estimates hold in {within}, "
        + ", ".join(f"that of {tier} in {by_tier[tier]}" for tier in tiers)
        + f"; median stated / measured {np.median(ratios):.2f} ({len(ratios)} above the noise); "
        f"cheapest adequate light chosen in {chosen}"
    )


def main() -> None:
    """Measure more scenes, and print the summary."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--scenes", type=int, default=0)
    options.add_argument("--pixels", type=int, default=100)
    options.add_argument("--photons", type=int, default=300)
    options.add_argument("--state", action="store_true", help="state the errors of all scenes of the table anew")
    options.add_argument("--layers", action="store_true", help="scenes with two layers of cloud")
    options.add_argument("--table", type=Path)
    given = options.parse_args()
    layers = 2 if given.layers else 1
    table = given.table or FOLDER / ("estimates-layers.csv" if given.layers else "estimates.csv")
    measure(table, layers, given.scenes, given.pixels, given.photons)
    if given.state:
        state_anew(table, layers)
    print(summary(table, layers))


if __name__ == "__main__":
    main()
