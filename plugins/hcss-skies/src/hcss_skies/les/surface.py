"""Fluxes between sea and air: of heat, water and momentum into the lowest level.

Given fluxes are uniform, as published cases have them. Bulk fluxes follow C |U| (sea - air) with the wind, temperature
and water of the lowest level (van Zanten et al. 2011, JAMES 3, M06001, sect. 2, has such coefficients). The stress is
-u*^2 U / |U| with a given u*, or -C_d |U| U, with the local wind.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_skies.les.advection import FAST
from hcss_twin.core.kernels import kernel


@kernel(fastmath=FAST)
def add_stress(
    u: Any, v: Any, frame: Any, friction: float, drag: float, per_depth: float, u_rate: Any, v_rate: Any
) -> None:
    """Add the drag of the sea to the tendencies of the lowest level.

    Parameters
    ----------
    u, v : ndarray
        Velocities in the moving frame.
    frame : tuple of float
        Velocity of the frame, m/s.
    friction : float
        u*^2, m2 s-2; 0 with a drag coefficient.
    drag : float
        C_d; 0 with u*.
    per_depth : float
        rho on the sea / (rho dz) of the lowest level, m-1.
    u_rate, v_rate : ndarray
        Tendencies.
    """
    nx, ny, _ = u.shape
    for i in range(nx):
        left, right = (i - 1) % nx, (i + 1) % nx
        for j in range(ny):
            below, above = (j - 1) % ny, (j + 1) % ny
            east = frame[0] + u[i, j, 0]
            north = frame[1] + 0.25 * (v[i, j, 0] + v[left, j, 0] + v[i, above, 0] + v[left, above, 0])
            speed = max(np.sqrt(east * east + north * north), 0.1)
            u_rate[i, j, 0] -= per_depth * (friction / speed + drag * speed) * east
            north = frame[1] + v[i, j, 0]
            east = frame[0] + 0.25 * (u[i, j, 0] + u[right, j, 0] + u[i, below, 0] + u[right, below, 0])
            speed = max(np.sqrt(east * east + north * north), 0.1)
            v_rate[i, j, 0] -= per_depth * (friction / speed + drag * speed) * north


@kernel(fastmath=FAST)
def add_bulk_flux(
    q: Any, u: Any, v: Any, frame: Any, coefficient: float, at_sea: float, per_depth: float, tendency: Any
) -> float:
    """Add C |U| (sea - air) to the tendency of a scalar in the lowest level; return the mean flux.

    Parameters
    ----------
    q, u, v : ndarray
        Scalar, and velocities in the moving frame.
    frame, per_depth
        As in :func:`add_stress`.
    coefficient : float
        C.
    at_sea : float
        Value of the scalar at the sea, as the field has it.
    tendency : ndarray
        (nx, ny, nz).
    """
    nx, ny, _ = q.shape
    total = 0.0
    for i in range(nx):
        right = (i + 1) % nx
        for j in range(ny):
            above = (j + 1) % ny
            east = frame[0] + 0.5 * (u[i, j, 0] + u[right, j, 0])
            north = frame[1] + 0.5 * (v[i, j, 0] + v[i, above, 0])
            flux = coefficient * np.sqrt(east * east + north * north) * (at_sea - q[i, j, 0])
            tendency[i, j, 0] += per_depth * flux
            total += flux
    return float(total / (nx * ny))
