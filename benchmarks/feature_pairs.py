"""Which features of a scene combine: plans of all pairs of them, and of some triples.

::

    python benchmarks/feature_pairs.py                  # plans all pairs and 300 triples: half an hour
    python benchmarks/feature_pairs.py --pairs camera   # plans the pairs of one feature
    python benchmarks/feature_pairs.py --run 40         # runs 40 random pairs and triples of those that are planned

A feature is what a user adds to a scene: some keys, from this package or one of ``plugins/``. Two features are
alternatives if they set the same key; the others should combine. A refusal is listed with its message; ``MEANINGLESS``
names the pairs that no program could compute, and why. A run must pass its certificate, and where an effect of
``EFFECTS`` is switched off, the cube must change by no more than twice what the plan without it states.

Needs hcss-examples, hcss-light, hcss-payload and hcss-skies.
"""

from __future__ import annotations

import argparse
import copy
import itertools
import json
import re
import sys
import tempfile
import time
import tomllib
import traceback
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import HcssError, Problem, ScenarioError
from hcss_twin.plan.few_columns import OMISSION_SHARE

Raw = dict[str, Any]
PLACE = {"latitude": 35.7, "longitude": 140.9}
"""At a coast, for maps of the ground."""

LOW = {"type": "stratus", "generator": "fractal", "base": 600.0, "top": 1000.0, "coverage": 0.4}
"""Clouds of all scenes but those with a generator of their own: films, the default, take seconds of each plan."""

BASE: Raw = {
    "time": "2024-04-20T11:00:00+09:00",
    "place": PLACE,
    "image": {"rows": 20, "columns": 24, "pixel_size": 200.0},
    "frames": {"count": 1},
    "view": {"zenith": 25.0, "azimuth": 60.0},
    "sea": {"temperature": 288.0, "wind_speed": 7.0},
    "bands": ["mwir-3.7", "lwir-10.8"],
    "clouds": {"layers": [LOW]},
    "radiance": {"model": "as-printed"},
    "accuracy": 1e-2,
    "output": {"variables": ["radiance", "cloud_mask"], "certificate": 8},
    "seed": 3,
}
GEOSTATIONARY_M = 35_786_034.0


@dataclass(frozen=True)
class Feature:
    """What a user adds to a scene.

    Attributes
    ----------
    keys : mapping of str to object
        Dotted keys and their values. ``+clouds.layers`` appends to a list; ``clouds.layers.0.top`` changes its first
        item.
    package : str
        Which brings it; empty: this one.
    without : tuple of str
        Keys of the base scene that it replaces.
    """

    keys: Mapping[str, Any]
    package: str = ""
    without: tuple[str, ...] = ()

    @property
    def touched(self) -> set[str]:
        """Keys that it sets, without those that it adds to a list."""
        return {key for key in (*self.keys, *self.without) if not key.startswith("+")}


LOW_CAMERA = {
    "camera": {"rows": 20, "columns": 24, "focal_length": 0.15, "detector_pitch": 4.3e-5, "points": 2},
    "orbit": {"altitude": 7e5, "inclination": 98.2, "above": [35.7, 143.0], "above_time": 0.0},
}
LAYER = "clouds.layers.0"
MIDDLE = {"type": "altocumulus", "generator": "fractal", "coverage": 0.4}
HIGH = {"type": "cirrus", "generator": "fractal", "base": 9000.0, "top": 10000.0, "coverage": 0.4}


