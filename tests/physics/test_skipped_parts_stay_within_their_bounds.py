"""Whatever the plan leaves out changes less than it says: each rule against a run, or columns, without it."""

import dataclasses
import math
import re
from pathlib import Path

import numpy as np
import pytest
from cheap import APART, CHEAP

from hcss_twin import Scenario, make_plan
from hcss_twin.engine import compile as compiling
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.stream import stream
from hcss_twin.engine.tables.spectrum import Spectrum
from hcss_twin.models.radiance.physical import sunlight_in_air
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.physics.sun import sun_position
from hcss_twin.plan import sunlight
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Sun, View

TWO = [[3.7, 3.8], [10.5, 11.0]]  # of sunlight and of none; narrow, because time grows with the wavenumbers
SMALL = {"image.rows": 16, "image.columns": 16, "frames.count": 2, "bands": TWO}
PHYSICAL = {"bands": TWO, "accuracy": 1e-2, **APART}
NIGHT = {"time": "2024-04-20T00:30:00+10:00"}
FIELD = {"clouds.coverage_mode": "field"}
ROUNDING = 1e-6
"""Radiance is in single precision."""


def plan_of(name="stratus", models=CHEAP, **overrides):
    return make_plan(Scenario.load(name, {**SMALL, **models, **overrides}))


def bound_of(plan, what):
    (item,) = [item for item in plan.omissions if item.what == what]
    return item.bound


def frames_of(plan):
    tables = compile_tables(plan) if plan.needs_radiance else None
    return list(stream(plan, tables))


def radiance_of(plan):
    return np.stack([frame["radiance"] for frame in frames_of(plan)]).astype(np.float64)


def largest_change(full, short):
    return float(np.max(np.abs(full - short) / short))


@pytest.fixture
def every_wavenumber(monkeypatch):
    """No wavenumbers are chosen, so that runs differ by what is left out and not by the choice."""

    def all_of(plan, *_):
        grid = plan.spectral_grid
        return Spectrum(grid.all_nodes(), grid.wavenumber_cm1.size, 0.0)

    monkeypatch.setattr(compiling, "choose_spectrum", all_of)


def seen_below_the_horizon(plan, time_s):
    """Sun as a run without the rule has it."""
    return plan.sun_track.at(time_s)


@pytest.mark.parametrize("models", [CHEAP, PHYSICAL], ids=["as-printed", "physical"])
def test_sunlight_at_night(monkeypatch, models):
    plan = plan_of(models=models, **NIGHT)
    short = radiance_of(plan)
    monkeypatch.setattr(Plan, "sun_at", seen_below_the_horizon)
    assert bound_of(plan, "sunlight") == 0.0
    assert np.array_equal(radiance_of(plan), short)


def test_sunlight_in_frames_after_sunset(monkeypatch):
    sunset = {"time": "2024-04-20T17:30:00+10:00", "frames.count": 4, "frames.interval": 1800.0}
    plan = plan_of(**sunset)
    assert 0 < np.count_nonzero(plan.sun_zenith_deg < 90.0) < 4
    short = radiance_of(plan)
    monkeypatch.setattr(Plan, "sun_at", seen_below_the_horizon)
    assert bound_of(plan, "sunlight in some frames") == 0.0
    assert np.array_equal(radiance_of(plan), short)


@pytest.mark.parametrize(
    ("models", "name", "time"),
    [
        (CHEAP, "stratus", "12:30"),
        (CHEAP, "cirrus-over-cumulus", "15:30"),
        (PHYSICAL, "stratus", "16:00"),
        pytest.param(PHYSICAL, "cirrus", "15:00", marks=pytest.mark.campaign),
        pytest.param(PHYSICAL, "stratus", "12:30", marks=pytest.mark.campaign),
    ],
)
def test_faint_sunlight_by_day(models, name, time):
    day = {"time": f"2024-04-20T{time}:00+10:00", "bands": [[10.5, 11.5]], "accuracy": 1e-2, "frames.count": 1}
    plan = plan_of(name, models, **day)
    bound = bound_of(plan, "sunlight")
    assert 0.0 < bound < plan.budget.faint_sunlight
    assert plan.sun_at(0.0) is None
    layers = plan.layers
    random = np.random.default_rng(0).random((6, len(layers)))
    columns = np.stack(
        [
            low.thickness_min_m * (low.thickness_max_m / low.thickness_min_m) ** share
            for low, share in zip(layers, random.T, strict=True)
        ],
        axis=1,
    )
    # Clear sky, each layer alone, and all layers.
    columns[0] = 0.0
    columns[1 : 1 + len(layers)] *= np.eye(len(layers))
    grid, model = plan.spectral_grid, plan.assembly.model
    sun = plan.sun_up_at(0.0)
    with_sun, without = (
        SpectralGrid.reference_radiance(model, plan.assembly.setting(each), grid, columns, 8) for each in (sun, None)
    )
    assert 0.1 * bound < largest_change(with_sun, without) < bound
    lit = dataclasses.replace(plan, sunlight=sunlight.COMPUTED)
    assert lit.sun_at(0.0) == sun
    errors = compile_tables(plan).estimated_error + compile_tables(lit).estimated_error
    assert largest_change(radiance_of(lit), radiance_of(plan)) < errors + ROUNDING


