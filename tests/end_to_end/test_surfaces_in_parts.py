"""Scenes with surfaces have the same bits however they are divided, and equal scenes with one surface alone."""

import json
from functools import partial

import numpy as np
import pytest
from cheap import CHEAP, NARROW
from surface_files import write_half
from written_cubes import assert_same_bits

from hcss_twin import Scenario, make_plan
from hcss_twin.core.errors import HcssError, ScenarioError
from hcss_twin.cube.reader import open_cube
from hcss_twin.engine import parts, stream
from hcss_twin.engine.simulate import run
from hcss_twin.engine.tables import frame_look_up
from hcss_twin.engine.verification import Verdict, verify_cube
from hcss_twin.plan.windows import windows
from hcss_twin.reports.plan_text import plan_text

SCENE = """
time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
image = {rows = 30, columns = 40}
frames.count = 2
bands = [{name = "mwir", limits = [3.6, 3.8]}, {name = "lwir", limits = [10.5, 11.0]}]
sea = {temperature = 290.0, wind_speed = 6.0}
clouds = {type = "stratus", coverage = 0.5, coverage_mode = "field"}
output.variables = ["radiance", "truth", "terms"]

[surfaces]
provider = "raster"
parameters = {file = "half.nc", classes = {0 = "sea", 1 = "sand"}}
"""
FIELD = {"file": "half.nc", "classes": {0: "sea", 1: "sand"}, "temperature_layer": "temperature"}
MIXED = {"surfaces.parameters": FIELD, "image.samples_per_pixel": 2, "bands": NARROW[1:], "output.certificate": 12}
ALONE = {"surfaces": None, "sea.temperature_texture": 0.0, "output.variables": ["radiance", "cloud_mask", "terms"]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("surfaces")
    write_half(path / "half.nc", temperature=lambda latitude, longitude: 290.0 + 300.0 * (latitude - 35.0))
    write_half(path / "steep.nc", temperature=lambda latitude, longitude: 290.0 + 1500.0 * (latitude - 35.0))
    return path


def planned(folder, **changes):
    return make_plan(Scenario.from_toml(SCENE, {**CHEAP, **changes}, base=folder))


def written(folder, name, workers=1, **changes):
    return run(planned(folder, **changes), folder / name, workers=workers)


def values(path, *names):
    with open_cube(path) as cube:
        return [cube[name].to_numpy() for name in names]


@pytest.fixture(scope="module")
def whole(folder):
    return written(folder, "whole.nc", **MIXED)


@pytest.fixture(scope="module")
def halves(folder):
    return written(folder, "halves.nc")


def test_windows_tiles_and_workers_have_the_same_bits(folder, whole):
    again = partial(written, folder, **MIXED | {"output.certificate": 0})
    part = {"image.window": {"rows": [11, 19], "columns": [17, 26]}}
    assert_same_bits(whole, again("part.nc", **part), (slice(11, 19), slice(17, 26)))
    # Patches of its own, on which no analysis of the scene depends: that of the whole serves.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stream, "windows", partial(windows, most_points=300))
        patch.setattr(frame_look_up, "VALUES_AT_ONCE", 2000)
        assert_same_bits(whole, again("strips.nc"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parts, "LARGEST_FRAME_BYTES", 1)
        patch.setattr(parts, "TILE_PIXELS", 90)
        assert_same_bits(whole, again("tiles.nc"))
        assert_same_bits(whole, again("workers.nc", workers=2))


def test_pixels_of_a_class_equal_the_scene_of_that_class_alone(folder, halves):
    radiance, number, emitted = values(halves, "radiance", "surface_class", "radiance_sea_emission")
    assert 0.4 < np.mean(number) < 0.6
    sea = values(written(folder, "sea.nc", **ALONE), "radiance", "radiance_sea_emission")
    sand = {"surfaces.parameters": {"file": "half.nc", "classes": {0: "sand", 1: "sand"}}}
    land = values(written(folder, "sand.nc", **sand), "radiance", "radiance_sea_emission")
    for own, (of_radiance, of_term) in enumerate((sea, land)):
        here = np.broadcast_to(number[:, None] == own, radiance.shape)
        np.testing.assert_array_equal(radiance[here], of_radiance[here])
        np.testing.assert_array_equal(emitted[here], of_term[here])
    assert np.median(np.abs(land[0] / sea[0] - 1.0)) > 1e-3


def test_a_mixed_pixel_is_the_mean_of_its_points(folder, halves):
    """Four points of a clear pixel: the mean of two of sea and two of sand."""
    clear = {"clouds": {}, "output.variables": ["radiance", "surface_class"], "frames.count": 1}
    fine = written(folder, "fine.nc", **clear, **{"image.rows": 60, "image.columns": 82, "image.pixel_size": 10.0})
    coarse = written(folder, "coarse.nc", **clear, **{"image.columns": 41, "image.samples_per_pixel": 2})
    (points,), (pixels,) = values(fine, "radiance"), values(coarse, "radiance")
    means = points.astype(float).reshape(1, 2, 30, 2, 41, 2).mean(axis=(3, 5))
    np.testing.assert_allclose(pixels, means, rtol=2e-7)
    assert np.unique(pixels[0, 1]).size == 3


def test_a_point_in_a_field_of_temperature_equals_the_sea_of_that_temperature(folder):
    """Within the accuracy, at the places where the polynomial is farthest from its nodes."""
    sea = {"file": "steep.nc", "temperature_layer": "temperature"}
    path = written(folder, "field.nc", **{"surfaces.parameters": sea})
    radiance, kelvin, mask = values(path, "radiance", "surface_temperature", "cloud_mask")
    assert np.ptp(kelvin) > 5.0
    for row in (0, 12):
        here = float(kelvin[0, row, 0])
        other = written(folder, f"{row}.nc", **ALONE, **{"sea.temperature": here})
        (expected,) = values(other, "radiance")
        near = np.abs(kelvin[:, None, row] - here) < 1e-4
        near = np.broadcast_to(near, expected[:, :, row].shape)
        error = np.abs(radiance[:, :, row] / expected[:, :, row] - 1.0)[near]
        assert np.max(error) < 5e-4  # both scenes have an error of their own
    assert 0.1 < np.mean(mask) < 0.9


def test_truth_has_the_map_and_its_flags(halves, whole):
    with open_cube(halves) as cube:
        assert cube["surface_class"].attrs["flag_meanings"] == "sea sand"
        kelvin, number = cube["surface_temperature"].to_numpy(), cube["surface_class"].to_numpy()
        assert np.all(kelvin[number == 0] == np.float32(290.0))
        assert np.unique(kelvin[number == 1]).size == 1
    kelvin, number = values(whole, "surface_temperature", "surface_class")
    assert np.ptp(kelvin[0, :, 0]) > 1.0
    assert np.all(np.diff(number[0], axis=1) >= 0)


def test_the_certificate_draws_from_each_class_and_passes(whole):
    with open_cube(whole) as cube:
        assert cube.attrs["hcss_certificate"].startswith("computed as specified")
        strata = {each["name"]: each["checked"] for each in json.loads(cube.attrs["hcss_certificate_strata"])}
        assert strata["clear over sea"] > 0
        assert strata["clear over sand"] > 0
        assert cube.attrs["hcss_table_error_estimated"] < 1e-3


def test_the_certificate_sees_a_wrong_surface(folder, monkeypatch):
    fill = frame_look_up.FrameLookUp.fill

    def wrong(self, radiance, *arguments):
        own = np.full_like(radiance, np.nan)
        fill(self, own, *arguments)
        np.copyto(radiance, own * np.float32(1.01), where=~np.isnan(own))

    monkeypatch.setattr(frame_look_up.FrameLookUp, "fill", wrong)
    with pytest.warns(match="NOT as specified"):
        written(folder, "wrong.nc")


def test_verification_reproduces_surfaces(whole):
    assert verify_cube(whole).verdict is Verdict.IDENTICAL


def test_elements_hide_the_surface_behind_them(folder):
    """A source adds the same over sea and over sand."""
    source = {"elements": [{"parameters": {"tracks": [{"x": x, "intensity": 1e4} for x in (-300, 300)]}}]}
    clear = {"clouds": {}, "output.variables": ["radiance", "surface_class", "element_radiance"], "frames.count": 1}
    added, number = values(written(folder, "source.nc", **clear, **source), "element_radiance", "surface_class")
    places = np.nonzero(added[0, 0])
    assert set(number[0][places].tolist()) == {0, 1}
    np.testing.assert_allclose(added[0, :, places[0][0], places[1][0]], added[0, :, places[0][1], places[1][1]], 1e-5)


def test_views_of_single_pixels_reach_every_surface(folder):
    far = {"platform.altitude": 5e5, "image.pixel_size": 90.0, "view.zenith": 60.0, "accuracy": 1e-4, "frames.count": 1}
    far |= {"bands": ["lwir"], "clouds": {}, "output.variables": ["radiance", "surface_class"]}
    plan = planned(folder, **far)
    assert plan.views.varies
    path = run(plan, folder / "views.nc")
    radiance, number = values(path, "radiance", "surface_class")
    expected = values(written(folder, "views-sea.nc", **{**far, **ALONE}), "radiance")[0]
    here = np.broadcast_to(number[:, None] == 0, radiance.shape)
    np.testing.assert_allclose(radiance[here], expected[here], rtol=1e-4)
    with open_cube(path) as cube:
        assert cube.attrs["hcss_certificate"].startswith("computed as specified")


def test_shadows_fall_on_every_class_and_waves_stay_on_the_sea(folder):
    low = {"time": "2024-04-20T07:30:00+10:00", "frames.count": 1, "image.pixel_size": 40.0}
    shadows = {**low, "slant.shadows": "on"}
    radiance, number, shadow = values(
        written(folder, "shadows.nc", **shadows), "radiance", "surface_class", "shadow_mask"
    )
    off = {**low, "output.variables": ["radiance", "cloud_mask"]}
    (lit,) = values(written(folder, "lit.nc", **off), "radiance")
    loss = (lit - radiance)[:, 0]
    for own in (0, 1):
        assert np.all(loss[(number == own) & (shadow == 1)] >= 0.0)
        assert np.all(loss[(number == own) & (shadow == 0)] == 0.0)
    assert np.mean(loss[(number == 1) & (shadow == 1)]) > 10 * np.mean(loss[(number == 0) & (shadow == 1)]) > 0.0
    waves = {"sea.model": "rough-sea", "sea.waves": "on", "clouds": {}, "frames.count": 1}
    waves["output.variables"] = ["radiance", "surface_class"]
    rough, number = values(written(folder, "waves.nc", **waves), "radiance", "surface_class")
    assert np.unique(rough[:, 0][number == 1]).size == 1
    assert np.unique(rough[:, 0][number == 0]).size > 100


def test_the_plan_prints_the_classes_and_their_shares(folder):
    text = plan_text(planned(folder, **{"surfaces.parameters": FIELD}))
    assert "sea 50" in text
    assert "raster" in text


@pytest.mark.parametrize(
    ("changes", "field", "message"),
    [
        ({"surfaces.provider": "coats"}, "surfaces.provider", "closest"),
        ({"surfaces.parameters": {"file": "none.nc"}}, "surfaces.parameters.file", "no file 'none.nc'"),
        ({"surfaces.parameters": {"file": "half.nc"}}, "surfaces.parameters.file", "neither classes nor temperature"),
        (
            {"surfaces.parameters": {"file": "half.nc", "classes": {0: "sea", 1: "sandy"}}},
            "surfaces.provider",
            "'sand'",
        ),
        ({"surfaces.parameters": FIELD, "sea.waves": "on", "sea.model": "rough-sea"}, "surfaces", "'off'"),
        ({"bands": [[1.5, 1.7]]}, "bands[0]", "surface class 'sand'"),
    ],
)
def test_wrong_sections_name_field_and_what_is_allowed(folder, changes, field, message):
    with pytest.raises(ScenarioError) as error:
        planned(folder, **changes)
    assert [(each.field, message in each.message) for each in error.value.problems] == [(field, True)]


def test_outside_the_raster_is_an_error_that_names_it(folder):
    with pytest.raises(HcssError, match=r"'half.nc' covers .*34.9799 to 35.0201"):
        planned(folder, **{"image.pixel_size": 500.0})
    with pytest.raises(HcssError, match=r"class 1, .*parameters.classes .*allowed: 0"):
        planned(folder, **{"surfaces.parameters": {"file": "half.nc", "classes": {0: "sea"}}})


def test_variables_of_surfaces_need_surfaces(folder):
    with pytest.raises(ScenarioError, match=r"output\.variables.*allowed: .*\[surfaces\]"):
        Scenario.from_toml(SCENE, {"surfaces": None, "output.variables": ["surface_class"]}, base=folder)