def features(folder: Path) -> dict[str, Feature]:
    """Return all features by name.

    Parameters
    ----------
    folder : Path
        Of the files that some need (:func:`write_inputs`).
    """

    def at(name: str) -> str:
        return str(folder / name)

    example = {f"{LAYER}.generator": "example", f"{LAYER}.thickness_min": 10.0}
    return {
        # clouds
        "cumulus": Feature({f"{LAYER}.type": "cumulus"}),
        "clouds of a film": Feature({f"{LAYER}.generator": "simulation"}, "hcss-skies"),
        "two layers": Feature({"+clouds.layers": [HIGH]}),
        "three layers": Feature({"+clouds.layers": [MIDDLE, HIGH]}),
        "sky without end": Feature({f"{LAYER}.coverage_mode": "field"}),
        "cloud temperature": Feature({f"{LAYER}.temperature": 280.0}),
        "clouds of an image": Feature({
            f"{LAYER}.generator": "imagery",
            f"{LAYER}.parameters": {"entry": "made-stratus", "reinterpret_pixel_size": True, "beyond": "mirror"},
        }),
        "single clouds of an image": Feature({
            f"{LAYER}.generator": "imagery",
            f"{LAYER}.parameters": {
                "entry": "made-stratus", "placement": "single-clouds", "reinterpret_pixel_size": True
            },
        }),
        "sky like an example": Feature(
            {**example, f"{LAYER}.parameters": {"example": "closed-cells-1"}}, "hcss-skies"
        ),
        "own tops": Feature(
            {**example, f"{LAYER}.parameters": {"example": "closed-cells-1", "tops": "example"}}, "hcss-skies"
        ),
        "large-eddy clouds": Feature(
            {
                f"{LAYER}.generator": "les", f"{LAYER}.parameters": {"file": at("les.nc")},
                f"{LAYER}.base": 400.0, f"{LAYER}.thickness_min": 1.0,
            },
            "hcss-examples",
        ),
        "ash": Feature(
            {"+clouds.layers": [{"type": at("ash-type.toml"), "base": 11_000.0, "top": 12_000.0, "coverage": 0.4,
                                 "optics": {"provider": "ash", "parameters": {"absorption": 0.2}}}]},
            "hcss-examples",
        ),
        "smoke": Feature({"smoke": {"optical_depth": 0.8, "width": 1000.0}}, "hcss-examples"),
        # image and view
        "window": Feature({"image.window": {"rows": [4, 16], "columns": [2, 20]}}),
        "points within a pixel": Feature({"image.samples_per_pixel": 2}),
        "view to the glint": Feature({"view.zenith": 30.0, "view.azimuth": 180.0}),
        "low view": Feature({"view.zenith": 75.0}),
        "altitude": Feature({"platform.altitude": 7e5, "image.pixel_size": 4000.0}),
        "push-broom": Feature({"platform.altitude": 7e5, "platform.mode": "push-broom"}),
        "camera": Feature({**LOW_CAMERA, "attitude": {"provider": "track"}}, "hcss-payload", ("view",)),
        "camera, push-broom": Feature({**LOW_CAMERA, "attitude": {"provider": "push-broom", "roll": 10.0},
                                       "camera.line_time": 0.01, "camera.integration_time": 0.05,
                                       "jitter": {"rms": ["20 urad", "20 urad", "10 urad"]}},
                                      "hcss-payload", ("view",)),
        "conical scanner": Feature(
            {"conical_scanner": {"rows": 12, "columns": 12, "half_arc": 1.0, "step": 500.0}}, "hcss-examples", ("view",)
        ),
        # time and sun
        "night": Feature({"time": "2024-04-20T23:00:00+09:00"}),
        "low sun": Feature({"time": "2024-04-20T17:30:00+09:00"}),
        "sequence": Feature({"frames": {"count": 3, "interval": 60.0}}),
        # slant paths, waves, texture
        "shadows": Feature({"slant.shadows": "on"}),
        "parallax": Feature({"slant.parallax": "on"}),
        "waves": Feature({"sea.waves": "on", "image.pixel_size": 20.0}),
        "sea texture": Feature({"sea.temperature_texture": 0.3}),
        "vapour texture": Feature({"atmosphere.water_vapour_texture": 0.05}),
        # bands
        "wide band": Feature({"+bands": ["lwir"]}),
        "narrow band": Feature({"+bands": [{"name": "line", "limits": [10.0, 10.05]}]}),
        "absorbing band": Feature({"+bands": ["mwir-4.2-4.4"]}),
        "response": Feature({"+bands": [{"name": "channel", "response": at("response.csv")}]}),
        # air
        "inversion": Feature({"atmosphere.inversion": {"height": 1000.0, "strength": 5.0}}),
        "field of profiles": Feature({"atmosphere.profile": at("profiles.nc")}),
        "own profile": Feature({"atmosphere.profile": at("profile.csv")}),
        "aerosol": Feature({"atmosphere.parameters": {"aerosol": "navy-maritime"}}),
        "table of air": Feature({"atmosphere.provider": "table"}),
        # ground
        "coast": Feature({"surfaces": {"provider": "coast"}}),
        "ice": Feature({"surfaces": {"provider": "ice-map", "parameters": {"file": at("ice.nc")}}}, "hcss-examples"),
        # elements
        "aircraft": Feature({"+elements": [{"provider": "aircraft", "parameters": {
            "x": 300, "y": -200, "altitude": 9000, "heading": 45, "area": 400.0}}]}, "hcss-examples"),
        "source": Feature({"+elements": [{"provider": "point-sources", "parameters": {"tracks": [
            {"x": 500.0, "y": 300.0, "altitude": 0.0, "temperature": 600.0, "area": 50.0}]}}]}),
        # radiance
        "many streams": Feature({"radiance.model": "physical"}),
        "slanted rays": Feature({"radiance.light": "slant"}, "hcss-light"),
        "scattered light": Feature({"radiance.light": "source"}, "hcss-light"),
        "relief of clouds": Feature({f"{LAYER}.generator": "fractal-relief", "radiance.light": "slant"}, "hcss-light"),
        "accuracy in kelvin": Feature({"accuracy": "0.3 K"}),
        # sensor
        "blur and noise": Feature({"+sensor.stages": [{"parameters": {
            "psf": "gaussian", "psf_sigma": 0.8, "noise": "nedt", "nedt": 0.05}}]}),
        "digital numbers": Feature({"sensor.variables": ["all"], "+sensor.stages": [{"parameters": {
            "bits": 12, "saturation_radiance": 100.0}}]}),
        "rows one by one": Feature({"+sensor.stages": [{"model": "rolling-shutter", "parameters": {"delay": 0.01}}]},
                                   "hcss-examples"),
        "stray light": Feature({"+sensor.stages": [{"model": "stray-light", "parameters": {"veil": 0.02}}]},
                               "hcss-payload"),
        # output
        "all variables": Feature({"output.variables": ["all"]}),
        "mask alone": Feature({"output.variables": ["cloud_mask"]}),
        "derived variable": Feature({"output.variables": ["radiance", "split_window_difference"],
                                     "output.derived": [{"provider": "split-window", "parameters": {
                                         "bands": ["mwir-3.7", "lwir-10.8"]}}]}, "hcss-examples"),
        "int16": Feature({"output.packing": "int16"}),
        "no certificate": Feature({"output.certificate": 0}),
    }  # fmt: skip


