"""What a sensor measures at the edges of an image and of its windows: the scene around them, as it is computed."""

import json

import numpy as np
import pytest
from cheap import CHEAP
from click.testing import CliRunner
from written_cubes import measured_and_clean

import hcss_twin
from hcss_twin.cli.main import cli
from hcss_twin.cli.options import Stop
from hcss_twin.engine.simulate import run
from hcss_twin.engine.verification import Verdict, verify_cube
from hcss_twin.plan.make_plan import make_plan

SCENE = """
time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
seed = 5
bands = [{name = "window", limits = [3.7, 3.9]}]
image = {rows = 40, columns = 50}
frames = {count = 2, first = 1, interval = 0.5}
motion.platform_speed = 1000
clouds = {type = "stratus", coverage = 0.5}
output = {variables = ["radiance", "cloud_mask"], certificate = 0}
"""

COUNTING = {"name": "generic-mwir", "variables": ["all"]}
BLURRED = {"parameters": {"psf": "gaussian", "psf_sigma": 1.2}}
WIDE = {"parameters": {"psf": "gaussian", "psf_sigma": 2.5}}  # reaches 12 pixels
ROWS, COLUMNS = slice(10, 30), slice(5, 45)
WINDOW = {"image.window.rows": [10, 30], "image.window.columns": [5, 45]}
MEASURED = ("radiance", "photon_rate", "digital_number", "saturated")


def planned(sensor, **changes):
    keys = {name.replace("__", "."): value for name, value in changes.items()}
    return make_plan(hcss_twin.Scenario.from_toml(SCENE, {**CHEAP, "sensor": sensor, **keys}))


def measured(path, sensor, **changes):
    """The measured cube of a run, and its clean one."""
    run(planned(sensor, **changes), path)
    return measured_and_clean(path)


def assert_same(one, other, names=MEASURED):
    for name in names:
        np.testing.assert_array_equal(one[name], other[name], err_msg=name)


@pytest.mark.parametrize("mode", ["frame", "field"])
def test_the_measured_window_is_that_part_of_the_measured_image(tmp_path, mode):
    changes = {"clouds__coverage_mode": mode}
    whole, _ = measured(tmp_path / "whole.nc", COUNTING, **changes)
    window, _ = measured(tmp_path / "window.nc", COUNTING, **changes, **WINDOW)
    assert whole.radiance.std() > 0.05 * whole.radiance.mean()
    assert_same(whole.isel(y=ROWS, x=COLUMNS), window)
    found = verify_cube(tmp_path / "window.sensor.nc", frames=1)
    assert found.verdict == Verdict.IDENTICAL
    assert not found.attributes


def test_the_window_of_an_image_whose_clouds_end_with_it_sees_the_rest_of_the_image(tmp_path, monkeypatch):
    monkeypatch.delattr("hcss_twin.models.clouds.fractal.generator.FractalClouds.thickness_around_m")
    plan = planned(WIDE, **WINDOW)
    assert plan.sensor.given == (slice(0, 40), slice(0, 50))
    (note,) = plan.sensor.notes
    assert "sees the scene up to 10 rows and columns beyond them" in note
    assert "the clouds of 'stratus' are known within the image" in note
    whole, clean = measured(tmp_path / "whole.nc", WIDE)
    window, _ = measured(tmp_path / "window.nc", WIDE, **WINDOW)
    np.testing.assert_allclose(whole.radiance[:, :, ROWS, COLUMNS], window.radiance, rtol=3e-7)
    # of the whole nothing is known around it
    assert "takes the scene beyond them for its mirror image" in planned(WIDE).sensor.notes[0]
    assert_same(whole, hcss_twin.sense(clean, WIDE), ["radiance"])
    for name in ("whole", "window"):
        assert verify_cube(tmp_path / f"{name}.sensor.nc", frames=1).verdict == Verdict.IDENTICAL


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"image__samples_per_pixel": 2},
        {"slant__shadows": "on", "slant__parallax": "on", "view__zenith": 35.0, "sea__waves": "off"},
    ],
    ids=["plain", "points", "slant"],
)
def test_pixels_at_the_edges_are_those_of_a_larger_image(tmp_path, changes):
    # Around the same centre, whose clouds do not depend on the image.
    sensor = {"parameters": {**BLURRED["parameters"], "integration_time": 0.03}}
    changes = {"clouds__coverage_mode": "field", **changes}
    small, clean = measured(tmp_path / "small.nc", sensor, **changes)
    large, around = measured(tmp_path / "large.nc", sensor, **changes, **{"image.rows": 60, "image.columns": 70})
    middle = {"y": slice(10, 50), "x": slice(10, 60)}
    np.testing.assert_array_equal(clean.radiance, around.radiance.isel(middle))
    np.testing.assert_allclose(small.radiance, large.radiance.isel(middle), rtol=3e-7)
    # which the mirror image does not give
    mirrored = hcss_twin.sense(clean, sensor).radiance
    assert np.abs(mirrored / small.radiance - 1.0).max() > 0.01


