"""How fast clouds move and change: what the generators of moving skies take from the motion of a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcss_twin.providers import Array, Grid, Motion

MEASURED_S = 1800.0
"""``motion.evolution_time`` with which clouds change as fast as measured or simulated: the default of a scenario."""


@dataclass(frozen=True)
class Pace:
    """Motion and change of clouds.

    Attributes
    ----------
    speed_m_s : (float, float)
        Of the image over the sky along y and x.
    rate : float
        Time of the clouds per time of the scene; NaN: nothing changes.
    """

    speed_m_s: tuple[float, float]
    rate: float

    @classmethod
    def of(cls, motion: Motion) -> Pace:
        """Return the pace that a scene asks for."""
        wind_x, wind_y = motion.cloud_velocity_m_s
        evolves = math.isfinite(motion.evolution_time_s)
        rate = MEASURED_S / motion.evolution_time_s if evolves else math.nan
        return cls((-wind_y, motion.platform_speed_m_s - wind_x), rate)

    @property
    def evolves(self) -> bool:
        """Whether clouds change in other ways than by moving."""
        return math.isfinite(self.rate)

    @property
    def depends_on(self) -> frozenset[str]:
        """What the declaration of a generator says: time matters, or nothing does."""
        return frozenset({"time"}) if self.evolves or any(self.speed_m_s) else frozenset()

    def positions_m(self, grid: Grid, first: tuple[int, int], shape: tuple[int, ...], time_s: float) -> list[Array]:
        """Return the positions along y and x, in the moving sky, of the middles of pixels from ``first`` on.

        Parameters
        ----------
        grid : Grid
            Plane of the image, whose middle is the origin at time 0.
        first, shape : (int, int)
            First row and column, and how many.
        time_s : float
            Time.
        """
        return [
            grid.pixel_size_m
            * (
                np.arange(low, low + size, dtype=np.float64)
                + 0.5
                - 0.5 * total
                + grid.displacement_pixels(speed, time_s)
            )
            for low, size, total, speed in zip(first, shape, (grid.rows, grid.columns), self.speed_m_s, strict=True)
        ]