_CAMERAS = ("camera", "camera, push-broom", "conical scanner")
_OTHER_AIR = ("inversion", "field of profiles", "own profile", "aerosol", "vapour texture")

MEANINGLESS: dict[frozenset[str], str] = {
    frozenset((one, other)): why
    for why, ones, others in (
        ("two views of one image", _CAMERAS, ("altitude", "push-broom", "view to the glint", "low view")),
        ("two image geometries", _CAMERAS[:2], _CAMERAS[2:]),
        (
            "two sizes of one image: [image] is the sky's, and keys of a camera say which pixels are read",
            _CAMERAS,
            ("window",),
        ),
        ("a table is computed for one air", ("table of air",), _OTHER_AIR),
        ("tops of their own have the temperature of the air there", ("own tops",), ("cloud temperature",)),
    )
    for one in ones
    for other in others
}
"""Pairs that no program could compute, and why."""


# --- inputs ---------------------------------------------------------------------------------


def write_inputs(folder: Path) -> None:
    """Write the files that features name."""
    (folder / "response.csv").write_text("wavelength_um,response\n8.5,0\n8.8,0.7\n9.2,1\n9.5,0\n", encoding="utf-8")
    (folder / "ash-type.toml").write_text(_ASH, encoding="utf-8")
    height_m = np.array([0.0, 500.0, 1000.0, 2000.0, 4000.0, 7000.0, 10_000.0, 14_000.0, 18_000.0])
    pressure_pa = 101_300.0 * np.exp(-height_m / 7800.0)
    kelvin = np.maximum(287.0 - 6.3e-3 * height_m, 210.0)
    humidity = np.interp(height_m, [0.0, 2000.0, 10_000.0], [75.0, 55.0, 10.0])
    rows = [f"{p},{t},{rh}" for p, t, rh in zip(pressure_pa, kelvin, humidity, strict=True)]
    (folder / "profile.csv").write_text(
        "\n".join(["pressure_Pa,temperature_K,relative_humidity_percent", *rows]), encoding="utf-8"
    )
    north = PLACE["latitude"] + np.linspace(-20.0, 20.0, 9)
    with netCDF4.Dataset(folder / "profiles.nc", "w") as file:
        for name, values in (("latitude", north), ("pressure_level", pressure_pa)):
            file.createDimension(name, values.size)
            file.createVariable(name, "f8", (name,))[:] = values
        file["pressure_level"].units = "Pa"
        for name, units, values, slope in (("t", "K", kelvin, -0.5), ("rh", "percent", humidity, -0.3)):
            variable = file.createVariable(name, "f8", ("pressure_level", "latitude"))
            variable.units, variable[:] = units, values[:, None] + slope * (north - PLACE["latitude"])
    _write_map(
        folder / "ice.nc",
        concentration=lambda north, east: np.clip(0.5 + 40.0 * north, 0.0, 1.0),
        temperature=lambda north, east: 262.0 - 2.0 * east,
    )
    _write_les(folder / "les.nc")


