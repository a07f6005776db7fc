"""An example blended without end: what the generator of its clouds and the places of simulated ones have in common."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcss_skies.blending import blend
from hcss_skies.example import Example
from hcss_skies.flow import OCTAVES, flow_nodes, long_waves
from hcss_skies.pyramid import make_level
from hcss_twin.providers import Array

PATCH_S = 12_000.0
"""Time in which a patch becomes another one."""

PATCH_SPEED_M_S = 1.35
"""Scale of the speeds of patches: by them alone, structures would live for 2 min per km of wavelength."""

NODES = 0.8
"""Distance of the nodes of waves longer than patches in those of the lattice."""


class BlendedExample:
    """An example blended on the lattice of a seed: its scores at any place and time.

    Each seed has its lattice elsewhere, so that no place is special.

    Parameters
    ----------
    example : Example
        What is blended.
    pixel_size_m : float
        Pixel size for which it is averaged.
    seed : int
        Of all random numbers.
    """

    def __init__(self, example: Example, pixel_size_m: float, seed: int) -> None:
        self.example, self._seed = example, seed
        self.level = level = make_level(example, pixel_size_m)
        rows = 0.5 * math.sqrt(3.0), 1.0  # distances of rows and of points in them
        shift = level.spacing * np.random.default_rng([seed, 0x5EA]).random(2) * rows
        drift = PATCH_SPEED_M_S * PATCH_S / example.pixel_size_m
        self._geometry = np.array(
            [level.spacing, *level.first, *level.span, level.scale, *shift, drift, level.of_excess]
        )

    def blend(
        self, time_s: float, out: NDArray[np.float32], y: Array, x: Array, tables: NDArray[np.float32], pixel: float
    ) -> None:
        """Write the values of tables (N, 2) that belong to the blended scores, (rows, columns, 1 or 2).

        Parameters
        ----------
        time_s : float
            Time at the pace of the clouds; NaN: nothing changes.
        out : ndarray of float32 (rows, columns, 1 or 2)
            The result.
        y, x : ndarray
            Positions in pixels of the example from the middle of the sky.
        tables : ndarray of float32 (N, 2)
            Values at scores from -4 to 4.
        pixel : float
            Distance of positions in pixels of the example: flows that are much smaller are left out.
        """
        level = self.level
        nodes, bounds = flow_nodes(OCTAVES, y, x, self.example.pixel_size_m, pixel, self._seed, time_s)
        waves, wave_bounds = long_waves(y, x, NODES * level.spacing, level.long, self._seed, time_s)
        blend(
            out, y, x, level.scores, tables, self._geometry, nodes, np.vstack([bounds, wave_bounds]), waves,
            np.uint64(key_of(self._seed, -2)), time_s / PATCH_S,
        )  # fmt: skip


def key_of(seed: int, number: int) -> int:
    """Return the key of the random numbers of one of the fields of a seed."""
    return (seed * 0x9E3779B97F4A7C15 + (number + 1) * 0xD1B54A32D192ED03) % 2**64
