"""Frames from a pose against the cube of the same scenario."""

import numpy as np
import pytest
from hcss_payload import Camera, Nadir, PayloadError, PositionTable, Track
from hcss_payload.frames import frames, interpolated_thickness

import hcss_twin
from hcss_twin.physics.geodesy import to_earth_centred, to_plane
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.plan.slant_paths import reference_height_m

SIZE, HEIGHT = 96, 3_000_000.0


def scene(**overrides):
    """A broken stratus field at the equator, seen from straight above."""
    scenario = {
        "seed": 1,
        "time": "2024-04-20T02:30:00Z",
        "place": {"latitude": 30.0, "longitude": 150.0},
        "view": {"zenith": 0.0, "azimuth": 0.0},
        "image": {"rows": SIZE, "columns": SIZE, "pixel_size": 100.0},
        "frames": {"count": 2, "interval": 10.0},
        "motion": {"platform_speed": 0.0, "wind_speed": 10.0, "wind_from": 270.0},
        "clouds": {"type": "stratus", "coverage": 0.5},
        "sea": {"wind_speed": 10.0, "temperature": 291.4},
        "output": {"certificate": 0},
    }
    return hcss_twin.Scenario.model_validate(scenario | overrides)


def above(height=HEIGHT):
    """A trajectory that rests above the scene."""
    position = to_earth_centred(np.float64(30.0), np.float64(150.0), height)
    return PositionTable([-100.0, 100.0], [position, position])


def matching(size=SIZE, height=HEIGHT, pixel_m=100.0):
    """A camera with the pixels of the scene."""
    return Camera(size, size, 1.0, pixel_m / height)


@pytest.fixture(scope="module")
def cube():
    return hcss_twin.simulate(scene())


@pytest.fixture(scope="module")
def seen():
    trajectory = above()
    return list(frames(scene(), matching(), trajectory, Nadir(trajectory), [0.0, 10.0]))


def test_nadir_camera_gives_the_cube(cube, seen):
    for number, frame in enumerate(seen):
        expected = cube["radiance"].values[number][:, ::-1]  # the first row of a cube is the southern one
        difference = frame.radiance.astype(float) - expected
        contrast = expected.std(axis=(1, 2))
        assert np.all(np.sqrt(np.mean(difference**2, axis=(1, 2))) <= 0.005 * contrast)
        assert np.all(np.abs(difference.mean(axis=(1, 2))) <= 1e-3 * expected.mean(axis=(1, 2)))


@pytest.mark.parametrize(("kind", "samples"), [("cumulus", 1), ("stratus", 3)])
def test_nadir_camera_gives_the_cube_of_other_clouds(kind, samples):
    image = {"rows": 48, "columns": 48, "pixel_size": 100.0, "samples_per_pixel": samples}
    scenario = scene(clouds={"type": kind, "coverage": 0.5}, image=image)
    expected = hcss_twin.simulate(scenario)["radiance"].values[0][:, ::-1]
    trajectory = above(36e6)
    (frame,) = frames(scenario, matching(48, 36e6), trajectory, Nadir(trajectory), [0.0])
    difference = frame.radiance.astype(float) - expected
    assert np.all(np.sqrt(np.mean(difference**2, axis=(1, 2))) <= 0.005 * expected.std(axis=(1, 2)))
    assert np.all(np.abs(difference.mean(axis=(1, 2))) <= 1e-3 * expected.mean(axis=(1, 2)))


def test_places_of_pixels_are_those_of_the_scene(seen):
    latitude, longitude = seen[0].latitude_deg, seen[0].longitude_deg
    assert latitude[0, 0] > latitude[-1, 0]
    assert longitude[0, -1] > longitude[0, 0]
    assert latitude[47:49, 47:49].mean() == pytest.approx(30.0, abs=1e-6)


