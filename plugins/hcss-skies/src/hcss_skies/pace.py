"""How fast clouds move and change: what the generators of moving skies take from the motion of a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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


def turned(of_clouds: tuple[float, float], wind: tuple[float, float]) -> tuple[float, float]:
    """Return cosine and sine of the angle by which clouds are turned, so that their own wind blows along the scene's.

    Streets, and towers that lean with the shear, then point along the wind. Without one of the winds nothing turns.

    Parameters
    ----------
    of_clouds, wind : (float, float)
        Velocities along x and y of the clouds where they were simulated, and in the scene, m/s.
    """
    both = math.hypot(*of_clouds) * math.hypot(*wind)
    if both == 0.0:
        return 1.0, 0.0
    along = of_clouds[0] * wind[0] + of_clouds[1] * wind[1]
    across = of_clouds[0] * wind[1] - of_clouds[1] * wind[0]
    # a wind from the east has a northward component of 1e-16: then nothing turns at all
    return round(along / both, 12), round(across / both, 12)


@dataclass(frozen=True)
class TurnedPixels:
    """Where pixels are among cells: pixel (i, j) at row ``y[i] - x_turned[j]`` and column ``x[j] + y_turned[i]``.

    No products are left to a kernel, which might round them otherwise in another window.

    Attributes
    ----------
    y, y_turned : ndarray of float64 (Y,)
    x, x_turned : ndarray of float64 (X,)
    """

    y: Array
    y_turned: Array
    x: Array
    x_turned: Array

    @classmethod
    def of(cls, y_m: Array, x_m: Array, turn: tuple[float, float], cell_m: float) -> TurnedPixels:
        """Return the places of pixels at positions in the sky, whose cells are turned; whole numbers are middles."""
        y, x = y_m / cell_m, x_m / cell_m
        cosine, sine = turn
        return cls(cosine * y - 0.5, sine * y, cosine * x - 0.5, sine * x)

    @property
    def window(self) -> tuple[int, int, int, int]:
        """First row and column, and numbers of rows and columns, of the cells between whose middles the pixels are."""
        rows = np.subtract.outer(self.y[[0, -1]], self.x_turned[[0, -1]])
        columns = np.add.outer(self.y_turned[[0, -1]], self.x[[0, -1]])
        row, column = math.floor(rows.min()), math.floor(columns.min())
        return row, column, math.floor(rows.max()) + 2 - row, math.floor(columns.max()) + 2 - column

    def needed(self, row: int, column: int, rows: int, columns: int) -> NDArray[np.int64]:
        """Return the first and the last column but one (2, rows) that the pixels need of each row of the window.

        They are between those of the outline of the pixels, which is followed in steps of less than a cell.
        """
        way = np.linspace(0.0, 1.0, 2 * (rows + columns))
        y, y_turned, x, x_turned = (
            of[0] + way * (of[-1] - of[0]) for of in (self.y, self.y_turned, self.x, self.x_turned)
        )
        sides = [(y - x_turned[end], x[end] + y_turned) for end in (0, -1)]
        sides += [(y[end] - x_turned, x + y_turned[end]) for end in (0, -1)]
        at_y, at_x = (np.floor(np.concatenate(axis)).astype(np.int64) for axis in zip(*sides, strict=True))
        found = np.repeat(np.array([[columns], [0]]), rows, axis=1)
        for near in (0, 1):
            np.minimum.at(found[0], at_y - row + near, np.maximum(at_x - column - 1, 0))
            np.maximum.at(found[1], at_y - row + near, np.minimum(at_x - column + 3, columns))
        return found
