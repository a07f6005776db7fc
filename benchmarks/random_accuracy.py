"""How many random scenes are as accurate as was asked, against the finest numerics?

    python benchmarks/random_accuracy.py --keep rows.jsonl                   # 8 scenes of each kind: hours
    python benchmarks/random_accuracy.py --kinds combination --number 100 --seed 44 --keep rows.jsonl
    python benchmarks/random_accuracy.py --kinds glory --only 4 --accuracies 1e-3   # a scene again
    python benchmarks/random_accuracy.py --kinds combination --seed 44 --keep rows.jsonl --summary

Scenes have one or two layers of any type, by day or night, any profile, aerosol and wind, views to 60 deg, suns to 80.
Others are near what few streams resolve badly: within 5 deg of the glory, the cloudbow or the glint, or with view or
sun between 75 and 85 deg. A combination has five features of ``feature_pairs.py``, and anything else at random; one in
three by day looks into the glint, and all sunlit combinations do. Scene n of a kind and seed is always the same, at any
accuracy.

The reference of a pixel is its exact column at the finest level of the radiance model and on the finest spectral grid,
at the thickness of its own clouds, without tables. At least a third of the pixels are at edges of clouds, at edges of
shadows and in the glint, where there are any. A scene beyond its accuracy is noticed if the plan finds no level fine
enough, the tables estimate a larger error, or the certificate of the run, whose reference is one level finer, fails.

Rows go to the file of ``--keep`` as they are found; those that are there are not computed again. Beside it, in a folder
of the same name, lie the scenarios beyond their accuracy. A scene that takes longer than ``--limit`` is listed as
such, not tried at finer accuracies, and tried again with a larger limit.
``campaigns/random_scenarios`` has other scenes and a reference that shares no code with certificates.

Combinations need hcss-examples, hcss-light, hcss-payload and hcss-skies.
"""

from __future__ import annotations

import argparse
import atexit
import functools
import json
import math
import shutil
import signal
import tempfile
import time
import traceback
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime, timedelta
from itertools import zip_longest
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray

from hcss_twin import Scenario, make_plan
from hcss_twin.core.errors import HcssError
from hcss_twin.engine.certificate import clear_points, reference_columns
from hcss_twin.engine.certificate.certificate import SHADED, Certificate
from hcss_twin.engine.certificate.certificate_pixels import PixelSample, SampledPixels
from hcss_twin.engine.certificate.certify import certify
from hcss_twin.engine.certificate.part_sample import strata_of
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.parts import stream_parts
from hcss_twin.models.radiance.physical import slab_solver
from hcss_twin.physics.geometry import scattering_cosine
from hcss_twin.physics.sun import sun_position
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.numerics import FINEST_GRID, GridRefinement
from hcss_twin.plan.plan import Plan

SEED, PIXELS, LIMIT_S = 20240620, 12, 180.0
REFERENCE_S = 20.0
"""Pixels with views or models of their own are compared two by two until so much processor time has gone."""
KINDS = ("one layer", "two layers", "one layer, night", "two layers, night", "glory", "cloudbow", "glint", "grazing")
COMBINATION, SUNLIT, FEATURES = "combination", "sunlit combination", 5
"""Kinds of their own, which need the packages of ``feature_pairs.py``: so many of its features in one scene."""
UNFIT = ("mask alone", "accuracy in kelvin", "no certificate")
"""Features that leave nothing to compare, or say what is asked."""
NEAR_DEG, BOW_DEG, GLINT_DEG = 5.0, 140.0, 20.0
LOW, HIGH = ("stratus", "cumulus", "stratocumulus"), ("cirrus", "altocumulus", "altostratus")
PROFILES = (
    "tropical",
    "us-standard-1976",
    *(f"{a}-{b}" for a in ("midlatitude", "subarctic") for b in ("summer", "winter")),
)
AEROSOLS = ("none", "maritime", "rural")
WITHIN = {1e-2: 0.99, 1e-3: 0.99, 1e-4: 0.95}
"""Share of scenes that must be as accurate as asked."""