def test_sunlight_is_not_faint_where_it_is_asked_for_or_makes_shadows():
    faint = {"bands": [[9.0, 12.0]], "accuracy": 1e-2}
    assert not plan_of(**faint).sunlight.is_computed
    assert plan_of(**faint, **{"output.variables": ["terms", "radiance"]}).sunlight.is_computed
    assert plan_of(**faint, **FIELD, **{"slant.shadows": "on"}).sunlight.is_computed
    assert plan_of(**faint | {"accuracy": 1e-5}).sunlight.is_computed
    assert plan_of(**faint | {"bands": [[9.0, 12.0], "mwir"]}).sunlight.is_computed


@pytest.mark.long
def test_sunlight_scattered_by_air_under_a_very_low_sun(monkeypatch):
    """With the limit moved from 88 to 70 degrees, where the model can do without the rule."""
    evening = {"bands": ["swir-2.7-3.0"], "accuracy": 1e-2, "time": "2024-04-20T17:15:00+10:00"}
    full = plan_of(models={}, **evening)
    assert not any("low sun" in item.what for item in full.omissions)
    sun = full.sun_up_at(0.0)
    with_all = reached(full, full.assembly, sun)
    monkeypatch.setattr(sunlight, "LOW_SUN_DEG", 70.0)
    monkeypatch.setattr(sunlight_in_air, "MAX_SUN_ZENITH_DEG", 70.0)
    short = plan_of(models={}, **evening)
    bound = bound_of(short, "sunlight of a very low sun")
    assert 70.0 < sun.zenith_deg < 80.0
    assert 0.2 * bound < largest_change(with_all, reached(short, short.assembly, sun)) < bound


def test_a_very_low_sun_is_told():
    low = {"time": "2024-04-20T18:27:00+10:00", "bands": ["swir-2.7-3.0", "mwir"]}
    plan = plan_of(models={}, accuracy=1e-2, **low)
    assert 88.0 < plan.sun_zenith_deg[0] < 90.0
    assert 1e-3 < bound_of(plan, "sunlight of a very low sun") < 0.1


def test_clouds_where_there_are_none(monkeypatch, every_wavenumber):
    nothing = plan_of(**{"clouds": {"layers": []}})
    empty = plan_of(**{"clouds.coverage": 0.0})
    assert bound_of(nothing, "cloud optics and cloudy columns") == bound_of(empty, "cloudy columns") == 0.0
    short = radiance_of(nothing), radiance_of(empty)
    monkeypatch.setattr(Assembly, "cloudy_layers", property(lambda assembly: (True,) * len(assembly.layers)))
    tables = compile_tables(plan_of(**{"clouds.coverage": 0.0}))
    assert tables.axes[0] is not None
    full = radiance_of(plan_of(**{"clouds.coverage": 0.0}))
    assert np.array_equal(short[0], short[1])
    assert np.array_equal(short[0], full)


def test_a_layer_without_coverage(monkeypatch, every_wavenumber):
    name, coverage = "cirrus-over-cumulus", {"accuracy": 1e-2, "bands": TWO, "image.samples_per_pixel": 1}
    layers = Scenario.load(name).clouds.layers
    kinds = [{"type": layer.type, "coverage": 0.5 * number} for number, layer in enumerate(layers)]
    plan = plan_of(name, **coverage, **{"clouds": {"layers": kinds}})
    empty = plan.layers[plan.assembly.cloudy_layers.index(False)].name
    assert bound_of(plan, f"columns with {empty}") == 0.0
    short = radiance_of(plan)
    monkeypatch.setattr(Assembly, "cloudy_layers", property(lambda assembly: (True, True)))
    full = plan_of(name, **coverage, **{"clouds": {"layers": kinds}})
    tables = compile_tables(full)
    assert None not in tables.axes
    # Tables of two layers have other nodes than that of one; both keep their own errors.
    errors = tables.estimated_error + compile_tables(plan).estimated_error
    assert largest_change(np.stack([f["radiance"] for f in stream(full, tables)]), short) < errors + ROUNDING


