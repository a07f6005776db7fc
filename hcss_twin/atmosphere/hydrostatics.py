"""Altitudes and pressures of air at rest."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcss_twin.atmosphere.humidity import AVOGADRO, BOLTZMANN_J_K, MOLAR_MASS_DRY_AIR, MOLAR_MASS_WATER

Array = NDArray[np.float64]

GRAVITY_M_S2 = 9.80665
EARTH_RADIUS_M = 6_356_766.0
"""Radius that belongs to the standard gravity in the geopotential of the 1976 US Standard Atmosphere."""

GAS_CONSTANT = BOLTZMANN_J_K * AVOGADRO


def altitude_of_pressure(
    pressure_Pa: Array, temperature_K: Array, h2o: Array, lowest_m: float = 0.0
) -> Array:
    """Altitudes of levels in hydrostatic balance.

    dH = R T / (M g0) d(-ln p) with T and the molar mass M (of moist air) linear in ln p between levels;
    the geopotential height H becomes altitude by z = r H / (r - H) (U.S. Standard Atmosphere, 1976, eq. 19).

    Parameters
    ----------
    pressure_Pa, temperature_K, h2o : ndarray (L,)
        Pressure falls; h2o is the mole fraction of water vapour.
    lowest_m : float
        Altitude of the first level.

    Returns
    -------
    ndarray (L,)
    """
    molar_mass = MOLAR_MASS_DRY_AIR * (1.0 - h2o) + MOLAR_MASS_WATER * h2o
    scale = GAS_CONSTANT * temperature_K / (molar_mass * GRAVITY_M_S2)
    steps = 0.5 * (scale[1:] + scale[:-1]) * -np.diff(np.log(pressure_Pa))
    start = EARTH_RADIUS_M * lowest_m / (EARTH_RADIUS_M + lowest_m)
    geopotential = start + np.concatenate(([0.0], np.cumsum(steps)))
    return geometric_altitude(geopotential)


def geometric_altitude(geopotential_m: Array) -> Array:
    """Altitude of a geopotential height (U.S. Standard Atmosphere, 1976, eq. 19)."""
    return EARTH_RADIUS_M * geopotential_m / (EARTH_RADIUS_M - geopotential_m)


def pressure_beyond(
    pressure_Pa: float, temperature_K: float, altitude_m: float, other_temperature_K: float, other_m: float
) -> float:
    """Pressure at another altitude in hydrostatic balance, dry, with the mean of both temperatures between."""
    geopotential = [EARTH_RADIUS_M * height / (EARTH_RADIUS_M + height) for height in (altitude_m, other_m)]
    mean = 0.5 * (temperature_K + other_temperature_K)
    scale = GAS_CONSTANT * mean / (MOLAR_MASS_DRY_AIR * GRAVITY_M_S2)
    return pressure_Pa * math.exp(-(geopotential[1] - geopotential[0]) / scale)