# --- scenes ---------------------------------------------------------------------------------


@functools.cache
def known_features(folder: Path | None = None) -> Mapping[str, Any]:
    """Features by name, with the files that some need; without a folder these last as long as the process."""
    from feature_pairs import features, write_inputs

    if folder is None:
        folder = Path(tempfile.mkdtemp(prefix="hcss-features-"))
        atexit.register(shutil.rmtree, folder)
    write_inputs(folder)
    return features(folder)


def combination(number: int, seed: int, sunlit: bool = False) -> tuple[str, ...]:
    """Return the names of features that can be combined: the first draw in which no two exclude each other.

    With ``sunlit`` none of them has a time or a view of its own.
    """
    from feature_pairs import are_alternatives, why_meaningless

    random, known = np.random.default_rng([seed, len(KINDS) + 2 * sunlit, number]), known_features()
    while True:
        names = tuple(map(str, random.choice([*known], FEATURES, replace=False)))
        excluded = why_meaningless(names) is not None or are_alternatives([known[name] for name in names])
        own = {key.partition(".")[0] for name in names for key in known[name].touched}
        if not excluded and not set(UNFIT) & set(names) and not (sunlit and own & {"time", "view"}):
            return names


def combined(number: int, seed: int, folder: Path | None = None, sunlit: bool = False) -> dict[str, Any]:
    """Keys of a scene with a combination, and random values where no feature of it sets any."""
    from feature_pairs import LAYER, PLACE, put, scene

    random, known = np.random.default_rng([seed, len(KINDS) + 1 + 2 * sunlit, number]), known_features(folder)
    chosen = [known[name] for name in combination(number, seed, sunlit)]
    touched = {key for feature in chosen for key in feature.touched}
    made = scene(chosen)
    del made["accuracy"]

    def free(key: str) -> bool:
        return not any(own == key or own.startswith(f"{key}.") or key.startswith(f"{own}.") for own in touched)

    base, hours = round(float(random.uniform(300.0, 1200.0)), 0), (8, 16) if sunlit else (0, 24)
    values = {
        "seed": int(random.integers(1000)),
        "sea.temperature": round(float(random.uniform(274.0, 303.0)), 1),
        "sea.wind_speed": round(float(random.uniform(1.0, 15.0)), 1),
        "sea.wind_from": round(float(random.uniform(0.0, 360.0)), 0),
        f"{LAYER}.coverage": round(float(random.uniform(0.2, 0.8)), 2),
        "image.pixel_size": float(random.choice([20.0, 50.0, 200.0, 500.0])),
        "time": f"2024-04-20T{int(random.integers(*hours)):02d}:{int(random.integers(60)):02d}:00+09:00",
    }
    thickness = round(float(random.uniform(150.0, 800.0)), 0)
    if free(f"{LAYER}.base") and free(f"{LAYER}.type"):
        values |= {f"{LAYER}.base": base, f"{LAYER}.top": base + thickness}
    if "view" not in made:  # pixels of a camera lie as far apart as those of the scene
        del values["image.pixel_size"]
    for key, value in values.items():
        if free(key):
            put(made, key, value)
    zenith, azimuth, glint = random.uniform(0.0, 60.0), random.uniform(0.0, 360.0), sunlit or number % 3 == 0
    if "view" in made and free("view"):
        sun, bearing, _ = (float(x[0]) for x in sun_position([datetime.fromisoformat(made["time"])], *PLACE.values()))
        if glint and sun < 75.0:
            zenith, azimuth = min(sun, 60.0) + random.uniform(-5.0, 5.0), bearing + 180.0 + random.uniform(-10.0, 10.0)
        made["view"] = {"zenith": round(abs(float(zenith)), 1), "azimuth": round(float(azimuth) % 360.0, 1)}
    if number % 3 and made["radiance"].get("model") == "as-printed":
        del made["radiance"]["model"]  # the default
    return made


