"""Advection in flux form with weighted essentially non-oscillatory interpolation of fifth order (WENO5).

d(rho q)/dt = -div(rho U q). The value of q on a face is upwind and weighted among three parabolas by their smoothness
(Jiang and Shu 1996, J. Comput. Phys. 126, 202, eq. 2.10 to 2.17); its dissipation is the model of the turbulence below
the grid (Pressel et al. 2017, JAMES 9, 1342). What leaves a cell enters its neighbour, so that the integral of rho q is
kept to rounding. On a stretched grid the interpolation is in the index, not in height: of lower order, still
conservative.

The kernels run along z, which is innermost: values of a face are selected by the sign of the wind, without a branch, so
that compilers make vector code.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hcss_twin.core.kernels import kernel

FAST = {"contract", "arcp", "nsz", "reassoc"}
"""Freedoms of the compiler: all but those that would hide values that are not finite."""


def constants(dtype: Any) -> tuple[Any, ...]:
    """Return the constants of WENO5 in the precision of the fields; mixed precision would be double and slow."""
    kind = np.dtype(dtype).type
    return tuple(kind(x) for x in (1.0 / 3.0, 0.5, 1.0 / 6.0, 13.0 / 3.0, 2.0, 4e-6, 6.0, 3.0))


@kernel(inner=True, fastmath=FAST)
def weno5(a: Any, b: Any, c: Any, d: Any, e: Any, weno: Any) -> Any:
    """Return the value between c and d, upwind from c, of five cells in a row; one division in the place of four."""
    third, half, sixth, curved, two, least, six, three = weno
    s0 = (a - b) - (b - c)
    s1 = (b - c) - (c - d)
    s2 = (c - d) - (d - e)
    f0 = s0 + two * (c - b)
    f1 = b - d
    f2 = s2 + two * (c - d)
    b0 = least + curved * s0 * s0 + f0 * f0
    b1 = least + curved * s1 * s1 + f1 * f1
    b2 = least + curved * s2 * s2 + f2 * f2
    a0 = b1 * b2
    a1 = b0 * b2
    a2 = b0 * b1
    a0 = a0 * a0
    a1 = six * a1 * a1
    a2 = three * a2 * a2
    change = (
        a0 * (s0 * third + half * (c - b)) + a1 * (half * (d - c) - s1 * sixth) + a2 * (half * (d - c) - s2 * sixth)
    )
    return c + change / (a0 + a1 + a2)


@kernel(inner=True, fastmath=FAST)
def upwind(speed: Any, q: Any, weno: Any) -> Any:
    """Return the flux speed * q through a face of six cells in a row, three on each side."""
    q0, q1, q2, q3, q4, q5 = q
    # 1 or 0; a choice between values would become one between addresses, which is no vector code
    right = weno[1] + math.copysign(weno[1], speed)
    left = weno[1] - math.copysign(weno[1], speed)
    a = right * q0 + left * q5
    b = right * q1 + left * q4
    c = right * q2 + left * q3
    d = right * q3 + left * q2
    e = right * q4 + left * q1
    return speed * weno5(a, b, c, d, e, weno)


@kernel(fastmath=FAST)
def advect(
    q: Any,
    u: Any,
    v: Any,
    w: Any,
    di: int,
    dj: int,
    density: Any,
    per_mass: Any,
    per_side: Any,
    tendency: Any,
    weno: Any,
) -> None:
    """Add the advection of a scalar, or of u or v, to its tendency.

    Parameters
    ----------
    q : ndarray
        Field (nx, ny, nz).
    u, v, w : ndarray
        Velocities.
    di, dj : int
        0, 0 for scalars; 1, 0 for u; 0, 1 for v: its faces have the mean velocity of two faces of cells.
    density : ndarray
        rho (nz + 1,) on faces.
    per_mass : ndarray
        1 / (rho dz) (nz,).
    per_side : float
        1 / dx.
    tendency : ndarray
        (nx, ny, nz).
    weno : tuple
        Of :func:`constants`.
    """
    nx, ny, nz = q.shape
    half = weno[1]
    flux = np.empty(nz + 1, q.dtype)
    speed = np.empty(nz + 1, q.dtype)
    column = np.empty(nz + 6, q.dtype)
    for i in range(nx):
        i0, i1, i2, i4, i5 = (i - 3) % nx, (i - 2) % nx, (i - 1) % nx, (i + 1) % nx, (i + 2) % nx
        before = (i - di) % nx
        for j in range(ny):
            j0, j1, j2, j4, j5 = (j - 3) % ny, (j - 2) % ny, (j - 1) % ny, (j + 1) % ny, (j + 2) % ny
            below = (j - dj) % ny
            for k in range(nz):
                speed[k] = half * (u[i, j, k] + u[before, below, k])
            for k in range(nz):
                six = (q[i0, j, k], q[i1, j, k], q[i2, j, k], q[i, j, k], q[i4, j, k], q[i5, j, k])
                flux[k] = upwind(speed[k], six, weno)
            for k in range(nz):
                tendency[i, j, k] += per_side * flux[k]
                tendency[i2, j, k] -= per_side * flux[k]
            for k in range(nz):
                speed[k] = half * (v[i, j, k] + v[before, below, k])
            for k in range(nz):
                six = (q[i, j0, k], q[i, j1, k], q[i, j2, k], q[i, j, k], q[i, j4, k], q[i, j5, k])
                flux[k] = upwind(speed[k], six, weno)
            for k in range(nz):
                tendency[i, j, k] += per_side * flux[k]
                tendency[i, j2, k] -= per_side * flux[k]
            for k in range(nz):
                column[k + 3] = q[i, j, k]
            for k in range(3):
                column[k] = q[i, j, 0]
                column[nz + 3 + k] = q[i, j, nz - 1]
            for k in range(nz + 1):
                speed[k] = half * density[k] * (w[i, j, k] + w[before, below, k])
            for k in range(nz + 1):
                six = (column[k], column[k + 1], column[k + 2], column[k + 3], column[k + 4], column[k + 5])
                flux[k] = upwind(speed[k], six, weno)  # 0 through sea and lid, where w is 0
            for k in range(nz):
                tendency[i, j, k] += per_mass[k] * (flux[k] - flux[k + 1])


@kernel(fastmath=FAST)
def advect_w(
    w: Any, u: Any, v: Any, lower: Any, upper: Any, density: Any, per_mass: Any, per_side: Any, tendency: Any, weno: Any
) -> None:
    """Add the advection of w to its tendency.

    Parameters
    ----------
    w : ndarray
        Field (nx, ny, nz + 1); its first and last level stay 0.
    u, v : ndarray
        Velocities.
    lower, upper : ndarray
        Weights (nz + 1,) of the levels below and above a face in the mass that crosses the sides of its cell.
    density : ndarray
        rho (nz + 1,) on faces.
    per_mass : ndarray
        1 / (rho dz) (nz + 1,) of cells around faces.
    per_side, tendency, weno
        As in :func:`advect`.
    """
    nx, ny, faces = w.shape
    nz = faces - 1
    half = weno[1]
    flux = np.empty(faces, w.dtype)
    speed = np.zeros(faces, w.dtype)
    column = np.zeros(faces + 6, w.dtype)
    for i in range(nx):
        i0, i1, i2, i4, i5 = (i - 3) % nx, (i - 2) % nx, (i - 1) % nx, (i + 1) % nx, (i + 2) % nx
        for j in range(ny):
            j0, j1, j2, j4, j5 = (j - 3) % ny, (j - 2) % ny, (j - 1) % ny, (j + 1) % ny, (j + 2) % ny
            for k in range(1, nz):
                speed[k] = lower[k] * u[i, j, k - 1] + upper[k] * u[i, j, k]
            for k in range(nz):
                six = (w[i0, j, k], w[i1, j, k], w[i2, j, k], w[i, j, k], w[i4, j, k], w[i5, j, k])
                flux[k] = upwind(speed[k], six, weno)
            for k in range(1, nz):
                tendency[i, j, k] += per_side * flux[k]
                tendency[i2, j, k] -= per_side * flux[k]
            for k in range(1, nz):
                speed[k] = lower[k] * v[i, j, k - 1] + upper[k] * v[i, j, k]
            for k in range(nz):
                six = (w[i, j0, k], w[i, j1, k], w[i, j2, k], w[i, j, k], w[i, j4, k], w[i, j5, k])
                flux[k] = upwind(speed[k], six, weno)
            for k in range(1, nz):
                tendency[i, j, k] += per_side * flux[k]
                tendency[i, j2, k] -= per_side * flux[k]
            # beyond sea and lid w is 0, as on them
            for k in range(faces):
                column[k + 2] = w[i, j, k]
            for k in range(nz):
                mass = half * (density[k] * w[i, j, k] + density[k + 1] * w[i, j, k + 1])
                six = (column[k], column[k + 1], column[k + 2], column[k + 3], column[k + 4], column[k + 5])
                flux[k] = upwind(mass, six, weno)
            for k in range(1, nz):
                tendency[i, j, k] += per_mass[k] * (flux[k - 1] - flux[k])


@kernel(fastmath=FAST)
def step(new: Any, old: Any, tendency: Any, seconds: Any) -> None:
    """Set new = old + seconds * tendency, and the tendency to 0 for the next stage."""
    nx, ny, nz = new.shape
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                new[i, j, k] = old[i, j, k] + seconds * tendency[i, j, k]
                tendency[i, j, k] = 0


@kernel()
def courant(u: Any, v: Any, w: Any, per_side: float, per_depth: Any) -> float:
    """Return the largest sum (s-1) over the three axes of |velocity| / cell side; nan if a velocity is."""
    nx, ny, nz = u.shape
    largest = 0.0
    for i in range(nx):
        for j in range(ny):
            most = 0.0
            for k in range(nz):
                rate = (abs(u[i, j, k]) + abs(v[i, j, k])) * per_side + abs(w[i, j, k]) * per_depth[k]
                most = max(most, rate) if rate == rate else np.inf
            largest = max(largest, most)
    return largest
