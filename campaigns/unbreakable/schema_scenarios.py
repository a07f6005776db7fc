"""A thousand random scenarios that together set every key of a scenario, on both sides of each of its bounds.

Scenario number n is a random one of the campaign ``random_scenarios``, smaller, with one trial of ``schema_keys.py``.
A value outside a bound must be refused with the name of its key; all else is planned, and every fifth scenario that is
small is run. Random scenarios are valid or nearly so (some have more water vapour than air can hold): a refused one is
drawn again, up to :data:`DRAWS` times, and each refusal is noted. Rows have :data:`TOGETHER` scenarios, computed in one
process.
"""

import json
import resource
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from pathlib import Path

import numpy as np
import xarray as xr

sys.path.append(str(Path(__file__).parents[1] / "random_scenarios"))
sys.path.append(str(Path(__file__).parents[2] / "tests" / "stability"))

from hang import Hang, limited
from schema_keys import COMPANIONS, groups, trials

COUNT = 1000
TOGETHER = 20
MEMORY = 8 * 2**30
RUN_EVERY = 5
DRAWS = 4
LARGEST = 1024
"""Pixels and frames of scenarios that are run."""


def keys():
    """Return the first number of each row, as text."""
    return [str(first) for first in range(0, COUNT, TOGETHER)]


def prepare():
    """Nothing is shared by rows."""


def write_files(folder):
    """Write the files that trials name."""
    from hcss_evaluate.database.cloud_import import ImportOptions, import_image
    from input_files import noise, write_airs
    from surface_files import write_half

    image = np.kron(noise(), np.ones((2, 2)))
    np.save(folder / "image.npy", image)
    np.savez(folder / "image.npz", a=image)
    xr.Dataset({"a": (("time", "y", "x"), np.stack([image, image]))}).to_netcdf(folder / "stack.nc")
    y, x = np.mgrid[:80, :80]
    clouds = sum(np.exp(-((y - row) ** 2 + (x - column) ** 2) / 60.0) for row, column in ((20, 20), (55, 30), (40, 62)))
    np.save(folder / "clouds.npy", clouds)  # whole ones
    import_image(folder / "clouds.npy", ImportOptions(pixel_size_m=100.0)).write(folder / "entry.nc")
    (folder / "response.csv").write_text("wavelength_um,response\n10,0\n10.5,1\n11,0.5\n12,0\n")
    (folder / "psf.txt").write_text("0 1 0\n1 4 1\n0 1 0\n")
    (folder / "tracks.csv").write_text("source,time,x,y,altitude,intensity\n1,0,0,0,0,5\n1,1000,10,0,0,5\n")
    write_half(folder / "raster.nc", temperature=lambda latitude, longitude: 280.0 + latitude - 35.0)
    write_airs(folder)


def scenario_of(number, folder, attempt=0):
    """Return trials, raw scenario and overrides of a number."""
    from random_scenario_draws import random_raw

    inside, beyond = groups()
    own = [*inside, *beyond][number] if number < len(inside) + len(beyond) else inside[number % len(inside)]
    draw = np.random.default_rng([20, number])
    raw = random_raw(number, attempt, folder, "as-printed")
    raw["image"] |= {"rows": int(draw.integers(1, 9)), "columns": int(draw.integers(1, 9))}
    raw["frames"]["count"] = 2
    raw["output"]["certificate"] = 2
    raw["accuracy"] = 1e-2
    overrides = {trial.key.partition(" of ")[0]: trial.value for trial in own}
    if own[0].side == "inside":
        ((key, value),) = overrides.items()
        # Values may be lists, and True equals 1.
        overrides |= next((more for known, more in COMPANIONS.items() if repr(known) == repr((key, value))), {})
    return own, raw | own[0].context, overrides


def outcome_of(number, folder):
    """Compute a scenario, or another draw of it if it is refused though no value is beyond its bounds.

    Returns
    -------
    outcome, touched, message
        ``accepted``, ``refused``, or if something is wrong ``escaped`` or ``wrong``; the names of what was touched;
        what went wrong, or the refusals of all draws.
    """
    touched, messages = set(), []
    for attempt in range(DRAWS):
        outcome, own, message = _outcome_of(number, folder, attempt)
        touched.update(own)
        messages += [message] if message else []
        if outcome != "refused" or not message:
            break
    return outcome, sorted(touched), "; ".join(dict.fromkeys(messages))