_ASH = """
title = "Ash"
description = "Cloud of volcanic ash"
source = "An example"
[layer]
material = "ash"
base = 9000.0
top = 10000.0
thickness_min = 100.0
[fractal]
gamma = 3.0
H = 0.8
L = [20, 10]
k = [0, 4]
[microphysics]
effective_radius_um = 3.0
effective_variance = 0.3
water_content_kg_m3 = 1e-6
density = 2600.0
source = "An example"
"""


def _write_map(path: Path, **layers: Any) -> None:
    """Write functions of the distances (degrees) north and east of the place, over some degrees around it."""
    steps = np.sign(np.linspace(-1.0, 1.0, 161)) * np.linspace(-1.0, 1.0, 161) ** 2 * 3.0
    with netCDF4.Dataset(path, "w") as file:
        for name in ("latitude", "longitude"):
            file.createDimension(name, steps.size)
            file.createVariable(name, "f8", (name,))[:] = PLACE[name] + steps
        for name, layer in layers.items():
            values = layer(*np.meshgrid(steps, steps, indexing="ij"))
            file.createVariable(name, "f8", ("latitude", "longitude"), fill_value=np.nan)[:] = values


def _write_les(path: Path) -> None:
    """Write the water of turrets on a base of 400 m, which grow with time."""
    z, cells = np.arange(10.0, 1000.0, 20.0), 40
    y, x = np.mgrid[:cells, :cells] * 2.0 * np.pi / cells
    turret = np.sin(2.0 * x + 0.3) * np.sin(y) + 0.4 * np.cos(3.0 * y - x)
    times = np.array([0.0, 600.0, 1200.0])
    top = 400.0 + 100.0 * np.maximum(turret, 0.0) * (1.0 + times[:, None, None] / 1200.0)
    height = z[:, None, None]
    wet = (height > 400.0) & (height < top[:, None])
    distance = (np.arange(cells) + 0.5) * 100.0
    with netCDF4.Dataset(path, "w") as file:
        for name, values, units in (("time", times, "s"), ("z", z, "m"), ("y", distance, "m"), ("x", distance, "m")):
            file.createDimension(name, values.size)
            file.createVariable(name, "f8", (name,))[:] = values
            file[name].units = units
        file.createVariable("lwc", "f8", ("time", "z", "y", "x"))[:] = np.where(wet, 4.5e-7 * (height - 400.0), 0.0)
        file["lwc"].units = "kg m-3"


# --- scenes ---------------------------------------------------------------------------------


def are_alternatives(chosen: Iterable[Feature]) -> bool:
    """Whether features set a key, or one a part of what another replaces, to different values, or add the same item."""
    for one, other in itertools.combinations(chosen, 2):
        if any(item in other.keys.get(key, ()) for key in one.keys if key.startswith("+") for item in one.keys[key]):
            return True
        for key, below in itertools.chain(
            itertools.product(one.touched, other.touched), itertools.product(other.touched, one.touched)
        ):
            same = key == below or below.startswith(f"{key}.")
            if same and not (key == below and one.keys.get(key) == other.keys.get(key)):
                return True
    return False


def scene(chosen: Sequence[Feature], changes: Mapping[str, Any] | None = None) -> Raw:
    """Return the scenario with some features, and further dotted keys."""
    raw = copy.deepcopy(BASE)
    for key in {key for each in chosen for key in each.without}:
        remove(raw, key)
    for each in chosen:
        for key, value in each.keys.items():
            put(raw, key, copy.deepcopy(value))
    for key, value in (changes or {}).items():
        put(raw, key, value)
    return raw


def put(raw: Raw, dotted: str, value: Any) -> None:
    """Set a dotted key; ``+`` before it appends to a list."""
    *path, last = dotted.removeprefix("+").split(".")
    here: Any = raw
    for part in path:
        here = here[int(part)] if isinstance(here, list) else here.setdefault(part, {})
    if dotted.startswith("+"):
        here[last] = [*here.get(last, []), *value]
    else:
        here[last] = value


def remove(raw: Raw, dotted: str) -> None:
    """Remove a dotted key, if it is there."""
    *path, last = dotted.split(".")
    here: Any = raw
    for part in path:
        here = here[int(part)] if isinstance(here, list) else here.get(part, {})
    here.pop(last, None)


@dataclass
class Outcome:
    """What came of a scene: accepted, refused, or a crash.

    Attributes
    ----------
    messages : list of str
        Why it was refused, field first, or the traceback of the crash.
    """

    names: tuple[str, ...]
    kind: str = "accepted"
    messages: list[str] = field(default_factory=list)
    seconds: float = 0.0


