"""Profile in LOWTRAN7's input form: at most 34 levels, mixing ratios in parts per million."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.providers import Profile

Array = NDArray[np.float64]

MAX_LEVELS = 34
TOP_KM = 120.0
"""Highest level for which LOWTRAN7 knows the gases a profile leaves out."""

GASES = ("h2o", "co2", "o3", "n2o", "co", "ch4", "o2", "no", "so2", "no2", "nh3", "hno3")
"""In the order of cards 2C1 and 2C2."""

OWN_ALTITUDES_KM = (*range(26), 30, 35, 40, 45, 50, 70, 100)
"""Levels of the built-in atmospheres (data ZAER in FLAYZ)."""


@dataclass(frozen=True)
class Levels:
    """Levels of a profile.

    Attributes
    ----------
    altitude_km, pressure_mb, temperature_K : ndarray (L,)
    mixing_ppmv : tuple of (ndarray (L,) or None)
        For each of ``GASES``; None where the profile does not say.
    """

    altitude_km: Array
    pressure_mb: Array
    temperature_K: Array
    mixing_ppmv: tuple[Array | None, ...]


def levels_of(profile: Profile) -> Levels:
    """Return the profile's own levels up to 120 km or, if there are more than 34, LOWTRAN7's 33 altitudes.

    Between levels temperature is linear, pressure and mixing ratios are exponential, as in LOWTRAN7.
    """
    own_km = profile.altitude_m / 1000.0
    altitude = own_km[own_km <= TOP_KM]
    if altitude.size > MAX_LEVELS:
        top = altitude[-1]
        standard = np.array(OWN_ALTITUDES_KM, dtype=np.float64)
        altitude = standard[standard <= top]
        if altitude[-1] < min(top, 100.0):
            altitude = np.append(altitude, min(top, 100.0))
    ratios: list[Array | None] = []
    for gas in GASES:
        given = profile.mixing_ratio.get(gas)
        ratios.append(None if given is None else 1e6 * _exponential(altitude, own_km, given))
    return Levels(
        altitude_km=altitude,
        pressure_mb=_exponential(altitude, own_km, profile.pressure_Pa) / 100.0,
        temperature_K=np.interp(altitude, own_km, profile.temperature_K),
        mixing_ppmv=tuple(ratios),
    )


def missing_gases(levels: Levels) -> tuple[str, ...]:
    """Name the gases of the engine's profiles that are missing."""
    known = GASES[:7]
    return tuple(gas for gas, column in zip(known, levels.mixing_ppmv[: len(known)], strict=True) if column is None)


def temperature_departure_K(levels: Levels, profile: Profile) -> float:
    """Return the largest difference between levels and profile up to 20 km, at the profile's altitudes."""
    own_km = profile.altitude_m / 1000.0
    low = own_km <= min(20.0, levels.altitude_km[-1])
    found = np.interp(own_km[low], levels.altitude_km, levels.temperature_K)
    return float(np.max(np.abs(found - profile.temperature_K[low])))


def _exponential(where: Array, altitude: Array, values: Array) -> Array:
    """Interpolate exponentially in altitude; linearly where a value is zero."""
    if np.all(values > 0.0):
        result: Array = np.exp(np.interp(where, altitude, np.log(values)))
        return result
    linear: Array = np.interp(where, altitude, values)
    return linear
