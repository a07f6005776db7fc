"""The sun over the frames of a scene."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from hcss_twin.physics.local_plane import to_geographic
from hcss_twin.physics.sun import sun_position
from hcss_twin.providers import Sun

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SunTrack:
    """Where the sun is, seen from the image centre, at any time of the scene.

    The centre moves east with the platform along the local plane, as the cube's coordinates say.
    """

    start: datetime
    latitude_deg: float
    longitude_deg: float
    platform_speed_m_s: float = 0.0

    def at(self, time_s: float, aside_m: tuple[float, float] = (0.0, 0.0)) -> Sun:
        """Sun at seconds after the start, seen from a point east and north of the centre."""
        return _sun(self, time_s, aside_m)

    def positions(
        self, time_s: Array, aside_m: tuple[float, float] = (0.0, 0.0)
    ) -> tuple[Array, Array, Array]:
        """Zenith (deg), azimuth (deg) and distance (au), each (F,), at seconds after the start."""
        instants = [self.start + timedelta(seconds=float(second)) for second in time_s]
        east = self.platform_speed_m_s * time_s + aside_m[0]
        place = to_geographic(east, np.full_like(east, aside_m[1]), self.latitude_deg, self.longitude_deg)
        return sun_position(instants, *place)


@lru_cache(maxsize=1024)
def _sun(track: SunTrack, time_s: float, aside_m: tuple[float, float]) -> Sun:
    """Sun at a time; plan, tables and certificate ask for the same few again and again, a millisecond or two each."""
    zenith, azimuth, distance = track.positions(np.array([time_s]), aside_m)
    return Sun(float(zenith[0]), float(azimuth[0]), float(distance[0]))
