"""Estimates of the plan against Monte Carlo: random small scenes, what each light states there and what it errs by.

    python plugins/hcss-light/benchmarks/estimates.py --scenes 100 --table estimates.csv
    python plugins/hcss-light/benchmarks/estimates.py --scenes 0 --state    # states the errors of its scenes anew
    python plugins/hcss-light/benchmarks/estimates.py --scenes 0            # summary of the table alone

Scenes have 24 x 24 pixels; type, cover, view, hour, band, pixel size and accuracy are random. The noise of Monte Carlo
is subtracted from the rms and told apart: an error counts as within what is stated if it would be with two standard
errors less. Numbers of the rule (hcss_light.stated) were chosen on scenes with even numbers; those with odd ones test
it.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from typing import Any

import numpy as np
from hcss_light.comparison import compare
from hcss_light.stated import EMITTED_UM
from hcss_light.transport import SlantLight, SourceLight

from hcss_twin import Scenario
from hcss_twin.core.errors import HcssError
from hcss_twin.models.radiance.spectral_grid import all_nodes
from hcss_twin.plan.choose_light import light_inputs
from hcss_twin.plan.make_plan import make_plan

TABLE = Path(__file__).parent / "estimates.csv"
TIERS = ("columns", "slant", "source")
SUNLIT = 5
BANDS = ([10.3, 11.3], [8.3, 9.2], [3.6, 3.9], [3.9, 4.1])
COLUMNS = [
    "seed", "type", "coverage", "view_deg", "azimuth_deg", "hour", "wavelength_um", "pixel_m", "allowed", "sunlit",
    *TIERS, "noise", *(f"stated_{tier}" for tier in TIERS),
]  # fmt: skip


def scene(seed: int) -> tuple[Scenario, dict[str, Any]]:
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
    values = {
        "time": f"2024-04-20T{int(hour):02d}:{int(60 * (hour % 1)):02d}:00+10:00",
        "place": {"latitude": 20.0, "longitude": 150.0},
        "view": {"zenith": row["view_deg"], "azimuth": row["azimuth_deg"]},
        "image": {"rows": 24, "columns": 24, "pixel_size": row["pixel_m"]},
        "frames": {"count": 1},
        "accuracy": 0.02,
        "seed": seed,
        "bands": [band],
        "clouds": {"type": row["type"], "coverage": row["coverage"], "coverage_mode": "field"},
        "output": {"variables": ["radiance"], "certificate": 0},
    }
    return Scenario.from_dict(values), row


def measure(table: Path, scenes: int, pixels: int, photons: int) -> None:
    """Append those of the first scenes that a table lacks; sunlight gets :data:`SUNLIT` times as many photons."""
    known = set()
    if table.exists():
        with table.open(encoding="utf-8") as file:
            known = {int(row["seed"]) for row in csv.DictReader(file)}
    else:
        table.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")
    for seed in range(scenes):
        if seed in known:
            continue
        given, row = scene(seed)
        own = photons * (SUNLIT if row["sunlit"] and row["wavelength_um"] < EMITTED_UM else 1)
        try:
            (band,) = compare(given, pixels, own, 0, seed, TIERS[1:])["bands"]
        except HcssError as error:
            print(f"scene {seed} is refused: {error}")
            continue
        row |= {tier: round(band["errors"][tier]["rms"], 5) for tier in TIERS} | {"noise": round(band["noise"], 5)}
        row |= stated(given)
        with table.open("a", encoding="utf-8") as file:
            print(*(row[each] for each in COLUMNS), sep=",", file=file)


def stated(given: Scenario) -> dict[str, float]:
    """Return what the plan would state of each tier."""
    plan = make_plan(given)
    inputs = light_inputs(plan, all_nodes(plan.spectral_grid))
    slant = SlantLight(inputs)
    errors = slant.errors_of_columns(), slant.expected_errors(), SourceLight(inputs).expected_errors()
    return {f"stated_{tier}": round(max(own), 5) for tier, own in zip(TIERS, errors, strict=True)}


def state_anew(table: Path) -> None:
    """Replace what is stated in a table by that of the present rule."""
    with table.open(encoding="utf-8") as file:
        rows = [row | stated(scene(int(row["seed"]))[0]) for row in csv.DictReader(file)]
    lines = [",".join(COLUMNS), *(",".join(str(row[each]) for each in COLUMNS) for row in rows)]
    table.write_text("\n".join(lines) + "\n", encoding="utf-8")


def summary(table: Path) -> str:
    """Return how many estimates hold, by what ratio they are too large, and how often the best light is chosen."""
    with table.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    halves = {"even": [row for row in rows if int(row["seed"]) % 2 == 0]}
    halves["odd"] = [row for row in rows if int(row["seed"]) % 2]
    return "\n".join(f"{name} numbers: {_summary(own)}" for name, own in halves.items() if own)


def _summary(rows: list[dict[str, str]]) -> str:
    within, ratios, chosen, by_tier = 0, [], 0, dict.fromkeys(TIERS, 0)
    for row in rows:
        bounds, found = ({tier: float(row[of + tier]) for tier in TIERS} for of in ("stated_", ""))
        noise = 2.0 * float(row["noise"])
        holds = {tier: found[tier] - noise <= bounds[tier] for tier in TIERS}
        for tier in TIERS:
            by_tier[tier] += holds[tier]
        within += all(holds.values())
        ratios += [bounds[tier] / found[tier] for tier in TIERS if found[tier] > noise]
        allowed = float(row["allowed"])
        best = next((tier for tier in TIERS if found[tier] <= allowed), "none")
        chosen += next((tier for tier in TIERS if bounds[tier] <= allowed), "none") == best
    return (
        f"{len(rows)} scenes: all three estimates hold in {within}, "
        + ", ".join(f"that of {tier} in {by_tier[tier]}" for tier in TIERS)
        + f"; median stated / measured {np.median(ratios):.2f} ({len(ratios)} above the noise); "
        f"cheapest adequate light chosen in {chosen}"
    )


def main() -> None:
    """Measure more scenes, and print the summary."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--scenes", type=int, default=0)
    options.add_argument("--pixels", type=int, default=20)
    options.add_argument("--photons", type=int, default=300)
    options.add_argument("--state", action="store_true", help="state the errors of all scenes of the table anew")
    options.add_argument("--table", type=Path, default=TABLE)
    given = options.parse_args()
    measure(given.table, given.scenes, given.pixels, given.photons)
    if given.state:
        state_anew(given.table)
    print(summary(given.table))


if __name__ == "__main__":
    main()
