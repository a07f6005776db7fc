"""Sensors of one file see the same clouds, each with keys of its own."""

import numpy as np
import pytest
from hcss_sweep import sweep
from hcss_sweep.design import Design
from hcss_sweep.points import points_of

import hcss_twin
from hcss_twin import ScenarioError

SKY = {
    "time": "2024-07-20T12:40:00+09:00",
    "place": {"latitude": 30.0, "longitude": 140.0},
    "seed": 3,
    "clouds": {"type": "paper-cumulus", "coverage": 0.4},
    "frames": {"count": 1},
    "bands": ["lwir"],
    "output": {"variables": ["cloud_thickness"]},
}
FINE = {"name": "fine", "image": {"rows": 256, "columns": 256, "pixel_size": 20.0}}
COARSE = {"name": "coarse", "image": {"rows": 8, "columns": 8, "pixel_size": 640.0}}


def thickness(folder, sensors, **keys):
    """Thickness (y, x) that each sensor sees."""
    result = sweep({**SKY, "sensors": sensors, **keys}, folder)
    assert not result.failed, result.failed
    seen = {}
    for record in result.points:
        with hcss_twin.open_cube(result.cube(record.point)) as cube:
            seen[record.values["sensors"]] = cube.cloud_thickness.values[0].astype(float)
    return seen


def test_a_coarse_sensor_sees_the_means_of_the_clouds_that_a_fine_one_sees(tmp_path):
    coarse = {**COARSE, "image": {**COARSE["image"], "samples_per_pixel": 32}}
    seen = thickness(tmp_path / "same", [FINE, coarse])
    means = seen["fine"].reshape(8, 32, 8, 32).mean((1, 3))
    np.testing.assert_allclose(seen["coarse"], means, rtol=1e-5, atol=1e-3)
    # Points of 58 m stand between those of 20 m: their means differ by the detail of the sky.
    seen = thickness(tmp_path / "fewer", [FINE, COARSE])
    assert np.corrcoef(seen["coarse"].ravel(), means.ravel())[0, 1] > 0.98


def test_the_clouds_are_those_of_the_finest_sensor_in_every_sky():
    made = points_of(Design.load({**SKY, "sensors": [COARSE, FINE], "sweep": {"seed": [1, 2]}}))
    assert [(p.values["seed"], p.values["sensors"]) for p in made] == [
        (1, "coarse"), (1, "fine"), (2, "coarse"), (2, "fine")
    ]  # fmt: skip
    assert all(p.scenario.clouds == made[0].scenario.clouds for p in made)
    assert made[0].scenario.clouds.layers[0].coverage_mode == "field"
    assert [p.scenario.image.samples_per_pixel for p in made] == [11, 1, 11, 1]


@pytest.mark.parametrize("height_m", [1000.0, 10_000.0])
def test_opposite_views_displace_a_cloud_by_its_height_times_the_tangents(tmp_path, height_m):
    zenith_deg, pixel_m = 50.0, height_m / 50.0
    sensors = [
        {"name": name, "view": {"zenith": zenith_deg, "azimuth": azimuth}}
        for name, azimuth in (("east", 90.0), ("west", 270.0))
    ]
    keys = {
        "clouds": {**SKY["clouds"], "base": height_m, "top": height_m + 20.0, "thickness_min": 5.0},
        # Clouds of a grid are displaced by whole points.
        "image": {"rows": 32, "columns": 256, "pixel_size": pixel_m, "samples_per_pixel": 5},
    }
    expected = height_m * 2.0 * np.tan(np.radians(zenith_deg)) / pixel_m

    def displaced(parallax):
        seen = thickness(tmp_path / parallax, sensors, slant={"parallax": parallax}, **keys)
        # The sensor in the east sees a cloud farther to the west.
        shifts = np.arange(200)
        alike = [np.corrcoef(seen["east"][:, : 256 - s].ravel(), seen["west"][:, s:].ravel())[0, 1] for s in shifts]
        return float(shifts[int(np.argmax(alike))])

    assert abs(displaced("on") - expected) <= 0.5
    assert displaced("off") == 0.0


@pytest.mark.parametrize(
    ("sensors", "field", "why"),
    [
        ([], "sensors", "allowed: [[sensors]] tables"),
        ([{"image": {}}], "sensors[0].name", "allowed: a text of its own"),
        ([FINE, FINE], "sensors[1].name", "allowed: a text of its own"),
        ([{"name": "a", "clouds": {"coverage": 0.2}}], "sensors[0].clouds", "belongs to the sky"),
        ([{"name": "a", "motion": {"wind_speed": 3.0}}], "sensors[0].motion.wind_speed", "belongs to the sky"),
    ],
)
def test_sensors_that_cannot_share_a_sky_are_named(sensors, field, why):
    with pytest.raises(ScenarioError) as caught:
        points_of(Design.load({**SKY, "sensors": sensors}))
    assert any(problem.field == field and why in problem.message for problem in caught.value.problems)


def test_sensors_are_combined_with_every_other_value():
    with pytest.raises(ScenarioError, match="'zip' with"):
        Design.load({**SKY, "sensors": [FINE, COARSE], "sweep": {"seed": [1, 2], "combine": "zip"}})


def test_a_run_of_one_scene_names_the_command_for_several_sensors():
    with pytest.raises(ScenarioError, match="hcss sweep FILE"):
        hcss_twin.Scenario.from_dict({**SKY, "sensors": [FINE]})
