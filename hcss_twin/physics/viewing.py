"""Lines of sight from the ground to a sensor.

The first functions assume a spherical Earth and a circular orbit; they solve the triangle of Earth centre, ground point
and sensor. :class:`LinesOfSight` uses the WGS 84 ellipsoid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.physics.geodesy import MEAN_EARTH_RADIUS_M, Ellipsoid, altitude_m


def view_zenith_deg(off_nadir_deg: float, altitude_m: float) -> float:
    """Return the zenith angle at the ground for a look angle at the sensor; infinite if it misses the Earth."""
    sine = (1.0 + altitude_m / MEAN_EARTH_RADIUS_M) * math.sin(math.radians(off_nadir_deg))
    return math.degrees(math.asin(sine)) if sine <= 1.0 else math.inf


def off_nadir_deg(view_zenith_deg: float, altitude_m: float) -> float:
    """Return the look angle at the sensor, from nadir to the line of sight, for a zenith angle at the ground."""
    sine = math.sin(math.radians(view_zenith_deg)) / (1.0 + altitude_m / MEAN_EARTH_RADIUS_M)
    return math.degrees(math.asin(sine))


def slant_range_m(view_zenith_deg: float, altitude_m: float) -> float:
    """Return the distance from the ground to the sensor."""
    zenith, radius = math.radians(view_zenith_deg), MEAN_EARTH_RADIUS_M
    down = radius * math.cos(zenith)
    # A quotient: the difference of the two lengths would lose precision at low altitudes.
    return (
        altitude_m
        * (2.0 * radius + altitude_m)
        / (math.sqrt(down**2 + altitude_m * (2.0 * radius + altitude_m)) + down)
    )


EARTH_M3_S2 = 3.986004418e14
"""Gravitational constant times mass of the Earth; G. Petit and B. Luzum, IERS Conventions (2010), table 1.1."""


def ground_speed_m_s(altitude_m: float) -> float:
    """Return the speed of the point below a satellite over the ground.

    sqrt(mu / r) R / r with r = R + altitude (Kepler's third law). The Earth's own rotation, up to 465 m/s at the
    equator, is neglected.
    """
    radius = MEAN_EARTH_RADIUS_M + altitude_m
    return math.sqrt(EARTH_M3_S2 / radius) * MEAN_EARTH_RADIUS_M / radius


GEOSTATIONARY_M = 35_786_034.0
"""Altitude of a geostationary orbit above the ellipsoid, from the constant above and 7.292115e-5 rad/s (WGS 84)."""


def toward_equatorial_deg(
    latitude_deg: float, longitude_deg: float, sensor_longitude_deg: float, altitude_m: float
) -> tuple[float, float]:
    """Return zenith and azimuth angle, at a place, of a sensor above the equator of the ellipsoid."""
    position_deg = np.array(latitude_deg), np.array(longitude_deg)
    sensor = Ellipsoid.to_earth_centred(np.array(0.0), np.array(sensor_longitude_deg), altitude_m)
    zenith, azimuth = _angles_deg(sensor - Ellipsoid.to_earth_centred(*position_deg), *position_deg)
    return float(zenith), float(azimuth)


def _angles_deg(ray_m: Array, latitude_deg: Array, longitude_deg: Array) -> tuple[Array, Array]:
    """Return zenith and azimuth angles (...) of vectors (..., 3) at places (...)."""
    east, north, up = (np.sum(axis * ray_m, axis=-1) for axis in Ellipsoid.east_north_up(latitude_deg, longitude_deg))
    return np.degrees(np.arctan2(np.hypot(east, north), up)), np.degrees(np.arctan2(east, north)) % 360.0


def from_another_place_deg(
    zenith_deg: float, azimuth_deg: float, from_deg: tuple[float, float], to_deg: tuple[float, float]
) -> tuple[float, float]:
    """Return zenith and azimuth angle of a direction at another place, for what is as far as the sun.

    Parameters
    ----------
    from_deg, to_deg : (float, float)
        Latitude and longitude of the place of the angles given, and of that of the angles returned.
    """
    zenith, azimuth = math.radians(zenith_deg), math.radians(azimuth_deg)
    local = np.array([math.sin(zenith) * math.sin(azimuth), math.sin(zenith) * math.cos(azimuth), math.cos(zenith)])
    latitude, longitude = (np.array(angle) for angle in to_deg)
    before = np.array(Ellipsoid.east_north_up(np.array(from_deg[0]), np.array(from_deg[1])))
    there = _angles_deg(local @ before, latitude, longitude)
    return float(there[0]), float(there[1])


_CLOSE_M, _MAX_ITERATIONS = 1e-6, 50


@dataclass(frozen=True)
class Sight:
    """Lines of sight from points of the image plane to the sensor.

    Attributes
    ----------
    latitude_deg, longitude_deg : ndarray (...)
        Of the points.
    zenith_deg, azimuth_deg : ndarray (...)
        Direction toward the sensor: from the normal of the ellipsoid, and clockwise from north, 0 to 360.
    plane_azimuth_deg : ndarray (...)
        The azimuth clockwise from the plane's y axis, like the directions of sun and wind at the image centre.
    range_m : ndarray (...)
        Distance to the sensor.
    """

    latitude_deg: Array
    longitude_deg: Array
    zenith_deg: Array
    azimuth_deg: Array
    plane_azimuth_deg: Array
    range_m: Array


@dataclass(frozen=True)
class LinesOfSight:
    """A sensor that looks at an image centre.

    Attributes
    ----------
    latitude_deg, longitude_deg : float
        Of the image centre.
    view_zenith_deg, view_azimuth_deg : float
        Direction from the image centre to the sensor.
    altitude_m : float
        Of the sensor above the ellipsoid.
    """

    latitude_deg: float
    longitude_deg: float
    view_zenith_deg: float
    view_azimuth_deg: float
    altitude_m: float

    @property
    def centre_range_m(self) -> float:
        """Distance from the image centre to the sensor: where the line of sight reaches the altitude."""
        start, direction = self._line()
        distance = slant_range_m(self.view_zenith_deg, self.altitude_m)
        for _ in range(_MAX_ITERATIONS):
            # The derivative of altitude by distance is the cosine of the local zenith angle, close to the centre's.
            position = start + distance * direction
            miss = self.altitude_m - altitude_m(position)
            distance += miss * float(np.linalg.norm(position) / (position @ direction))
            if abs(miss) < _CLOSE_M:
                break
        return distance

    @cached_property
    def sensor_m(self) -> Array:
        """Position (3,) of the sensor from the Earth's centre."""
        start, direction = self._line()
        return start + self.centre_range_m * direction

    def from_points(self, x_m: Array, y_m: Array) -> Sight:
        """Return the lines of sight from points (...) east and north of the image centre."""
        latitude, longitude, turn = Ellipsoid.to_geographic_with_turn(x_m, y_m, self.latitude_deg, self.longitude_deg)
        ray = self.sensor_m - Ellipsoid.to_earth_centred(latitude, longitude)
        zenith, azimuth = _angles_deg(ray, latitude, longitude)
        return Sight(latitude, longitude, zenith, azimuth, (azimuth - turn) % 360.0, np.linalg.norm(ray, axis=-1))

    def _line(self) -> tuple[Array, Array]:
        """Return the image centre and the unit vector from it to the sensor, both (3,)."""
        centre = np.float64(self.latitude_deg), np.float64(self.longitude_deg)
        zenith, azimuth = np.radians(self.view_zenith_deg), np.radians(self.view_azimuth_deg)
        east, north, up = Ellipsoid.east_north_up(*centre)  # type: ignore[arg-type]
        direction = np.sin(zenith) * (np.sin(azimuth) * east + np.cos(azimuth) * north) + np.cos(zenith) * up
        return Ellipsoid.to_earth_centred(*centre), direction  # type: ignore[arg-type]