def planned(names: tuple[str, ...], chosen: Sequence[Feature]) -> Outcome:
    """Plan a scene with features."""
    start, found = time.perf_counter(), Outcome(names)
    try:
        make_plan(Scenario.from_dict(scene(chosen)))
    except ScenarioError as error:
        found.kind, found.messages = "refused", [f"{each.field}: {each.message}" for each in error.problems]
    except HcssError as error:
        found.kind, found.messages = "refused", [f"{type(error).__name__}: {error}"]
    except Exception:  # a crash is what is looked for
        found.kind, found.messages = "crash", [traceback.format_exc()]
    found.seconds = time.perf_counter() - start
    return found


def pairs_of(known: Mapping[str, Feature], only: Sequence[str] = ()) -> list[tuple[str, ...]]:
    """Return the pairs of features that are no alternatives."""
    return [
        pair
        for pair in itertools.combinations(known, 2)
        if (not only or set(only) & set(pair)) and not are_alternatives([known[name] for name in pair])
    ]


def triples_of(known: Mapping[str, Feature], count: int, seed: int) -> list[tuple[str, ...]]:
    """Return some random triples of features that are no alternatives."""
    rng, names, found = np.random.default_rng(seed), list(known), set()
    while len(found) < count:
        triple = tuple(names[n] for n in sorted(rng.choice(len(names), 3, replace=False)))
        if not are_alternatives([known[name] for name in triple]):
            found.add(triple)
    return sorted(found)


def plan_all(groups: Sequence[tuple[str, ...]], known: Mapping[str, Feature], kept: Path | None) -> list[Outcome]:
    """Plan scenes in random order; those of a file are not planned again, and new ones are added to it."""
    before = {}
    if kept is not None and kept.exists():
        rows = (json.loads(line) for line in kept.read_text(encoding="utf-8").splitlines())
        before = {tuple(row["names"]): Outcome(**{**row, "names": tuple(row["names"])}) for row in rows}
    outcomes = []
    for names in (groups[n] for n in np.random.default_rng(0).permutation(len(groups))):
        outcome = before.get(names) or planned(names, [known[name] for name in names])
        outcomes.append(outcome)
        if kept is not None and names not in before:
            with kept.open("a", encoding="utf-8") as file:
                file.write(json.dumps(vars(outcome)) + "\n")
    return outcomes


# --- advice ---------------------------------------------------------------------------------

NO_KEY = "no key computes it"
"""How advice ends that does not name a key."""

_REMOVE = (
    "to leave it out",
    "without it",
    "no ",
    "none",
    "one profile",
    "one without",
    "omit the key",
    "sea everywhere",
)

_PROVIDERS = (".generator", ".provider", ".model")


def advised(raw: Raw, advice: str) -> Raw | None:
    """Return a scenario that follows one piece of advice; None if it cannot be followed as it is.

    Advice is ``key = value``, ``key: what is allowed``, or a key alone, which may have any value.
    """
    changed = copy.deepcopy(raw)
    assigned = re.match(r"([a-z_][\w.\[\]]*) = ('[^']*'|\"[^\"]*\"|[-\w.+]+|\{.*?\})", advice)
    named = re.match(r"([a-z_][\w.\[\]]*)(?:: (.*))?$", advice, re.DOTALL)
    if assigned:
        _remove_parameters(changed, _path(assigned[1]))
        put(changed, _path(assigned[1]), tomllib.loads(f"value = {assigned[2]}")["value"])
        return changed
    if not named:
        return None
    key, allowed = _path(named[1]), named[2]
    if allowed is None:
        put(changed, key, 7e5)
        return changed
    _remove_parameters(changed, key)
    quoted = re.search(r"['\"]([^'\"]+)['\"]", allowed)
    if allowed.startswith(_REMOVE):
        remove(changed, key)
    elif quoted and allowed.startswith("a list with "):
        put(changed, f"+{key}", [quoted[1]])
    elif quoted:
        put(changed, key, quoted[1])
    elif number := re.match(r"-?[0-9][0-9.e+-]*$", allowed):
        put(changed, key, float(number[0]))
    else:
        return None
    return changed


def _remove_parameters(raw: Raw, key: str) -> None:
    """Remove the parameters of a provider that another replaces, as ``--set`` does."""
    if key.endswith(_PROVIDERS):
        remove(raw, f"{key.rpartition('.')[0]}.parameters")


def alternatives(problem: Problem) -> list[str]:
    """Return the alternatives that a problem allows, each as a piece of advice."""
    allowed = problem.message.rpartition("allowed: ")[2]
    assigned = r"[a-z_][\w.]* = "
    return [part if re.match(assigned, part) else f"{problem.field}: {part}" for part in allowed.split(", or ")]


