"""Air over the sea at a place and date: what a scene has whose scenario names no profile.

Clear sea is seen through water vapour, whose amount and height decide the split window (10.8 less 12.0 um). One of six
model atmospheres is too coarse: the air of the subtropics is as warm as a moist model and far drier aloft. This profile
follows the place:

* **temperature, pressure and other gases** of the two model atmospheres around the air temperature at the sea,
  interpolated;
* **water vapour** of the climatology up to the condensation level; a relative humidity of ``CLOUD_LAYER_HUMIDITY`` at
  ``CLOUD_LAYER_TOP_M``, as in trade-wind air (BOMEX: A. P. Siebesma et al., J. Atmos. Sci. 60, 1201 (2003), initial
  profiles), and that of the free troposphere from ``TRANSITION_M`` above it to the tropopause;
* **humidity of the free troposphere**: ``MOIST``, but ``DRY`` in the descending air of the subtropics, at
  ``DRY_BELT_DEG`` from the zone of convergence, which follows the sun between 2 and 9 degrees north (D. E. Waliser and
  C. Gautier, J. Climate 6, 2162 (1993)). The pattern is that of zonal means from radiosondes (J. P. Peixoto and
  A. H. Oort, J. Climate 9, 3443 (1996)).

``MOIST``, ``DRY``, ``DRY_BELT_DEG`` and ``BELT_WIDTH_DEG`` were chosen with 14 boxes of clear sea in one SEVIRI image
(6 September 2020, Atlantic); what they leave there is in ``docs/how-to/atmospheres.md``. There is no weather in it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime

import numpy as np

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.climatology import Climatology
from hcss_twin.models.atmosphere.cloud_top import SURFACE_TEMPERATURE_K
from hcss_twin.models.atmosphere.moist_air import (
    from_relative_humidity,
    from_specific_humidity,
    relative_humidity,
    saturation_pressure_Pa,
    water_vapour_column_kg_m2,
)
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.physics.profile import Profile

NAME = "marine air"

MOIST, DRY = 0.5, 0.1
"""Relative humidity of the free troposphere outside and in the middle of the dry belts."""

DRY_BELT_DEG, BELT_WIDTH_DEG = 27.0, 14.0
"""Distance of the middle of a dry belt from the zone of convergence, and its half-width at 1/e."""

CLOUD_LAYER_TOP_M, CLOUD_LAYER_HUMIDITY = 1500.0, 0.75
TRANSITION_M = 500.0
"""Depth in which the air above the cloud layer becomes that of the free troposphere (BOMEX)."""

STEP_M = 250.0
"""Distance of levels up to the free troposphere."""

CHAIN = ("subarctic-winter", "midlatitude-winter", "us-standard-1976", "midlatitude-summer", "tropical")
"""Model atmospheres by the temperature of their air at the sea; one chain for all latitudes has no steps."""

FARTHEST_SHARE = 1.5
"""Largest share of the warmest one, at 2.7 K above it."""

MONTH_OF_NORTHERNMOST = 9.0
"""The zone of convergence is northernmost at the beginning of September."""

CONDENSATION_M_PER_K = 125.0
"""Height of the condensation level per kelvin of temperature above the dew point at the sea, within 2 %.

