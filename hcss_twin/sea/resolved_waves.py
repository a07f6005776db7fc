"""The resolved waves of an image: their slopes at its pixels, as the platform moves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import Grid, Motion
from hcss_twin.sea.wave_field import WaveField
from hcss_twin.sea.wave_spectrum import WaveSpectrum

EAST_DEG, NORTH_DEG = 90.0, 0.0


class ResolvedWaves:
    """Slopes of the waves longer than two pixels.

    Parameters
    ----------
    spectrum : WaveSpectrum
        Of elevation.
    wind_from_deg : float
        Bearing the wind comes from.
    grid : Grid
        The image; x points east, y north.
    motion : Motion
        The image moves along x with the platform's speed; waves travel by themselves.
    seed : int
        Selects the realisation.
    """

    def __init__(
        self, spectrum: WaveSpectrum, wind_from_deg: float, grid: Grid, motion: Motion, seed: int
    ) -> None:
        self._field = WaveField(
            spectrum, wind_from_deg, grid.pixel_size_m, seed, x_bearing_deg=EAST_DEG, y_bearing_deg=NORTH_DEG
        )
        self._speed_m_s = motion.platform_speed_m_s

    def slopes(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return slopes (2, y, x) along x and along y at the pixel centres of a window.

        A pixel's value does not depend on the window.

        Parameters
        ----------
        time_s : float
            Seconds after the scenario's start.
        rows, columns : slice
            Window with a start and a stop.
        """
        x_m = self._speed_m_s * time_s
        return np.stack(self._field.slopes(time_s, rows, columns, x_m)).astype(np.float32)
