"""Live frames of scenes that only cubes showed: the pixels of the cube at its times, from the same stages."""

from dataclasses import replace

import numpy as np
import pytest
from camera_scenes import MWIR, PASS, SCENE, merged
from hcss_payload import PayloadError, Pose, pose_at
from hcss_payload.build import payload_of
from hcss_payload.live import LiveTwin, PointTarget, live_pass
from hcss_payload.live.prepared_pass import FrameCost
from payload_scenes import radiometer_of
from scipy.spatial.transform import Rotation

import hcss_twin
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.engine.sense import measured_path
from hcss_twin.models.sensor.radiometer import Radiometer

INTERVAL_S = 60.0
SHORT = {"frames": {"count": 2, "interval": INTERVAL_S}, "output": {"certificate": 0}}
COARSE = {"accuracy": 1e-2}
"""For what holds to the bit at any accuracy."""
STRATUS = {"type": "stratus", "generator": "fractal", "coverage": 0.4, "coverage_mode": "field"}
CIRRUS = {"type": "cirrus", "generator": "fractal", "coverage": 0.5, "coverage_mode": "field"}
ALTOSTRATUS = {"type": "altostratus", "coverage": 0.3, "coverage_mode": "field"}
SHIP = {"x": 0.0, "y": 0.0, "altitude": 0.0, "intensity": 2e6}
PLUME = {"x": 300.0, "y": -200.0, "altitude": 9000.0, "intensity": 5e5, "velocity": [900.0, 0.0, 200.0]}
SPAIN = {"place": {"latitude": 36.7, "longitude": -6.42}, "orbit": {"above": [36.7, -3.4]}}
PUSH_BROOM = {"attitude": {"provider": "push-broom", "roll": -20.0}}

SCENES = {
    "two layers": {"clouds": {"layers": [STRATUS, CIRRUS]}},
    "three layers": {
        "accuracy": 0.02,
        "clouds": {"layers": [STRATUS, ALTOSTRATUS, CIRRUS | {"base": 8000.0, "top": 9000.0}]},
    },
    "no clouds": {"clouds": {"layers": []}},
    "clouds of an image": {
        "image": {"rows": 200, "columns": 200},
        "motion": {"wind_speed": 0.0},
        "clouds": STRATUS | {"generator": "imagery", "parameters": {"image": "image.npy", "method": "coverage"}},
    },
    "a coast": SPAIN | {"surfaces": {"provider": "coast"}},
    "small elements": {"elements": [{"provider": "point-sources", "parameters": {"tracks": [SHIP, PLUME]}}]},
    "shadows": {"slant": {"shadows": "on"}, "time": "2024-04-20T02:30:00Z", "bands": [MWIR]},
    "waves as shapes": {
        "accuracy": 0.02,
        "sea": {"waves": "on", "model": "rough-sea", "temperature": 295.0, "wind_speed": 10.0},
        "time": "2024-04-20T02:30:00Z",
        "bands": [MWIR],
    },
    "texture of the sea": {"sea": {"temperature_texture": 0.3}},
    "lines read in turn": {"camera": {"line_time": 2e-3}},
    "a scene that smears": {"camera": {"integration_time": 0.022, "points": 4}} | PUSH_BROOM,
    "ground beyond 75 degrees": {"accuracy": 0.02, "camera": {"beyond": "missing", "focal_length": 0.004}},
}
"""Parts of scenarios that fast frames cannot show."""