M. G. Lawrence, Bull. Am. Meteorol. Soc. 86, 225 (2005), eq 24."""


@dataclass(frozen=True)
class SurfaceAir:
    """Temperature, K, and mole fraction of water vapour of the air at the sea."""

    temperature_K: float
    h2o: float


def surface_air(
    climatology: Climatology, latitude_deg: float, longitude_deg: float, time: datetime, warmer_K: float
) -> SurfaceAir:
    """Return the air at the sea by climatology, warmed at constant relative humidity.

    Raises
    ------
    CatalogError
        If the climatology has no values there.
    """
    place = latitude_deg, longitude_deg, time
    kelvin = climatology.look_up("air_temperature", *place).value
    grams = climatology.look_up("specific_humidity", *place).value
    h2o = float(from_specific_humidity(np.array(1e-3 * grams)))
    more = float(saturation_pressure_Pa(kelvin + warmer_K) / saturation_pressure_Pa(kelvin))
    return SurfaceAir(kelvin + warmer_K, h2o * more)


def free_troposphere_humidity(latitude_deg: float, time: datetime) -> float:
    """Return the relative humidity of the air above the boundary layer, 0 to 1."""
    day = time.astimezone(UTC).timetuple().tm_yday
    convergence_deg = 5.5 + 3.5 * math.cos(2.0 * math.pi * (day / 365.25 - (MONTH_OF_NORTHERNMOST - 1.0) / 12.0))
    distance = (abs(latitude_deg - convergence_deg) - DRY_BELT_DEG) / BELT_WIDTH_DEG
    return MOIST - (MOIST - DRY) * math.exp(-(distance**2))


def condensation_level_m(surface: SurfaceAir, pressure_Pa: float) -> float:
    """Return the altitude at which air from the sea becomes saturated; 0 for saturated air."""
    kelvin = np.linspace(150.0, 330.0, 1801)
    dew_point_K = float(np.interp(surface.h2o * pressure_Pa, saturation_pressure_Pa(kelvin), kelvin))
    return max(0.0, CONDENSATION_M_PER_K * (surface.temperature_K - dew_point_K))


def marine_air(surface: SurfaceAir, latitude_deg: float, time: datetime, catalog: Catalog) -> Profile:
    """Return the profile over the sea at a latitude and date."""
    shares = _around(surface.temperature_K)
    air = Profile.mixed([load_profile(name, catalog) for name in shares], list(shares.values()))
    even = np.arange(0.0, CLOUD_LAYER_TOP_M + TRANSITION_M + 1.0, STEP_M)
    highest = tropopause_m(air)
    air = air.resampled(np.union1d(air.altitude_m, even))
    altitude, pressure = air.altitude_m, air.pressure_Pa
    saturated = from_relative_humidity(np.ones_like(altitude), pressure, np.maximum(air.temperature_K, 150.0))
    base = min(condensation_level_m(surface, float(pressure[0])), CLOUD_LAYER_TOP_M - STEP_M)
    of_mixed = min(float(surface.h2o / np.interp(base, altitude, saturated)), 1.0)
    free = free_troposphere_humidity(latitude_deg, time)
    heights = base, CLOUD_LAYER_TOP_M, CLOUD_LAYER_TOP_M + TRANSITION_M
    humidity = np.interp(altitude, heights, [of_mixed, CLOUD_LAYER_HUMIDITY, free])
    # Cold air over warm water is supersaturated in some means of the climatology.
    h2o = np.minimum(np.where(altitude <= base, 1.0, humidity) * saturated, surface.h2o)
    h2o = np.where(altitude <= highest, h2o, air.mixing_ratio["h2o"])
    changed = replace(air, name=NAME, mixing_ratio={**air.mixing_ratio, "h2o": h2o})
    at_sea = float(relative_humidity(h2o[:1], pressure[:1], air.temperature_K[:1])[0])
    note = (
        f"profile '{NAME}': temperatures {_in_words(shares)}; air at the sea {surface.temperature_K:.1f} K with a "
        f"relative humidity of {100.0 * at_sea:.0f} %, free troposphere {100.0 * free:.0f} %; water vapour "
        f"{water_vapour_column_kg_m2(changed):.3g} kg m-2"
    )
    return replace(changed, notes=(note,))


def tropopause_m(profile: Profile) -> float:
    """Return the altitude of the tropopause.

    The lowest level above 5 km from which temperature falls by at most 2 K/km, there and on average over the next 2 km
    (World Meteorological Organization, Bulletin 6, 136 (1957)).
    """
    altitude, kelvin = profile.altitude_m, profile.temperature_K
    top = float(altitude[-1])
    for level in np.flatnonzero((altitude >= 5000.0) & (altitude <= top - 2000.0)):
        start, here = float(altitude[level]), float(kelvin[level])
        ends = np.linspace(start + 250.0, start + 2000.0, 8)
        fall = (here - profile.temperature_at(ends)) / (ends - start)
        if np.all(fall <= 2e-3):
            return start
    return top


def _around(kelvin: float) -> Mapping[str, float]:
    """Return the shares of the model atmospheres around an air temperature; the trend goes on beyond the warmest."""
    temperatures = [SURFACE_TEMPERATURE_K[name] for name in CHAIN]
    upper = int(np.clip(np.searchsorted(temperatures, kelvin), 1, len(CHAIN) - 1))
    low, high = temperatures[upper - 1], temperatures[upper]
    share = float(np.clip((kelvin - low) / (high - low), 0.0, FARTHEST_SHARE))
    return {CHAIN[upper - 1]: 1.0 - share, CHAIN[upper]: share}


def _in_words(shares: Mapping[str, float]) -> str:
    """Say which model atmospheres temperatures lie between, or how far beyond the warmest."""
    (cooler, of_cooler), (warmer, _) = shares.items()
    if of_cooler < 0.0:
        return f"extrapolated beyond {warmer}, by {-100.0 * of_cooler:.0f} % of the step from {cooler} to it"
    return "of " + " and ".join(f"{100.0 * share:.0f} % {name}" for name, share in shares.items() if share > 0.0)
