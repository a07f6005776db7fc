"""The image plane on the globe.

x points east and y north on the plane of the azimuthal equidistant projection of the ellipsoid WGS 84 about the
image centre at the start: every point of it lies at its distance and bearing from the centre along a geodesic
(J. P. Snyder, "Map Projections: A Working Manual", USGS Professional Paper 1395, 1987, pp 197-202).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.physics.geodesic import direct

Array = NDArray[np.float64]

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
        Geodetic, degrees; longitudes lie within half a turn of the centre's and so run on beyond 180.
    """
    north, east, _ = _ends(x_m, y_m, latitude)
    return north, longitude + east


def to_geographic_with_turn(
    x_m: Array, y_m: Array, latitude: float, longitude: float
) -> tuple[Array, Array, Array]:
    """Return the same, and by how many degrees clockwise the plane's y axis points from north at each point.

    The plane's axes are carried along the geodesic from the centre, on which its direction stays as it is.
    """
    north, east, arriving = _ends(x_m, y_m, latitude)
    turn = np.degrees(arriving - np.arctan2(x_m, y_m))
    return north, longitude + east, (turn + 180.0) % 360.0 - 180.0


def _ends(x_m: Array, y_m: Array, latitude: float) -> tuple[Array, Array, Array]:
    return direct(latitude, np.hypot(x_m, y_m), np.arctan2(x_m, y_m))
