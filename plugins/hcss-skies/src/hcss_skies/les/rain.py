"""Warm rain with one moment: it forms from cloud water, falls, and evaporates below clouds. Droplets of clouds settle.

Autoconversion 1350 q_c^2.47 N^-1.79 and accretion 67 (q_c q_r)^1.15 (M. Khairoutdinov and Y. Kogan, Mon. Weather Rev.
128, 229 (2000), eq. 29 and 33; kg/kg, cm-3, s-1). Fall speed and evaporation (J. B. Klemp and R. B. Wilhelmson, J.
Atmos. Sci. 35, 1070 (1978)) are those of drops of Marshall and Palmer: drizzle falls too fast in it.

Droplets of a lognormal distribution settle by Stokes' law with the flux 1.19e8 m-1 s-1 (3 / (4 pi rho_w N))^(2/3) (rho
q_c)^(5/3) exp(5 ln^2 sigma) (A. S. Ackerman et al., Mon. Weather Rev. 137, 1083 (2009), whose sigma is 1.5).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hcss_skies.les.advection import FAST
from hcss_skies.les.thermodynamics import G, saturation
from hcss_twin.core.kernels import kernel


@kernel(fastmath=FAST)
def fall_and_change(
    theta_l: Any, water: Any, rain: Any, liquid: Any, theta_0: float, warming: float, pressure: Any, exner: Any,
    density: Any, depth: Any, droplets: float, seconds: float, heating: Any,
) -> float:  # fmt: skip
    """Let rain fall and change for one step; return what fell on the sea, kg m-2 in the mean.

    Parameters
    ----------
    theta_l, water, rain : ndarray
        Fields, changed in place; theta_l less theta_0, water in g/kg.
    liquid : ndarray
        Cloud water, g/kg, of the same instant.
    theta_0, warming : float
        Of the reference state, K.
    pressure, exner, density, depth : ndarray
        Reference state (nz,) and depth of levels.
    droplets : float
        N, cm-3.
    seconds : float
        Step.
    heating : ndarray
        Result: mean change (nz,) of theta_l, K.
    """
    nx, ny, nz = rain.shape
    q, speed = np.empty(nz), np.empty(nz)
    fallen = 0.0
    heating[:] = 0.0
    for i in range(nx):
        for j in range(ny):
            wet = False
            for k in range(nz):
                q[k] = rain[i, j, k] * G
                # what advection leaves below 0 is taken from vapour: the sum is kept
                if q[k] < 0.0:
                    water[i, j, k] += rain[i, j, k]
                    q[k] = 0.0
                wet = wet or q[k] > 0.0 or liquid[i, j, k] > 0.0
            if not wet:
                for k in range(nz):
                    rain[i, j, k] = 0.0
                continue
            fastest = 0.0
            for k in range(nz):
                speed[k] = 36.34 * (1e-3 * density[k] * q[k]) ** 0.1346 * math.sqrt(density[0] / density[k])
                fastest = max(fastest, speed[k] / depth[k])
            parts = max(1, math.ceil(seconds * fastest))
            for _ in range(parts):
                flux = 0.0
                for k in range(nz - 1, -1, -1):
                    through = density[k] * speed[k] * q[k]
                    q[k] += seconds / parts * (flux - through) / (density[k] * depth[k])
                    flux = through
                fallen += seconds / parts * flux
            for k in range(nz):
                cloud = G * liquid[i, j, k]
                if cloud > 0.0:
                    rate = 1350.0 * cloud**2.47 * droplets**-1.79 + 67.0 * (cloud * q[k]) ** 1.15
                    change = min(seconds * rate, cloud)
                elif q[k] > 0.0:
                    temperature = exner[k] * (theta_0 + theta_l[i, j, k])
                    at_saturation = G * saturation(temperature, pressure[k])[0]
                    dryness = max(1.0 - G * water[i, j, k] / at_saturation, 0.0)
                    amount = 1e-3 * density[k] * q[k]
                    ventilation = 1.6 + 124.9 * amount**0.2046
                    resistance = 5.4e5 + 2.55e6 / (0.01 * pressure[k] * at_saturation)
                    rate = dryness * ventilation * amount**0.525 / (resistance * 1e-3 * density[k])
                    change = -min(seconds * rate, q[k])
                else:
                    change = 0.0
                q[k] += change
                warmer = warming / G / exner[k] * change
                theta_l[i, j, k] += warmer
                water[i, j, k] -= change / G
                rain[i, j, k] = q[k] / G
                heating[k] += warmer
    heating[:] /= nx * ny
    return float(fallen / (nx * ny))


def settling_coefficient(droplets_cm3: float, sigma: float) -> float:
    """Return the flux (kg m-2 s-1) of droplets that settle, of 1 kg m-3."""
    volume = 3.0 / (4.0 * math.pi * 1000.0 * 1e6 * droplets_cm3)
    return 1.19e8 * float(volume ** (2.0 / 3.0)) * math.exp(5.0 * math.log(sigma) ** 2)


@kernel(fastmath=FAST)
def settle(
    theta_l: Any, water: Any, liquid: Any, warming: float, exner: Any, density: Any, depth: Any, coefficient: float,
    seconds: float, heating: Any,
) -> float:  # fmt: skip
    """Let droplets of clouds settle for one step; return what came to the ground, kg m-2 in the mean.

    Parameters
    ----------
    theta_l, water, liquid, warming, exner, density, depth, seconds, heating
        As in :func:`fall_and_change`; temperature and vapour stay, so that theta_l changes with the cloud water.
    coefficient : float
        Of :func:`settling_coefficient`.
    """
    nx, ny, nz = liquid.shape
    fallen = 0.0
    heating[:] = 0.0
    for i in range(nx):
        for j in range(ny):
            flux = 0.0
            for k in range(nz - 1, -1, -1):
                content = density[k] * G * liquid[i, j, k]
                if content <= 0.0 and flux == 0.0:
                    continue
                root = np.cbrt(content)
                through = min(coefficient * content * root * root, content * depth[k] / seconds)
                change = seconds * (flux - through) / (density[k] * depth[k] * G)
                warmer = -warming / exner[k] * change
                water[i, j, k] += change
                theta_l[i, j, k] += warmer
                heating[k] += warmer
                flux = through
            fallen += seconds * flux
    heating[:] /= nx * ny
    return float(fallen / (nx * ny))
