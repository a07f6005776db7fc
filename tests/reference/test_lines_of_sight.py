"""Lines of sight against closed forms on a round Earth, and against positions that PROJ gives in space."""

import math

import numpy as np
import pyproj
import pytest

from hcss_twin.physics.viewing import LinesOfSight, ground_speed_m_s, off_nadir_deg, slant_range_m, view_zenith_deg

RADIUS_M = 6371008.7714
TO_CENTRE = pyproj.Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)

ALTITUDES = (100e3, 700e3, 35_786e3, 42_000e3)
LATITUDES = (-90.0, -40.0, 0.0, 35.0, 90.0)
VIEWS = ((0.0, 0.0), (20.0, 18.72), (60.0, 200.0), (85.0, 359.0))
PLACES = [
    (ALTITUDES[(row + column) % 4], latitude, *view)  # each altitude with each latitude and each view
    for row, latitude in enumerate(LATITUDES)
    for column, view in enumerate(VIEWS)
]


@pytest.mark.parametrize("altitude", ALTITUDES)
@pytest.mark.parametrize("zenith", [0.0, 1e-6, 20.0, 60.0, 85.0])
def test_the_triangle_of_earth_and_sensor_obeys_the_laws_of_sines_and_cosines(altitude, zenith):
    look, distance, far = (off_nadir_deg(zenith, altitude), slant_range_m(zenith, altitude), RADIUS_M + altitude)
    assert math.sin(math.radians(look)) * far == pytest.approx(RADIUS_M * math.sin(math.radians(zenith)), rel=1e-12)
    at_centre = math.radians(zenith - look)
    square = RADIUS_M**2 + far**2 - 2.0 * RADIUS_M * far * math.cos(at_centre)
    assert distance == pytest.approx(math.sqrt(square), rel=1e-9)
    assert view_zenith_deg(look, altitude) == pytest.approx(zenith, abs=1e-6)


def test_a_look_past_the_horizon_misses_the_earth():
    horizon = math.degrees(math.asin(RADIUS_M / (RADIUS_M + 800e3)))
    assert view_zenith_deg(horizon - 1e-6, 800e3) < 90.0
    assert view_zenith_deg(horizon + 1e-6, 800e3) == math.inf


@pytest.mark.parametrize(
    ("altitude", "period_s"),
    # A geostationary satellite takes one turn of the Earth against the stars.
    [(42_164_172.0 - RADIUS_M, 86_164.0905), (0.0, 2 * math.pi * math.sqrt(RADIUS_M**3 / 3.986004418e14))],
)
def test_the_footprint_of_an_orbit_goes_round_the_globe_in_its_period(altitude, period_s):
    assert ground_speed_m_s(altitude) == pytest.approx(2 * math.pi * RADIUS_M / period_s, rel=1e-6)


def test_the_footprint_of_a_low_orbit_covers_seven_kilometres_a_second():
    # Landsat 8: 705 km, 233 orbits of equal length in 16 days.
    assert ground_speed_m_s(705e3) == pytest.approx(2 * math.pi * RADIUS_M * 233 / (16 * 86400), rel=2e-3)


@pytest.mark.parametrize(("altitude", "latitude", "zenith", "azimuth"), PLACES)
def test_directions_and_ranges_are_those_of_positions_in_space(altitude, latitude, zenith, azimuth):
    """The sensor and the verticals from PROJ: angles between vectors, without any of our axes."""
    lines = LinesOfSight(latitude, 150.0, zenith, azimuth, altitude)
    x = np.array([0.0, 2e5, -1e5, 2.5e5, -2.5e5, 10.0])
    y = np.array([0.0, -1e5, 2e5, 2.5e5, -2.5e5, 10.0])
    seen = lines.from_points(x, y)
    ground = at(seen.latitude_deg, seen.longitude_deg, 0.0)
    sensor = lines.sensor_m
    ray = sensor - ground
    distance = np.linalg.norm(ray, axis=-1)
    np.testing.assert_allclose(seen.range_m, distance, rtol=1e-12)
    up = at(seen.latitude_deg, seen.longitude_deg, 1.0) - ground
    across = np.linalg.norm(np.cross(ray, up), axis=-1)
    np.testing.assert_allclose(seen.zenith_deg, np.degrees(np.arctan2(across, np.sum(ray * up, axis=-1))), atol=1e-6)
    assert seen.zenith_deg[0] == pytest.approx(zenith, abs=1e-9)
    # East is along the parallel: level, and square to the Earth's axis.
    east = np.cross([0.0, 0.0, 1.0], up)
    if abs(latitude) < 90.0:
        north = np.cross(up, east)
        bearing = np.arctan2(
            np.sum(ray * east, -1) / np.linalg.norm(east, axis=-1),
            np.sum(ray * north, -1) / np.linalg.norm(north, axis=-1),
        )
        turn = (np.degrees(bearing) - seen.azimuth_deg + 180.0) % 360.0 - 180.0
        assert np.max(np.abs(turn * np.sin(np.radians(seen.zenith_deg)))) < 1e-6
    assert altitude_of(sensor) == pytest.approx(altitude, abs=0.02)


def test_straight_below_the_sensor_pixels_see_it_toward_the_centre():
    lines = LinesOfSight(35.0, 150.0, 0.0, 0.0, 800e3)
    x, y = np.array([1e5, 0.0, -1e5, 0.0]), np.array([0.0, 1e5, 0.0, -1e5])
    seen = lines.from_points(x, y)
    away = (seen.plane_azimuth_deg - [270.0, 180.0, 90.0, 0.0] + 180.0) % 360.0 - 180.0
    np.testing.assert_allclose(away, 0.0, atol=0.01)
    assert np.all(seen.zenith_deg > np.degrees(np.arctan(1e5 / 800e3)))  # the ground falls away
    assert lines.centre_range_m == pytest.approx(800e3, abs=1e-3)


@pytest.mark.parametrize("latitude", [89.9, 90.0, -90.0])
def test_directions_in_the_plane_hang_together_over_a_pole(latitude):
    """Bearings from north turn all round there, those from the plane's axis do not."""
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-5e4, 5e4, 11), np.linspace(-5e4, 5e4, 11)))
    seen = LinesOfSight(latitude, 10.0, 40.0, 90.0, 800e3).from_points(x, y)
    assert np.max(np.abs(seen.plane_azimuth_deg - 90.0)) < 6.0
    assert np.ptp(seen.azimuth_deg) > 180.0


def at(latitude_deg, longitude_deg, altitude):
    return np.stack(TO_CENTRE.transform(longitude_deg, latitude_deg, np.full_like(latitude_deg, altitude)), axis=-1)


def altitude_of(position):
    """Where the vertical through a position in space meets the ellipsoid: the nearest point, found by a search."""
    from scipy.optimize import minimize_scalar

    across, up = math.hypot(position[0], position[1]), float(position[2])

    def far(latitude):
        x, _, z = TO_CENTRE.transform(0.0, latitude, 0.0)
        return math.hypot(across - x, up - z)

    guess = math.degrees(math.atan2(up, across))
    bounds = (max(guess - 1.0, -90.0), min(guess + 1.0, 90.0))
    return float(minimize_scalar(far, bounds=bounds, method="bounded", options={"xatol": 1e-10}).fun)
