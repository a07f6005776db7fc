"""The image plane on the ellipsoid against PROJ: its azimuthal equidistant projection and C. Karney's geodesics."""

import numpy as np
import pyproj
import pytest

from hcss_twin.physics.geodesy import Ellipsoid, altitude_m, distance_from_equator_m, to_geographic

GLOBE = pyproj.Geod(ellps="WGS84")
ALLOWED_M = 1e-3
"""A thousandth of what is asked for."""

LATITUDES = (-90.0, -89.9999, -60.0, 0.0, 1e-9, 35.0, 80.0, 89.5, 90.0)
LONGITUDES = (0.0, 150.0, 179.9999, -180.0, 360.0)

centres = pytest.mark.parametrize(
    ("latitude", "longitude"),  # the figure of the Earth is the same at all longitudes: they need no crossing
    [*((latitude, 179.9999) for latitude in LATITUDES), *((35.0, longitude) for longitude in LONGITUDES)],
)


def plane(side_m):
    """Points of an image of this side, its centre, corners and axes among them."""
    along = np.linspace(-0.5, 0.5, 41) * side_m
    return tuple(np.ravel(each) for each in np.meshgrid(along, along))


def apart_m(one, other):
    return GLOBE.inv(one[1], one[0], other[1], other[0])[2]


@centres
@pytest.mark.parametrize("side_m", [16e3, 500e3, 4000e3])
def test_pixels_lie_where_proj_has_them(latitude, longitude, side_m):
    x, y = plane(side_m)
    projection = pyproj.Proj(proj="aeqd", lat_0=latitude, lon_0=longitude, ellps="WGS84")
    theirs = projection(x, y, inverse=True)[::-1]
    assert np.max(apart_m(to_geographic(x, y, latitude, longitude), theirs)) < ALLOWED_M


@centres
@pytest.mark.parametrize("side_m", [16e3, 4000e3])
def test_places_lie_where_proj_has_them_in_the_plane(latitude, longitude, side_m):
    projection = pyproj.Proj(proj="aeqd", lat_0=latitude, lon_0=longitude, ellps="WGS84")
    x, y = plane(side_m)
    places = projection(x, y, inverse=True)[::-1]
    found = np.stack(Ellipsoid.to_plane(*places, latitude, longitude))
    assert np.max(np.abs(found - np.stack(projection(*places[::-1])))) < ALLOWED_M


def test_places_beyond_60_degrees_are_refused():
    with pytest.raises(ValueError, match="60 degrees or more from the image centre"):
        Ellipsoid.to_plane(np.array([0.0]), np.array([61.0]), 0.0, 0.0)


@pytest.mark.parametrize("latitude", [-80.0, 0.0, 45.0, 89.0])
def test_points_of_the_plane_keep_their_distance_and_bearing_from_the_centre(latitude):
    x, y = plane(4000e3)
    found, longitude, turn = Ellipsoid.to_geographic_with_turn(x, y, latitude, 100.0)
    start = np.full_like(x, 100.0), np.full_like(x, latitude)
    bearing, back, distance = GLOBE.inv(*start, longitude, found)
    assert np.max(np.abs(distance - np.hypot(x, y))) < ALLOWED_M
    away = distance > 0
    expected = np.degrees(np.arctan2(x, y))
    sideways = np.sin(np.radians(bearing - expected)) * distance
    assert np.max(np.abs(sideways)) < 0.01
    # The geodesic arrives turned from its bearing at the centre by as much as the plane's axes are.
    arriving = np.radians(back + 180.0 - bearing - turn)[away]
    assert np.max(np.abs(np.sin(arriving) * distance[away])) < 0.01


@pytest.mark.parametrize("longitude", LONGITUDES)
def test_longitudes_run_on_over_the_date_line(longitude):
    x, y = plane(500e3)
    _, found = to_geographic(x, y, 60.0, longitude)
    assert np.max(np.abs(found - longitude)) < 10.0
    assert np.all(np.diff(found.reshape(41, 41), axis=1) > 0.0)


@pytest.mark.parametrize("latitude", [-90.0, -33.0, 0.0, 12.5, 90.0])
def test_distances_along_a_meridian(latitude):
    expected = GLOBE.inv(0.0, 0.0, 0.0, latitude)[2] * np.sign(latitude)
    assert distance_from_equator_m(latitude) == pytest.approx(expected, abs=ALLOWED_M)


@pytest.mark.parametrize("altitude", [0.0, 100e3, 800e3, 35_786e3, 42_000e3])
def test_positions_and_altitudes_are_those_of_proj(altitude):
    latitude = np.array([-90.0, -45.0, 0.0, 1e-7, 30.0, 89.9999, 90.0])
    longitude = np.linspace(-180.0, 180.0, latitude.size)
    ours = Ellipsoid.to_earth_centred(latitude, longitude, altitude)
    to_centre = pyproj.Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)
    theirs = np.stack(to_centre.transform(longitude, latitude, np.full_like(latitude, altitude)), axis=-1)
    np.testing.assert_allclose(ours, theirs, atol=1e-6)
    for position in ours:
        assert altitude_m(position) == pytest.approx(altitude, abs=1e-6)
