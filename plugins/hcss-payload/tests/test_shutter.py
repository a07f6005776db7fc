"""Integration time and rolling shutter of cubes: means over instants, the sinc of linear motion, the poses of lines."""

import numpy as np
import pytest
from camera_scenes import PASS, scenario
from hcss_payload import Camera, Circular, Jitter, PayloadError, PushBroom, Track, pose_at
from hcss_payload.camera_rays import make_rays
from hcss_payload.rays import geographic, meet
from hcss_payload.shutter import Shutter, instants_for, smear_px

import hcss_twin
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.physics.geodesy import Ellipsoid

ORBIT = Circular.above(7e5, 98.2, 30.0, 153.0, 60.0)
STILL = {"attitude": {"provider": "push-broom", "roll": -20.0}, "frames": {"count": 1}, "output": {"certificate": 0}}
CAMERA = {"rows": 64, "columns": 48, "points": 4}


def image(**camera):
    cube = hcss_twin.simulate(scenario(PASS, STILL, {"camera": CAMERA | camera}))
    return cube["radiance"].values[0, 0].astype(float)


def test_every_row_and_column_of_points_has_all_instants():
    shutter = Shutter(0.1, 0.0, 4)
    which = shutter.which(8)
    for lines in (which, which.T):
        assert all(np.array_equal(np.bincount(line), np.full(4, 2)) for line in lines)
    times = shutter.times_s(1.0)
    assert np.diff(times) == pytest.approx(np.full(3, np.diff(times)[0]))
    assert (np.mean(times), np.var(times)) == pytest.approx((1.0, 0.1**2 / 12.0))


def test_smear_is_the_ground_speed_over_the_pixel():
    camera, attitude = Camera(64, 48, 0.15, 1.5e-5), PushBroom(ORBIT)
    before, after = (pose_at(time_s, ORBIT, attitude) for time_s in (60.0, 60.02))
    # A circular orbit over the turning Earth: the ground below moves at 6.7 to 7 km/s, pixels are 70 m wide.
    assert smear_px(camera, before, after) == pytest.approx(0.02 * 6.85e3 / 70.0, rel=0.04)
    assert instants_for(0.0) == 1
    assert instants_for(2.2) == 5
    with pytest.raises(PayloadError, match=r"camera\.integration_time: smears by 9 pixels; allowed: up to 8"):
        instants_for(9.0)


def test_linear_motion_smears_by_its_sinc():
    # Rows of a push-broom attitude follow the motion: 2 pixels in this time.
    sharp, smeared = image(), image(integration_time=0.022)
    camera = Camera(64, 48, 0.15, 1.5e-5)
    attitude = PushBroom(ORBIT, roll_deg=-20.0)
    moved = smear_px(camera, *(pose_at(time_s, ORBIT, attitude) for time_s in (-0.011, 0.011)))
    assert 1.5 < moved < 3.0
    window = np.hanning(64)[:, None]
    power = [
        np.mean(np.abs(np.fft.rfft((image - image.mean()) * window, axis=0)) ** 2, axis=1) for image in (sharp, smeared)
    ]
    frequency = np.fft.rfftfreq(64)
    low = (frequency > 0.02) & (frequency * moved < 0.6)
    ratio = np.sqrt(power[1][low] / power[0][low])
    assert ratio == pytest.approx(np.sinc(frequency[low] * moved), abs=0.08)
    assert smeared.mean() == pytest.approx(sharp.mean(), rel=2e-3)


