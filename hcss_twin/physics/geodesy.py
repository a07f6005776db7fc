"""WGS 84 ellipsoid: positions in space, altitudes, geodesics, and the image plane on the globe.

Ellipsoid: NIMA TR8350.2, "Department of Defense World Geodetic System 1984", 3rd edition (2000), table 3.1, section 4.

Geodesics from one point: T. Vincenty, "Direct and inverse solutions of geodesics on the ellipsoid with application of
nested equations", Survey Review 23 (176), 88-93 (1975), with the constants A and B in Helmert's expansion parameter
k1; better than 1 mm over any distance. The direct problem converges everywhere, poles included.

Image plane: x points east and y north on the plane of the azimuthal equidistant projection about the image centre at
the start. Every point lies at its distance and bearing from the centre along a geodesic (J. P. Snyder, "Map
Projections: A Working Manual", USGS Professional Paper 1395, 1987, pp 197-202).
"""

from __future__ import annotations

import numpy as np

from hcss_twin.core.arrays import Array

__all__ = ["Ellipsoid"]

SEMI_MAJOR_AXIS_M = 6378137.0
INVERSE_FLATTENING = 298.257223563
FLATTENING = 1.0 / INVERSE_FLATTENING
SEMI_MINOR_AXIS_M = SEMI_MAJOR_AXIS_M * (1.0 - FLATTENING)
ECCENTRICITY_SQUARED = FLATTENING * (2.0 - FLATTENING)

_ALTITUDE_ITERATIONS = 8
"""Each iteration reduces the error by more than a factor of 100."""


def altitude_m(position_m: Array) -> float:
    """Return the altitude of a position (3,) above the ellipsoid, along its normal; the position lies outside.

    Fixed-point iteration between geodetic and reduced latitude (B. R. Bowring, "Transformation from spatial to
    geographical coordinates", Survey Review 23 (181), 323-327, 1976).
    """
    across, up = float(np.hypot(position_m[0], position_m[1])), float(position_m[2])
    second = ECCENTRICITY_SQUARED / (1.0 - ECCENTRICITY_SQUARED)
    reduced = np.arctan2(up * SEMI_MAJOR_AXIS_M, across * SEMI_MINOR_AXIS_M)
    phi = reduced
    for _ in range(_ALTITUDE_ITERATIONS):
        phi = np.arctan2(
            up + second * SEMI_MINOR_AXIS_M * np.sin(reduced) ** 3,
            across - ECCENTRICITY_SQUARED * SEMI_MAJOR_AXIS_M * np.cos(reduced) ** 3,
        )
        reduced = np.arctan2(SEMI_MINOR_AXIS_M * np.sin(phi), SEMI_MAJOR_AXIS_M * np.cos(phi))
    # Not (across / cos(phi)) - normal, which divides by 0 at the poles.
    along = across * np.cos(phi) + up * np.sin(phi)
    return float(along - SEMI_MAJOR_AXIS_M * np.sqrt(1.0 - ECCENTRICITY_SQUARED * np.sin(phi) ** 2))


def distance_from_equator_m(latitude_deg: float) -> float:
    """Return the distance from the equator along a meridian, positive to the north.

    Series in the third flattening to its fourth power, as in J. P. Snyder, "Map Projections: A Working Manual", USGS
    Professional Paper 1395 (1987), eq 3-21, written in n (F. R. Helmert, 1880): below 1e-4 m.
    """
    phi, n = np.radians(latitude_deg), FLATTENING / (2.0 - FLATTENING)
    whole = (1.0 + n**2 / 4.0 + n**4 / 64.0) * phi
    second = -1.5 * (n - n**3 / 8.0) * np.sin(2.0 * phi)
    fourth = 15.0 / 16.0 * (n**2 - n**4 / 4.0) * np.sin(4.0 * phi)
    sixth = -35.0 / 48.0 * n**3 * np.sin(6.0 * phi)
    eighth = 315.0 / 512.0 * n**4 * np.sin(8.0 * phi)
    return float(SEMI_MAJOR_AXIS_M / (1.0 + n) * (whole + second + fourth + sixth + eighth))


_CLOSE_RAD = 1e-13
"""Convergence limit: less than a micrometre."""

_GEODESIC_ITERATIONS = 16
"""Maximum; each reduces the error to a few thousandths, down to rounding."""