def test_clouds_move_against_the_sea_as_with_parallax_of_the_engine():
    cloudy = {"clouds": {"type": "altostratus", "coverage": 0.5, "coverage_mode": "field"}, "bands": ["lwir"]}
    plain = scene(**cloudy)
    height = reference_height_m(hcss_twin.make_plan(plain).layers[0])
    # The engine displaces clouds by whole pixels: here by exactly 20.
    zenith = float(np.degrees(np.arctan(2000.0 / height)))
    displaced = scene(**cloudy, view={"zenith": zenith, "azimuth": 0.0}, slant={"parallax": True})
    expected, without = (hcss_twin.simulate(each)["radiance"].values[0, -1] for each in (displaced, plain))
    position = LinesOfSight(30.0, 150.0, zenith, 0.0, 3e6).sensor_m
    trajectory = PositionTable([-1.0, 1.0], [position, position])
    away = np.linalg.norm(position - to_earth_centred(np.float64(30.0), np.float64(150.0)))
    (frame,) = frames(plain, matching(40, away), trajectory, Track(trajectory, 30.0, 150.0), [0.0])
    assert frame.view.zenith_deg == pytest.approx(zenith, abs=1e-6)
    x, y = to_plane(frame.latitude_deg, frame.longitude_deg, 30.0, 150.0)
    row, column = (np.rint(each / 100.0 + 47.5).astype(int) for each in (y, x))
    inside = (row >= 0) & (row < SIZE)
    assert inside.mean() > 0.5
    seen_now = frame.radiance[-1][inside]
    shown, still = (each[row[inside], column[inside]] for each in (expected, without))
    assert np.corrcoef(seen_now, shown)[0, 1] > 0.95
    assert np.corrcoef(seen_now, still)[0, 1] < 0.8


def test_clear_sea_of_a_pass_has_the_radiance_of_each_view():
    clouds = {"type": "stratus", "coverage": 0.0}
    views = [LinesOfSight(30.0, 150.0, abs(zenith), 0.0 if zenith > 0 else 180.0, 7e5) for zenith in (-30, 0, 24, 48)]
    times = np.arange(4) * 3.0
    trajectory = PositionTable(times, [each.sensor_m for each in views])
    small = {"rows": 8, "columns": 8, "pixel_size": 100.0}
    sequence = {"count": 2, "interval": 9.0}
    moving = frames(
        scene(clouds=clouds, image=small, frames=sequence),
        Camera(4, 4, 1.0, 2e-5),
        trajectory,
        Track(trajectory, 30.0, 150.0),
        np.linspace(0.0, 9.0, 19),
    )
    for frame in list(moving)[::5]:
        view = {"zenith": frame.view.zenith_deg, "azimuth": frame.view.azimuth_deg}
        still = hcss_twin.simulate(scene(clouds=clouds, image=small, frames=sequence, view=view))["radiance"].values
        expected = still[0] + frame.pose.time_s / 9.0 * (still[1] - still[0])
        relative = frame.radiance.mean(axis=(1, 2)) / expected.mean(axis=(1, 2)) - 1.0
        assert np.abs(relative).max() < 2e-3


def test_interpolated_clouds_are_never_thinner_than_the_thinnest():
    rng = np.random.default_rng(5)
    field = np.where(rng.random((40, 50)) < 0.5, rng.uniform(20.0, 300.0, (40, 50)), 0.0).astype(np.float32)
    row, column = rng.uniform(-0.5, 39.5, 10_000), rng.uniform(-0.5, 49.5, 10_000)
    between = interpolated_thickness(field, row, column)
    assert between[between > 0.0].min() >= 20.0 * (1 - 1e-6)
    assert np.mean(between > 0.0) == pytest.approx(0.5, abs=0.03)
    y, x = np.indices(field.shape, dtype=float)
    assert interpolated_thickness(field, y, x) == pytest.approx(field)


def test_what_cannot_be_shown_is_refused_by_name():
    trajectory = above()

    def first(scenario, camera=None, attitude=None, times=(0.0,)):
        camera = matching() if camera is None else camera
        return next(frames(scenario, camera, trajectory, attitude or Nadir(trajectory), times))

    moving = {"platform_speed": 1000.0, "wind_speed": 10.0, "wind_from": 270.0}
    with pytest.raises(PayloadError, match=r"motion\.platform_speed: the trajectory moves the camera"):
        first(scene(motion=moving))
    with pytest.raises(PayloadError, match="times_s: 11 s; allowed: 0 to 10 s"):
        first(scene(), times=[11.0])
    with pytest.raises(PayloadError, match="times_s: 2 times; allowed: one or more, none earlier"):
        first(scene(), times=[5.0, 1.0])
    with pytest.raises(PayloadError, match="times_s: 0 times"):
        first(scene(), times=[])
    with pytest.raises(PayloadError, match=r"view zenith at time 0 s: 7.* deg; allowed: 0 to 75 deg"):
        first(scene(), attitude=Track(trajectory, 30.0, 191.0))
    with pytest.raises(PayloadError, match="points of the scene at time 0 s; allowed: up to"):
        first(scene(), Camera(SIZE, SIZE, 1.0, 1e-2))
