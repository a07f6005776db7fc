"""A circular orbit around a round Earth that stands still."""

from __future__ import annotations

import math

from hcss_twin.physics.local_plane import MEAN_EARTH_RADIUS_M

EARTH_M3_S2 = 3.986004418e14
"""Gravitational constant times mass of the Earth; G. Petit and B. Luzum, IERS Conventions (2010), table 1.1."""


def ground_speed_m_s(altitude_m: float) -> float:
    """Return the speed of the point below a satellite over the ground.

    sqrt(mu / r) R / r with r = R + altitude (Kepler's third law). The Earth's own rotation, up to 465 m/s at the
    equator, is left out.
    """
    radius = MEAN_EARTH_RADIUS_M + altitude_m
    return math.sqrt(EARTH_M3_S2 / radius) * MEAN_EARTH_RADIUS_M / radius
