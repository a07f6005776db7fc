"""A pixel of a wide image has the radiance of a narrow scene seen along that pixel's line of sight."""

import dataclasses
import re

import numpy as np
import pytest
from cheap import CHEAP

from hcss_twin import Scenario, ScenarioError, make_plan, simulate
from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.engine.certificate.certify import certify
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.stream import stream
from hcss_twin.engine.verification import verify_cube
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.plan.views import ONE_VIEW

WIDE = {
    "image.rows": 30,
    "image.columns": 40,
    "image.pixel_size": 3000.0,
    "frames.count": 2,
    "bands": ["mwir-3.7", "lwir-10.8"],
    "accuracy": 1e-2,
    "platform.altitude": "800 km",
    "output.variables": ["radiance", "cloud_thickness"],
}
PHYSICAL = {**WIDE, "bands": ["mwir-3.7"], "image.pixel_size": 2500.0}


def plan_of(changes, models=CHEAP, name="stratus"):
    return make_plan(Scenario.load(name, {**WIDE, **models, **changes}))


def narrow_scene(plan, row, column):
    """The scene without a platform, with the view of one pixel."""
    scenario, image = plan.scenario, plan.scenario.image
    place, view = scenario.place, scenario.view
    lines = LinesOfSight(place.latitude, place.longitude, view.zenith, view.azimuth, 800e3)
    x, y = column - 0.5 * (image.columns - 1), row - 0.5 * (image.rows - 1)
    seen = lines.from_points(np.array(x * image.pixel_size), np.array(y * image.pixel_size))
    raw = {key: value for key, value in scenario.model_dump(mode="json").items() if key != "platform"}
    raw["view"] = {"zenith": float(seen.zenith_deg), "azimuth": float(seen.plane_azimuth_deg)}
    raw["image"] |= {"rows": 1, "columns": 1, "pixel_size": 1.0}
    return make_plan(Scenario.from_dict(raw)).assembly


def radiance_of(scene, plan, thickness):
    setting = scene.setting(plan.sun_up_at(0.0))
    return SpectralGrid.reference_radiance(scene.model, setting, plan.spectral_grid, thickness)[0]


@pytest.mark.parametrize(
    ("changes", "models", "name"),
    [
        ({}, CHEAP, "stratus"),
        # The pole lies in the image.
        (
            {"time": "2024-04-20T00:30:00+10:00", "place.latitude": 89.7, "accuracy": 1e-3, "bands": ["mwir-3.7"]},
            CHEAP,
            "stratus",
        ),
        pytest.param({"view.zenith": 0.0, "image.pixel_size": 8000.0}, CHEAP, "stratus", marks=pytest.mark.campaign),
        pytest.param(
            {"view.zenith": 45.0, "view.azimuth": 250.0, "accuracy": 1e-3}, CHEAP, "cumulus", marks=pytest.mark.long
        ),
        pytest.param(PHYSICAL, {}, "stratus", marks=pytest.mark.campaign),
    ],
)
def test_a_pixel_has_the_radiance_of_a_narrow_scene_at_its_view(changes, models, name):
    flat = {"sea.temperature": 290.0, "sea.temperature_texture": 0, "sea.wind_speed": 8.0}
    plan = plan_of({**flat, **changes}, models, name)
    assert plan.views.varies
    accuracy = plan.accuracy.relative
    frame = next(stream(plan, compile_tables(plan)))
    random, one_view = np.random.default_rng(2), []
    pixels = [(0, 0), (0, 39), (29, 0), (29, 39), *random.integers((0, 0), (30, 40), (2, 2)).tolist()]
    for row, column in pixels:
        thickness = frame["cloud_thickness"][row, column : column + 1].astype(np.float64)
        exact = radiance_of(narrow_scene(plan, row, column), plan, thickness)
        found = frame["radiance"][:, row, column]
        assert np.max(np.abs(found / exact - 1.0)) < accuracy
        centre = radiance_of(plan.assembly, plan, thickness)
        one_view.append(np.max(np.abs(centre / exact - 1.0)))
    # It is needed: one view for all pixels would miss the accuracy.
    assert max(one_view) > 2.0 * accuracy


