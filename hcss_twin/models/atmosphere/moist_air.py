"""Moist air: saturation, humidity conversions, column water vapour and its scaling, and hydrostatic balance."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError
from hcss_twin.physics.profile import Profile

BOLTZMANN_J_K = 1.380649e-23
MOLAR_MASS_WATER = 18.01528e-3
MOLAR_MASS_DRY_AIR = 28.9647e-3
AVOGADRO = 6.02214076e23
MASS_RATIO = MOLAR_MASS_WATER / MOLAR_MASS_DRY_AIR

MAX_RELATIVE_HUMIDITY = 1.05
"""Relative humidity over liquid water above which a profile is rejected.

Over liquid water at all temperatures, as radiosondes report it. Humidity may exceed ice saturation by half, but below
about -38 degC droplets freeze homogeneously before water saturation is reached."""

MIN_SATURATION_K = 123.0
"""The saturation formula is not valid below this temperature."""


def saturation_pressure_Pa(temperature_K: Array | float) -> Array:
    """Return the saturation vapour pressure over liquid water, supercooled below 0 degC.

    D. M. Murphy and T. Koop, Q. J. R. Meteorol. Soc. 131, 1539 (2005), eq. 10; valid 123 to 332 K.
    """
    t = np.asarray(temperature_K, dtype=np.float64)
    cold = np.tanh(0.0415 * (t - 218.8))
    result: Array = np.exp(
        54.842763
        - 6763.22 / t
        - 4.210 * np.log(t)
        + 0.000367 * t
        + cold * (53.878 - 1331.22 / t - 9.44523 * np.log(t) + 0.014025 * t)
    )
    return result


def from_relative_humidity(relative_humidity: Array, pressure_Pa: Array, temperature_K: Array) -> Array:
    """Return the mole fraction for relative humidity (0 to 1) over liquid water, all of shape (L,)."""
    return relative_humidity * saturation_pressure_Pa(temperature_K) / pressure_Pa


def from_dewpoint(dewpoint_K: Array, pressure_Pa: Array) -> Array:
    """Return the mole fraction for the dew point over liquid water, both of shape (L,)."""
    return saturation_pressure_Pa(dewpoint_K) / pressure_Pa


def from_mixing_ratio(mass_ratio: Array) -> Array:
    """Return the mole fraction for the mass of vapour per mass of dry air."""
    return mass_ratio / (mass_ratio + MASS_RATIO)


def from_specific_humidity(specific_humidity: Array) -> Array:
    """Return the mole fraction for the mass of vapour per mass of moist air."""
    return specific_humidity / (MASS_RATIO + (1.0 - MASS_RATIO) * specific_humidity)


def relative_humidity(h2o: Array, pressure_Pa: Array, temperature_K: Array) -> Array:
    """Return relative humidity (0 to 1) over liquid water; 0 at temperatures outside the range of the formula."""
    saturation = saturation_pressure_Pa(np.clip(temperature_K, MIN_SATURATION_K, 332.0))
    inside = (temperature_K >= MIN_SATURATION_K) & (temperature_K <= 332.0)
    return np.where(inside, h2o * pressure_Pa / saturation, 0.0)


def water_vapour_column_kg_m2(profile: Profile) -> float:
    """Return the water vapour column; density is exponential in altitude between levels.

    Raises
    ------
    CatalogError
        If the profile has no water vapour.
    """
    _vapour(profile)
    return column_m2(profile, "h2o") * MOLAR_MASS_WATER / AVOGADRO


def column_m2(profile: Profile, gas: str) -> float:
    """Return the number of molecules of a gas above 1 m2; density is exponential in altitude between levels."""
    density = profile.mixing_ratio[gas] * profile.pressure_Pa / (BOLTZMANN_J_K * profile.temperature_K)
    below, above = density[:-1], density[1:]
    ratio = np.log(np.maximum(below, 1e-300) / np.maximum(above, 1e-300))
    even = np.abs(ratio) < 1e-6
    mean = np.where(even, 0.5 * (below + above), (below - above) / np.where(even, 1.0, ratio))
    return float(np.sum(mean * np.diff(profile.altitude_m)))


def largest_factor(profile: Profile) -> float:
    """Return the factor on water vapour at which the first level reaches the maximum relative humidity."""
    humidity = relative_humidity(_vapour(profile), profile.pressure_Pa, profile.temperature_K)
    most = float(np.max(humidity))
    return np.inf if most == 0.0 else MAX_RELATIVE_HUMIDITY / most


def with_water_vapour(profile: Profile, *, factor: float | None = None, column_kg_m2: float | None = None) -> Profile:
    """Scale the water vapour at all levels; pressure, temperature and other gases are unchanged.

    Parameters
    ----------
    profile : Profile
    factor : float, optional
        Factor on the water vapour.
    column_kg_m2 : float, optional
        Target column amount instead of a factor; one of the two must be given.

    Raises
    ------
    CatalogError
        If a level would exceed the maximum relative humidity; the message gives the largest factor or column allowed.
    """
    if (factor is None) == (column_kg_m2 is None):
        raise ValueError("factor, column_kg_m2: give one of them")
    column = water_vapour_column_kg_m2(profile)
    if factor is None:
        assert column_kg_m2 is not None
        if column == 0.0:
            raise CatalogError(f"profile '{profile.name}' is dry; its column water vapour cannot be scaled")
        factor = column_kg_m2 / column
    if factor < 0:
        raise CatalogError(f"the factor on water vapour is {factor:g}; allowed: 0 or more")
    limit = largest_factor(profile)
    if factor > limit:
        humidity = factor * relative_humidity(_vapour(profile), profile.pressure_Pa, profile.temperature_K)
        worst = int(np.argmax(humidity))
        raise CatalogError(
            f"a column of {factor * column:.4g} kg m-2 ({factor:.4g} times that of '{profile.name}') makes a relative "
            f"humidity of {100 * humidity[worst]:.0f} % at {profile.altitude_m[worst] / 1e3:g} km; allowed: up to "
            f"{100 * MAX_RELATIVE_HUMIDITY:g} %; closest valid choice is a factor of {_floor(limit)}, or a column "
            f"of {_floor(limit * column)} kg m-2"
        )
    gases = {**profile.mixing_ratio, "h2o": _vapour(profile) * factor}
    note = (
        f"profile '{profile.name}': water vapour times {factor:.6g}, column {factor * column:.4g} kg m-2 "
        f"instead of {column:.4g}"
    )
    return replace(profile, mixing_ratio=gases, notes=(*profile.notes, note))


def _vapour(profile: Profile) -> Array:
    if "h2o" not in profile.mixing_ratio:
        raise CatalogError(f"profile '{profile.name}' has no water vapour (h2o)")
    return profile.mixing_ratio["h2o"]


def _floor(value: float) -> str:
    """Round down to four digits, so that the suggested value is allowed."""
    step = 10.0 ** (np.floor(np.log10(value)) - 3)
    return f"{np.floor(value / step) * step:.4g}"


GRAVITY_M_S2 = 9.80665
EARTH_RADIUS_M = 6_356_766.0
"""Earth radius in the geopotential of the 1976 US Standard Atmosphere."""

GAS_CONSTANT = BOLTZMANN_J_K * AVOGADRO


def altitude_of_pressure(pressure_Pa: Array, temperature_K: Array, h2o: Array, lowest_m: float = 0.0) -> Array:
    """Return the altitudes of levels in hydrostatic balance.

    dH = R T / (M g0) d(-ln p) with T and the molar mass M (of moist air) linear in ln p between levels;
    the geopotential height H is converted to altitude by z = r H / (r - H) (U.S. Standard Atmosphere, 1976, eq. 19).

    Parameters
    ----------
    pressure_Pa, temperature_K, h2o : ndarray (L,)
        Pressure decreases; h2o is the mole fraction of water vapour.
    lowest_m : float
        Altitude of the first level.

    Returns
    -------
    ndarray (L,)
    """
    steps = _mean_scale_height(temperature_K, h2o) * -np.diff(np.log(pressure_Pa))
    start = EARTH_RADIUS_M * lowest_m / (EARTH_RADIUS_M + lowest_m)
    geopotential = start + np.concatenate(([0.0], np.cumsum(steps)))
    return geometric_altitude(geopotential)


def pressure_of_altitude(altitude_m: Array, temperature_K: Array, h2o: Array, surface_Pa: float) -> Array:
    """Return the pressures (L,) of levels in hydrostatic balance: the inverse of :func:`altitude_of_pressure`."""
    geopotential = EARTH_RADIUS_M * altitude_m / (EARTH_RADIUS_M + altitude_m)
    steps = np.diff(geopotential) / _mean_scale_height(temperature_K, h2o)
    return surface_Pa * np.exp(-np.concatenate(([0.0], np.cumsum(steps))))


def _mean_scale_height(temperature_K: Array, h2o: Array) -> Array:
    """Return the scale heights (L - 1,) between levels, m of geopotential height."""
    molar_mass = MOLAR_MASS_DRY_AIR * (1.0 - h2o) + MOLAR_MASS_WATER * h2o
    scale = GAS_CONSTANT * temperature_K / (molar_mass * GRAVITY_M_S2)
    result: Array = 0.5 * (scale[1:] + scale[:-1])
    return result


def geometric_altitude(geopotential_m: Array) -> Array:
    """Convert geopotential height to altitude (U.S. Standard Atmosphere, 1976, eq. 19)."""
    return EARTH_RADIUS_M * geopotential_m / (EARTH_RADIUS_M - geopotential_m)


def pressure_beyond(
    pressure_Pa: float, temperature_K: float, altitude_m: float, other_temperature_K: float, other_m: float
) -> float:
    """Return the pressure at another altitude: hydrostatic balance of dry air at the mean of both temperatures."""
    geopotential = [EARTH_RADIUS_M * height / (EARTH_RADIUS_M + height) for height in (altitude_m, other_m)]
    mean = 0.5 * (temperature_K + other_temperature_K)
    scale = GAS_CONSTANT * mean / (MOLAR_MASS_DRY_AIR * GRAVITY_M_S2)
    return pressure_Pa * math.exp(-(geopotential[1] - geopotential[0]) / scale)
