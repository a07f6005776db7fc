"""How many random scenes are as accurate as was asked, by their certificates?

    python benchmarks/random_accuracy.py                                     # an hour
    python benchmarks/random_accuracy.py --number 10 --accuracies 1e-4
    python benchmarks/random_accuracy.py --kinds glory --only 4 --accuracies 1e-3   # a scene again, in full
    python benchmarks/random_accuracy.py --kinds combination --number 100   # five features at random in each scene

Scenes have one or two layers of any type, by day or night, any profile, aerosol and wind, views to 60 deg, suns to 80.
Others are near what few streams resolve badly: within 5 deg of the glory, the cloudbow or the glint, or with view or
sun between 75 and 85 deg. Scene n of a kind is always the same, at any accuracy. The reference of a certificate is one
level finer in streams, moments, azimuth, grid and heights. A scene counts as noticed if its plan says that no level is
fine enough, or its tables estimate a larger error. ``campaigns/random_scenarios`` has other scenes and a reference that
shares no code with certificates, but takes hours.
"""

from __future__ import annotations

import argparse
import atexit
import functools
import json
import math
import re
import shutil
import tempfile
import time
import warnings
from collections.abc import Mapping
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.core.errors import CertificateWarning, HcssError
from hcss_twin.physics.geometry import scattering_cosine
from hcss_twin.physics.sun import sun_position

SEED, PIXELS = 20240620, 12
KINDS = ("one layer", "two layers", "one layer, night", "two layers, night", "glory", "cloudbow", "glint", "grazing")
COMBINATION, FEATURES = "combination", 5
"""A kind of its own, which needs the packages of ``feature_pairs.py``: so many of its features in one scene."""
NEAR_DEG, BOW_DEG = 5.0, 140.0
LOW, HIGH = ("stratus", "cumulus", "stratocumulus"), ("cirrus", "altocumulus", "altostratus")
PROFILES = (
    "tropical",
    "us-standard-1976",
    *(f"{a}-{b}" for a in ("midlatitude", "subarctic") for b in ("summer", "winter")),
)
AEROSOLS = ("none", "maritime", "rural")
WITHIN = {1e-2: 0.99, 1e-3: 0.98, 1e-4: 0.95}
"""Share of scenes that must be as accurate as asked."""


@functools.cache
def known_features() -> Mapping[str, Any]:
    """Features by name, with the files that some need, which last as long as the process."""
    from feature_pairs import features, write_inputs

    folder = Path(tempfile.mkdtemp(prefix="hcss-features-"))
    atexit.register(shutil.rmtree, folder)
    write_inputs(folder)
    return features(folder)


def combination(number: int) -> tuple[str, ...]:
    """Return the names of features that can be combined: the first draw in which no two exclude each other."""
    from feature_pairs import are_alternatives, why_meaningless

    random, known = np.random.default_rng([SEED, len(KINDS), number]), known_features()
    while True:
        names = tuple(map(str, random.choice([*known], FEATURES, replace=False)))
        excluded = why_meaningless(names) is not None or are_alternatives([known[name] for name in names])
        if "mask alone" not in names and not excluded:
            return names


def combined(number: int) -> dict[str, Any]:
    """Keys of a scene with a combination; every second one computes radiance by the default model."""
    from feature_pairs import scene

    made = scene([known_features()[name] for name in combination(number)], {"output.certificate": 2 * PIXELS})
    del made["accuracy"]
    if number % 2 and made["radiance"].get("model") == "as-printed":
        del made["radiance"]["model"]
    return made


def scenario(kind: str, number: int) -> dict[str, Any]:
    """Keys of a scene, but for its accuracy."""
    if kind == COMBINATION:
        return combined(number)
    random = np.random.default_rng([SEED, KINDS.index(kind), number])
    place, moment, zenith, azimuth = _geometry(kind, random)
    count = 2 if kind.startswith("two") else 1 + int(kind not in KINDS[:4] and random.random() < 0.25)
    types = [random.choice(LOW), random.choice(HIGH)]
    if count == 1:
        types = [random.choice(types)]
    return {
        "place": place,
        "time": moment.isoformat(),
        "seed": int(random.integers(1000)),
        "view": {"zenith": zenith, "azimuth": azimuth},
        "image": {"rows": 32, "columns": 32, "pixel_size": 100.0},
        "bands": [[2.7, 3.0], [3.0, 5.0], [8.0, 14.0]],
        "clouds": {"layers": [{"type": str(t), "coverage": float(random.uniform(0.3, 0.9))} for t in types]},
        "sea": {
            "temperature": float(random.uniform(274.0, 303.0)),
            "wind_speed": float(random.uniform(1.0, 15.0)),
            "wind_from": float(random.uniform(0.0, 360.0)),
        },
        "atmosphere": {
            "profile": str(random.choice(PROFILES)),
            "parameters": {"aerosol": str(random.choice(AEROSOLS))},
        },
        "output": {"certificate": PIXELS},
    }


