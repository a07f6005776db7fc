"""Does what ``auto`` skips stay within its bounds? Random scenes against the same with all effects on.

::

    python benchmarks/auto_against_on.py                       # 40 scenes: an hour
    python benchmarks/auto_against_on.py --only 3 7 --seed 44  # some scenes again

Scenes are those of ``random_accuracy.py``, all kinds in turn, with fractal clouds, narrow bands and the radiance model
``as-printed``: the effects are not the model's. The plan decides for an accuracy of 1 % or .1 % which effects
of :data:`EFFECTS` it skips, and states a bound of each. The scene is then computed for a tenth of that accuracy with
these effects off, with each alone, and with all of them: no pixel may change by more than the bound of the effect
alone, and by more than the accuracy by all together, beside the errors of the tables. An effect is computed if the plan
neither skips nor leaves it out.
"""

from __future__ import annotations

import argparse
import copy
import itertools
import sys
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from feature_pairs import put, remove
from random_accuracy import KINDS, scenario

from hcss_twin import Scenario, make_plan
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import HcssError
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import stream
from hcss_twin.plan.few_columns import SKIP_SHARE

EFFECTS: Mapping[str, tuple[str, Any, Any]] = {
    "shadows of clouds on the sea": ("slant.shadows", "on", "off"),
    "parallax of clouds": ("slant.parallax", "on", "off"),
    "waves as shapes": ("sea.waves", "on", "off"),
    "texture of the sea's temperature": ("sea.temperature_texture", 0.3, 0.0),
    "texture of water vapour": ("atmosphere.water_vapour_texture", 0.05, 0.0),
    "view angles of single pixels": ("platform.altitude", 8e5, None),
    "sun angles of single pixels": ("platform.altitude", 8e5, None),
}
"""Key of each effect as plans call it, and its values on and off (None: without it); one key may bring two effects."""

CHEAP = {"bands": ["mwir-3.7", "lwir-10.8"], "radiance": {"model": "as-printed"}, "output": {"certificate": 0}}

FINER = 0.1
"""Accuracy of the cubes that are compared, of that for which effects are skipped."""


def radiance(raw: Mapping[str, Any], skipped: Mapping[str, float], on: set[str]) -> tuple[Array, float]:
    """Return the radiance of the first frame (B, y, x) with some of the skipped effects on, and the tables' error."""
    changed = copy.deepcopy(dict(raw)) | {"accuracy": FINER * raw["accuracy"]}
    for what in (*(each for each in skipped if each not in on), *on):  # several effects may have one key
        key, value, without = EFFECTS[what]
        chosen = value if what in on else without
        if chosen is None:
            remove(changed, key)
        else:
            put(changed, key, chosen)
    plan = make_plan(Scenario.from_dict(changed))
    tables = tables_of(plan)
    frame = next(iter(stream(plan, tables, frames=[0])))
    return frame["radiance"].astype(np.float64), float(tables.estimated_error)


def change(one: Array, other: Array) -> float:
    """Return the largest relative change of a pixel in any band."""
    return float(np.nanmax(np.abs(one - other) / np.where(other > 0.0, other, np.inf)))


def compare(number: int, seed: int) -> tuple[int, bool]:
    """Print what a scene skips and how that changes it; return how many it computes, and whether it is right."""
    kind, accuracy = KINDS[number % len(KINDS)], (1e-2, 1e-3)[number // len(KINDS) % 2]
    raw = {**scenario(kind, number, seed), **CHEAP, "accuracy": accuracy}
    for layer in raw["clouds"]["layers"]:
        layer["generator"] = "fractal"
    omissions = {item.what: item for item in make_plan(Scenario.from_dict(copy.deepcopy(raw))).omissions}
    skipped = {
        what: item.bound
        for what, item in omissions.items()
        if what in EFFECTS and item.bound is not None and item.bound <= SKIP_SHARE * accuracy
    }
    others = {EFFECTS[what][0] for what in omissions if what in EFFECTS and what not in skipped}
    skipped = {what: bound for what, bound in skipped.items() if EFFECTS[what][0] not in others}
    computed, right = sum(what not in omissions for what in EFFECTS), True
    print(f"{number} {kind}, {accuracy:g}: {computed} effects computed, {len(skipped)} skipped", flush=True)
    without, error = radiance(raw, skipped, set()) if skipped else (np.zeros(0), 0.0)
    together = [set(skipped)] if len(skipped) > 1 else []
    for on in [{what} for what in skipped] + together:
        name = " + ".join(sorted(on))
        try:
            changed, other_error = radiance(raw, skipped, on)
        except HcssError as refusal:
            print(f"    {name}: cannot be switched on: {' '.join(str(refusal).split())[:160]}")
            continue
        most, allowed = change(changed, without), accuracy if len(on) > 1 else skipped[min(on)]
        wrong = most > allowed + error + other_error
        right = right and not wrong
        print(
            f"    {'WRONG ' * wrong}{name}: {most:.2g}, {allowed:.2g} allowed, {error + other_error:.1g} for tables",
            flush=True,
        )
    return computed, right


def main() -> int:
    """Print the scenes and the counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--number", type=int, default=40, help="of scenes")
    parser.add_argument("--only", type=int, nargs="+", help="these alone")
    parser.add_argument("--seed", type=int, default=44)
    parser.add_argument("--seconds", type=float, default=np.inf, help="processor time after which no scene is begun")
    given = parser.parse_args()
    numbers = itertools.takewhile(
        lambda _: time.process_time() < given.seconds, given.only if given.only else range(given.number)
    )
    results = [compare(number, given.seed) for number in numbers]
    many, right = sum(computed >= 4 for computed, _ in results), sum(fine for _, fine in results)
    print(
        f"{len(results)} scenes: {many} compute four effects or more; what is skipped is within its bounds in {right}"
    )
    return int(right < len(results))


if __name__ == "__main__":
    sys.exit(main())
