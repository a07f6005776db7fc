"""The pressure that keeps the wind free of divergence: div(rho U) = 0 (Ogura and Phillips 1962, JAS 19, 173).

Fourier transforms along x and y leave one tridiagonal system along z for each pair of wavenumbers, of the operator that
is exactly the discrete divergence of the discrete gradient. Always in double precision.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import fft

from hcss_skies.les.advection import FAST
from hcss_skies.les.grid import Mesh
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array


class PressureSolver:
    """Makes velocities free of divergence.

    Parameters
    ----------
    mesh : Mesh
        Cells.
    density : ndarray
        rho (nz + 1,) on faces.
    density_of_cells : ndarray
        rho (nz,).
    """

    def __init__(self, mesh: Mesh, density: Array, density_of_cells: Array) -> None:
        self._mesh = mesh
        nx, ny = mesh.columns
        dz = mesh.depth_m
        self._density, self._mass = density, density_of_cells * dz
        self._per_distance = 1.0 / mesh.distance_m
        eigenvalue = [(2.0 - 2.0 * np.cos(2.0 * np.pi * np.arange(n) / size)) / mesh.side_m**2
                      for n, size in ((nx, nx), (ny // 2 + 1, ny))]  # fmt: skip
        waves = (eigenvalue[0][:, None] + eigenvalue[1][None, :]).reshape(-1, 1)
        link = density[1:-1] * self._per_distance[1:-1]
        lower, upper = np.concatenate([[0.0], link]), np.concatenate([link, [0.0]])
        diagonal = -waves * self._mass - lower - upper
        # the mean has a free constant: its pressure in the lowest cell is 0
        diagonal[0, 0] *= 2.0
        self._lower = lower
        # forward sweep of the Thomas algorithm, the same for every right-hand side
        self._pivot, self._ratio = np.empty_like(diagonal), np.empty_like(diagonal)
        self._pivot[:, 0] = 1.0 / diagonal[:, 0]
        self._ratio[:, 0] = upper[0] * self._pivot[:, 0]
        for k in range(1, mesh.levels):
            self._pivot[:, k] = 1.0 / (diagonal[:, k] - lower[k] * self._ratio[:, k - 1])
            self._ratio[:, k] = upper[k] * self._pivot[:, k]

    def divergence(self, u: Any, v: Any, w: Any) -> Array:
        """Return div(rho U) dz (nx, ny, nz), kg m-2 s-1."""
        out = np.empty(self._mesh.shape)
        _divergence(u, v, w, self._density, self._mass, 1.0 / self._mesh.side_m, out)
        return out

    def project(self, u: Any, v: Any, w: Any) -> None:
        """Subtract the gradient that makes a wind free of divergence from it."""
        nx, ny, nz = self._mesh.shape
        spectrum = fft.rfft2(self.divergence(u, v, w), axes=(0, 1), overwrite_x=True)
        _solve(spectrum.reshape(-1, nz), self._lower, self._pivot, self._ratio)
        potential = fft.irfft2(spectrum, (nx, ny), axes=(0, 1), overwrite_x=True)
        _subtract_gradient(potential, u, v, w, 1.0 / self._mesh.side_m, self._per_distance)


@kernel(fastmath=FAST)
def _divergence(u: Any, v: Any, w: Any, density: Any, mass: Any, per_side: float, out: Any) -> None:
    nx, ny, nz = out.shape
    for i in range(nx):
        right = (i + 1) % nx
        for j in range(ny):
            above = (j + 1) % ny
            for k in range(nz):
                sideways = np.float64(u[right, j, k]) - u[i, j, k] + v[i, above, k] - v[i, j, k]
                out[i, j, k] = mass[k] * per_side * sideways + density[k + 1] * w[i, j, k + 1] - density[k] * w[i, j, k]


@kernel(fastmath=FAST)
def _solve(x: Any, lower: Any, pivot: Any, ratio: Any) -> None:
    modes, nz = x.shape
    for m in range(modes):
        x[m, 0] *= pivot[m, 0]
        for k in range(1, nz):
            x[m, k] = (x[m, k] - lower[k] * x[m, k - 1]) * pivot[m, k]
        for k in range(nz - 2, -1, -1):
            x[m, k] -= ratio[m, k] * x[m, k + 1]


@kernel(fastmath=FAST)
def _subtract_gradient(potential: Any, u: Any, v: Any, w: Any, per_side: float, per_distance: Any) -> None:
    nx, ny, nz = potential.shape
    for i in range(nx):
        left = (i - 1) % nx
        for j in range(ny):
            below = (j - 1) % ny
            for k in range(nz):
                here = potential[i, j, k]
                u[i, j, k] -= per_side * (here - potential[left, j, k])
                v[i, j, k] -= per_side * (here - potential[i, below, k])
            for k in range(1, nz):
                w[i, j, k] -= per_distance[k] * (potential[i, j, k] - potential[i, j, k - 1])
