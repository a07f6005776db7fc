"""How a sensor above WGS 84 sees each point of the image plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.physics.ellipsoid import altitude_m, east_north_up, to_earth_centred
from hcss_twin.physics.local_plane import to_geographic_with_turn
from hcss_twin.viewing.look_angle import slant_range_m

Array = NDArray[np.float64]

_CLOSE_M = 1e-6
_MOST_ROUNDS = 50


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
        The same clockwise from the plane's y axis, as the directions of sun and wind at the image centre are meant.
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
        for _ in range(_MOST_ROUNDS):
            # The altitude grows with the distance by the cosine to the vertical there, which is near the centre's.
            position = start + distance * direction
            miss = self.altitude_m - altitude_m(position)
            distance += miss * float(np.linalg.norm(position) / (position @ direction))
            if abs(miss) < _CLOSE_M:
                break
        return distance

    @property
    def sensor_m(self) -> Array:
        """Position (3,) of the sensor from the Earth's centre."""
        start, direction = self._line()
        return start + self.centre_range_m * direction

    def from_points(self, x_m: Array, y_m: Array) -> Sight:
        """Return the lines of sight from points (...) east and north of the image centre."""
        latitude, longitude, turn = to_geographic_with_turn(x_m, y_m, self.latitude_deg, self.longitude_deg)
        ray = self.sensor_m - to_earth_centred(latitude, longitude)
        east, north, up = (np.sum(axis * ray, axis=-1) for axis in east_north_up(latitude, longitude))
        zenith = np.degrees(np.arctan2(np.hypot(east, north), up))
        azimuth = np.degrees(np.arctan2(east, north)) % 360.0
        return Sight(
            latitude, longitude, zenith, azimuth, (azimuth - turn) % 360.0, np.linalg.norm(ray, axis=-1)
        )

    def _line(self) -> tuple[Array, Array]:
        """Return the image centre and the unit vector from it to the sensor, both (3,)."""
        place = np.float64(self.latitude_deg), np.float64(self.longitude_deg)
        zenith, azimuth = np.radians(self.view_zenith_deg), np.radians(self.view_azimuth_deg)
        east, north, up = east_north_up(*place)  # type: ignore[arg-type]
        direction = np.sin(zenith) * (np.sin(azimuth) * east + np.cos(azimuth) * north) + np.cos(zenith) * up
        return to_earth_centred(*place), direction  # type: ignore[arg-type]
