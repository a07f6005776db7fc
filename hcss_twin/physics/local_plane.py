"""The image plane on the globe.

x points east and y north on the plane of the azimuthal equidistant projection of a sphere about the
image centre at the start (J. P. Snyder, "Map Projections: A Working Manual", USGS Professional Paper
1395, 1987, eqs 20-14, 20-15 and 25-15 with c = rho / R).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

MEAN_EARTH_RADIUS_M = 6371008.7714
"""Mean radius of the WGS 84 ellipsoid (2 a + b) / 3; H. Moritz, Geodetic Reference System 1980."""


def to_geographic(
    x_m: NDArray[np.float64], y_m: NDArray[np.float64], latitude: float, longitude: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return latitude and longitude in degrees of points of the plane centred on a place.

    Parameters
    ----------
    x_m, y_m : ndarray (N,)
        Distances east and north of the centre.
    latitude, longitude : float
        Centre, degrees.
    """
    rho = np.hypot(x_m, y_m)
    angle = rho / MEAN_EARTH_RADIUS_M
    # sin(c) / rho -> 1 / R at the centre, where the direction is undefined
    scale = np.sinc(angle / np.pi) / MEAN_EARTH_RADIUS_M
    phi = np.deg2rad(latitude)
    sine = np.cos(angle) * np.sin(phi) + y_m * scale * np.cos(phi)
    north = np.rad2deg(np.arcsin(np.clip(sine, -1.0, 1.0)))
    across = np.cos(phi) * np.cos(angle) - y_m * scale * np.sin(phi)
    return north, longitude + np.rad2deg(np.arctan2(x_m * scale, across))
