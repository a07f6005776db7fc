"""The staggered grid (Arakawa C): scalars in cells, each velocity component on the faces that it crosses.

Fields have the axes (x, y, z), z innermost. ``u[i, j, k]`` is on the lower x face of cell (i, j, k), ``v`` on the lower
y face; ``w[i, j, k]`` is on the lower z face and has one more level, so that ``w[..., 0]`` is the sea and ``w[...,
-1]`` the lid. x and y are periodic.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hcss_twin.providers import Array


@dataclass(frozen=True)
class Mesh:
    """Cells of a box.

    Attributes
    ----------
    columns : tuple of int
        Cells along x and y.
    side_m : float
        Horizontal side of a cell.
    faces_m : ndarray
        Heights (nz + 1,) of the faces between levels above the floor, from 0 to the lid.
    floor_m : float
        Altitude of the floor: 0 is the sea, more a level surface in the air below a high layer.
    """

    columns: tuple[int, int]
    side_m: float
    faces_m: Array
    floor_m: float = 0.0

    @cached_property
    def centres_m(self) -> Array:
        """Heights (nz,) of cell centres."""
        return 0.5 * (self.faces_m[1:] + self.faces_m[:-1])

    @cached_property
    def depth_m(self) -> Array:
        """Depths (nz,) of cells."""
        return np.diff(self.faces_m)

    @cached_property
    def distance_m(self) -> Array:
        """Distances (nz + 1,) of the centres beside each face; at sea and lid of the centre's mirror image."""
        inner = np.diff(self.centres_m)
        return np.concatenate([self.depth_m[:1], inner, self.depth_m[-1:]])

    @property
    def levels(self) -> int:
        """Number of levels."""
        return len(self.faces_m) - 1

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of a field of scalars."""
        return (*self.columns, self.levels)


def stretched_faces(top_m: float, spacing_m: float | list[tuple[float, float]]) -> Array:
    """Return heights (nz + 1,) of faces whose distances follow a piecewise linear function of height.

    Parameters
    ----------
    top_m : float
        Height of the lid, which the last face meets: all distances change by the same small factor.
    spacing_m : float or list of (float, float)
        Distance of faces; or heights and the distance there, constant beyond the first and the last.
    """
    heights, spacings = np.array(spacing_m if isinstance(spacing_m, list) else [(0.0, spacing_m)], float).T
    if np.all(spacings == spacings[0]):
        return np.linspace(0.0, top_m, max(1, round(top_m / spacings[0])) + 1)
    # the number of cells is the integral of 1 / spacing; faces are at its whole values
    fine = np.linspace(0.0, top_m, max(2, math.ceil(50.0 * top_m / spacings.min())) + 1)
    density = 1.0 / np.interp(0.5 * (fine[1:] + fine[:-1]), heights, spacings)
    count = np.concatenate([[0.0], np.cumsum(density * np.diff(fine))])
    cells = max(1, round(float(count[-1])))
    faces = np.interp(np.linspace(0.0, count[-1], cells + 1), count, fine)
    faces[0], faces[-1] = 0.0, top_m
    return faces