def _geometry(kind: str, random: np.random.Generator) -> tuple[dict[str, float], datetime, float, float]:
    """Place, time, and zenith and azimuth of the view: the first draw that is of the kind."""
    while True:
        place = {"latitude": float(random.uniform(-60.0, 60.0)), "longitude": float(random.uniform(-180.0, 180.0))}
        moment = datetime(2024, 1, 1, tzinfo=UTC) + timedelta(minutes=int(random.integers(0, 366 * 1440)))
        sun, bearing, _ = (float(x[0]) for x in sun_position([moment], *place.values()))
        grazing = kind == "grazing"
        side = random.random() < 0.5
        zenith = float(random.uniform(75.0, 85.0) if grazing and side else random.uniform(0.0, 60.0))
        turned = float(random.uniform(0.0, 360.0))
        if kind in ("glory", "glint"):  # else hardly any draw would be of the kind
            zenith = float(np.clip(sun + random.uniform(-NEAR_DEG, NEAR_DEG), 0.0, 60.0))
            turned = float(random.uniform(-20.0, 20.0) + (180.0 if kind == "glint" else 0.0))
        turn = math.radians(abs((turned + 180.0) % 360.0 - 180.0))
        cosines = math.cos(math.radians(zenith)), math.cos(math.radians(sun))
        angle = math.degrees(math.acos(scattering_cosine(*cosines, turn)))
        mirrored = math.degrees(math.acos(-scattering_cosine(*cosines, math.pi - turn)))
        wanted = {
            "glory": sun < 80.0 and angle > 180.0 - NEAR_DEG,
            "cloudbow": sun < 80.0 and abs(angle - BOW_DEG) < NEAR_DEG,
            "glint": sun < 80.0 and mirrored < NEAR_DEG,
            "grazing": sun < 80.0 if side else 75.0 < sun < 85.0,
        }
        if wanted.get(kind, sun > 95.0 if kind.endswith("night") else sun < 80.0):
            return place, moment, zenith, (bearing + turned) % 360.0


def run(kind: str, number: int, accuracy: float, whole: bool = False) -> dict[str, Any] | None:
    """Return what the certificate of a scene says; None if the scene is refused."""
    start = time.process_time()
    try:
        made = Scenario.from_dict({**scenario(kind, number), "accuracy": accuracy})
        plan = make_plan(made)
        certificate = simulate(made).attrs
    except HcssError as error:
        print(f"{kind} {number}: refused: {' '.join(str(error).split())[:300]}", flush=True)
        return None
    achieved = json.loads(certificate["hcss_accuracy_achieved"])
    text = str(certificate["hcss_certificate"])
    estimated = re.search(r"estimated ([\d.e+-]+)", text)
    noticed = not plan.numerics.enough or (estimated is not None and float(estimated[1]) > accuracy)
    worst = max(achieved, key=lambda band: achieved[band])
    row = {"ratio": achieved[worst] / accuracy, "noticed": noticed, "passed": text.startswith("PASSED")}
    level = f"level {plan.numerics.level} + {plan.numerics.sunlight_steps}"
    seconds = time.process_time() - start
    print(f"{accuracy:g} {kind} {number}: {row['ratio']:.2f} in {worst}, {level}, noticed {noticed}, {seconds:.0f} s")
    if kind == COMBINATION:
        print(f"    {' + '.join(combination(number))}", flush=True)
    print(text if whole else "", end="", flush=True)
    return row


def main() -> None:
    """Print each scene as it is known, and a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--number", type=int, default=8, help="of scenes of each kind")
    parser.add_argument("--kinds", nargs="+", choices=(*KINDS, COMBINATION), default=KINDS)
    parser.add_argument("--accuracies", type=float, nargs="+", choices=list(WITHIN), default=[1e-2, 1e-3])
    parser.add_argument("--only", type=int, help="this number of each kind")
    given = parser.parse_args()
    warnings.simplefilter("ignore", CertificateWarning)
    numbers = range(given.number) if given.only is None else [given.only]
    found = {
        (accuracy, kind, number): run(kind, number, accuracy, given.only is not None)
        for accuracy in given.accuracies
        for number in numbers
        for kind in given.kinds
    }
    rows = {key: row for key, row in found.items() if row is not None}
    print(
        f"{'accuracy':10}{'kind':20}{'scenes':>7}{'within':>8}{'beyond twice':>14}{'unnoticed':>11}  worst, its ratio"
    )
    for accuracy in given.accuracies:
        for kind in (*given.kinds, "all"):
            some = {key: row for key, row in rows.items() if key[0] == accuracy and kind in (key[1], "all")}
            if not some:
                continue
            worst = max(some, key=lambda key: float(some[key]["ratio"]))
            twice = [row for row in some.values() if row["ratio"] > 2.0]
            counts = len(some), sum(row["passed"] for row in some.values()), len(twice)
            unnoticed = sum(not row["noticed"] for row in twice)
            of = f"{worst[1]} {worst[2]}, {some[worst]['ratio']:.2f}"
            print(f"{accuracy:<10g}{kind:20}{counts[0]:7d}{counts[1]:8d}{counts[2]:14d}{unnoticed:11d}  {of}")
        print(f"{accuracy:g}: at least {100.0 * WITHIN[accuracy]:g} % must be within, and none beyond twice unnoticed")


if __name__ == "__main__":
    main()