def direct(latitude_deg: float, distance_m: Array, bearing_rad: Array) -> tuple[Array, Array, Array]:
    """Solve the direct problem: where geodesics of given length and bearing end.

    Parameters
    ----------
    latitude_deg : float
        Of the start.
    distance_m, bearing_rad : ndarray (...)
        Length and direction at the start, clockwise from north. From a pole, north is toward the longitude opposite to
        that of the start.

    Returns
    -------
    latitude_deg, longitude_deg, bearing_rad : ndarray (...)
        Of the end; longitude relative to the start, -180 to 180, and the forward bearing of the geodesic there.
    """
    phi = np.radians(latitude_deg)
    start = np.arctan2((1.0 - FLATTENING) * np.sin(phi), np.cos(phi))
    sin_u, cos_u = np.sin(start), np.cos(start)
    sin_a, cos_a = np.sin(bearing_rad), np.cos(bearing_rad)
    sine = cos_u * sin_a
    cos_square = 1.0 - sine**2
    first = np.arctan2(sin_u, cos_u * cos_a)
    u_square = cos_square * (SEMI_MAJOR_AXIS_M**2 / SEMI_MINOR_AXIS_M**2 - 1.0)
    root = np.sqrt(1.0 + u_square)
    k = (root - 1.0) / (root + 1.0)
    scale, b = (1.0 + 0.25 * k**2) / (1.0 - k), k * (1.0 - 0.375 * k**2)
    straight = distance_m / (SEMI_MINOR_AXIS_M * scale)
    sigma = straight
    moves = np.ones(np.shape(straight), dtype=np.bool_)
    for _ in range(_GEODESIC_ITERATIONS):
        sin_s, cos_s = np.sin(sigma), np.cos(sigma)
        twice = np.cos(2.0 * first + sigma)
        inner = cos_s * (2.0 * twice**2 - 1.0) - b / 6.0 * twice * (4.0 * sin_s**2 - 3.0) * (4.0 * twice**2 - 3.0)
        before = sigma
        # Every point converges separately, so its result does not depend on the others.
        sigma = np.where(moves, straight + b * sin_s * (twice + 0.25 * b * inner), sigma)
        moves = moves & (np.abs(sigma - before) > _CLOSE_RAD)
        if not np.any(moves):
            break
    sin_s, cos_s = np.sin(sigma), np.cos(sigma)
    twice = np.cos(2.0 * first + sigma)
    toward_axis = sin_u * sin_s - cos_u * cos_s * cos_a
    latitude = np.arctan2(sin_u * cos_s + cos_u * sin_s * cos_a, (1.0 - FLATTENING) * np.hypot(sine, toward_axis))
    on_sphere = np.arctan2(sin_s * sin_a, cos_u * cos_s - sin_u * sin_s * cos_a)
    c = FLATTENING / 16.0 * cos_square * (4.0 + FLATTENING * (4.0 - 3.0 * cos_square))
    turned = sigma + c * sin_s * (twice + c * cos_s * (2.0 * twice**2 - 1.0))
    longitude = np.degrees(on_sphere - (1.0 - c) * FLATTENING * sine * turned)
    # Longitude differences beyond 180 degrees.
    longitude = np.where(np.abs(longitude) > 180.0, (longitude + 180.0) % 360.0 - 180.0, longitude)
    return np.degrees(latitude), longitude, np.arctan2(sine, -toward_axis)


MEAN_EARTH_RADIUS_M = 6371008.7714
"""Mean radius of the WGS 84 ellipsoid (2 a + b) / 3; H. Moritz, Geodetic Reference System 1980."""


def to_geographic(x_m: Array, y_m: Array, latitude: float, longitude: float) -> tuple[Array, Array]:
    """Return latitude and longitude in degrees of points of the plane centred on a place.

    Parameters
    ----------
    x_m, y_m : ndarray (...)
        Distances east and north of the centre.
    latitude, longitude : float
        Centre, degrees.

    Returns
    -------
    latitude, longitude : ndarray (...)
        Geodetic, degrees; longitudes are within 180 of the centre's, and so may exceed 180.
    """
    north, east, _ = _ends(x_m, y_m, latitude)
    return north, longitude + east


def _ends(x_m: Array, y_m: Array, latitude: float) -> tuple[Array, Array, Array]:
    return direct(latitude, np.hypot(x_m, y_m), np.arctan2(x_m, y_m))


