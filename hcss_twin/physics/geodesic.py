"""Geodesics of the ellipsoid WGS 84 from one point: where they lead, and in which direction they arrive.

T. Vincenty, "Direct and inverse solutions of geodesics on the ellipsoid with application of nested equations", Survey
Review 23 (176), 88-93 (1975), with the constants A and B in Helmert's expansion parameter k1; better than 1 mm over
any distance. The direct problem converges everywhere, poles included.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.physics.ellipsoid import FLATTENING, SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M

Array = NDArray[np.float64]

_CLOSE_RAD = 1e-13
"""Under a micrometre."""

_MOST_ROUNDS = 16
"""Each leaves a few thousandths of the error; over many turns of the globe rounding ends them first."""


def direct(latitude_deg: float, distance_m: Array, bearing_rad: Array) -> tuple[Array, Array, Array]:
    """Return where geodesics lead.

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
        Of the end; longitude relative to the start, -180 to 180, and the direction in which the geodesic goes on there.
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
    for _ in range(_MOST_ROUNDS):
        sin_s, cos_s = np.sin(sigma), np.cos(sigma)
        twice = np.cos(2.0 * first + sigma)
        inner = cos_s * (2.0 * twice**2 - 1.0) - b / 6.0 * twice * (4.0 * sin_s**2 - 3.0) * (
            4.0 * twice**2 - 3.0
        )
        before = sigma
        # Each stops by itself: what is found of a point does not depend on those beside it.
        sigma = np.where(moves, straight + b * sin_s * (twice + 0.25 * b * inner), sigma)
        moves = moves & (np.abs(sigma - before) > _CLOSE_RAD)
        if not np.any(moves):
            break
    sin_s, cos_s = np.sin(sigma), np.cos(sigma)
    twice = np.cos(2.0 * first + sigma)
    toward_axis = sin_u * sin_s - cos_u * cos_s * cos_a
    latitude = np.arctan2(
        sin_u * cos_s + cos_u * sin_s * cos_a, (1.0 - FLATTENING) * np.hypot(sine, toward_axis)
    )
    on_sphere = np.arctan2(sin_s * sin_a, cos_u * cos_s - sin_u * sin_s * cos_a)
    c = FLATTENING / 16.0 * cos_square * (4.0 + FLATTENING * (4.0 - 3.0 * cos_square))
    turned = sigma + c * sin_s * (twice + c * cos_s * (2.0 * twice**2 - 1.0))
    longitude = np.degrees(on_sphere - (1.0 - c) * FLATTENING * sine * turned)
    # Beyond half a turn of the globe.
    longitude = np.where(np.abs(longitude) > 180.0, (longitude + 180.0) % 360.0 - 180.0, longitude)
    return np.degrees(latitude), longitude, np.arctan2(sine, -toward_axis)
