"""Frames from poses in code, at any times, against cubes and the engine's own parallax."""

import numpy as np
import pytest
from camera_scenes import PASS, scenario
from hcss_payload import Camera, Circular, Nadir, PayloadError, PositionTable, Track
from hcss_payload.frames import frames

import hcss_twin
from hcss_twin.core.errors import ScenarioError
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.physics.viewing import LinesOfSight

ORBIT = Circular.above(7e5, 98.2, 30.0, 153.0, 60.0)
CAMERA = Camera(40, 48, 0.15, 1.5e-5)


def scene(**parts):
    """The scene of a pass, without the sections of the camera."""
    return scenario({name: PASS[name] for name in ("place", "frames")}, parts)


def above(height_m=3e6):
    """A trajectory that rests above the scene."""
    position = Ellipsoid.to_earth_centred(np.float64(30.0), np.float64(150.0), height_m)
    return PositionTable([-100.0, 200.0], [position, position])


def test_frames_of_objects_have_the_bits_of_sections_in_every_list_of_times():
    track = Track(ORBIT, 30.0, 150.0)
    expected = list(hcss_twin.Twin(scenario(PASS)).frames())
    passed = list(frames(scene(), CAMERA, ORBIT, track, [0.0, 37.5, 120.0]))
    for frame, number in ((passed[0], 0), (passed[2], 2)):
        assert set(frame.variables) == set(expected[number].variables)
        for name, values in expected[number].variables.items():
            assert np.array_equal(frame.variables[name], values)
    (alone,) = frames(scene(), CAMERA, ORBIT, track, [37.5])
    assert np.array_equal(alone.radiance, passed[1].radiance)
    assert alone.pose.position_m == pytest.approx(ORBIT.at(37.5))
    assert not np.array_equal(alone.radiance, passed[0].radiance)


def test_clouds_move_against_the_sea_as_with_parallax_of_the_engine():
    size = 96
    image = {"rows": size, "columns": size, "pixel_size": 100.0}
    output = {"certificate": 0}
    plain = scene(image=image, clouds={"type": "altostratus"}, output=output)
    height = hcss_twin.make_plan(plain).layers[0].reference_height_m
    # The engine displaces clouds by whole pixels: here by exactly 20.
    zenith = float(np.degrees(np.arctan(2000.0 / height)))
    view = {"view": {"zenith": zenith, "azimuth": 0.0}, "slant": {"parallax": "on"}}
    displaced = scene(image=image, clouds={"type": "altostratus"}, output=output, **view)
    expected, without = (hcss_twin.simulate(scenario)["radiance"].values[0, -1] for scenario in (displaced, plain))
    position = LinesOfSight(30.0, 150.0, zenith, 0.0, 3e6).sensor_m
    trajectory = PositionTable([-1.0, 200.0], [position, position])
    away = np.linalg.norm(position - Ellipsoid.to_earth_centred(np.float64(30.0), np.float64(150.0)))
    track, camera = Track(trajectory, 30.0, 150.0), Camera(40, 40, 1.0, 100.0 / away)
    (frame,) = frames(plain, camera, trajectory, track, [0.0], points=1)
    x, y = Ellipsoid.to_plane(frame.variables["pixel_latitude"], frame.variables["pixel_longitude"], 30.0, 150.0)
    row, column = (np.rint(coordinate / 100.0 + 0.5 * size - 0.5).astype(int) for coordinate in (y, x))
    inside = (row >= 0) & (row < size)
    assert inside.mean() > 0.5
    shown, still = (image[row[inside], column[inside]] for image in (expected, without))
    assert np.corrcoef(frame.radiance[-1][inside], shown)[0, 1] > 0.95
    assert np.corrcoef(frame.radiance[-1][inside], still)[0, 1] < 0.8


def test_what_cannot_be_shown_is_refused_by_name():
    trajectory = above()

    def first(planned, camera=CAMERA, attitude=None, times=(0.0,), **options):
        return next(frames(planned, camera, trajectory, attitude or Nadir(trajectory), times, **options))

    with pytest.raises(ScenarioError, match=r"motion\.platform_speed: .*cannot be computed with a camera"):
        first(scene(motion={"platform_speed": 1000.0}))
    with pytest.raises(PayloadError, match="times_s: 121 s; allowed: 0 to 120 s"):
        first(scene(), times=[121.0])
    with pytest.raises(PayloadError, match="points: 17; allowed: 1 to 16"):
        first(scene(), points=17)
    with pytest.raises(ScenarioError, match=r"camera\.beyond: 'refuse', and at time 0 s"):
        first(scene(), attitude=Track(trajectory, 30.0, 191.0))
    with pytest.raises(ScenarioError, match="points of the scene at time 0 s; allowed: up to"):
        first(scene(), Camera(96, 96, 1.0, 1e-2), points=1)