def _path(key: str) -> str:
    """Return the dotted key of a field as messages name it."""
    dotted = re.sub(r"\[(\d+)\]", r".\1", key)
    head, _, rest = dotted.partition(".")
    return f"clouds.layers.0.{rest}" if head == "clouds" and not rest.startswith("layers") else dotted


def wrong_advice(raw: Raw) -> list[str]:
    """Return the advice of a scene that fails: of its refusal, or of the effects that its plan leaves out.

    A refused scene must be planned when all advice of its refusal is followed; a scene that leaves something out
    must be planned without that omission, with a smaller one, or with one that does not matter, when it is followed.
    """
    scenario = Scenario.from_dict(copy.deepcopy(raw))
    try:
        plan = make_plan(scenario)
    except ScenarioError as error:
        return _wrong_refusal(raw, error)
    wrong = []
    for omission in plan.omissions:
        if not omission.exceeds(OMISSION_SHARE * plan.accuracy.relative) or omission.needs.endswith(NO_KEY):
            continue
        followed = advised(raw, omission.needs)
        if followed is None:
            wrong.append(f"{omission.what}: needs {omission.needs!r}, which names no key and value")
            continue
        try:
            after = make_plan(Scenario.from_dict(followed))
        except HcssError as error:
            wrong.append(f"{omission.what}: needs {omission.needs!r}, with which it is refused: {error}")
            continue
        left = next((each for each in after.omissions if each.what == omission.what), None)
        matters = left is not None and left.exceeds(OMISSION_SHARE * after.accuracy.relative)
        if left is not None and matters and (left.size or 0.0) > 0.5 * (omission.size or 0.0):
            wrong.append(f"{omission.what}: needs {omission.needs!r}, with which it is left out: {left.why}")
    return wrong


def _wrong_refusal(raw: Raw, error: ScenarioError) -> list[str]:
    """Return what is wrong with the advice of a refusal: every alternative of its first problem is followed.

    Another refusal that follows must be of another kind: then its advice is followed, too, in the same way.
    """
    first, wrong, followed = error.problems[0], [], 0
    for advice in alternatives(first):
        after = advised(raw, advice)
        if after is None:
            continue
        followed += 1
        try:
            make_plan(Scenario.from_dict(after))
        except ScenarioError as second:
            if second.problems[0] in error.problems[:1] or _is_refused(after, second):
                wrong.append(f"refused ({first}), and refused as advised ({advice}): {second}")
    return wrong if followed else [f"refused, and no alternative is a value of a key: {first}"]


def _is_refused(raw: Raw, error: ScenarioError) -> bool:
    """Whether no alternative of a refusal is planned."""
    for advice in alternatives(error.problems[0]):
        after = advised(raw, advice)
        try:
            if after is not None:
                make_plan(Scenario.from_dict(after))
                return False
        except ScenarioError:
            continue
    return True


# --- runs -----------------------------------------------------------------------------------

WRONG = "wrong"
"""Verdict on a scene whose run crashed, failed its certificate or changed by more than stated."""


def largest(on: Array, off: Array) -> float:
    """Return the largest change of a pixel in any band, relative to the pixel without the effect."""
    return float(np.nanmax(np.abs(on - off) / off))


def rms(on: Array, off: Array) -> float:
    """Return the rms change in the worst band, relative to the mean radiance."""
    change = np.sqrt(np.nanmean((on - off) ** 2, axis=(0, 2, 3)))
    return float(np.max(change / np.nanmean(off, axis=(0, 2, 3))))


def most(on: Array, off: Array) -> float:
    """Return the change that 98.9 % of the pixels do not exceed in the worst band."""
    change = np.abs(on - off) / off
    return float(np.max(np.nanquantile(change, 0.989, axis=(0, 2, 3))))


def at_edges(on: Array, off: Array) -> float:
    """Return the mean change of the pixels that change, in the worst band, relative to the mean radiance."""
    change = np.abs(on - off)
    changed = change > 1e-4 * off
    sums = np.sum(np.where(changed, change, 0.0), axis=(0, 2, 3)), np.maximum(np.sum(changed, axis=(0, 2, 3)), 1)
    return float(np.max(sums[0] / sums[1] / np.nanmean(off, axis=(0, 2, 3))))


@dataclass(frozen=True)
class Effect:
    """What a feature computes: how to switch it off, and how the plan calls what is then left out.

    Attributes
    ----------
    off : mapping of str to object
        Keys and values; None removes a key.
    what : str
        Of its :class:`~hcss_twin.plan.few_columns.Omission`.
    measure : callable
        Change of the cube (F, B, rows, columns) in the sense of the omission's size; :func:`largest` of its bound.
    of_clear : bool
        Whether the size is that of clear pixels.
    """

    off: Mapping[str, Any]
    what: str
    measure: Callable[[Array, Array], float]
    of_clear: bool = False


