"""Every number of a scenario at the ends of its stated limits, just beyond them, and several ends together.

At an end a scene runs, or is refused with the name of a key: no model is blamed, nothing else is raised and numpy does
not warn. Beyond an end the message has the key, the value and what is allowed. Numbers without a limit are tried at
1e30 and 1e300, and numbers that must exceed 0 at 1e-30 and 1e-300. Each row is one of :data:`PARTS`, in one process.
"""

import itertools
import json
import math
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[2] / "tests" / "stability"))

from hang import Hang, limited
from schema_keys import COARSE, COMPANIONS, context_of, leaves, parameters_of

TOGETHER_ENDS = 200
"""Random scenarios with several keys at their ends."""

PARTS = {"open": 1, "together": 2, "closed": 3, "beyond": 1}
"""Values without a limit or near 0, several ends, other ends, values beyond; of each part every so many are tried."""

_OPEN = (1e-300, 1e-30, 1e30, 1e300, float(2**31), float(2**63))

LARGEST = 40_000
"""Points (rows, columns, frames, samples) of scenes that are run; others are planned only."""

_LIMITS = {"minimum": (-1, False), "exclusiveMinimum": (-1, True), "maximum": (1, False), "exclusiveMaximum": (1, True)}

SCENE = {
    "time": "2024-04-20T12:30:00Z",
    "place": {"latitude": 20.0, "longitude": -40.0},
    "image": {"rows": 3, "columns": 3, "pixel_size": 100.0},
    "frames": {"count": 1},
    "accuracy": 1e-2,
    "bands": [[10.5, 10.6]],
    "sea": {"model": "cox-munk", "temperature": 290.0, "wind_speed": 8.0},
    "clouds": {"type": "stratus", "coverage": 0.5},
    "optics": COARSE,
    "radiance": {"model": "as-printed"},
    "output": {"variables": ["radiance"], "certificate": 0},
}
"""A scene that costs a tenth of a second."""

WORDS = {
    "motion.platform_speed": ([-1e5, 1e5], [-1.0001e5, 1.0001e5, math.nan]),
    "motion.evolution_time": ([1e-3, 1e12], [0.99e-3, 1.001e12, -1.0]),
    "clouds.temperature": ([150.0, 350.0], [149.9, 350.1, math.inf]),
    "accuracy": ([1e-6, 0.1, "1 mK", "10 K"], [0.9e-6, 0.11, "0.9 mK", "10.1 K", 0.0]),
    **{
        f"atmosphere.gases.{gas}": (
            [1e-300, 100.0, "1e-300 ppm", "1e5 ppm", "1e9 ppb"],
            [0.0, 100.1, "-1 ppm", "1e400 ppm"],
        )
        for gas in ("CO2", "CH4", "N2O", "O3", "CO")
    },
    "bands.0": (
        [[0.7001, 0.7002], [14.29, 14.3], [10.5, 10.5000001], [0.75, 14.3]],
        [[10.5, 10.5], [11, 10], [0, 1], [1e-300, 1e300]],
    ),
}  # fmt: skip
"""Values inside and outside the limits of keys that the JSON schema has no bounds for."""


@cache
def trials():
    """Return the trials within limits and beyond them: (name, value, context)."""
    inside, beyond = [], []
    for name, leaf, context in itertools.chain(leaves(json_schema(), ""), parameters_of(None)):
        if leaf.get("type") in ("number", "integer"):
            own = context_of(name) if context is None else context
            for side, values in zip((inside, beyond), _ends(leaf), strict=True):
                side += [(name, value, own) for value in values]
    for name, both in WORDS.items():
        for side, values in zip((inside, beyond), both, strict=True):
            side += [(name, value, context_of(name)) for value in values]
    return inside, beyond


def json_schema():
    """Return the schema of scenarios with those of sections that plugins own."""
    from hcss_twin.scenario import reference

    return reference.json_schema()


def _ends(leaf):
    """Return values at the ends of a number's limits, and beyond them."""
    whole = leaf["type"] == "integer"
    inside, beyond, signs = [], [], {-1, 1}
    for name, (sign, is_open) in _LIMITS.items():
        if name not in leaf:
            continue
        signs.discard(sign)
        bound = leaf[name]
        if not whole:
            bound = float(bound)
        within = bound - sign if whole else math.nextafter(bound, -sign * math.inf)
        outer = bound + sign if whole else math.nextafter(bound, sign * math.inf)
        beyond.append(bound if is_open else outer)
        if is_open and bound == 0.0 and not whole:
            inside += [1e-300, 1e-30]
        else:
            inside.append(within if is_open else bound)
    inside += [sign * each for sign in sorted(signs) for each in ((2**31, 2**63) if whole else (1e30, 1e300))]
    beyond += [1.5] if whole else [math.nan, math.inf]
    return inside, beyond


def together(number):
    """Return several trials within limits that need the same sections."""
    draw = np.random.default_rng([42, number])
    groups = {}
    for trial in trials()[0]:
        groups.setdefault(repr(trial[2]), []).append(trial)
    largest = [own for own in groups.values() if len({name for name, *_ in own}) > 1]
    own = largest[int(draw.integers(len(largest)))]
    names = sorted({name for name, *_ in own})
    chosen = draw.choice(names, min(len(names), int(draw.integers(2, 5))), replace=False)
    return [
        [each for each in own if each[0] == name][int(draw.integers(sum(n == name for n, *_ in own)))]
        for name in chosen
    ]


