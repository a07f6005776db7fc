"""Frames from a pose against the cube of the same scenario."""

import numpy as np
import pytest
from hcss_payload import Camera, Nadir, PositionTable
from hcss_payload.frames import frames

import hcss_twin
from hcss_twin.physics.geodesy import to_earth_centred

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