def test_background_and_target_smear_alike_within_the_integration_time_of_the_sensor():
    camera, attitude = Camera(64, 48, 0.15, 1.5e-5), PushBroom(ORBIT, roll_deg=-20.0)
    pose = pose_at(0.0, ORBIT, attitude)
    seen = geographic(meet(pose.position_m, pose.to_earth(camera.directions(np.float64(31.2), np.float64(23.6)))))
    x, y = (float(coordinate) for coordinate in Ellipsoid.to_plane(seen[0], seen[1], 30.0, 150.0))
    parts = {
        "camera": CAMERA | {"points": 8},
        "elements": [{"parameters": {"tracks": [{"x": x, "y": y, "altitude": 0.0, "intensity": 1e6}]}}],
        "output": {"certificate": 0, "variables": ["radiance", "element_radiance"]},
    }

    def parted(*sensor):
        cube = hcss_twin.simulate(scenario(PASS, STILL, parts, *sensor))
        radiance, added = (cube[name].values[0, 0].astype(float) for name in ("radiance", "element_radiance"))
        return radiance - added, added, "camera.integration_time" in cube.attrs["hcss_filled_in"]

    def measured(time_s):
        return {"sensor": {"parameters": {"integration_time": time_s}}}

    sharp, _, filled_in = parted(measured(1e-3))  # 0.09 pixels
    assert not filled_in
    background, target, filled_in = parted(measured(0.022))
    assert filled_in
    moved = smear_px(camera, *(pose_at(time_s, ORBIT, attitude) for time_s in (-0.011, 0.011)))
    assert 1.5 < moved < 2.5
    # The line of weights that turns the sharp image into the other one.
    shifts = np.arange(-5, 6)
    shifted = np.stack([sharp[5 + shift : 59 + shift].ravel() for shift in shifts], axis=1) - sharp.mean()
    weight = np.linalg.lstsq(shifted, background[5:59].ravel() - sharp.mean(), rcond=None)[0]
    assert weight.sum() == pytest.approx(1.0, abs=1e-3)
    assert weight @ shifts**2 - (weight @ shifts) ** 2 == pytest.approx(moved**2 / 12.0, abs=0.015)
    rows = np.indices(target.shape)[0]
    middle = np.sum(target * rows) / target.sum()
    spread = np.sum(target * (rows - middle) ** 2) / target.sum()
    assert spread == pytest.approx(moved**2 / 12.0 + 1.0 / 12.0, abs=0.03)


def test_an_integration_time_of_the_camera_that_the_sensor_contradicts_is_refused_by_name():
    def given(smear, **camera):
        sensor = {"parameters": {"integration_time": 0.022, "smear": smear}}
        return scenario(PASS, STILL, {"camera": camera, "sensor": sensor})

    for camera in ({}, {"integration_time": 0.0}):
        assert make_rays(given(False, **camera), Catalog()).filled_in == ()
    ((field, value, _),) = make_rays(given(True), Catalog()).filled_in
    assert (field, value) == ("camera.integration_time", "0.022 s")
    with pytest.raises(ScenarioError, match=r"integration_time: 0\.022 s, and camera\.integration_time 0 s; allowed"):
        hcss_twin.make_plan(given(True, integration_time=0.0))


def test_rows_of_a_rolling_shutter_see_what_their_own_pose_sees():
    line_s, shaken = 2e-3, {"jitter": {"rms": ["200 urad", "200 urad", "200 urad"], "highest": 50.0, "seed": 3}}
    parts = {"camera": {"line_time": line_s}, "output": {"certificate": 0}, "clouds": {"coverage": 0.0}}
    cube = hcss_twin.simulate(scenario(PASS, parts, shaken, {"frames": {"count": 1}}))
    camera, track = Camera(40, 48, 0.15, 1.5e-5), Track(ORBIT, 30.0, 150.0)
    jitter, columns = Jitter((2e-4, 2e-4, 2e-4), highest_hz=50.0, seed=3), np.arange(48.0)
    for row in (0, 7, 20, 39):
        pose = pose_at((row - 19.5) * line_s, ORBIT, track, jitter)
        seen = meet(pose.position_m, pose.to_earth(camera.directions(np.full(48, float(row)), columns)))
        latitude, longitude, _ = geographic(seen)
        # The mesh errs by up to .02 of a pixel of 100 m.
        assert cube["pixel_latitude"].values[0, row] == pytest.approx(latitude, abs=0.02 * 100.0 / 111e3)
        assert cube["pixel_longitude"].values[0, row] == pytest.approx(longitude, abs=0.03 * 100.0 / 96e3)


