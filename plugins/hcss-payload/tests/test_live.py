"""Live frames against cubes, frames from poses and closed forms."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from camera_scenes import LWIR, MWIR
from hcss_payload import Camera, Circular, Jitter, Nadir, PayloadError, Pose, PositionTable, Track, pose_at
from hcss_payload.frames import frames
from hcss_payload.live import LiveTwin, PointTarget
from hcss_payload.live.fast_scenes import excluded_by_plan
from payload_scenes import radiometer_of

import hcss_twin
from hcss_twin.core.errors import ScenarioError
from hcss_twin.models.sensor.detector import band_radiance_per_kelvin
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.providers import SensorBand

SIZE = 96
SEA = {"wind_speed": 10.0, "temperature": 291.4, "model": "cox-munk"}
FAST = {"radiance": {"model": "as-printed"}, "optics": {"provider": "mie"}}


def scene(kind="paper-stratus", pixels=SIZE, samples=1, pixel_m=100.0, **overrides):
    scenario = {
        "seed": 1,
        "time": "2024-04-20T02:30:00Z",
        "bands": [LWIR, MWIR],
        "place": {"latitude": 30.0, "longitude": 150.0},
        "view": {"zenith": 0.0, "azimuth": 0.0},
        "image": {"rows": pixels, "columns": pixels, "pixel_size": pixel_m, "samples_per_pixel": samples},
        "frames": {"count": 2, "interval": 30.0},
        "motion": {"platform_speed": 0.0, "wind_speed": 10.0, "wind_from": 250.0},
        "clouds": {"type": kind, "coverage": 0.5, "coverage_mode": "field"},
        "slant": {"shadows": "off", "parallax": "off"},
        "sea": SEA,
        "atmosphere": {"water_vapour_texture": 0.0},
        "output": {"certificate": 0},
    }
    return hcss_twin.Scenario.model_validate(scenario | FAST | overrides)


def above(height=36e6):
    position = Ellipsoid.to_earth_centred(np.float64(30.0), np.float64(150.0), height)
    return PositionTable([-100.0, 100.0], [position, position])


def of_orbit(size=64, pixel_m=300.0):
    """A camera that stares at the place from low orbit."""
    orbit = Circular(altitude_m=700e3, inclination_deg=98.2, node_longitude_deg=156.0, argument_deg=26.5)
    return Camera(size, size, 1.0, pixel_m / 700e3), orbit, Track(orbit, 30.0, 150.0)


def neighbour_contrast(image):
    return np.sqrt(np.mean(np.diff(image, axis=0) ** 2) + np.mean(np.diff(image, axis=1) ** 2))


@pytest.mark.parametrize("kind", ["paper-stratus", "paper-cumulus"])
def test_pixels_are_the_means_over_their_footprint(kind):
    cube = hcss_twin.simulate(scene(kind, samples=6))["radiance"].values[:, :, ::-1].astype(float)
    trajectory = above()
    with LiveTwin(scene(kind), Camera(SIZE, SIZE, 1.0, 100.0 / 36e6)).prepare(
        trajectory, Nadir(trajectory), 0.0, 30.0
    ) as live:
        for time_s, exact in zip((0.0, 30.0), cube, strict=True):
            for image, expected in zip(live.frame(time_s).radiance.astype(float), exact, strict=True):
                assert image.mean() == pytest.approx(expected.mean(), rel=1e-3)
                assert image.std() == pytest.approx(expected.std(), rel=0.02)
                assert neighbour_contrast(image) == pytest.approx(neighbour_contrast(expected), rel=0.05)
                assert np.std(image - expected) < 0.12 * expected.std()


def test_poses_of_an_orbit_see_the_clouds_of_frames():
    camera, orbit, track = of_orbit()
    jitter = Jitter((3e-3, 3e-3, 1e-2), seed=3)
    times = [3.0, 29.0]
    fine = scene(pixels=800, pixel_m=50.0)
    with LiveTwin(scene(), camera).prepare(orbit, track, 0.0, 30.0, jitter) as live:
        for exact in frames(fine, camera, orbit, track, times, jitter, points=8):
            radiance = live.frame(exact.pose.time_s).radiance
            for mine, expected in zip(radiance.astype(float), exact.radiance.astype(float), strict=True):
                assert mine.mean() == pytest.approx(expected.mean(), rel=2e-3)
                assert np.std(mine - expected) < 0.33 * expected.std()
                inner, around = expected[1:-1, 1:-1], [(0, 1), (2, 1), (1, 0), (1, 2)]
                moved = [np.corrcoef(mine[i : i + 62, j : j + 62].ravel(), inner.ravel())[0, 1] for i, j in around]
                assert np.corrcoef(mine[1:-1, 1:-1].ravel(), inner.ravel())[0, 1] > max(0.95, *moved)
        assert live.errors["tables"] < 1e-3


CLEAR = {"type": "paper-stratus", "coverage": 1e-9, "coverage_mode": "field"}


@pytest.mark.parametrize(
    ("texture_K", "clouds", "alike", "error"),
    [
        (1.0, CLEAR, (0.96, 0.99), (0.26, 0.14)),
        (0.0, CLEAR, (0.0, 0.9999), (0.05, 0.01)),
        (1.0, CLEAR | {"coverage": 0.5}, (0.98, 0.98), (0.2, 0.2)),
    ],
    ids=["texture and glint", "glint", "between clouds"],
)
def test_the_sea_of_fast_frames_has_the_texture_and_the_glint_of_cubes(texture_K, clouds, alike, error):
    """By day under a high sun; error: relative to the contrast."""
    trajectory, camera = above(700e3), Camera(SIZE, SIZE, 1.0, 100.0 / 700e3)
    planned = scene(clouds=dict(clouds), sea=SEA | {"temperature_texture": texture_K, "waves": "off"})
    (cube,) = frames(planned, camera, trajectory, Nadir(trajectory), [0.0], points=4)
    with LiveTwin(planned, camera, method="fast").prepare(trajectory, Nadir(trajectory), 0.0, 30.0) as live:
        for image, exact, least, most in zip(live.frame(0.0).radiance, cube.radiance, alike, error, strict=True):
            image, exact = image.astype(float), exact.astype(float)
            if exact.std() > 1e-4 * exact.mean():
                assert np.corrcoef(image.ravel(), exact.ravel())[0, 1] > least
                assert np.std(image - exact) < most * exact.std()
            assert image.mean() == pytest.approx(exact.mean(), rel=3e-3)


def test_the_same_pose_gives_the_same_bits_whatever_came_before():
    camera, orbit, track = of_orbit(48)
    times = [0.0, 0.5, 9.25, 30.0]
    jitter = Jitter((2e-3, 2e-3, 1e-3))
    noisy = scene(sensor=radiometer_of(camera))
    with LiveTwin(noisy, camera, threads=1).prepare(orbit, track, 0.0, 30.0, jitter) as live:
        first = [live.frame(time).digital_number.copy() for time in times]
    with LiveTwin(noisy, camera, threads=3).prepare(orbit, track, 0.0, 30.0, jitter) as live:
        for time in np.linspace(0.0, 30.0, 23):
            live.frame(float(time))
        for time, before in reversed(list(zip(times, first, strict=True))):
            assert np.array_equal(live.frame(time).digital_number, before)
        given = live.frame(9.25, pose_at(9.25, orbit, track, jitter), out=np.empty((2, 48, 48), np.float32))
        assert np.array_equal(given.digital_number, first[2])
        assert not np.array_equal(first[0], first[1])


def test_numbers_of_the_sensor_give_the_radiance_back():
    trajectory, camera = above(), Camera(SIZE, SIZE, 1.0, 1e-5)
    clouds = {"type": "paper-stratus", "coverage": 1e-9, "coverage_mode": "field"}
    even = scene(
        clouds=clouds, sensor=radiometer_of(camera), bands=["lwir", "mwir"], sea=SEA | {"temperature_texture": 0.0}
    )
    with LiveTwin(even, camera).prepare(trajectory, Nadir(trajectory), 0.0, 1.0) as live:
        frame = live.frame(0.25)
        measured = live._sensor.scene[:, 0, 0]
        worked_out = live._sensor._sensor.worked_out["bands"]
    checked = []
    for band, radiance, number, name in zip(
        frame.radiance, measured, frame.digital_number, ("lwir", "mwir"), strict=True
    ):
        per, step = worked_out[name]["electrons_per_radiance"], worked_out[name]["signal_per_number"]
        noise = float(np.sqrt(radiance * per + 100.0**2 + step**2 / 12.0))
        electrons = number.astype(float) * step
        if noise > step:  # otherwise all pixels may have one number
            assert electrons.mean() == pytest.approx(float(radiance * per), abs=5.0 * noise / SIZE)
            assert electrons.std() == pytest.approx(noise, rel=0.05)
            checked.append(name)
        assert electrons.mean() == pytest.approx(float(radiance * per), abs=step)
        assert np.allclose(band * per, electrons, rtol=1e-5)
    assert checked == ["lwir"]


@pytest.mark.parametrize("pattern", [{}, {"offset_radiance": 1e-3}])
def test_offsets_drift_by_kelvin_between_calibrations(pattern):
    trajectory, camera = above(), Camera(8, 8, 1.0, 1e-5)
    steady = {"noise": "nedt", "nedt": 0.02, **pattern}
    drifting = {**steady, "drift": 2.0, "calibration_cycle": 10.0}
    clear = {"type": "paper-stratus", "coverage": 1e-9, "coverage_mode": "field"}

    def seen(parameters, *times):
        sensor = {"parameters": parameters}
        with LiveTwin(scene(clouds=clear, sensor=sensor), camera).prepare(
            trajectory, Nadir(trajectory), 0.0, 20.0
        ) as live:
            return [live.frame(time).radiance[0].astype(float) for time in times]

    per_kelvin = band_radiance_per_kelvin(SensorBand("lwir", np.array(LWIR["limits"]), np.ones(2)), 300.0)
    times = 0.0, 2.5, 9.0, 12.5
    for time, before, after in zip(times, seen(steady, *times), seen(drifting, *times), strict=True):
        np.testing.assert_allclose(after - before, 2.0 * (time % 10.0) / 10.0 * per_kelvin, rtol=1e-3, atol=1e-5)


def test_a_target_above_the_air_has_its_intensity_over_the_squared_distance():
    trajectory, camera = above(700e3), Camera(33, 33, 1.0, 1e-4)
    target = PointTarget(30.003, 150.002, 99e3, (1e4, 2e4))
    live_twin = LiveTwin(scene(), camera)
    with live_twin.prepare(trajectory, Nadir(trajectory), 0.0, 1.0) as live:
        without = live.frame(0.0).radiance.astype(float)
    with live_twin.prepare(trajectory, Nadir(trajectory), 0.0, 1.0, target=target) as live:
        added = live.frame(0.0).radiance - without
    distance = np.linalg.norm(target.position_m(0.0) - trajectory.at(0.0))
    expected = np.array(target.intensity) / (distance**2 * 1e-8)
    assert added.sum(axis=(1, 2)) == pytest.approx(expected, rel=2e-4)
    row, column = np.indices((33, 33))
    middle = (added[0] * row).sum() / added[0].sum(), (added[0] * column).sum() / added[0].sum()
    pose = pose_at(0.0, trajectory, Nadir(trajectory))
    seen = camera.pixels(pose.to_body((target.position_m(0.0) - pose.position_m) / distance))
    assert middle == pytest.approx([float(coordinate) for coordinate in seen], abs=1e-3)


def test_a_sensor_shows_a_target_at_its_place_within_the_pixel_smeared_by_its_motion():
    trajectory, camera = above(700e3), Camera(33, 33, 1.0, 1e-4)
    # Above the air, 4 km/s toward the east: 6 pixels of 60 m in .09 s.
    target = PointTarget(30.003, 149.981, 99e3, (1e4, 2e4), velocity_m_s=(4e3, 0.0, 0.0))
    sensor = {"parameters": {"psf": "gaussian", "psf_sigma": 0.5, "integration_time": 0.09}}
    with LiveTwin(scene(sensor=sensor), camera).prepare(trajectory, Nadir(trajectory), 0.0, 1.0, target=target) as live:
        added = live.frame(0.5).radiance - live.frame(0.5, targets=()).radiance.astype(float)
    ray = target.position_m(0.5) - trajectory.at(0.5)
    expected = np.array(target.intensity) / (ray @ ray * 1e-8)
    assert added.sum(axis=(1, 2)) == pytest.approx(expected, rel=1e-3)
    pose = pose_at(0.5, trajectory, Nadir(trajectory))
    ends = [camera.pixels(pose.to_body(target.position_m(0.5 + later) - pose.position_m)) for later in (-0.045, 0.045)]
    moved, places = np.subtract(ends[1], ends[0]), np.indices((33, 33)).reshape(2, -1)
    assert 5.5 < np.abs(moved).max() < 6.5
    weight = added[0].ravel() / added[0].sum()
    assert places @ weight == pytest.approx(np.mean(ends, axis=0), abs=0.01)
    variance = (places - (places @ weight)[:, None]) ** 2 @ weight
    assert variance == pytest.approx(moved**2 / 12.0 + 0.5**2 + 1.0 / 12.0, rel=0.03)  # in single precision


def test_targets_that_appear_at_run_time_have_the_light_of_prepared_ones():
    trajectory, camera = above(700e3), Camera(33, 33, 1.0, 1e-4)
    # In the air, in the cloud (33 to 1000 m) and above it; none at an altitude that is prepared.
    targets = [PointTarget(30.0, 150.0, altitude, (3e3, 4e3)) for altitude in (13e3, 560.0, 5.0)]
    live_twin = LiveTwin(scene(), camera)
    with live_twin.prepare(trajectory, Nadir(trajectory), 0.0, 1.0, highest_target_m=20e3) as live:
        without = live.frame(0.0).radiance.astype(float)
        added = [live.frame(0.0, targets=[target]).radiance - without for target in targets]
        both = live.frame(0.0, targets=targets[:2]).radiance - without
        with pytest.raises(PayloadError, match=r"targets: altitude 21000 m, .* allowed: altitudes up to 20000 m"):
            live.frame(0.0, targets=[PointTarget(30.0, 150.0, 21e3, (1.0, 1.0))])
    assert both == pytest.approx(added[0] + added[1], abs=1e-5)
    for target, change in zip(targets, added, strict=True):
        with live_twin.prepare(trajectory, Nadir(trajectory), 0.0, 1.0, target=target) as live:
            expected = live.frame(0.0).radiance - live.frame(0.0, targets=()).radiance
        assert change.sum(axis=(1, 2)) == pytest.approx(expected.sum(axis=(1, 2)), rel=0.02)


def test_cloud_weakens_a_target_below_by_its_optical_thickness():
    trajectory, camera = above(), Camera(33, 33, 1.0, 100.0 / 36e6)
    target = PointTarget(30.0, 150.0, 0.0, (1e9, 1e9))
    sky, light = {"type": "paper-stratus", "coverage_mode": "field"}, {}
    for coverage in (1.0, 1e-9):
        with LiveTwin(scene(clouds=sky | {"coverage": coverage}), camera).prepare(
            trajectory, Nadir(trajectory), 0.0, 1.0, target=target
        ) as live:
            with_target = live.frame(0.0).radiance.astype(float)
            light[coverage] = (with_target - live.frame(0.0, targets=()).radiance).sum(axis=(1, 2))
    output = {"certificate": 0, "variables": ["cloud_optical_thickness"]}
    cube = hcss_twin.simulate(scene(clouds=sky | {"coverage": 1.0}, pixels=33, samples=5, output=output))
    depth = cube["cloud_optical_thickness"].values[0][..., 16, 16]
    assert -np.log(light[1.0] / light[1e-9]) == pytest.approx(depth.ravel(), rel=0.1)


def test_what_fast_frames_cannot_show_is_refused_by_name():
    camera, orbit, track = of_orbit(16)
    frames_of_images = {"type": "paper-stratus", "coverage": 0.5, "coverage_mode": "frame"}
    with pytest.raises(ScenarioError, match=r"coverage_mode: .* cannot be computed with fast frames; allowed: 'field'"):
        LiveTwin(scene(clouds=frames_of_images), camera, method="fast")
    with pytest.raises(ScenarioError, match=r"atmosphere\.water_vapour_texture: .* or method = 'cube'"):
        LiveTwin(scene(atmosphere={"water_vapour_texture": 0.05}), camera, method="fast")
    lit = replace(hcss_twin.make_plan(scene()), light=SimpleNamespace(name="source"))
    assert [excluded.field for excluded in excluded_by_plan(lit) if excluded.present] == ["radiance.light"]
    with pytest.raises(PayloadError, match=r"method: .*'slow'.*allowed: auto, cube, fast"):
        LiveTwin(scene(), camera, method="slow")
    twin = LiveTwin(scene(), camera)
    with twin.prepare(orbit, track, 0.0, 1.0) as live:
        assert live.method == "fast"
        before = live.omissions
    (finer,) = (item for item in before if item.what == "texture of the sea's temperature")  # of four pixels
    assert 0.0 < finer.size < 0.01
    with pytest.raises(PayloadError, match="start_s, end_s: 0 to 31 s; allowed: within 0 to 30 s"):
        twin.prepare(orbit, track, 0.0, 31.0)
    with pytest.raises(PayloadError, match="hold several cells of the coarsest octave"):
        LiveTwin(scene("paper-cumulus"), of_orbit(4, 3000.0)[0], method="fast").prepare(orbit, track, 0.0, 1.0)
    with twin.prepare(orbit, Nadir(orbit), 0.0, 1.0, integration_s=0.09) as live:
        (smear,) = (item for item in live.omissions if item.what not in {each.what for each in before})
        # The ground below moves at 6.7 to 7 km/s.
        moved = float(smear.why.partition("by up to ")[2].split()[0])
        assert (smear.what, moved) == ("smear of the scene", pytest.approx(0.09 * 6.85e3 / 300.0, rel=0.04))
        with pytest.raises(PayloadError, match="time_s: 2 s; allowed: 0 to 1 s"):
            live.frame(2.0)
        with pytest.raises(PayloadError, match=r"out: float64 \(2, 16, 16\); allowed: contiguous float32"):
            live.frame(0.5, out=np.empty((2, 16, 16)))
        pose = pose_at(0.5, orbit, track)
        with pytest.raises(PayloadError, match=r"pose.time_s: 0.5 s; allowed: 0.25 s"):
            live.frame(0.25, pose)
        astray = Pose(0.5, pose.position_m, pose_at(0.5, orbit, Track(orbit, 33.0, 150.0)).quaternion)
        with pytest.raises(PayloadError, match="lines of sight are beyond the limb or far from"):
            live.frame(0.5, astray)
        assert live.frame(0.5).radiance.shape == (2, 16, 16)
