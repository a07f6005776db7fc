"""What becomes of the atmospheres of ``airs.py``: absorber amounts against integration, a scene, or a refusal."""

import json
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from pathlib import Path

import numpy as np
from air_reference import slant_amount, vertical_amount
from airs import COUNT, bad_air, good_air

sys.path.append(str(Path(__file__).parents[2] / "tests" / "stability"))

from hang import Hang, limited

TOGETHER = 20
ZENITH_DEG = (60.0, 85.0, 88.0, 89.5, 89.98)
TOLERANCE = {60.0: 3e-5, 85.0: 5e-4, 88.0: 1e-3, 89.5: 1e-2, 89.98: 5e-2}
"""Relative, of amounts along a ray: a few times what cells with one slant factor cost in the standard atmosphere. The
most inclined node of 32 streams has 89.93 degrees."""

SCENE = """
time = 2020-09-06T12:45:00+00:00
place = {latitude = -16.0, longitude = 1.8}
image = {rows = 1, columns = 2}
frames.count = 1
sea = {temperature = 285.0, wind_speed = 6.0}
view.zenith = 85.0
bands = [[10.4, 10.6], [3.7, 3.8]]
output.certificate = 0
clouds = {type = "stratus", coverage = 0.5, base = 300.0, top = 700.0}
"""


def keys():
    """Return the rows: the first number of a few good and bad ones."""
    return [f"{kind} {first}" for kind in ("good", "bad") for first in range(0, COUNT, TOGETHER)]


def prepare():
    """Nothing is shared by rows."""


def scenario_of(air, folder):
    """Return the scenario of an atmosphere, with its file written."""
    from hcss_twin.scenario.scenario import Scenario

    if air.file is not None:
        (folder / "air.csv").write_text(air.file)
    return Scenario.from_toml(SCENE, {"atmosphere": dict(air.keys)}, base=folder)


def outcome_of(kind, number, folder, runs=True):
    """Return ``good`` or ``refused`` as expected, or what is wrong, and a message."""
    from hcss_twin.core.errors import HcssError, ScenarioError
    from hcss_twin.engine.simulate import simulate
    from hcss_twin.plan.make_plan import make_plan

    air = good_air(number) if kind == "good" else bad_air(number)
    try:
        with warnings.catch_warnings(), limited(120):
            warnings.simplefilter("error", RuntimeWarning)
            made = scenario_of(air, folder)
            if kind == "good":
                problem = wrong_amounts(made)
                if problem:
                    return "wrong", f"{number} {air.kind}: {problem}"
                if not runs:
                    return "good", ""
            cube = simulate(made) if kind == "good" else make_plan(made)
    except ScenarioError as error:
        said = all(each in str(error) for each in air.names)
        return ("refused" if kind == "bad" and said else "unexpected refusal"), f"{number} {air.kind}: {error}"
    except HcssError as error:
        return "blames", f"{number} {air.kind}: {error}"
    except (Exception, Hang) as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        return "escaped", f"{number} {air.kind}: {type(error).__name__} at {last.name}:{last.lineno}: {error}"
    if kind == "bad":
        return "accepted", f"{number} {air.kind}"
    sound = bool(np.all(np.isfinite(cube["radiance"].values)))
    return ("good" if sound else "unsound"), ""


def wrong_amounts(scenario):
    """Compare absorber amounts of the scene's air with an independent integration; return a problem or ''."""
    from hcss_twin.core.catalog import Catalog
    from hcss_twin.models.atmosphere.band_model.absorber_density import level_state
    from hcss_twin.models.atmosphere.band_model.absorption import read_coefficients
    from hcss_twin.models.atmosphere.band_model.layers import LayeredAir
    from hcss_twin.models.parameters import BandModelParameters
    from hcss_twin.physics.paths import SPACE, Leg, Path
    from hcss_twin.physics.profile import EARTH_RADIUS_M
    from hcss_twin.plan.surroundings import surroundings

    catalog = Catalog(base=scenario.base)
    profile = surroundings(scenario, catalog, None).profile
    coefficients = read_coefficients(catalog.find("band-model-rrtmgp", "atmospheres", ".nc"))
    state = level_state(profile, coefficients, BandModelParameters())
    air = LayeredAir(state, EARTH_RADIUS_M)
    level, count = state.altitude_m, coefficients.exponent.size
    columns = {"water": coefficients.channel_gas.index("h2o"), "air": count + 4, "haze": state.density.shape[1] - 5}
    top = float(level[-1])
    for lower in (0.0, 0.37 * float(level[1]), float(level[min(5, level.size - 2)]) + 0.01):
        legs = [Leg(lower, SPACE, zenith) for zenith in (0.0, *ZENITH_DEG)]
        amounts = air.amounts([Path((leg,)) for leg in legs])
        if not np.all(amounts[:, :count] >= 0.0) or not np.all(np.isfinite(amounts)):
            return f"amounts from {lower:g} m: negative or not finite"
        for name, column in columns.items():
            density = state.density[:, column]
            expected = vertical_amount(level, density, lower, top)
            if abs(amounts[0, column] - expected) > 1e-7 * expected + 1e-12:
                return f"{name} above {lower:g} m: {amounts[0, column]:.9g}, integrated {expected:.9g}"
            if name != "air":
                continue
            for row, zenith in enumerate(ZENITH_DEG, start=1):
                expected = slant_amount(level, density, state.refractivity, EARTH_RADIUS_M, lower, top, zenith)
                got = amounts[row, column]
                if expected is not None and abs(got / expected - 1.0) > TOLERANCE[zenith]:
                    return f"{name} from {lower:g} m at {zenith:g} deg: {got:.7g}, integrated {expected:.7g}"
    return ""


def compute(key):
    """Return the row of a key."""
    done = subprocess.run([sys.executable, __file__, *key.split()], capture_output=True, text=True)
    if done.returncode:
        return {"outcomes": {"crashed": 1}, "problems": [done.stderr[-400:]]}
    return json.loads(done.stdout.splitlines()[-1])


def _compute_here(kind, first):
    outcomes, problems = Counter(), []
    for number in range(first, first + TOGETHER):
        with tempfile.TemporaryDirectory() as temporary:
            outcome, message = outcome_of(kind, number, Path(temporary), runs=False)
        outcomes[f"{kind}: {outcome}"] += 1
        if outcome not in ("good", "refused"):
            problems.append(f"{outcome} {message}"[:400])
    print(json.dumps({"outcomes": outcomes, "problems": problems}))


def summary(rows):
    """Return lines of text: outcomes and problems."""
    yield str(dict(sorted(sum((Counter(row["outcomes"]) for row in rows.values()), Counter()).items())))
    yield from (f"  {problem}" for row in rows.values() for problem in row["problems"])


if __name__ == "__main__":
    _compute_here(sys.argv[1], int(sys.argv[2]))