def scenario(kind: str, number: int, seed: int = SEED, folder: Path | None = None) -> dict[str, Any]:
    """Keys of a scene, but for its accuracy."""
    if kind not in KINDS:
        return combined(number, seed, folder, kind == SUNLIT)
    random = np.random.default_rng([seed, KINDS.index(kind), number])
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


# --- pixels ---------------------------------------------------------------------------------


def all_pixels(plan: Plan, tables: Any) -> SampledPixels:
    """Return all pixels of one frame that a certificate could draw."""
    sample = PixelSample(plan)
    (frame, *_) = sample.counts
    sample.counts = {frame: math.prod(plan.pixels)}
    for _ in stream_parts(plan, tables, sample, frames=[frame]):
        pass
    return sample.frames[0]


def kinds_of(plan: Plan, pixels: SampledPixels) -> dict[str, NDArray[np.intp]]:
    """Return which pixels are at edges of clouds, at edges of shadows, and clear in the glint."""
    names = strata_of(plan)
    clear, shaded, edge = (
        np.array([test(name) for name in names])[pixels.stratum]
        for test in (
            lambda name: name.startswith(Certificate.CLEAR),
            lambda name: SHADED in name,
            lambda name: "edge" in name,
        )
    )
    # 1: lit, 2: in shadow, 0: anything else and the border
    sea = np.zeros([size + 2 for size in plan.pixels], dtype=np.int8)
    at = pixels.row + 1, pixels.column + 1
    sea[at] = np.where(clear, 1 + shaded, 0)
    beside = [sea[at[0] + down, at[1] + right] for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0))]
    border = clear & np.any([(other != 0) & (other != sea[at]) for other in beside], axis=0)
    sun, glint = plan.sun_up_at(pixels.time_s), np.zeros(clear.size, dtype=np.bool_)
    if sun is not None:
        places = [(pixels.row, pixels.column)[axis] + plan.extent[axis].start for axis in (0, 1)]
        views = plan.views_of_pixels(places[0].tolist(), places[1].tolist(), pixels.time_s)
        mu0 = math.cos(math.radians(sun.zenith_deg))
        for number, view in enumerate(views):
            turn = math.radians(view.azimuth_deg - sun.azimuth_deg)
            cosine = -scattering_cosine(math.cos(math.radians(view.zenith_deg)), mu0, math.pi - turn)
            glint[number] = math.degrees(math.acos(np.clip(cosine, -1.0, 1.0))) < GLINT_DEG
    return {
        "edges of clouds": np.flatnonzero(edge),
        "edges of shadows": np.flatnonzero(border),
        "glint": np.flatnonzero(clear & glint),
    }


def chosen_pixels(plan: Plan, pixels: SampledPixels, count: int, seed: int) -> tuple[list[int], dict[str, list[int]]]:
    """Return numbers of some pixels, every second one of these kinds in turn, and those of them of each kind."""
    random, kinds = np.random.default_rng([77, seed]), kinds_of(plan, pixels)
    queues = {name: random.permutation(which).tolist() for name, which in kinds.items()}
    special: list[int] = []
    while len(special) < count // 2 and any(queues.values()):
        for queue in queues.values():
            if queue and (number := queue.pop()) not in special:
                special.append(number)
    others = np.setdiff1d(random.permutation(pixels.row.size), special)
    strata = pixels.stratum[others]
    firsts = [int(random.choice(others[strata == one])) for one in np.unique(strata)]  # rare strata have a pixel, too
    rest = firsts + [number for number in random.permutation(others).tolist() if number not in firsts]
    both = [number for pair in zip_longest(special, rest) for number in pair if number is not None][:count]
    return both, {name: [number for number in both if number in own] for name, own in kinds.items()}