def test_outputs_that_are_not_asked_for():
    short, full = plan_of(**{"output.certificate": 0}), plan_of(**{"output.variables": ["all"]})
    for what in ("look-up of terms of the radiance", "other variables", "the certificate"):
        assert bound_of(short, what) == 0.0
        assert not any(item.what == what for item in full.omissions)
    assert np.array_equal(radiance_of(short), radiance_of(full))


def test_radiance_that_is_not_asked_for():
    mask = plan_of(**{"output.variables": ["cloud_mask"]})
    assert bound_of(mask, "all radiance") == 0.0
    for short, full in zip(frames_of(mask), frames_of(plan_of()), strict=True):
        assert set(short) == {"cloud_mask"}
        assert np.array_equal(short["cloud_mask"], full["cloud_mask"])


def test_tables_for_single_pixels():
    plan = plan_of(**{"output.variables": ["radiance", "cloud_thickness"], "accuracy": 1e-3})
    bound = bound_of(plan, "radiance of single pixels")
    assert bound == 1e-3
    for time_s, frame in zip(plan.frame_times_s, frames_of(plan), strict=True):
        pixels = np.random.default_rng(1).choice(frame["cloud_thickness"].size, 16, replace=False)
        thickness = frame["cloud_thickness"].ravel()[pixels].astype(np.float64)
        setting = plan.assembly.setting(plan.sun_up_at(float(time_s)))
        exact = SpectralGrid.reference_radiance(plan.assembly.model, setting, plan.spectral_grid, thickness)
        assert largest_change(frame["radiance"].reshape(len(plan.bands), -1)[:, pixels].T, exact) < bound


LARGE = {"image.pixel_size": 1000.0, "frames.count": 1}
PLACES = [(x, y) for x in (-8e3, -3e3, 0.0, 8e3) for y in (-8e3, 0.0, 5e3, 8e3)]


def reached(plan, scene, sun):
    """Clear sky and clouds from the thinnest to the thickest."""
    layer = plan.layers[0]
    columns = np.concatenate(([0.0], np.geomspace(layer.thickness_min_m, layer.thickness_max_m, 3)))
    return SpectralGrid.reference_radiance(scene.model, scene.setting(sun), plan.spectral_grid, columns, 8)


@pytest.mark.parametrize(
    ("models", "changes"),
    [
        (CHEAP, {}),
        (CHEAP, {"view.zenith": 0.0}),
        (CHEAP, {"view.zenith": 55.0, **NIGHT}),
        (CHEAP, {"time": "2024-04-20T16:30:00+10:00", "view.azimuth": 100.0}),
        pytest.param(PHYSICAL, {}, marks=pytest.mark.campaign),
        pytest.param(PHYSICAL, {"time": "2024-04-20T16:00:00+10:00"}, marks=pytest.mark.campaign),
        # Toward the glory and beside the rainbow of the droplets.
        pytest.param(PHYSICAL, {"view.zenith": 26.0, "view.azimuth": 200.0}, marks=pytest.mark.long),
        pytest.param(PHYSICAL, {"view.zenith": 16.0, "view.azimuth": 90.0}, marks=pytest.mark.campaign),
    ],
)
def test_one_view_angle_for_all_pixels(models, changes):
    plan = plan_of(models=models, **LARGE, **changes)
    bound, sun = bound_of(plan, "view angles of single pixels"), plan.sun_up_at(0.0)
    zenith, azimuth = math.radians(plan.view.zenith_deg), math.radians(plan.view.azimuth_deg)
    foot = 800e3 * math.tan(zenith)
    known, found = reached(plan, plan.assembly, sun), []
    for x, y in PLACES:
        east, north = foot * math.sin(azimuth) - x, foot * math.cos(azimuth) - y
        seen = View(math.degrees(math.atan(math.hypot(east, north) / 800e3)), math.degrees(math.atan2(east, north)))
        found.append(largest_change(reached(plan, plan.assembly.toward(seen), sun), known))
    assert 0.2 * bound < max(found) < bound


