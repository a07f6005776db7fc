"""Lines of sight of a scene with a sensor altitude, and the sun over its frames."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import lru_cache

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.physics.geodesy import to_geographic
from hcss_twin.physics.sun import sun_position
from hcss_twin.physics.viewing import LinesOfSight
from hcss_twin.providers import Sun
from hcss_twin.scenario.scenario import Scenario

LARGEST_ZENITH_DEG = 88.0
"""Maximum view zenith of a pixel; the image centre has a separate limit."""


def lines_of_sight(scenario: Scenario) -> LinesOfSight | None:
    """Return the lines of sight; None if the scenario has no sensor altitude.

    Raises
    ------
    ScenarioError
        If a corner of the image is not visible.
    """
    altitude, place, view, image = (scenario.platform.altitude, scenario.place, scenario.view, scenario.image)
    if altitude is None:
        return None
    lines = LinesOfSight(place.latitude, place.longitude, view.zenith, view.azimuth, altitude)
    x, y = (0.5 * count * image.pixel_size for count in (image.columns, image.rows))
    corners = lines.from_points(np.array([x, x, -x, -x]), np.array([y, -y, y, -y]))
    farthest = float(np.max(corners.zenith_deg))
    if farthest > LARGEST_ZENITH_DEG:
        message = (
            f"a corner of {image.columns} x {image.rows} pixels of {image.pixel_size:g} m sees the sensor at zenith "
            f"{farthest:.1f} deg from {altitude / 1e3:g} km; allowed: up to {LARGEST_ZENITH_DEG:g} deg, with a smaller "
            "image, a smaller view.zenith or a higher platform"
        )
        raise ScenarioError([Problem("platform.altitude", message)])
    return lines


def detector_notes(scenario: Scenario) -> tuple[str, ...]:
    """Return a note that compares the pixels of a slant view with detector footprints."""
    zenith, size = scenario.view.zenith, scenario.image.pixel_size
    if scenario.platform.detector_pitch is None or zenith == 0.0:
        return ()
    return (
        f"pixels are squares of {size:.4g} m; along the line of sight the footprint of a detector is "
        f"{size / math.cos(math.radians(zenith)):.4g} m long, which the image is not sampled by",
    )


@dataclass(frozen=True)
class SunTrack:
    """Position of the sun, seen from the image centre, at any time of the scene.

    The centre moves east with the platform along the local plane, as in the coordinates of the cube. ``is_timed``: suns
    know their time, from which views know the place that they see.
    """

    start: datetime
    latitude_deg: float
    longitude_deg: float
    platform_speed_m_s: float = 0.0
    is_timed: bool = False

    def at(self, time_s: float, aside_m: tuple[float, float] = (0.0, 0.0)) -> Sun:
        """Sun at seconds after the start, seen from a point east and north of the centre."""
        return _sun(self, time_s, aside_m)

    def positions(
        self, time_s: Array, aside_m: tuple[float, float] | tuple[Array, Array] = (0.0, 0.0)
    ) -> tuple[Array, Array, Array]:
        """Zenith (deg), azimuth (deg) and distance (au), each (F,), at seconds after the start, seen from points."""
        instants = [self.start + timedelta(seconds=float(second)) for second in time_s]
        east = self.platform_speed_m_s * time_s + aside_m[0]
        position_deg = to_geographic(east, np.full_like(east, aside_m[1]), self.latitude_deg, self.longitude_deg)
        return sun_position(instants, *position_deg)


@lru_cache(maxsize=1024)
def _sun(track: SunTrack, time_s: float, aside_m: tuple[float, float]) -> Sun:
    """Sun at a time, cached: plan, tables and certificate use the same few, and each takes a millisecond or two."""
    zenith, azimuth, distance = track.positions(np.array([time_s]), aside_m)
    return Sun(float(zenith[0]), float(azimuth[0]), float(distance[0]), time_s if track.is_timed else None)
