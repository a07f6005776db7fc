"""What the air around the box does to it: subsidence, given tendencies, the earth's rotation; the sponge at the lid.

d q/dt = S(z) - w_s dq/dz - a (q - mean q), du/dt = f (v - v_g), dv/dt = -f (u - u_g), dw/dt = -a w. Subsidence w_s is
upwind and acts on the field itself: on its mean alone, it would not compress the inversion where it is bent. The sponge
(rate a) absorbs waves below the lid (Klemp and Lilly 1978, JAS 35, 78) and keeps the means.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_skies.les.advection import FAST
from hcss_skies.les.grid import Mesh
from hcss_twin.core.kernels import kernel
from hcss_twin.providers import Array


def sponge_rate(heights_m: Array, bottom_m: float, top_m: float, rate_s: float) -> Array:
    """Return the rate (s-1) of the sponge at heights: sin^2 from 0 at its bottom to the greatest at the lid."""
    return rate_s * np.sin(0.5 * np.pi * np.clip((heights_m - bottom_m) / (top_m - bottom_m), 0.0, 1.0)) ** 2


def subsidence_weights(mesh: Mesh, speed_m_s: Array) -> Array:
    """Return weights (2, nz) of the differences to the level below and above in -w_s dq/dz, upwind of w_s (nz,).

    The lowest and highest level have no neighbour beyond and take the difference on their other side.
    """
    weights = np.zeros((2, mesh.levels))
    between = mesh.distance_m[1:-1]
    weights[1, :-1] = np.where(speed_m_s[:-1] < 0.0, -speed_m_s[:-1] / between, 0.0)
    weights[0, 1:] = np.where(speed_m_s[1:] > 0.0, -speed_m_s[1:] / between, 0.0)
    if speed_m_s[-1] < 0.0:
        weights[0, -1] = -speed_m_s[-1] / between[-1]
    if speed_m_s[0] > 0.0:
        weights[1, 0] = -speed_m_s[0] / between[0]
    return weights


def subsidence_of_profile(profile: Array, weights: Array) -> Array:
    """Return -w_s dq/dz (nz,) of a profile: as the operator is linear, the mean of that of a field with this mean."""
    difference = np.diff(profile)
    tendency = np.zeros_like(profile)
    tendency[1:] += weights[0, 1:] * difference
    tendency[:-1] += weights[1, :-1] * difference
    return tendency


def falls_through(heights_m: Array, profile: Array, value: float) -> float:
    """Return the greatest height where a profile falls through a value, linear between levels; the lid if never."""
    above = np.flatnonzero(profile >= value)
    k = int(above[-1]) if len(above) else 0
    if k == len(profile) - 1 or profile[k] < value:
        return float(heights_m[-1])
    part = (profile[k] - value) / (profile[k] - profile[k + 1])
    return float(heights_m[k] + part * (heights_m[k + 1] - heights_m[k]))


@kernel(fastmath=FAST)
def add_large_scale(q: Any, mean: Any, source: Any, weights: Any, sponge: Any, tendency: Any) -> None:
    """Add source, subsidence and sponge to the tendency of a field of cells.

    Parameters
    ----------
    q, tendency : ndarray
        (nx, ny, nz).
    mean, source, sponge : ndarray
        Horizontal mean, source (per s) and rate of the sponge (nz,), in the precision of q.
    weights : ndarray
        Of :func:`subsidence_weights` (2, nz), in the precision of q.
    """
    nx, ny, nz = q.shape
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                tendency[i, j, k] += source[k] - sponge[k] * (q[i, j, k] - mean[k])
            for k in range(nz - 1):
                tendency[i, j, k] += weights[1, k] * (q[i, j, k + 1] - q[i, j, k])
            for k in range(1, nz):
                tendency[i, j, k] += weights[0, k] * (q[i, j, k] - q[i, j, k - 1])


@kernel(fastmath=FAST)
def add_rotation(
    u: Any, v: Any, rotation: Any, u_away: Any, v_away: Any, quarter: Any, u_rate: Any, v_rate: Any
) -> None:
    """Add f (v - v_g) and -f (u - u_g) to the tendencies; each component is the mean of its four faces around.

    Parameters
    ----------
    u, v : ndarray
        Velocities in the moving frame.
    rotation : float
        f, s-1.
    u_away, v_away : ndarray
        Geostrophic wind (nz,) in the moving frame.
    quarter : float
        1/4 in the precision of the fields.
    u_rate, v_rate : ndarray
        Tendencies.
    """
    nx, ny, nz = u.shape
    for i in range(nx):
        left, right = (i - 1) % nx, (i + 1) % nx
        for j in range(ny):
            below, above = (j - 1) % ny, (j + 1) % ny
            for k in range(nz):
                v_here = quarter * (v[i, j, k] + v[left, j, k] + v[i, above, k] + v[left, above, k])
                u_rate[i, j, k] += rotation * (v_here - v_away[k])
            for k in range(nz):
                u_here = quarter * (u[i, j, k] + u[right, j, k] + u[i, below, k] + u[right, below, k])
                v_rate[i, j, k] -= rotation * (u_here - u_away[k])


@kernel(fastmath=FAST)
def damp(w: Any, sponge: Any, tendency: Any) -> None:
    """Add -a w to the tendency of w; ``sponge`` (nz + 1,) is on faces."""
    nx, ny, faces = w.shape
    for i in range(nx):
        for j in range(ny):
            for k in range(faces):
                tendency[i, j, k] -= sponge[k] * w[i, j, k]