EFFECTS = {
    "shadows": Effect({"slant.shadows": "off"}, "shadows of clouds on the sea", largest),
    "parallax": Effect({"slant.parallax": "off"}, "parallax of clouds", rms),
    "waves": Effect({"sea.waves": "off"}, "waves as shapes", most, True),
    "sea texture": Effect({"sea.temperature_texture": 0.0}, "texture of the sea's temperature", rms, True),
    "points within a pixel": Effect({"image.samples_per_pixel": 1}, "clouds within the footprint of a pixel", at_edges),
    "altitude": Effect({"platform.altitude": None}, "view angles of single pixels", largest),
}


def run(names: Sequence[str], chosen: Sequence[Feature], folder: Path) -> Iterator[str]:
    """Run a scene with features, and without each of its effects; yield what is wrong, and what was found."""
    raw = scene(chosen)
    try:
        on, radiance = _simulated(raw, folder / "on.nc")
    except HcssError as error:
        yield f"refused: {error}"
        return
    verdict = on.attrs.get("hcss_certificate", "")
    if radiance is not None and raw["output"]["certificate"] and not verdict.startswith("computed as specified"):
        yield f"WRONG certificate: {verdict}"
    left_out = {omission.what for omission in make_plan(Scenario.from_dict(raw)).omissions}
    for name in [name for name in names if name in EFFECTS and radiance is not None]:
        effect = EFFECTS[name]
        if effect.what in left_out:
            yield f"{name}: the plan lists it as left out"
            continue
        without = copy.deepcopy(raw)
        for key, value in effect.off.items():
            if value is None:
                remove(without, key)
            else:
                put(without, key, value)
        try:
            _, other = _simulated(without, folder / "off.nc")
        except ScenarioError as error:
            yield f"{name}: cannot be switched off alone: {error.problems[0]}"
            continue
        plan = make_plan(Scenario.from_dict(without))
        stated = next((omission for omission in plan.omissions if omission.what == effect.what), None)
        seen = radiance
        if effect.of_clear and "cloud_mask" in on:
            clear = on["cloud_mask"].to_numpy()[:, None] == 0
            if not np.any(clear):
                yield f"{name}: no pixel is clear"
                continue
            seen, other = (np.where(clear, x, np.nan) for x in (radiance, other))
        changed = effect.measure(seen, other)
        if stated is None:
            wrong = "WRONG " if changed > plan.accuracy.relative else ""
            yield f"{wrong}{name}: {changed:.2g}, and nothing is stated"
            continue
        size, sense = (stated.bound, "") if effect.measure is largest else (stated.size, stated.sense)
        if size is None:
            yield f"{name}: {changed:.2g}, and the plan states no size"
        else:
            wrong = "WRONG " if changed > max(2.0 * size, plan.accuracy.relative) else ""
            text = f"{wrong}{name}: {changed:.2g}, {size:.2g} stated ({sense or 'any pixel'}): "
            yield text + judged(changed, size, plan.accuracy.relative)


def judged(changed: float, size: float, accuracy: float) -> str:
    """Return how a change compares with its stated size, which is an upper limit where it says "at most" or a bound."""
    if changed == 0.0:
        return "no pixel of this image changes"
    if 0.5 * size <= changed <= 2.0 * size:
        return "within a factor of 2"
    if max(changed, size) <= accuracy:
        return "both below the accuracy asked for"
    return "more than twice" if changed > size else "less than half"


def _simulated(raw: Raw, path: Path) -> tuple[Any, Array | None]:
    """Return a cube in memory, and its radiance (F, B, rows, columns) if it has any."""
    with simulate(Scenario.from_dict(copy.deepcopy(raw)), path) as opened:
        cube = opened.load()
    path.unlink()
    return cube, cube["radiance"].to_numpy().astype(np.float64) if "radiance" in cube else None