def test_a_target_is_in_the_pixel_that_sees_its_place_when_its_row_is_read():
    source = {"x": 800.0, "y": -900.0, "altitude": 0.0, "intensity": 1e6}
    parts = {
        "camera": {"line_time": 2e-2},
        "clouds": {"coverage": 0.0},
        "frames": {"count": 1},
        "elements": [{"provider": "point-sources", "parameters": {"tracks": [source]}}],
        "output": {"certificate": 0},
    }
    cube = hcss_twin.simulate(scenario(PASS, parts))
    bright = np.unravel_index(np.argmax(cube["radiance"].values[0, 0]), (40, 48))
    latitude, longitude = (cube[f"pixel_{name}"].values[0] for name in ("latitude", "longitude"))
    # Lengths of a degree at 30 N on the ellipsoid.
    away = np.hypot((latitude - 30.0) * 110_852.0 + 900.0, (longitude - 150.0) * 96_486.0 - 800.0)
    nearest = np.unravel_index(np.argmin(away), away.shape)
    assert np.abs(np.subtract(bright, nearest)).max() <= 1


def test_a_target_smears_by_its_motion_through_the_image_and_has_its_own_distance():
    camera, track = Camera(40, 48, 0.15, 1.5e-5), Track(ORBIT, 30.0, 150.0)
    pose, ground = pose_at(0.0, ORBIT, track), Ellipsoid.to_earth_centred(np.float64(30.0), np.float64(150.0))
    # On the line of sight to the place that is tracked, 30 km away from it.
    toward = (pose.position_m - ground) / np.linalg.norm(pose.position_m - ground)
    target_m = ground + 3e4 * toward
    latitude, longitude, altitude = (float(coordinate) for coordinate in geographic(target_m))
    x, y = (
        float(coordinate) for coordinate in Ellipsoid.to_plane(np.float64(latitude), np.float64(longitude), 30.0, 150.0)
    )
    source = {"x": x, "y": y, "altitude": altitude, "intensity": 1e6, "velocity": [2e4, 5.5e4, 0.0]}
    parts = {
        "camera": {"integration_time": 1e-2},
        "clouds": {"coverage": 0.0},
        "frames": {"count": 1},
        "elements": [{"parameters": {"tracks": [source]}}],
        "output": {"certificate": 0, "variables": ["element_radiance", "element_transmittance"]},
    }
    cube = hcss_twin.simulate(scenario(PASS, parts))
    added = cube["element_radiance"].values[0, 0].astype(float)
    east, north = np.array(Ellipsoid.east_north_up(np.float64(30.0), np.float64(150.0))[:2])
    velocity = 2e4 * east + 5.5e4 * north
    ends = []
    for later in (-5e-3, 5e-3):
        pose = pose_at(later, ORBIT, track)
        ends.append(camera.pixels(pose.to_body(target_m + later * velocity - pose.position_m)))
    moved = np.subtract(ends[1], ends[0])
    assert 5.0 < np.hypot(*moved) < 9.0
    rows, columns = np.indices(added.shape)
    centre = np.array([np.sum(added * rows), np.sum(added * columns)]) / added.sum()
    np.testing.assert_allclose(centre, np.mean(ends, axis=0), atol=0.03)
    spread = [
        np.sum(added * (numbers - at) ** 2) / added.sum() for numbers, at in zip((rows, columns), centre, strict=True)
    ]
    # The pixels on its way, each as long as the target is in it.
    on_the_way = np.rint(ends[0] + (np.arange(10_000)[:, None] + 0.5) / 10_000.0 * moved)
    np.testing.assert_allclose(spread, np.var(on_the_way, axis=0), atol=0.06)
    ray = target_m - pose.position_m
    distance = np.linalg.norm(ray)
    axis = camera.directions(np.float64(19.5), np.float64(23.5))
    solid_angle = (
        1e-8 * float(camera.directions(*(np.float64(coordinate) for coordinate in np.mean(ends, axis=0))) @ axis) ** 3
    )
    arriving = 1e6 * float(cube["element_transmittance"].max())
    assert added.sum() == pytest.approx(arriving / (distance**2 * solid_angle), rel=2e-3)


def test_too_much_smear_is_refused_by_name():
    with pytest.raises(ScenarioError, match=r"camera\.integration_time: smears by .* pixels; allowed: up to 8"):
        hcss_twin.make_plan(scenario(PASS, STILL, {"camera": {"integration_time": 0.5}}))