def only(pixels: SampledPixels, numbers: Sequence[int]) -> SampledPixels:
    """Return some of the pixels."""
    which = np.array(numbers, dtype=np.intp)
    fields = ("stratum", "row", "column", "thickness_m", "radiance")
    return replace(pixels, **{name: getattr(pixels, name)[which] for name in fields})


# --- reference ------------------------------------------------------------------------------


@contextmanager
def finest_numerics() -> Iterator[None]:
    """Within it, the reference of a certificate is at the finest level, and layers are solved at each thickness.

    Spectra at all wavenumbers are of few streams, as those of a certificate are, and their change to the finest level
    is computed at wavenumbers chosen for these columns. With 24 streams at all wavenumbers instead of 8, errors of a
    scene of cumulus differ by 6e-6.
    """

    def last(assembly: Assembly) -> int:
        return assembly.model.declares.numerical_levels - 1

    def few(assembly: Assembly) -> Assembly:
        return assembly.at_level(1).with_finer_sunlight(0) if last(assembly) else assembly

    with ExitStack() as patches:
        for module in (reference_columns, clear_points):
            patches.enter_context(mock.patch.object(module, "reference_level", last))
        patches.enter_context(mock.patch.object(reference_columns, "for_spectra", few))
        patches.enter_context(mock.patch.object(slab_solver, "FEW_THICKNESSES", np.inf))
        yield


def against_finest(plan: Plan, tables: Any, pixels: SampledPixels) -> Certificate:
    """Return the certificate of some pixels against the finest level and grid."""
    # A key of its own in the cache: errors are part of it, and levels of the reference are not.
    fine = replace(plan, grid_refinement=GridRefinement(FINEST_GRID, 0.0), numerics=replace(plan.numerics, error=-1.0))
    with finest_numerics():
        return certify(fine, tables, [pixels])


class TooDear(BaseException):
    """More processor time than is allowed; not an exception that guards of providers wrap."""


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """End what takes more processor time."""

    def end(*_: object) -> None:
        raise TooDear

    signal.signal(signal.SIGPROF, end)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


# --- rows -----------------------------------------------------------------------------------


@dataclass
class Row:
    """What was found for a scene at an accuracy.

    Attributes
    ----------
    outcome : str
        ``compared``, ``refused``, ``too dear``, ``not tried``, or ``crash``.
    ratio : float
        Largest error of a pixel in any band, of what was asked.
    noticed : bool
        Whether plan, tables or certificate of the run said that its error is larger.
    compared, special : int
        Pixels compared, and those of them at edges or in the glint.
    pixels : mapping of str to int
        The latter by kind; a pixel may be of several.
    run_s, reference_s : float
        Processor time of plan, tables and frame, and of the reference.
    limit_s : float
        Processor time that was allowed.
    """

    seed: int
    kind: str
    number: int
    accuracy: float
    features: Sequence[str] = ()
    outcome: str = "compared"
    message: str = ""
    ratio: float = 0.0
    band: str = ""
    stratum: str = ""
    model: str = ""
    level: str = ""
    estimated: float = 0.0
    noticed: bool = False
    own: str = ""
    compared: int = 0
    special: int = 0
    pixels: Mapping[str, int] = field(default_factory=dict)
    run_s: float = 0.0
    reference_s: float = 0.0
    limit_s: float = 0.0

    @property
    def key(self) -> tuple[int, str, int, float]:
        """What the scene is drawn from."""
        return self.seed, self.kind, self.number, self.accuracy

    def is_done(self, limit_s: float) -> bool:
        """Whether it need not be computed again, with a limit of processor time."""
        return self.outcome not in ("too dear", "not tried") or self.limit_s >= limit_s

    def __str__(self) -> str:
        text = f"{self.accuracy:g} {self.kind} {self.number}: "
        if self.outcome == "compared":
            text += f"asked {self.accuracy:g}, found/asked {self.ratio:.2g} in {self.band} ({self.stratum}), "
            text += f"estimated {self.estimated:.2g}, {self.model}, {self.level}, noticed {self.noticed}, "
            text += f"{self.compared} pixels ({', '.join(f'{count} {kind}' for kind, count in self.pixels.items())})"
        else:
            text += f"{self.outcome}: {self.message[-300:]}"
        text += f", {self.run_s:.0f} + {self.reference_s:.0f} s"
        return f"{text}\n    {' + '.join(self.features)}" if self.features else text