@pytest.mark.parametrize("altitude", ["400 km", "36000 km"])
def test_one_view_angle_seen_from_a_platform(altitude):
    narrow = {"image.pixel_size": 40.0, "frames.count": 1, "accuracy": 0.05, "platform.altitude": altitude}
    plan = plan_of(**narrow)
    assert not plan.views.varies
    (told,) = [item for item in plan.omissions if item.what == "view angles of single pixels"]
    assert f"seen from {altitude}" in told.why
    sun, known, found = plan.sun_up_at(0.0), reached(plan, plan.assembly, plan.sun_up_at(0.0)), []
    for x, y in PLACES:
        # Half an image is 320 m.
        seen = plan.assembly.lines_of_sight.from_points(np.array(x / 25.0), np.array(y / 25.0))
        view = View(float(seen.zenith_deg), float(seen.plane_azimuth_deg))
        found.append(largest_change(reached(plan, plan.assembly.toward(view), sun), known))
    assert 0.2 * told.bound < max(found) < told.bound


def test_one_view_angle_for_clouds_that_each_line_of_sight_meets_elsewhere():
    """They are displaced by half a pixel: by a hundredth more in some places, and so by a whole one."""
    changes = {
        "image.rows": 20, "image.columns": 24, "image.pixel_size": 4000.0, "view.zenith": 75.0, "view.azimuth": 0.0,
        "frames.count": 1, "accuracy": 1e-2, "slant.parallax": "on", "slant.shadows": "off",
        "clouds.base": 2000.0 / math.tan(math.radians(75.0)), "clouds.top": 1000.0, "clouds.anchor": "base",
        "output.variables": ["radiance", "cloud_thickness"],
    }  # fmt: skip
    plan = plan_of(**changes)
    (told,) = [item for item in plan.omissions if item.what == "view angles of single pixels"]
    assert told.sense == "pixels that see the same clouds"
    (short,), (full,) = (frames_of(each) for each in (plan, plan_of(**changes, **{"platform.altitude": "800 km"})))
    clouds = [np.nan_to_num(each["cloud_thickness"]) for each in (short, full)]
    same = np.broadcast_to(clouds[0] == clouds[1], full["radiance"].shape)
    assert 0.5 < same.mean() < 1.0
    change = np.abs(full["radiance"] / short["radiance"].astype(float) - 1.0)
    assert told.size < change.max() < told.bound
    assert 0.2 * told.size < change[same].max() < told.size


@pytest.mark.parametrize(
    ("models", "time"),
    [
        (CHEAP, "12:30"),
        (CHEAP, "16:30"),
        (CHEAP, "17:15"),
        pytest.param(PHYSICAL, "12:30", marks=pytest.mark.campaign),
        pytest.param(PHYSICAL, "16:30", marks=pytest.mark.long),
    ],
)
def test_one_sun_for_all_pixels(models, time):
    plan = plan_of(models=models, **LARGE, time=f"2024-04-20T{time}:00+10:00")
    bound = bound_of(plan, "sun angles of single pixels")
    place, known = plan.scenario.place, reached(plan, plan.assembly, plan.sun_up_at(0.0))
    found = []
    for x, y in PLACES:
        # Degrees on a sphere of 6371 km.
        north = place.latitude + y / 111_194.9
        east = place.longitude + x / (111_194.9 * math.cos(math.radians(place.latitude)))
        where = sun_position([plan.scenario.time], np.array([north]), np.array([east]))
        found.append(largest_change(reached(plan, plan.assembly, Sun(*(float(each[0]) for each in where))), known))
    assert 0.2 * bound < max(found) < bound


def test_clouds_within_the_footprint():
    changes = {"accuracy": 1e-2, "image.pixel_size": 200.0, **FIELD}
    plan = plan_of("cumulus", **changes)
    bound = bound_of(plan, "clouds within the footprint of a pixel")
    averaged = plan_of("cumulus", **changes, **{"image.samples_per_pixel": 4})
    assert not any("footprint" in item.what for item in averaged.omissions)
    assert 0.0 < largest_change(radiance_of(averaged), radiance_of(plan)) < bound