def scene(name, folder=None, accuracy=COARSE):
    """A scene, whose clouds are all that an earlier one's keys do not say."""
    raw = merged(SCENE, PASS, SHORT, accuracy)
    parts = SCENES[name]
    if "clouds" in parts:
        del raw["clouds"]
    return hcss_twin.Scenario.from_dict(merged(raw, parts), base=folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with an image of clouds."""
    path = tmp_path_factory.mktemp("image")
    waves = np.sin(np.arange(200) / 9.0)[:, None] + np.cos(np.arange(200) / 7.0)
    np.save(path / "image.npy", waves)
    return path


def image(live, *given, **options):
    """The radiance of a frame, in an array that the next one leaves alone."""
    return live.frame(*given, **options).radiance.copy()


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.campaign] * (name == "three layers")) for name in SCENES]
)
def test_a_frame_has_the_bits_of_the_cube(name, folder):
    planned = scene(name, folder)
    cube = hcss_twin.simulate(planned)["radiance"].values
    nominal = payload_of(planned, Catalog(base=folder))
    with live_pass(planned, method="cube", margin_px=0.0) as live:
        # In any order, after another time and another pose of the same time, half a pixel away.
        for number, time_s in ((1, INTERVAL_S), (None, 0.3 * INTERVAL_S), (0, 0.0)):
            pose = nominal.pose(time_s)
            turned = pose.rotation * Rotation.from_rotvec([5e-5, 0.0, 0.0])
            beside = image(live, time_s, Pose(time_s, pose.position_m, turned.as_quat()))
            found = image(live, time_s)
            assert not np.array_equal(beside, found, equal_nan=True)
            if number is not None:
                assert np.array_equal(found, cube[number], equal_nan=True)
        listed = {item.what for item in live.omissions}
    assert listed == {item.what for item in hcss_twin.make_plan(planned).omissions if item.bound != 0.0 and item.size}
    assert np.nanstd(cube[0]) > 0.0


def test_the_method_is_that_which_shows_the_scene_and_says_why(folder):
    for name, why in (
        ("two layers", "2 layers of cloud"),
        ("clouds of an image", "clouds that are no fractal field"),
        ("lines read in turn", "lines that are read in turn"),
    ):
        with live_pass(scene(name, folder)) as live:
            assert live.method == "cube"
            assert live.notes[0] == f"frames are those of cubes, since fast frames do not show {why}"
    # Fast frames average over footprints whose smear they list.
    with live_pass(scene("a scene that smears")) as live:
        assert live.method == "fast"
        assert live.omissions[-1].what == "smear of the scene"


def test_a_pass_that_fast_frames_do_not_reach_has_frames_of_cubes():
    coarse = {
        "camera": {"rows": 8, "columns": 8, "detector_pitch": 4.5e-4},
        "clouds": {"type": "cumulus", "generator": "fractal"},
    }
    with live_pass(hcss_twin.Scenario.from_dict(merged(SCENE, PASS, SHORT, COARSE, coarse)), end_s=1.0) as live:
        assert live.method == "cube"
        assert live.notes[0].startswith("frames are those of cubes, since fast frames do not show this pass (")
        assert "hold several cells of the coarsest octave" in live.notes[0]


def tables(folder, poses):
    """Sections of an orbit and an attitude that are tables of poses."""
    rows = [(pose.time_s, *pose.position_m, *pose.quaternion) for pose in poses]
    for name, columns, header in (
        ("orbit", slice(1, 4), "time_s,x_m,y_m,z_m"),
        ("attitude", slice(4, 8), "time_s,x,y,z,w"),
    ):
        lines = [",".join(map(repr, map(float, (row[0], *row[columns])))) for row in rows]
        (folder / f"{name}.csv").write_text("\n".join((header, *lines)))
    return {name: {"provider": "table", "file": f"{name}.csv"} for name in ("orbit", "attitude")}


def test_frames_of_given_poses_are_those_of_the_cube_of_these_poses(folder):
    planned = scene("two layers", folder, {"accuracy": 1e-3})
    nominal = payload_of(planned, Catalog(base=folder))
    # The body is turned by 6 to 10 pixels, and about its axis.
    off = Rotation.from_rotvec([6e-4, -1e-3, 1e-2])

    def posed(time_s):
        pose = pose_at(time_s, nominal.trajectory, nominal.attitude)
        return Pose(time_s, pose.position_m, (Rotation.from_quat(pose.quaternion) * off).as_quat())

    poses = [posed(time_s) for time_s in np.arange(0.0, INTERVAL_S + 1.0, 2.0)]
    raw = merged(SCENE, PASS, SHORT) | tables(folder, poses) | {"clouds": SCENES["two layers"]["clouds"]}
    of_poses = hcss_twin.Scenario.from_dict(raw, base=folder)
    cube = hcss_twin.simulate(of_poses)["radiance"].values
    with live_pass(planned) as live, live_pass(of_poses, margin_px=0.0) as of_table:
        nominal_image = image(live, 0.0)
        for number, pose in ((1, poses[-1]), (0, poses[0])):
            # Tables of the directions of another pass are within the accuracy; clouds and places are the same.
            assert image(live, pose.time_s, pose) == pytest.approx(cube[number], rel=1e-3)
            assert np.array_equal(image(of_table, pose.time_s, pose), cube[number])
        # The same time, another pose, and again.
        assert np.array_equal(image(live, 0.0), nominal_image)
        assert not np.array_equal(nominal_image, image(live, 0.0, poses[0]))
        astray = Pose(0.0, poses[0].position_m, pose_at(20.0, nominal.trajectory, nominal.attitude).quaternion)
        with pytest.raises(PayloadError, match=r"pose: a pixel looks farther than 12 pixels beside what .* margin_px"):
            live.frame(0.0, astray)
        assert np.array_equal(image(live, 0.0), nominal_image)


def test_a_given_pose_smears_as_the_pass_does():
    planned = scene("a scene that smears")
    nominal = payload_of(planned, Catalog())
    with live_pass(planned, method="cube") as live:
        assert image(live, 30.0, nominal.pose(30.0)) == pytest.approx(image(live, 30.0), rel=1e-6)


@pytest.mark.parametrize("stages", [(), ("integration",)])
def test_a_measured_frame_has_the_numbers_of_the_sensor_cube(tmp_path, stages):
    planned = scene("small elements")
    camera = payload_of(planned, Catalog()).camera
    radiometer = radiometer_of(camera) | {"variables": ["digital_number"]}
    sensor = radiometer
    if stages:
        before = [{"model": name, "parameters": {"integration_time": 1e-3, "exposures": 2}} for name in stages]
        asked = {"variables": radiometer.pop("variables")}
        sensor = asked | {"stages": [*before, radiometer]}
    measuring = hcss_twin.Scenario.from_dict(
        merged(SCENE, PASS, SHORT, COARSE, SCENES["small elements"]) | {"sensor": sensor}
    )
    hcss_twin.simulate(measuring, tmp_path / "pass.nc").close()
    cube = hcss_twin.open_cube(measured_path(tmp_path / "pass.nc"))
    with live_pass(measuring, margin_px=0.0) as live:
        assert live.has_numbers
        for number in (1, 0):
            frame = live.frame(INTERVAL_S * number)
            assert np.array_equal(frame.radiance, cube["radiance"].values[number])
            assert np.array_equal(frame.digital_number, cube["digital_number"].values[number])
        # Between frames, noise is that of the time.
        one, same, other = (live.frame(time_s).digital_number for time_s in (3.0, 3.0, 3.000001))
        assert np.array_equal(one, same)
        assert not np.array_equal(one, other)
    cube.close()


def test_a_target_is_an_element_of_the_scene():
    height_m, upward = 16e3, [0.0, 0.0, 30.0]
    # Beside the target, which would stay between two rows.
    beside = {"latitude": 30.0004, "longitude": 150.0006, "altitude": height_m}
    raw = merged(SCENE, PASS, SHORT, {"attitude": beside})
    raw["clouds"] = SCENES["two layers"]["clouds"]
    alone = hcss_twin.Scenario.from_dict(raw)
    moving = {"x": 0.0, "y": 0.0, "altitude": height_m, "intensity": 5e5, "velocity": upward}
    raw["elements"] = [{"provider": "point-sources", "parameters": {"tracks": [moving]}}]
    cube = hcss_twin.simulate(hcss_twin.Scenario.from_dict(raw))["radiance"].values
    target = PointTarget(alone.place.latitude, alone.place.longitude, height_m, (5e5,), tuple(upward))
    with live_pass(alone, target=target) as live:
        for number in (0, 1):
            found = image(live, INTERVAL_S * number)
            assert found == pytest.approx(cube[number], rel=1e-3)
            assert np.sum(found > 1.1 * image(live, INTERVAL_S * number, targets=())) == 1
        with pytest.raises(PayloadError, match=r"target\.intensity: 2 values; allowed: 1, one a band"):
            live.frame(0.0, targets=[PointTarget(30.0, 150.0, 0.0, (1.0, 2.0))])


def test_a_sensor_that_remembers_earlier_frames_is_refused(monkeypatch):
    planned = scene("small elements")
    camera = payload_of(planned, Catalog()).camera
    raw = merged(SCENE, PASS, SHORT, COARSE, SCENES["small elements"]) | {"sensor": radiometer_of(camera)}
    build = Radiometer.__init__

    def build_one_that_remembers(self, *given):
        build(self, *given)
        self.declares = replace(self.declares, remembers=True)

    monkeypatch.setattr(Radiometer, "__init__", build_one_that_remembers)
    with pytest.raises(ScenarioError, match=r"sensor: .* remembers earlier frames, and live frames are those of any"):
        live_pass(hcss_twin.Scenario.from_dict(raw))


def test_sections_of_other_packages_stay_in_the_scene():
    pytest.importorskip("hcss_examples.smoke")
    raw = merged(SCENE, PASS, SHORT, COARSE, {"smoke": {"optical_depth": 1.0}})
    planned = hcss_twin.Scenario.from_dict(raw)
    cube = hcss_twin.simulate(planned)["radiance"].values
    with live_pass(planned, margin_px=0.0) as live:
        assert live.method == "cube"
        assert np.array_equal(live.frame(0.0).radiance, cube[0])
    without = hcss_twin.simulate(scene("texture of the sea"))["radiance"].values
    assert not np.allclose(cube, without, rtol=1e-3)


def test_what_is_too_slow_is_what_must_go_for_the_rate():
    cost = FrameCost(0.1, {"clouds": 0.05, "elements": 0.01, "look-up": 0.03})
    assert cost.of_rate() == cost.of_rate(10.0) == "100 ms a frame, 10 a second"
    assert cost.of_rate(15.0) == "100 ms a frame, 10 a second; too slow for 15 (66.7 ms): clouds 50 ms"
    assert cost.of_rate(50.0).endswith("too slow for 50 (20 ms): clouds 50 ms, look-up 30 ms")
    # What is left has no part to name.
    assert cost.of_rate(500.0).endswith("clouds 50 ms, look-up 30 ms, elements 10 ms, the rest 10 ms")


def test_twins_without_sections_show_what_those_with_sections_show():
    planned = scene("two layers")
    payload = payload_of(planned, Catalog())
    raw = merged(SCENE, {"place": PASS["place"]}, SHORT, COARSE)
    raw["clouds"] = SCENES["two layers"]["clouds"]
    twin = LiveTwin(hcss_twin.Scenario.from_dict(raw), payload.camera)
    with twin.prepare(payload.trajectory, payload.attitude, 0.0, INTERVAL_S) as live, live_pass(planned) as other:
        assert np.array_equal(live.frame(10.0).radiance, other.frame(10.0).radiance)
        assert live.notes[0] == "frames are those of cubes, since fast frames do not show 2 layers of cloud"
        cost = live.warm_up()
        assert {"clouds", "look-up of the radiance"} <= cost.parts.keys()
        assert sum(cost.parts.values()) <= cost.seconds