def compare(row: Row, made: Scenario) -> None:
    """Run a scene and compare pixels of it with the finest numerics."""
    start = time.process_time()
    plan = make_plan(made)
    tables = tables_of(plan)
    pixels = all_pixels(plan, tables)
    numbers, kinds = chosen_pixels(plan, pixels, PIXELS, row.number)
    row.run_s = time.process_time() - start
    row.model, row.estimated = plan.scenario.radiance.model, tables.estimated_error
    row.level = f"level {plan.numerics.level} + {plan.numerics.sunlight_steps}"
    apart = not plan.is_grid or plan.tops or plan.point_effects
    ratios, done = dict[tuple[str, str], float](), list[int]()
    size = 2 if apart else PIXELS
    for some in (numbers[first : first + size] for first in range(0, len(numbers), size)):
        certificate = against_finest(plan, tables, only(pixels, some))
        done += some
        for stratum in certificate.strata:
            for band, error in zip(certificate.bands, stratum.error, strict=False):
                if band not in certificate.dark:
                    key = stratum.name, band
                    ratios[key] = max(ratios.get(key, 0.0), error / plan.accuracy.relative)
        row.reference_s = time.process_time() - start - row.run_s
        if row.reference_s > REFERENCE_S:
            break
    row.pixels = {name: len(set(own) & set(done)) for name, own in kinds.items()}
    row.special, row.compared = len(set().union(*kinds.values()) & set(done)), len(done)
    (row.stratum, row.band), row.ratio = max(ratios.items(), key=lambda item: item[1])
    row.noticed = not plan.numerics.enough or tables.estimated_error > plan.accuracy.relative
    if row.ratio > 1.0:
        sample = PixelSample(plan)
        for _ in stream_parts(plan, tables, sample):
            pass
        own = certify(plan, tables, sample.frames)
        row.own = "; ".join(own.lines[:2])
        row.noticed |= not own.passed


def compute(row: Row, folder: Path | None, limit_s: float) -> Row:
    """Fill a row; the scenario of a scene beyond its accuracy goes to the folder."""
    start, made, row.limit_s = time.process_time(), None, limit_s
    if row.kind not in KINDS:
        row.features = combination(row.number, row.seed, row.kind == SUNLIT)
    try:
        raw = scenario(row.kind, row.number, row.seed, folder)
        raw |= {"accuracy": row.accuracy, "output": {**raw.get("output", {}), "certificate": 2 * PIXELS}}
        made = Scenario.from_dict(raw)
        with limited(limit_s):
            compare(row, made)
    except HcssError as error:
        row.outcome, row.message = "refused", f"{type(error).__name__}: {' '.join(str(error).split())}"
    except TooDear:
        row.outcome, row.message = "too dear", f"more than {limit_s:g} s of processor time"
        row.run_s = row.run_s or time.process_time() - start
    except Exception:  # one more finding; the others are still wanted
        row.outcome, row.message = "crash", traceback.format_exc()
    if folder is not None and made is not None and (row.ratio > 1.0 or row.outcome == "crash"):
        name = f"{row.kind}-{row.seed}-{row.number}-{row.accuracy:g}.json".replace(" ", "-")
        (folder / name).write_text(made.to_json(), encoding="utf-8")
    return row


