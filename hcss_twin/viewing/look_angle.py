"""One line of sight to a round Earth: look angle at the sensor, zenith angle at the ground, and the way between.

The triangle of the Earth's centre, the ground point and the sensor; law of sines and law of cosines.
"""

from __future__ import annotations

import math

from hcss_twin.physics.local_plane import MEAN_EARTH_RADIUS_M


def view_zenith_deg(off_nadir_deg: float, altitude_m: float) -> float:
    """Return the zenith angle at the ground of a look angle at the sensor; infinite if it misses the Earth."""
    sine = (1.0 + altitude_m / MEAN_EARTH_RADIUS_M) * math.sin(math.radians(off_nadir_deg))
    return math.degrees(math.asin(sine)) if sine <= 1.0 else math.inf


def off_nadir_deg(view_zenith_deg: float, altitude_m: float) -> float:
    """Return the look angle at the sensor, between nadir and the line of sight, of a zenith angle at the ground."""
    sine = math.sin(math.radians(view_zenith_deg)) / (1.0 + altitude_m / MEAN_EARTH_RADIUS_M)
    return math.degrees(math.asin(sine))


def slant_range_m(view_zenith_deg: float, altitude_m: float) -> float:
    """Return the distance from the ground to the sensor."""
    zenith, radius = math.radians(view_zenith_deg), MEAN_EARTH_RADIUS_M
    down = radius * math.cos(zenith)
    # As a quotient, because the difference of the two would lose the digits of low altitudes.
    return (
        altitude_m
        * (2.0 * radius + altitude_m)
        / (math.sqrt(down**2 + altitude_m * (2.0 * radius + altitude_m)) + down)
    )
