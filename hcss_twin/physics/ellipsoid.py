"""The ellipsoid WGS 84: positions in space, altitudes, and distances along a meridian.

NIMA TR8350.2, "Department of Defense World Geodetic System 1984", 3rd edition (2000), table 3.1 and section 4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SEMI_MAJOR_AXIS_M = 6378137.0
INVERSE_FLATTENING = 298.257223563
FLATTENING = 1.0 / INVERSE_FLATTENING
SEMI_MINOR_AXIS_M = SEMI_MAJOR_AXIS_M * (1.0 - FLATTENING)
ECCENTRICITY_SQUARED = FLATTENING * (2.0 - FLATTENING)

_ROUNDS = 8
"""Of the altitude's iteration, each of which leaves less than a hundredth of the error."""


def to_earth_centred(latitude_deg: Array, longitude_deg: Array, altitude_m: float = 0.0) -> Array:
    """Return positions (..., 3) in m from the Earth's centre: toward 0 N 0 E, 0 N 90 E and the north pole.

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


def east_north_up(latitude_deg: Array, longitude_deg: Array) -> tuple[Array, Array, Array]:
    """Return the unit vectors (..., 3) toward east, toward north and along the normal of the ellipsoid."""
    phi, lam = np.radians(latitude_deg), np.radians(longitude_deg)
    sine, cosine, zero = np.sin(phi), np.cos(phi), np.zeros_like(phi)
    east = np.stack((-np.sin(lam), np.cos(lam), zero), axis=-1)
    north = np.stack((-sine * np.cos(lam), -sine * np.sin(lam), cosine), axis=-1)
    up = np.stack((cosine * np.cos(lam), cosine * np.sin(lam), sine), axis=-1)
    return east, north, up


def altitude_m(position_m: Array) -> float:
    """Return the altitude of a position (3,) above the ellipsoid, along its normal; the position lies outside.

    Fixed-point iteration of the geodetic latitude with the reduced one (B. R. Bowring, "Transformation from spatial to
    geographical coordinates", Survey Review 23 (181), 323-327, 1976).
    """
    across, up = float(np.hypot(position_m[0], position_m[1])), float(position_m[2])
    second = ECCENTRICITY_SQUARED / (1.0 - ECCENTRICITY_SQUARED)
    reduced = np.arctan2(up * SEMI_MAJOR_AXIS_M, across * SEMI_MINOR_AXIS_M)
    phi = reduced
    for _ in range(_ROUNDS):
        phi = np.arctan2(
            up + second * SEMI_MINOR_AXIS_M * np.sin(reduced) ** 3,
            across - ECCENTRICITY_SQUARED * SEMI_MAJOR_AXIS_M * np.cos(reduced) ** 3,
        )
        reduced = np.arctan2(SEMI_MINOR_AXIS_M * np.sin(phi), SEMI_MAJOR_AXIS_M * np.cos(phi))
    # Also at the poles, where dividing by a cosine would not do.
    along = across * np.cos(phi) + up * np.sin(phi)
    return float(along - SEMI_MAJOR_AXIS_M * np.sqrt(1.0 - ECCENTRICITY_SQUARED * np.sin(phi) ** 2))


def distance_from_equator_m(latitude_deg: float) -> float:
    """Return the distance along a meridian from the equator, north positive.

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
