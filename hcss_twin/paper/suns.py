"""Where the sun is in Tables V and VI."""

from __future__ import annotations

from datetime import datetime, timedelta, timezone

from hcss_twin.paper.published import published
from hcss_twin.physics.sun import sun_position
from hcss_twin.providers import Sun

LEAP_YEAR_MONTHS = 4
"""Table VI prints 2019 throughout; its angles of January to April are those of 2024."""


def suns_of_table_5() -> tuple[Sun, ...]:
    """Suns of scenarios 19 to 38: 20 April 2019, 12:30 in the zone of round(longitude / 15) hours."""
    return tuple(
        _sun(datetime(2019, 4, 20, 12, 30), round(longitude / 15), latitude, longitude)
        for _, latitude, longitude, *_ in published()["table_5"]["rows"]
    )


def suns_of_table_6() -> tuple[Sun, ...]:
    """Suns of scenarios 7 to 18: 12:30 at UTC+10 over 35 N, 150 E."""
    suns = []
    for _, date, *_ in published()["table_6"]["rows"]:
        _, month, day = (int(part) for part in date.split("."))
        suns.append(sun_at_baseline(2024 if month <= LEAP_YEAR_MONTHS else 2019, month, day))
    return tuple(suns)


def sun_at_baseline(year: int, month: int, day: int) -> Sun:
    """Return the sun of 12:30 at UTC+10 over the place of the baseline scene."""
    place = published()["baseline_geometry"]
    return _sun(datetime(year, month, day, 12, 30), 10, place["latitude"], place["longitude"])


def _sun(clock: datetime, hours: int, latitude_deg: float, longitude_deg: float) -> Sun:
    time = clock.replace(tzinfo=timezone(timedelta(hours=hours)))
    zenith, azimuth, distance = sun_position([time], latitude_deg, longitude_deg)
    return Sun(float(zenith[0]), float(azimuth[0]), float(distance[0]))