def test_the_certificate_follows_the_view_of_each_pixel():
    plan = plan_of({"frames.count": 1, "bands": ["mwir-3.7"]})
    tables, sample = compile_tables(plan), PixelSample(plan)
    list(stream(plan, tables, sample))
    assert certify(plan, tables, sample.frames).passed
    blind = dataclasses.replace(plan, views=ONE_VIEW)
    tables, sample = compile_tables(blind), PixelSample(blind)
    list(stream(blind, tables, sample))
    assert certify(blind, tables, sample.frames).passed
    found = certify(plan, tables, sample.frames)
    assert not found.passed
    assert found.exceeding > 4


def test_long_paths_through_air_as_warm_as_the_sea_have_wavenumbers_of_their_own():
    """In the window at night the radiance of a wide field hardly changes, because air emits what it absorbs."""
    night = {"time": "2024-04-20T22:30:00+10:00", "frames.count": 1, "bands": ["lwir"], "accuracy": 1e-3}
    wide = {"image.rows": 32, "image.columns": 32, "image.pixel_size": 16e3, "view.zenith": 50.0}
    changes = {**WIDE, **CHEAP, **night, **wide, "sea.temperature_texture": 0.0, "output.certificate": 24}
    cube = simulate(Scenario.load("stratus", changes))
    clear = cube.radiance.values[0, 0][cube.cloud_thickness.values[0] == 0.0]
    assert clear.max() < 1.1 * clear.min()
    assert cube.attrs["hcss_certificate"].startswith("computed as specified")


def test_a_wide_cube_says_what_its_views_err_and_can_be_verified(tmp_path):
    changes = {"output.certificate": 4, "output.variables": ["radiance", "terms", "geometry"], "bands": ["mwir-3.7"]}
    scenario = plan_of(changes).scenario
    with simulate(scenario, tmp_path / "a.nc") as cube:
        errors = cube.attrs["hcss_table_errors"]
        assert '"views": 0.0,' not in errors
        assert cube.attrs["hcss_certificate"].startswith("computed as specified")
        assert "view angles" not in cube.attrs["hcss_skipped"]
        terms = sum(cube[name].to_numpy() for name in cube.data_vars if name.startswith("radiance_"))
        np.testing.assert_allclose(terms, cube["radiance"], rtol=2e-3)
    assert verify_cube(tmp_path / "a.nc").verdict == "identical"


def test_waves_that_no_pixel_of_a_wide_field_resolves_are_left_out():
    plan = plan_of({"sea.waves": "auto", "frames.count": 1}, {**CHEAP, "sea.model": "rough-sea"})
    assert plan.views.varies
    assert not plan.waves.varies


def test_kelvin_are_kept_where_the_hottest_pixel_is_in_a_corner():
    """It is nearer to the glint than the middle: the same kelvin are a smaller share of its radiance."""
    day = {"view.azimuth": 198.72, "image.pixel_size": 10_000.0, "bands": ["mwir-3.7"], "accuracy": "1 K"}
    wide, one = (plan_of({**day, "platform.altitude": each}).accuracy.relative for each in ("800 km", None))
    assert 0.5 * one < wide < 0.99 * one


def test_an_image_beyond_the_sensors_horizon_is_refused():
    with pytest.raises(ScenarioError, match=r"platform\.altitude: a corner of 40 x 30 pixels of 100000 m sees"):
        plan_of({"image.pixel_size": 100_000.0, "platform.altitude": "500 km"})


def test_a_day_over_a_wide_field_that_no_affordable_number_of_views_follows_is_refused(monkeypatch):
    monkeypatch.setattr("hcss_twin.plan.views.MAX_NODES", 6)
    needs = r"accuracy: 0\.01: the view changes over the image: .* needs (\d+) x (\d+) views, .* up to 6 views"
    with pytest.raises(ScenarioError, match=needs) as caught:
        plan_of({})
    x, y = map(int, re.search(needs, str(caught.value)).groups())
    assert f"which are {x * y}; allowed" in str(caught.value)
    assert x * y > 6


def test_a_wide_field_whose_error_stays_too_large_is_refused_with_this_error(monkeypatch):
    monkeypatch.setattr("hcss_twin.plan.views.MAX_ORDER", 1)
    with pytest.raises(ScenarioError, match=r"an error of (\S+) of the radiance remains .* of (\S+),") as caught:
        plan_of({"view.zenith": 60.0, "image.pixel_size": 8000.0, "accuracy": 1e-3})  # no narrow field
    error, allowed = re.search(r"an error of (\S+) of .* an error of (\S+),", str(caught.value)).groups()
    assert float(error) > float(allowed)