def _outcome_of(number, folder, attempt):
    from hcss_twin.core.errors import HcssError, ScenarioError
    from hcss_twin.engine.simulate import simulate
    from hcss_twin.plan.make_plan import make_plan
    from hcss_twin.scenario.scenario import Scenario

    own, raw, overrides = scenario_of(number, folder, attempt)
    names = [trial.name for trial in own]
    problems = []
    try:
        with warnings.catch_warnings(), limited():
            warnings.simplefilter("ignore")
            made = Scenario.from_dict(raw, overrides, base=folder)
            make_plan(made)
            if own[0].side == "outside":
                return "wrong", [], f"accepted: {overrides}"
            image = made.image
            points = image.rows * image.columns * made.frames.count * image.samples_per_pixel**2
            if number % RUN_EVERY == 0 and points <= LARGEST:
                return _judge(simulate(made), names)
    except ScenarioError as error:
        problems, message = list(error.problems), str(error)
    except HcssError as error:
        message = str(error)
    except (Exception, Hang) as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        return "escaped", [], f"{names}: {type(error).__name__} at {last.name}:{last.lineno}: {error}"[:300]
    else:
        return "accepted", names, ""
    if own[0].side == "outside":
        named = [each.name for each in own if _concerned(problems, each.key)]
        return ("refused", named, "") if len(named) == len(own) else ("wrong", named, f"{names}: {message}"[:400])
    # A refusal for other reasons than the value leaves it touched.
    value = own[0].value
    touched = [] if any(f"{value}" in each for each in _concerned(problems, own[0].key)) and not own[0].end else names
    return "refused", touched, f"{names} = {value!r}: {message}"[:300]


def _concerned(problems, key):
    """Return the messages of problems that name a key, with or without the number of a single layer."""

    def plain(text):
        text = text.partition(" of ")[0].replace("[", ".").replace("]", "").replace(".layers.0", "")
        return text.replace(".0", "").replace(".parameters", "")

    last = key.partition(" of ")[0].rpartition(".")[2]
    return [
        each.message
        for each in problems
        if plain(each.field).startswith(plain(key))
        or (plain(key).startswith(plain(each.field)) and last in each.message)
    ]


def _judge(cube, names):
    radiance = cube["radiance"].values if "radiance" in cube else np.zeros(1)
    sound = bool(np.all(np.isfinite(radiance)) and np.all(radiance >= 0.0))
    return ("accepted", names, "") if sound else ("wrong", names, f"{names}: radiance that is not finite or negative")


def compute(key):
    """Return the row of a key."""
    done = subprocess.run([sys.executable, __file__, key], capture_output=True, text=True)
    if done.returncode:
        return {"outcomes": {"crashed": 1}, "touched": [], "problems": [done.stderr[-400:]], "refusals": []}
    return json.loads(done.stdout.splitlines()[-1])


def _compute_here(first):
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    outcomes, touched, problems, refusals = Counter(), set(), [], []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        write_files(folder)
        for number in range(first, min(first + TOGETHER, COUNT)):
            outcome, own, message = outcome_of(number, folder)
            outcomes[outcome] += 1
            touched.update(own)
            if message:
                (problems if outcome in ("wrong", "escaped") else refusals).append(f"{number} {message}")
    print(json.dumps({"outcomes": outcomes, "touched": sorted(touched), "problems": problems, "refusals": refusals}))


def summary(rows):
    """Return lines of text: outcomes, and keys and bounds that no scenario has touched."""
    every, without = trials()
    counts = sum((Counter(row["outcomes"]) for row in rows.values()), Counter())
    touched = {name for row in rows.values() for name in row["touched"]}
    wanted = {trial.name for trial in every} | set(without)
    total = counts.total() or 1
    yield f"{counts.total()} scenarios: {dict(counts)}, {counts['accepted'] / total:.0%} accepted"
    bounds = {trial.name for trial in every if trial.end}
    sides = f"{len(touched & bounds)} of {len(bounds)} sides of bounds"
    yield f"touched: {len(touched - bounds)} of {len(wanted - bounds)} keys, {sides}"
    yield from (f"  not touched: {name}" for name in sorted(wanted - touched))
    yield from (f"  {problem}" for row in rows.values() for problem in row["problems"])


if __name__ == "__main__":
    _compute_here(int(sys.argv[1]))