_PLACED_M = 1e-4
"""Convergence limit of :meth:`Ellipsoid.to_plane`."""

_PLANE_ITERATIONS = 60


class Ellipsoid:
    """Positions on the WGS 84 ellipsoid, in space and in the image plane."""

    @staticmethod
    def to_earth_centred(latitude_deg: Array, longitude_deg: Array, altitude_m: float = 0.0) -> Array:
        """Return Earth-centred positions (..., 3) in m; axes toward 0 N 0 E, 0 N 90 E and the north pole.

        Parameters
        ----------
        latitude_deg, longitude_deg : ndarray (...)
            Geodetic.
        altitude_m : float
            Above the ellipsoid, along its normal.
        """
        phi, lam = np.radians(latitude_deg), np.radians(longitude_deg)
        sine, cosine = np.sin(phi), np.cos(phi)
        normal = SEMI_MAJOR_AXIS_M / np.sqrt(1.0 - ECCENTRICITY_SQUARED * sine**2)
        across = (normal + altitude_m) * cosine
        up = (normal * (1.0 - ECCENTRICITY_SQUARED) + altitude_m) * sine
        return np.stack((across * np.cos(lam), across * np.sin(lam), up), axis=-1)

    @staticmethod
    def east_north_up(latitude_deg: Array, longitude_deg: Array) -> tuple[Array, Array, Array]:
        """Return the unit vectors (..., 3) toward east, toward north and along the normal of the ellipsoid."""
        phi, lam = np.radians(latitude_deg), np.radians(longitude_deg)
        sine, cosine, zero = np.sin(phi), np.cos(phi), np.zeros_like(phi)
        east = np.stack((-np.sin(lam), np.cos(lam), zero), axis=-1)
        north = np.stack((-sine * np.cos(lam), -sine * np.sin(lam), cosine), axis=-1)
        up = np.stack((cosine * np.cos(lam), cosine * np.sin(lam), sine), axis=-1)
        return east, north, up

    @staticmethod
    def to_geographic_with_turn(
        x_m: Array, y_m: Array, latitude: float, longitude: float
    ) -> tuple[Array, Array, Array]:
        """Return latitude, longitude, and the bearing of the plane's y axis there, degrees clockwise from north.

        The plane's axes are carried along the geodesic from the centre and keep their angle to it.
        """
        north, east, arriving = _ends(x_m, y_m, latitude)
        turn = np.degrees(arriving - np.arctan2(x_m, y_m))
        return north, longitude + east, (turn + 180.0) % 360.0 - 180.0

    @staticmethod
    def to_plane(latitude_deg: Array, longitude_deg: Array, latitude: float, longitude: float) -> tuple[Array, Array]:
        """Return x and y in m of places in the plane centred on a place: the inverse of :func:`to_geographic`.

        Each iteration moves by the remaining vector on the tangent plane; its error falls by the square of the distance
        from the centre over six times that of the Earth's radius.

        Parameters
        ----------
        latitude_deg, longitude_deg : ndarray (...)
            Geodetic, less than 60 degrees from the centre.
        latitude, longitude : float
            Centre, degrees.

        Raises
        ------
        ValueError
            If a place is farther away.
        """
        target = Ellipsoid.to_earth_centred(latitude_deg, longitude_deg)
        x, y = np.zeros(target.shape[:-1]), np.zeros(target.shape[:-1])
        if np.any(
            target @ Ellipsoid.to_earth_centred(np.array(latitude), np.array(longitude)) < 0.5 * SEMI_MINOR_AXIS_M**2
        ):
            raise ValueError("a place 60 degrees or more from the image centre; allowed: nearer ones")
        for _ in range(_PLANE_ITERATIONS):
            north, east, turn = Ellipsoid.to_geographic_with_turn(x, y, latitude, longitude)
            rest = target - Ellipsoid.to_earth_centred(north, east)
            toward_east, toward_north, _up = Ellipsoid.east_north_up(north, east)
            right, ahead = np.sum(rest * toward_east, axis=-1), np.sum(rest * toward_north, axis=-1)
            sine, cosine = np.sin(np.radians(turn)), np.cos(np.radians(turn))
            x, y = x + right * cosine - ahead * sine, y + right * sine + ahead * cosine
            if np.all(np.hypot(right, ahead) < _PLACED_M):
                break
        return x, y
