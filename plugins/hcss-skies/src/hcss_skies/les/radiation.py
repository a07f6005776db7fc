"""Cooling of a stratocumulus layer by infrared radiation, column by column, from its liquid water alone.

F(z) = F_0 exp(-Q(z, top)) + F_1 exp(-Q(0, z)) + rho_i cp D a_z [(z - z_i)^(4/3) / 4 + z_i (z - z_i)^(1/3)] above z_i,
Q(a, b) = kappa * integral of rho q_c dz from a to b (Stevens et al. 2005, MWR 133, 1443, eq. 3 and 4). z_i is where q_t
falls through a given value; the last term balances the warming by subsidence above it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_skies.les.advection import FAST
from hcss_skies.les.thermodynamics import G
from hcss_twin.core.kernels import kernel


@kernel(fastmath=FAST)
def radiative_heating(
    liquid: Any, water: Any, faces: Any, density: Any, exner: Any, cp: float, law: Any, heating: Any, mean: Any
) -> None:
    """Set the radiative tendency (K/s) of theta_l, and its horizontal mean (nz,) in double precision.

    Parameters
    ----------
    liquid, water : ndarray
        q_c and q_t, g/kg.
    faces : ndarray
        Heights (nz + 1,) of faces.
    density, exner : ndarray
        Reference state (nz,).
    cp : float
        Heat capacity of air, J kg-1 K-1.
    law : tuple of float
        F_0, F_1 (W m-2), kappa (m2 kg-1), a_z (m-4/3), D (s-1), rho_i (kg m-3), q_t at z_i (g/kg).
    heating, mean : ndarray
        Results.
    """
    nx, ny, nz = liquid.shape
    f_0, f_1, kappa, a_z, divergence, density_i, at_inversion = law
    above, flux, balance = np.empty(nz + 1), np.empty(nz + 1), np.empty((nz + 1, nz + 1))
    # of z_i on a face: what balances subsidence takes powers, which are slow
    for i in range(nz + 1):
        for k in range(nz + 1):
            rise = max(faces[k] - faces[i], 0.0)
            balance[i, k] = density_i * cp * divergence * a_z * (0.25 * rise ** (4 / 3) + faces[i] * rise ** (1 / 3))
    mean[:] = 0.0
    for i in range(nx):
        for j in range(ny):
            above[nz] = 0.0
            for k in range(nz - 1, -1, -1):
                above[k] = above[k + 1] + kappa * density[k] * (faces[k + 1] - faces[k]) * G * liquid[i, j, k]
            inversion = nz
            for k in range(nz):
                if water[i, j, k] < at_inversion:
                    inversion = k
                    break
            whole = above[0]
            over, under = np.exp(-whole), 1.0
            for k in range(nz + 1):
                if k > 0 and above[k] != above[k - 1]:
                    over, under = np.exp(-above[k]), np.exp(above[k] - whole)
                flux[k] = f_0 * over + f_1 * under + balance[inversion, k]
            for k in range(nz):
                rate = (flux[k] - flux[k + 1]) / (density[k] * cp * exner[k] * (faces[k + 1] - faces[k]))
                heating[i, j, k] = rate
                mean[k] += rate
    mean[:] /= nx * ny