def test_overcast_pixels_hold_no_edge():
    changes = {"accuracy": 1e-2, "clouds.coverage": 1.0, **FIELD}
    plan = plan_of("stratus", **changes)
    (omission,) = [item for item in plan.omissions if "footprint" in item.what]
    averaged = plan_of("stratus", **changes, **{"image.samples_per_pixel": 4})
    change = radiance_of(plan) / radiance_of(averaged) - 1.0
    rms = np.sqrt(np.mean(change**2, axis=tuple(range(change.ndim))))
    assert "no pixel holds an edge" in omission.sense
    assert 0.0 < rms < omission.estimate


@pytest.mark.parametrize("shadows", ["off", "on"])
def test_parallax(shadows):
    changes = {"accuracy": 1e-2, "bands": TWO, "slant.shadows": shadows, **FIELD}
    plan = plan_of("cumulus", **changes)
    displaced = plan_of("cumulus", **changes, **{"slant.parallax": "on"})
    bound = bound_of(plan, "parallax of clouds")
    assert 0.0 < largest_change(radiance_of(displaced), radiance_of(plan)) < bound
    if shadows == "off":
        return
    vertical = plan_of("cumulus", **changes, **{"slant.parallax": "on", "view.zenith": 0.0})
    assert bound_of(vertical, "parallax of clouds") == 0.0
    straight = plan_of("cumulus", **changes, **{"view.zenith": 0.0})
    assert np.array_equal(radiance_of(vertical), radiance_of(straight))


def test_shadows():
    changes = {"accuracy": 1e-2, **FIELD}
    plan = plan_of("cumulus", **changes)
    shaded = plan_of("cumulus", **changes, **{"slant.shadows": "on"})
    bound = bound_of(plan, "shadows of clouds on the sea")
    assert 0.9 * bound < largest_change(radiance_of(shaded), radiance_of(plan)) < bound
    covered = {**changes, "clouds.coverage": 1.0}
    plan, shaded = plan_of(**covered), plan_of(**covered, **{"slant.shadows": "on"})
    assert bound_of(plan, "shadows of clouds on the sea") == 0.0
    assert np.array_equal(radiance_of(shaded), radiance_of(plan))


def test_shadows_left_to_the_plan_are_skipped_where_they_change_less_than_their_share(every_wavenumber):
    changes = {"accuracy": 1e-2, **FIELD, "bands": TWO[1:]}
    plan, shaded = (plan_of("cumulus", **changes, **{"slant.shadows": value}) for value in ("auto", "on"))
    assert not plan.has_shadows
    assert shaded.has_shadows
    bound = bound_of(plan, "shadows of clouds on the sea")
    assert bound <= 0.1 * changes["accuracy"]
    assert 0.0 < largest_change(radiance_of(shaded), radiance_of(plan)) <= bound + ROUNDING
    assert plan_of("cumulus", **{**changes, "bands": TWO[:1]}, **{"slant.shadows": "auto"}).has_shadows


def test_waves_under_a_closed_cloud(every_wavenumber):
    changes = {"bands": TWO[:1], "accuracy": 1e-2, "frames.count": 1}
    changes |= {"sea.model": "rough-sea", "image.pixel_size": 2.0, "clouds.coverage": 1.0}
    plan = plan_of(**changes, **{"sea.waves": "auto"})
    drawn = plan_of(**changes, **{"sea.waves": "on"})
    assert not plan.waves.varies
    assert drawn.waves.varies
    assert bound_of(plan, "waves as shapes") == 0.0
    assert np.array_equal(radiance_of(drawn), radiance_of(plan))
    gaps = changes | {"clouds.coverage": 0.9}
    assert bound_of(plan_of(**gaps, **{"sea.waves": "off"}), "waves as shapes") > 0.0


def test_every_rule_is_in_the_documentation():
    page = (Path(__file__).parents[2] / "docs" / "development" / "accuracy-and-speed.md").read_text(encoding="utf-8")
    told = {
        item.what
        for changes in ({}, {"clouds": {"layers": []}}, {"clouds.coverage": 0.0}, {"output.certificate": 0}, NIGHT)
        for item in plan_of(**changes, **{"output.variables": ["radiance"]}).omissions
        if item.bound is not None
    }
    assert len(told) > 10
    assert [what for what in sorted(told) if f"| {what} |" not in page] == []
    own = Path(__file__).read_text(encoding="utf-8")
    tests = re.findall(r"`(test_\w+)`", page)
    others = "".join(
        path.read_text(encoding="utf-8") for path in Path(__file__).parents[1].glob("end_to_end/test_[ow]*.py")
    )
    assert [name for name in tests if f"def {name}(" not in own + others] == []