def summary(rows: Sequence[Row], kinds: Sequence[str], accuracies: Sequence[float]) -> Iterator[str]:
    """Yield a table: scenes, those within, those beyond twice without notice, and the errors of what was asked."""
    quantiles = (0.5, 0.9, 0.99, 1.0)
    yield (
        f"{'accuracy':10}{'kind':20}{'scenes':>7}{'within':>8}{'beyond twice':>14}{'unnoticed':>11}{'pixels':>8}"
        f"{'at edges, in glint':>20}{'processor s':>13}  found/asked: median, 90 %, 99 %, largest"
    )
    for accuracy in accuracies:
        for kind in (*kinds, "all"):
            drawn = [
                row for row in rows if row.accuracy == accuracy and row.kind in kinds and kind in (row.kind, "all")
            ]
            some = [row for row in drawn if row.outcome == "compared"]
            if not some:
                continue
            ratios = np.array([row.ratio for row in some])
            twice = [row for row in some if row.ratio > 2.0]
            pixels, special = sum(row.compared for row in some), sum(row.special for row in some)
            seconds = np.median([row.run_s + row.reference_s for row in some])
            found = ", ".join(f"{each:.2g}" for each in np.quantile(ratios, quantiles))
            yield (
                f"{accuracy:<10g}{kind:20}{len(some):7d}{int(np.sum(ratios <= 1.0)):8d}{len(twice):14d}"
                f"{sum(not row.noticed for row in twice):11d}{pixels:8d}{special:20d}{seconds:13.0f}  {found}"
            )
            for outcome in ("refused", "too dear", "not tried", "crash"):
                if others := [row for row in drawn if row.outcome == outcome]:
                    yield f"    {outcome}: {len(others)} more ({', '.join(str(row.number) for row in others)})"
        yield f"{accuracy:g}: at least {100.0 * WITHIN[accuracy]:g} % must be within, and none beyond twice unnoticed"


def main() -> None:
    """Print each scene as it is known, and a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--number", type=int, default=8, help="of scenes of each kind")
    parser.add_argument("--kinds", nargs="+", choices=(*KINDS, COMBINATION, SUNLIT), default=KINDS)
    parser.add_argument("--accuracies", type=float, nargs="+", choices=list(WITHIN), default=[1e-2, 1e-3])
    parser.add_argument("--only", type=int, nargs="+", help="these numbers of each kind, computed again")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--limit", type=float, default=LIMIT_S, help="processor time of a scene, s")
    parser.add_argument("--without", nargs="+", default=[], help="features whose combinations are listed as not tried")
    parser.add_argument("--keep", type=Path, help="file of rows, to go on after a break")
    parser.add_argument("--summary", action="store_true", help="compute nothing")
    given = parser.parse_args()
    kept: Path | None = given.keep
    rows = [Row(**json.loads(line)) for line in kept.read_text().splitlines()] if kept and kept.exists() else []
    folder = kept.with_suffix("") if kept else None
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    numbers = range(given.number) if given.only is None else given.only
    for accuracy in () if given.summary else sorted(given.accuracies, reverse=True):
        for number in numbers:
            for kind in given.kinds:
                row = Row(given.seed, kind, number, accuracy)
                known = {each.key: each for each in rows}
                if given.only is None and row.key in known and known[row.key].is_done(given.limit):
                    continue
                looser = (known.get((given.seed, kind, number, other)) for other in WITHIN if other > accuracy)
                dear = next((each for each in looser if each and each.outcome == "too dear"), None)
                names = () if kind in KINDS else combination(number, given.seed, kind == SUNLIT)
                if given.only is None and dear and dear.is_done(given.limit):
                    row = replace(dear, accuracy=accuracy)
                elif without := set(given.without) & set(names):
                    row = replace(row, features=names, outcome="not tried", message=", ".join(sorted(without)))
                else:
                    row = compute(row, folder, given.limit)
                rows = [*(each for each in rows if each.key != row.key), row]
                print(row, flush=True)
                if kept:
                    kept.write_text("".join(json.dumps(asdict(each)) + "\n" for each in rows))
    print("\n".join(summary([row for row in rows if row.seed == given.seed], given.kinds, given.accuracies)))


if __name__ == "__main__":
    main()
