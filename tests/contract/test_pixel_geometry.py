"""Coordinates of every pixel: in the cube, in its readers, and when it is verified."""

import netCDF4
import numpy as np
import pyproj
import pytest
from cheap import CHEAP
from example_cube import example_header

from hcss_twin import Scenario, ScenarioError, make_plan, simulate
from hcss_twin.core.errors import CubeError
from hcss_twin.cube import geometry
from hcss_twin.cube.variables import GEOMETRY
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.engine.verification import verify_cube

SMALL = {
    **CHEAP,
    "bands": ["mwir-3.7"],
    "image.rows": 6,
    "image.columns": 9,
    "image.pixel_size": 1000.0,
    "frames.count": 2,
    "platform.altitude": "800 km",
    "output.variables": ["cloud_mask", "geometry"],
}
STARING = {**SMALL, "motion.platform_speed": 0.0}
MOVING = {**SMALL, "motion.platform_speed": "orbit"}
NAMES = [spec.name for spec in GEOMETRY]


def cube_of(overrides, path=None):
    return simulate(Scenario.load("stratus", overrides), path)


@pytest.fixture(scope="module")
def staring():
    return cube_of(STARING)


@pytest.fixture(scope="module")
def moving():
    return cube_of(MOVING)


def test_every_coordinate_is_written_once_where_nothing_moves(staring):
    assert set(NAMES) <= set(staring.coords)
    assert all(staring[name].dims == ("y", "x") for name in NAMES)
    assert set(staring.data_vars) == {"cloud_mask"}
    assert set(NAMES) <= set(staring.cloud_mask.coords)


def test_places_follow_the_platform_and_directions_move_with_it(moving, staring):
    for name in ("pixel_latitude", "pixel_longitude"):
        assert moving[name].dims == ("time", "y", "x")
        np.testing.assert_array_equal(moving[name].isel(time=0), staring[name])
    for name in NAMES[2:]:
        assert moving[name].dims == ("y", "x")
        np.testing.assert_array_equal(moving[name], staring[name])


def test_pixels_of_every_frame_lie_where_the_grid_mapping_puts_them(moving):
    """A reader that knows nothing but CF: x and y, the displacement of the frame, and the projection."""
    mapping = {name: value for name, value in moving.local_plane.attrs.items() if name != "comment"}
    projection = pyproj.Proj(pyproj.CRS.from_cf(mapping))
    globe = pyproj.Geod(ellps="WGS84")
    assert moving.centre_displacement[1] > 6000.0
    for frame in range(2):
        x, y = np.meshgrid(moving.x + moving.centre_displacement[frame], moving.y)
        longitude, latitude = projection(x, y, inverse=True)
        ours = moving.pixel_longitude[frame].to_numpy(), moving.pixel_latitude[frame].to_numpy()
        assert np.max(globe.inv(*ours, longitude, latitude)[2]) < 1e-3


def test_the_view_of_the_pixels_is_that_of_the_scene_in_the_middle(staring):
    at = {"y": slice(2, 4), "x": 4}
    middle = staring.isel(at)
    assert float(middle.pixel_view_zenith.mean()) == pytest.approx(20.0, abs=1e-3)
    assert float(middle.pixel_view_azimuth.mean()) == pytest.approx(18.72, abs=1e-3)
    assert float(middle.pixel_footprint_across.mean()) == pytest.approx(1000.0, rel=1e-4)
    along = float(middle.pixel_footprint_along.mean())
    assert along == pytest.approx(1000.0 / np.cos(np.radians(20.0)), rel=1e-4)


def test_readers_find_one_latitude(tmp_path):
    cube_of(STARING, tmp_path / "a.nc").close()
    with netCDF4.Dataset(tmp_path / "a.nc") as file:
        listed = file["cloud_mask"].coordinates.split()
        assert set(NAMES) <= set(listed)
        assert not {"latitude", "longitude", "sensor_zenith_angle", "sensor_azimuth_angle"} & set(listed)
        assert {"sensor_altitude", "solar_zenith_angle"} <= set(listed)
        assert float(file["sensor_altitude"][...]) == 800e3
        assert "earth_radius" not in file["local_plane"].ncattrs()


def test_without_an_altitude_pixels_have_places_and_no_directions(tmp_path):
    known = {**STARING, "platform.altitude": None}
    cube = cube_of(known)
    assert set(NAMES) & set(cube.coords) == {"pixel_latitude", "pixel_longitude"}
    assert "sensor_altitude" not in cube.coords
    with pytest.raises(ScenarioError, match="altitude of the sensor is not known"):
        cube_of({**known, "output.variables": ["pixel_slant_range"]})
    header = example_header(geometry=(GEOMETRY[2],))
    with pytest.raises(CubeError, match="pixel_view_zenith: needs sensor_altitude_m"):
        CubeWriter(tmp_path / "a.nc", header)


def test_a_cube_can_hold_nothing_but_coordinates_of_its_pixels():
    cube = cube_of({**MOVING, "output.variables": ["pixel_longitude"]})
    assert not cube.data_vars
    assert cube.pixel_longitude.shape == (2, 6, 9)


def test_all_is_what_frames_have(staring):
    plan = make_plan(Scenario.load("stratus", {**STARING, "output.variables": ["all"]}))
    assert not set(NAMES) & {spec.name for spec in plan.variables}


@pytest.mark.parametrize("overrides", [STARING, MOVING], ids=["staring", "moving"])
def test_parts_of_an_image_are_those_of_the_whole(overrides, staring, moving, monkeypatch):
    monkeypatch.setattr(geometry, "PIXELS_AT_ONCE", 20)
    whole = staring if overrides is STARING else moving
    parts = cube_of({**overrides, "output.compression": 1})
    for name in NAMES:
        np.testing.assert_array_equal(parts[name], whole[name])


@pytest.mark.parametrize("overrides", [STARING, MOVING], ids=["staring", "moving"])
def test_verifying_a_cube_checks_the_coordinates_of_its_pixels(overrides, tmp_path):
    path = tmp_path / "a.nc"
    cube_of(overrides, path).close()
    found = verify_cube(path)
    assert found.passed
    assert set(NAMES) <= {check.name for check in found.variables}
    with netCDF4.Dataset(path, "a") as file:
        file["pixel_latitude"][..., 4, 3] += 1.0
    (wrong,) = [check for check in verify_cube(path).variables if check.beyond]
    assert wrong.name == "pixel_latitude"
    assert (wrong.first.position["row"], wrong.first.position["column"]) == (4, 3)