def run_some(known: Mapping[str, Feature], count: int, seed: int, folder: Path) -> int:
    """Run random pairs and triples in turn, each with an effect whose size is stated; return 1 if one is wrong."""
    rng, names = np.random.default_rng(seed), list(known)
    sizes: Counter[int] = Counter()
    count_of: Counter[str] = Counter()
    done: set[tuple[str, ...]] = set()
    sizes_of: dict[str, Counter[str]] = defaultdict(Counter)
    while len(done) < count:
        group = str(rng.choice(list(EFFECTS))), *map(str, rng.choice(names, 1 + len(done) % 2, replace=False))
        chosen = [known[name] for name in group]
        if group in done or len({*group}) < len(group) or are_alternatives(chosen):
            continue
        done.add(group)
        try:
            lines = list(run(group, chosen, folder))
        except Exception:  # a crash is what is looked for
            lines = [f"WRONG {traceback.format_exc()}"]
        sizes[len(group)] += 1
        count_of[verdict(lines)] += 1
        for name, _, rest in (line.removeprefix("WRONG ").partition(": ") for line in lines):
            if name in EFFECTS:
                sizes_of[name][rest.rpartition(": ")[2] if " stated (" in rest else "nothing to compare"] += 1
        print(f"{' + '.join(group)}\n    " + "\n    ".join(lines), flush=True)
    print(
        f"{count} scenes ({sizes[2]} pairs, {sizes[3]} triples): "
        + ", ".join(f"{n} {of}" for of, n in count_of.items())
    )
    for name, found in sizes_of.items():
        print(f"{name}: " + ", ".join(f"{n} {what}" for what, n in found.most_common()))
    print(f"{count_of[WRONG]} of {count} scenes are wrong")
    return int(count_of[WRONG] > 0)


def verdict(lines: Sequence[str]) -> str:
    """Return what the lines of a run say in short."""
    if any(line.startswith("WRONG") for line in lines):
        return WRONG
    if any(line.startswith("refused") for line in lines):
        return "refused"
    stated = any(" stated (" in line for line in lines)
    return "as stated" if stated else "certified, with no size to compare"


# --- summary --------------------------------------------------------------------------------


def cause(message: str) -> str:
    """Return a refusal without what differs between scenes: its field, and the message without numbers."""
    name, _, text = message.partition(": ")
    key, words = re.sub(r"\[[0-9]+\]|\.[0-9]+", "", name), re.sub(r"[0-9][0-9.e+-]*", "#", text)
    return f"{key}: {words[:160]}"


def report(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yield the counts, the crashes, and the refusals by cause."""
    count = Counter(outcome.kind for outcome in outcomes)
    seconds = sum(outcome.seconds for outcome in outcomes)
    yield f"{len(outcomes)} scenes: " + ", ".join(f"{n} {kind}" for kind, n in count.items()) + f" ({seconds:.0f} s)"
    known, wanted = 0, 0
    causes: dict[str, list[Outcome]] = defaultdict(list)
    for outcome in outcomes:
        if outcome.kind == "refused":
            meaningless = why_meaningless(outcome.names) is not None
            known, wanted = known + meaningless, wanted + (not meaningless)
            for text in {cause(message) for message in outcome.messages}:
                causes[text].append(outcome)
        elif outcome.kind == "crash":
            yield f"CRASH {' + '.join(outcome.names)}: {outcome.messages[0].strip().splitlines()[-1]}"
    yield f"refused: {known} physically meaningless, {wanted} that a user would want"
    for text, of_cause in sorted(causes.items(), key=lambda item: -len(item[1])):
        yield f"{len(of_cause)} x {text}"
        for outcome in of_cause:
            why = why_meaningless(outcome.names)
            yield f"      {' + '.join(outcome.names)}" + (f" (meaningless: {why})" if why else "")


def why_meaningless(names: Sequence[str]) -> str | None:
    """Return why no program could compute features together; None if one could."""
    pairs = (frozenset(pair) for pair in itertools.combinations(names, 2))
    return next((MEANINGLESS[pair] for pair in pairs if pair in MEANINGLESS), None)


def main() -> int:
    """Plan, and run if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", action="append", default=[], metavar="FEATURE", help="pairs of this feature alone")
    parser.add_argument("--triples", type=int, default=300, help="number of random triples (default: 300)")
    parser.add_argument(
        "--run", type=int, default=0, metavar="N", help="run N random pairs and triples, plan no others"
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="file of outcomes, to go on after a break")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_inputs(folder)
        known = features(folder)
        if unknown := set(given.pairs) - set(known):
            parser.error(f"no feature {', '.join(unknown)}; there are: {', '.join(known)}")
        pairs = pairs_of(known, given.pairs)
        print(f"{len(known)} features")
        if given.run:
            return run_some(known, given.run, given.seed, folder)
        outcomes = plan_all(pairs, known, given.keep)
        print("\n".join(report(outcomes)))
        if given.triples and not given.pairs:
            outcomes += plan_all(triples_of(known, given.triples, given.seed), known, given.keep)
            print("\n".join(report(outcomes[len(pairs) :])))
    return int(any(outcome.kind == "crash" for outcome in outcomes))


if __name__ == "__main__":
    sys.exit(main())
