"""Sun-synchronous orbits: circular ones whose plane turns with the mean sun."""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np

from hcss_payload.checks import PayloadError, require_utc
from hcss_payload.earth import EARTH_M3_S2, OBLATENESS, SEMI_MAJOR_AXIS_M
from hcss_payload.trajectory import Circular

TROPICAL_YEAR_S = 365.2421897 * 86400.0
"""Explanatory Supplement to the Astronomical Almanac (2013), section 3.2."""

HIGHEST_M = 5_900e3
"""Above 5974 km the oblate Earth turns no plane fast enough."""

AGREEMENT_H = 0.05
"""Difference of local times that state the same, hours."""


def inclination_deg(altitude_m: float) -> float:
    """Return the inclination with which the node of a circular orbit turns by 360 degrees in a year.

    cos i = -(2 pi / year) / (1.5 J2 (R / a)^2 sqrt(mu / a^3)).

    References
    ----------
    D. A. Vallado, "Fundamentals of Astrodynamics and Applications" (2013), section 11.4.1.

    Raises
    ------
    PayloadError
        If there is none at this altitude.
    """
    if not 1e5 <= altitude_m <= HIGHEST_M:
        raise PayloadError(
            f"trajectory.altitude: {1e-3 * altitude_m:g} km; allowed for sun-synchronous orbits: 100 to "
            f"{1e-3 * HIGHEST_M:g} km"
        )
    axis = SEMI_MAJOR_AXIS_M + altitude_m
    node_rate = 1.5 * OBLATENESS * (SEMI_MAJOR_AXIS_M / axis) ** 2 * np.sqrt(EARTH_M3_S2 / axis**3)
    return float(np.degrees(np.arccos(-2.0 * np.pi / TROPICAL_YEAR_S / node_rate)))


def sun_synchronous(
    altitude_m: float, start: datetime, local_time_h: float, argument_deg: float = 0.0, ascending: bool = True
) -> Circular:
    """Return the orbit with a local mean solar time of its node.

    Parameters
    ----------
    start : datetime
        Time 0, in UTC.
    local_time_h : float
        Hours from local midnight at the node.
    argument_deg : float
        Angle from the ascending node along the orbit at time 0.
    ascending : bool
        Whether the local time is that of the ascending node; otherwise of the descending one.
    """
    require_utc("trajectory.start", start)
    ascending_h = local_time_h if ascending else local_time_h + 12.0
    node_deg = 15.0 * (ascending_h - _hours(start)) % 360.0
    return Circular(altitude_m, inclination_deg(altitude_m), node_deg, argument_deg % 360.0, precesses=True)


def sun_synchronous_above(
    altitude_m: float,
    start: datetime,
    above_deg: tuple[float, float],
    time_s: float = 0.0,
    rising: bool = True,
    node: tuple[float, bool] | None = None,
) -> Circular:
    """Return the orbit that passes above a place at a time, whose local time at the node follows.

    Parameters
    ----------
    above_deg : (float, float)
        Latitude and longitude.
    time_s : float
        When it does so, after the start.
    rising : bool
        Whether northward.
    node : (float, bool), optional
        Local time of the node in hours, and whether that is the ascending one, which must agree.

    Raises
    ------
    PayloadError
        If the local time of the node is another; names the time of the pass that has it.
    """
    inclination = inclination_deg(altitude_m)
    orbit = Circular.above(altitude_m, inclination, *above_deg, time_s, rising, precesses=True)
    if node is None:
        return orbit
    wanted_h, ascending = node
    found_h = node_hours(orbit, start) + (0.0 if ascending else 12.0)
    early_h = (found_h - wanted_h + 12.0) % 24.0 - 12.0
    if abs(early_h) > AGREEMENT_H:
        fitting = start + timedelta(seconds=round(time_s - 3600.0 * early_h))
        raise PayloadError(
            f"trajectory.local_time: {shown_hours(wanted_h)}, and the pass above {above_deg[0]:g} N {above_deg[1]:g} E "
            f"has {shown_hours(found_h)} at its node; allowed: one of them; a pass with this local time is above the "
            f"place at about {fitting.isoformat(timespec='minutes')}, southward and northward passes apart"
        )
    return orbit


def node_hours(orbit: Circular, start: datetime) -> float:
    """Return the local mean solar time of the ascending node at time 0, hours."""
    return (_hours(start) + orbit.node_longitude_deg / 15.0) % 24.0


def shown_hours(hours: float) -> str:
    """Return a time of day as HH:MM."""
    minutes = round(60.0 * hours) % 1440
    return f"{minutes // 60:02d}:{minutes % 60:02d}"


def _hours(time: datetime) -> float:
    """UTC of the day in hours; UT1 differs by less than a second."""
    return time.hour + (time.minute + (time.second + 1e-6 * time.microsecond) / 60.0) / 60.0
