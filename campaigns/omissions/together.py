"""``auto`` against everything on: do the effects that a plan skips, all together, stay within the accuracy?

    python campaigns/omissions/together.py               # 40 scenes
    python campaigns/omissions/together.py --scenes 5    # the first 5
    python campaigns/omissions/together.py --rich        # 40 others: by day, from 100 km and more, mostly two layers
    python campaigns/omissions/together.py --rich --keep rows.jsonl     # goes on after a break

A scene leaves every effect to the plan, which skips those whose bound is a small share of the accuracy. Each scene is
computed again with all of them switched on at once. A pixel must not change by more than the sum of the bounds, nor by
more than the accuracy that was asked for, beside the errors that both runs estimate of their tables. What the plan
leaves out as too dear it states, and does not skip: such effects are not part of it.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from omission_scenes import CHEAP, ROUNDING, SCENES, SWITCHES, radiance_of

from hcss_twin import Scenario, make_plan
from hcss_twin.core.errors import ProviderError, ScenarioError

PIXELS, FEW_PIXELS = 48, 24
BY_FIELDS = ("parallax of clouds", "clouds within the footprint of a pixel")
"""Effects that the fields of clouds have, so that they are not among ``plan.effects``."""


def scene(number: int) -> tuple[str, dict[str, Any]]:
    """Return the shipped scenario and the overrides of a scene, the same each time: nothing is switched on or off."""
    random = np.random.default_rng([44, number])
    overrides: dict[str, Any] = {
        **CHEAP,
        "sea.model": "rough-sea",
        "accuracy": float(random.choice([1e-2, 1e-3])),
        "clouds.coverage": round(float(random.uniform(0.1, 0.9)), 2),
        "frames.count": 1,
        "image.columns": PIXELS,
        "image.rows": PIXELS,
        "image.pixel_size": float(random.choice([5.0, 20.0, 100.0, 500.0, 2000.0])),
        "output.certificate": 0,
        "output.variables": ["radiance"],
        "sea.wind_speed": round(float(random.uniform(2.0, 15.0)), 1),
        "seed": number,
        "time": f"2024-04-20T{int(random.integers(24)):02d}:20:00+10:00",
        "view.azimuth": round(float(random.uniform(0.0, 359.0)), 0),
        "view.zenith": float(random.choice([0.0, 2.0, 10.0, 25.0, 45.0, 60.0])),
    }
    chosen = random.integers(3)
    overrides["bands"] = [[[8.0, 14.0]], [[3.7, 3.8], [10.5, 11.0]], [[2.75, 2.8], [3.7, 3.8], [10.5, 11.0]]][chosen]
    if altitude := int(random.integers(3)):
        overrides["platform.altitude"] = (None, 7e5, 35_786e3)[altitude]
    return str(random.choice(["stratus", "cumulus", "cirrus"])), overrides


def rich_scene(number: int) -> tuple[str, dict[str, Any]]:
    """Return the same of a scene that can have many effects: by day, seen from a finite altitude, mostly two layers.

    It is small, with one or two narrow bands, so that tables toward many views take minutes rather than hours.
    """
    random, (_, overrides) = np.random.default_rng([45, number]), scene(number)
    bands = [[3.7, 3.8]], [[10.5, 11.0]], [[3.7, 3.8], [10.5, 11.0]]
    overrides |= {
        "bands": bands[number % len(bands)],
        "image.columns": FEW_PIXELS,
        "image.rows": FEW_PIXELS,
        "image.pixel_size": float(random.choice([5.0, 20.0, 100.0, 500.0])),
        "platform.altitude": float(random.choice([1e5, 2e5, 7e5])),
        "time": f"2024-04-20T{int(random.integers(7, 17)):02d}:{int(random.integers(60)):02d}:00+10:00",
        "view.zenith": float(random.choice([10.0, 25.0, 45.0, 55.0])),
    }
    low = str(random.choice(["stratus", "cumulus"]))
    if random.random() < 0.7:
        coverage = overrides.pop("clouds.coverage")
        overrides["clouds.layers"] = [{"type": low, "coverage": coverage}, {"type": "cirrus", "coverage": 0.4}]
    return low, overrides


def check(number: int, rich: bool = False, **changes: Any) -> Mapping[str, Any]:
    """Return, of a scene: effects that are computed, those that are skipped, their bounds, and the largest change."""
    name, overrides = (rich_scene if rich else scene)(number)
    overrides |= changes
    plan = make_plan(Scenario.load(name, overrides))
    left = {omission.what: omission for omission in plan.omissions if omission.bound != 0.0}
    # A key that the scene gives cannot be switched on: another altitude would be another scene.
    switches = {what: keys for what, keys in SWITCHES.items() if not set(keys) & set(overrides)}
    skipped = {what: left[what] for what in switches if what in left and not left[what].decision and left[what].bound}
    stated = [omission.what for omission in plan.omissions]
    computed = [effect.kind for effect in plan.effects] + [what for what in BY_FIELDS if what not in stated]
    found = {
        "scene": number,
        "accuracy": plan.accuracy.relative,
        "computed": computed,
        "skipped": list(skipped),
        "bounds": float(sum(omission.bound for omission in skipped.values())),
    }
    if not skipped:
        return found
    switched = {key: value for what in skipped for key, value in switches[what].items()}
    off, off_error = radiance_of(plan)
    try:
        on, on_error = radiance_of(make_plan(Scenario.load(name, {**overrides, **switched})))
    except (ScenarioError, ProviderError) as error:
        return {**found, "refused": str(error)[:150]}
    error = off_error + on_error + ROUNDING
    change = np.abs(on / off - 1.0)
    return {
        **found,
        "change": float(change.max()),
        "error": error,
        "beyond bounds": int(np.count_nonzero(change > found["bounds"] + error)),
        "beyond accuracy": int(np.count_nonzero(change > found["accuracy"] + error)),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=SCENES, help="how many, from number 0")
    parser.add_argument("--rich", action="store_true", help="scenes that can have many effects")
    parser.add_argument("--keep", type=Path, help="file of rows, one for each scene; those in it are not run again")
    options = parser.parse_args()
    rows: dict[int, dict[str, Any]] = {}
    if options.keep is not None and options.keep.exists():
        rows = {row["scene"]: row for row in map(json.loads, options.keep.read_text(encoding="utf-8").splitlines())}
    for number in sorted(set(range(options.scenes)) - set(rows)):
        start = time.process_time()
        rows[number] = dict(check(number, options.rich))
        words = [
            f"{name}: {value:.2g}" if isinstance(value, float) else f"{name}: {value}"
            for name, value in rows[number].items()
        ]
        print(*words, f"{time.process_time() - start:.0f} s", sep="; ", flush=True)
        if options.keep is not None:
            with options.keep.open("a", encoding="utf-8") as file:
                file.write(json.dumps(rows[number]) + "\n")
    compared = [row for row in rows.values() if "change" in row]
    print(f"{len(compared)} of {len(rows)} scenes skip effects that can matter")
    for law in ("beyond bounds", "beyond accuracy"):
        print(f"{law}: {sum(row[law] > 0 for row in compared)} scenes")
    print(f"four effects or more computed: {sum(len(row['computed']) >= 4 for row in rows.values())} of {len(rows)}")


if __name__ == "__main__":
    main()