def part_of(name):
    """Return the trials of a part, each a list of (name, value, context)."""
    inside, beyond = trials()
    if name == "together":
        every = [together(number) for number in range(TOGETHER_ENDS)]
    else:
        chosen = beyond if name == "beyond" else [each for each in inside if _is_open(each[1]) == (name == "open")]
        every = [[each] for each in chosen]
    return every[:: PARTS[name]]


def _is_open(value):
    return isinstance(value, int | float) and abs(float(value)) in _OPEN


def keys():
    """Return the names of the parts."""
    return list(PARTS)


def prepare():
    """Nothing is shared by rows."""


def scene_of(own):
    """Return raw scenario and overrides of trials."""
    raw = {**SCENE, **own[0][2]}
    if "radiance" not in own[0][2] and any(name.startswith("slant") for name, *_ in own):
        raw["radiance"] = {"model": "as-printed"}
    for section in ("image", "output", "frames"):
        given = own[0][2].get(section, {})
        raw[section] = {**SCENE[section], **({"derived": given} if isinstance(given, list) else given)}
    if any(name.startswith("image.pixel_size") for name, *_ in own) or "detector_pitch" in str(raw.get("platform")):
        raw["image"].pop("pixel_size", None)
    overrides = {}
    for name, value, _ in own:
        key = name.partition(" of ")[0]
        overrides[key] = value
        overrides |= next((more for known, more in COMPANIONS.items() if repr(known) == repr((key, value))), {})
    return raw, overrides


def outcome_of(own, within, folder):
    """Return the outcome of trials (``runs``, ``planned``, ``refused``, or what is wrong) and a message."""
    from hcss_twin.core.errors import HcssError, ProviderDefect, ScenarioError
    from hcss_twin.engine.simulate import simulate
    from hcss_twin.plan.make_plan import make_plan
    from hcss_twin.scenario.scenario import Scenario

    raw, overrides = scene_of(own)
    names = {name: value for name, value, _ in own}
    with warnings.catch_warnings(record=True) as warned, limited(120):
        warnings.simplefilter("always")
        try:
            made = Scenario.from_dict(raw, overrides, base=folder)
            make_plan(made)
            points = made.image.rows * made.image.columns * made.frames.count * made.image.samples_per_pixel**2
            if points <= LARGEST:
                cube = simulate(made)
                radiance = cube["radiance"].values if "radiance" in cube else np.zeros(1)
                outcome, message = ("runs" if np.all(np.isfinite(radiance)) else "unsound"), ""
            else:
                outcome, message = "planned", ""
        except ScenarioError as error:
            outcome, message = _refusal(error, names, within), str(error)
        except ProviderDefect as error:
            outcome, message = "blames", str(error)
        except HcssError as error:
            outcome, message = "no key", str(error)
        except (Exception, Hang) as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            outcome, message = "escaped", f"{type(error).__name__} at {last.name}:{last.lineno}: {error}"
    numeric = [str(each.message) for each in warned if issubclass(each.category, RuntimeWarning)]
    if numeric and outcome in ("runs", "planned", "refused"):
        outcome, message = "warns", numeric[0]
    if not within and outcome in ("runs", "planned"):
        outcome = "accepted"
    return outcome, f"{names}: {message}"[:400]


def _refusal(error, names, within):
    """Judge a refusal: beyond a limit it must have the key, the value and what is allowed."""
    if within:
        return "refused" if all(each.field and each.field != "scenario" for each in error.problems) else "no key"
    ((name, value),) = names.items()
    last = name.partition(" of ")[0].rpartition(".")[2]
    for each in error.problems:
        if last in f"{each.field} {each.message}" or (last == "0" and "bands[0]" in each.field):
            said = (
                f"{value:g}"[:6] in each.message or str(value)[:6] in each.message if isinstance(value, float) else True
            )
            return "refused" if said and ("allowed" in each.message or "whole number" in each.message) else "half said"
    return "other key"


GOOD = ("runs", "planned", "refused")


def compute(key):
    """Return the row of a key."""
    done = subprocess.run([sys.executable, __file__, key], capture_output=True, text=True)
    if done.returncode:
        return {"outcomes": {"crashed": 1}, "problems": [done.stderr[-400:]]}
    return json.loads(done.stdout.splitlines()[-1])


def _compute_here(part):
    from schema_scenarios import write_files

    outcomes, problems = Counter(), []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        write_files(folder)
        for own in part_of(part):
            outcome, message = outcome_of(own, part != "beyond", folder)
            outcomes[outcome] += 1
            if outcome not in GOOD:
                problems.append(f"{outcome} {message}")
    print(json.dumps({"outcomes": outcomes, "problems": problems}))


def summary(rows):
    """Return lines of text: outcomes and problems."""
    yield from (f"{name}: {row['outcomes']}" for name, row in rows.items())
    yield from (f"  {problem}" for row in rows.values() for problem in row["problems"])


if __name__ == "__main__":
    _compute_here(sys.argv[1])