def test_a_far_blur_is_computed_on_sizes_that_transforms_are_fast_for():
    sensor = planned({"name": "generic-mwir"}).sensor
    for given, cube in zip(sensor.given, sensor.cube, strict=True):
        assert cube.start - given.start == sensor.reach > 64
        size, added = given.stop - given.start, given.stop - cube.stop - sensor.reach
        assert 0 <= added <= 0.05 * size
        for factor in (2, 3, 5, 7, 11):
            while size % factor == 0:
                size //= factor
        assert size == 1


def test_a_clear_scene_is_as_it_is_up_to_its_edges(tmp_path):
    for sensor in (BLURRED, {"parameters": {"psf": "airy", "aperture_diameter": 0.1, "pixel_angle": 4e-5}}):
        found, clean = measured(tmp_path / "clear.nc", sensor, clouds__coverage=0.0)
        np.testing.assert_allclose(found.radiance, clean.radiance, rtol=3e-7)


def test_a_cube_measured_later_knows_its_place_and_nothing_around_it(tmp_path):
    whole, clean = measured(tmp_path / "whole.nc", COUNTING)
    _, clean_window = measured(tmp_path / "window.nc", COUNTING, **WINDOW)
    later = hcss_twin.sense(clean_window, COUNTING)
    assert_same(later, hcss_twin.sense(clean.isel(y=ROWS, x=COLUMNS), COUNTING))
    assert not later.photon_rate.equals(whole.photon_rate[:, :, ROWS, COLUMNS])
    about = json.loads(later.attrs["hcss_sensor"])
    assert about["measured_from"] == "cube"
    assert "mirror image" in about["notes"][-1]
    # Without blur a pixel stands alone, with the random numbers of its place.
    sharp = {**COUNTING, "parameters": {"psf": "none", "smear": False}}
    assert_same(hcss_twin.sense(clean, sharp).isel(y=ROWS, x=COLUMNS), hcss_twin.sense(clean_window, sharp))
    # Other pixels than those of the scenario have no place in its image.
    hcss_twin.sense(clean.isel(y=slice(None, None, 2), x=slice(None, None, 2)), sharp)


def test_hcss_verify_makes_a_cube_anew_as_it_was_measured(tmp_path):
    measured(tmp_path / "window.nc", BLURRED, **WINDOW)
    later = tmp_path / "later.nc"
    words = ["sense", tmp_path / "window.nc", "--sensor", "generic-mwir", "-o", later]
    told = CliRunner().invoke(cli, list(map(str, words)), obj=Stop())
    assert told.exit_code == 0, told.output
    assert "mirror image" in told.output
    for name in ("later.nc", "window.nc", "window.sensor.nc"):
        told = CliRunner().invoke(cli, ["verify", str(tmp_path / name)], obj=Stop())
        assert told.exit_code == 0, told.output
        assert "bit-identical (all 2 frames)" in told.output
        assert "attribute" not in told.output


def test_how_far_the_scene_is_computed_has_an_end():
    plan = planned({"parameters": {"psf": "gaussian", "psf_sigma": 300.0}})
    assert plan.sensor.given == (slice(-512, 552), slice(-512, 562))
    assert "farther out takes it for its mirror image (more than 512 are not computed)" in plan.sensor.notes[0]


def test_large_frames_are_surrounded_tile_by_tile(tmp_path):
    whole, _ = measured(tmp_path / "whole.nc", COUNTING)
    # Patches of its own, on which no analysis of the scene depends: it is made once.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hcss_twin.engine.parts.LARGEST_FRAME_BYTES", 2**10)
        patch.setattr("hcss_twin.engine.parts.TILE_PIXELS", 2**8)
        patch.setattr("hcss_twin.engine.clouds.WHOLE_POINTS", 2**8)
        tiled, _ = measured(tmp_path / "tiled.nc", COUNTING)
    assert_same(whole, tiled)


@pytest.mark.long
def test_the_sea_with_its_waves_goes_on_beyond_the_edges(tmp_path):
    changes = {"sea__model": "rough-sea", "sea__waves": "on", "image__pixel_size": 1.0}
    changes |= {"clouds__coverage": 0.2, "sea__wind_speed": 6.0, "motion__platform_speed": 10}
    whole, clean = measured(tmp_path / "whole.nc", BLURRED, **changes)
    window, _ = measured(tmp_path / "window.nc", BLURRED, **changes, **WINDOW)
    assert "goes on beyond them" in planned(BLURRED, **changes).sensor.notes[0]
    assert clean.radiance.where(clean.cloud_mask == 0).std() > 0.0
    np.testing.assert_allclose(whole.radiance[:, :, ROWS, COLUMNS], window.radiance, rtol=3e-7)


@pytest.mark.long
def test_where_pixels_have_views_of_their_own_the_image_is_mirrored():
    changes = {"platform__altitude": 5e5, "image__pixel_size": 12_000.0, "view__zenith": 20.0}
    plan = planned(BLURRED, **changes)
    assert plan.views.varies
    assert "mirror image" in plan.sensor.notes[0]
    assert "views of their own" in plan.sensor.notes[0]
    window = planned(BLURRED, **changes, **WINDOW).sensor
    assert window.given == (slice(3, 37), slice(0, 50))  # 7 pixels more, as far as the image goes
