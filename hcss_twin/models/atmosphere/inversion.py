"""Trade inversion: a well-mixed, cloud-topped marine boundary layer under warm, dry air.

Model atmospheres fall steadily from the sea upwards; over the cold subtropical seas the air below 1 to 2 km is colder
than that, and the tops of stratocumulus with it. The boundary layer that replaces the lowest levels is well mixed: dry
adiabatic with constant water vapour up to the cloud base, saturated and moist adiabatic up to the inversion. Within
``JUMP_M`` temperature then rises and humidity falls; both return to those of the profile within ``RELAXATION_M``.

Measured inversions: 10 to 12 K, at 1000 m near the coast of Chile and 1600 m far offshore (C. S. Bretherton et al.,
Atmos. Chem. Phys. 10, 10639 (2010), abstract); 840 m, cloud base 600 m and 1.5 g/kg of water vapour above, a relative
humidity of about 0.1, in research flight 1 of DYCOMS-II (B. Stevens et al., Mon. Weather Rev. 133, 1443 (2005)).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.moist_air import (
    GAS_CONSTANT,
    GRAVITY_M_S2,
    MASS_RATIO,
    MOLAR_MASS_DRY_AIR,
    from_relative_humidity,
    pressure_of_altitude,
    relative_humidity,
    water_vapour_column_kg_m2,
)
from hcss_twin.physics.profile import Profile

JUMP_M = 100.0
"""Thickness of the inversion; our choice (DYCOMS-II: some tens of metres), so that lines between levels follow it."""

RELAXATION_M = 5000.0
"""Depth above the inversion within which the air becomes that of the profile; our choice."""

STEP_M = 100.0
"""Largest distance of levels in the boundary layer."""

HEAT_CAPACITY_J_KG_K = 1005.0
"""Of dry air at constant pressure."""

DRY_LAPSE_K_M = GRAVITY_M_S2 / HEAT_CAPACITY_J_KG_K


class Inversion(Protocol):
    """An inversion: altitude of its base (m), jump of temperature (K), cloud base (m), relative humidity above."""

    height: float
    strength: float
    cloud_base: float
    humidity_above: float


def with_inversion(profile: Profile, inversion: Inversion, surface_K: float) -> Profile:
    """Return a profile with a marine boundary layer under an inversion, in hydrostatic balance.

    Pressure at the sea, and the mole fractions of gases other than water vapour, are those of ``profile``.

    Parameters
    ----------
    profile : Profile
        From the sea to above 8.1 km, with water vapour.
    inversion : Inversion
        With the cloud base at or below the inversion.
    surface_K : float
        Temperature of the air at the sea.

    Raises
    ------
    CatalogError
        If the air above the inversion would have to cool faster than dry air that rises.
    """
    base, height = inversion.cloud_base, inversion.height
    above, end = height + JUMP_M, height + JUMP_M + RELAXATION_M
    upper_m = profile.altitude_m[profile.altitude_m > above + 1.0]
    upper_m = upper_m[np.abs(upper_m - end) > 1.0]
    altitude = np.unique(np.concatenate((_even(0.0, base), _even(base, height), [above, end], upper_m)))
    mixed, cloudy = altitude <= base, altitude <= height
    free, beyond = altitude >= above, altitude >= end
    given = profile.resampled(altitude)
    weight = np.clip((end - altitude) / RELAXATION_M, 0.0, 1.0)
    temperature, pressure, vapour = given.temperature_K.copy(), given.pressure_Pa, given.mixing_ratio["h2o"]
    humidity = relative_humidity(vapour, pressure, temperature)
    humidity = (1.0 - weight) * humidity + weight * inversion.humidity_above
    humidity[cloudy] = 1.0
    for _ in range(6):  # temperature in cloud and water vapour depend on pressure, and pressure a little on them
        temperature[cloudy] = _adiabat(altitude[cloudy], pressure[cloudy], surface_K, base)
        excess = temperature[cloudy][-1] + inversion.strength - given.temperature_K[free][0]
        temperature[free] = given.temperature_K[free] + weight[free] * excess
        vapour = from_relative_humidity(humidity, pressure, np.maximum(temperature, 150.0))
        vapour = np.where(beyond, given.mixing_ratio["h2o"], vapour)
        vapour[mixed] = vapour[mixed][-1]
        pressure = pressure_of_altitude(altitude, temperature, vapour, float(profile.pressure_Pa[0]))
        # The air beyond is in the balance of the profile.
        pressure[beyond] = given.pressure_Pa[beyond] * (pressure[beyond][0] / given.pressure_Pa[beyond][0])
    _require_stable(given, free & (altitude <= end), float(excess), inversion)
    changed = replace(
        given, temperature_K=temperature, pressure_Pa=pressure, mixing_ratio={**given.mixing_ratio, "h2o": vapour}
    )
    top_K, model_K = (float(air.temperature_at(height)) for air in (changed, profile))
    note = (
        f"profile '{profile.name}': inversion of {inversion.strength:g} K at {height:g} m over a mixed layer with its "
        f"cloud base at {base:g} m; air at the sea {surface_K:.1f} K instead of {profile.temperature_K[0]:.1f}, below "
        f"the inversion {top_K:.1f} K instead of {model_K:.1f}; water vapour "
        f"{water_vapour_column_kg_m2(changed):.3g} kg m-2 instead of {water_vapour_column_kg_m2(profile):.3g}"
    )
    return replace(changed, notes=(*profile.notes, note))


def saturated_lapse_K_m(temperature_K: float, pressure_Pa: float) -> float:
    """Return the fall of temperature with height of saturated air that rises.

    T. S. Glickman (ed.), Glossary of Meteorology, 2nd ed., American Meteorological Society (2000), "moist-adiabatic
    lapse rate"; latent heat 2.501 MJ/kg at 0 degC, less 2.37 kJ/kg per kelvin.
    """
    mole = float(from_relative_humidity(np.array(1.0), np.array(pressure_Pa), np.array(temperature_K)))
    mass = MASS_RATIO * mole / (1.0 - mole)
    gas, heat = GAS_CONSTANT / MOLAR_MASS_DRY_AIR, 2.501e6 - 2370.0 * (temperature_K - 273.15)
    warming = heat * mass / (gas * temperature_K)
    return (
        DRY_LAPSE_K_M * (1.0 + warming) / (1.0 + heat * MASS_RATIO * warming / (HEAT_CAPACITY_J_KG_K * temperature_K))
    )


def _even(low: float, high: float) -> Array:
    return np.linspace(low, high, int(np.ceil((high - low) / STEP_M)) + 1)


def _adiabat(altitude_m: Array, pressure_Pa: Array, surface_K: float, base_m: float) -> Array:
    """Return temperature (B,) of the boundary layer: dry adiabatic up to the cloud base, moist adiabatic above."""
    temperature = surface_K - DRY_LAPSE_K_M * altitude_m
    for level in range(int(np.searchsorted(altitude_m, base_m)), altitude_m.size - 1):
        step = float(altitude_m[level + 1] - altitude_m[level])
        low, middle = float(temperature[level]), float(np.sqrt(pressure_Pa[level] * pressure_Pa[level + 1]))
        halfway = low - 0.5 * step * saturated_lapse_K_m(low, float(pressure_Pa[level]))
        temperature[level + 1] = low - step * saturated_lapse_K_m(halfway, middle)
    return temperature


def _require_stable(given: Profile, changed: NDArray[np.bool_], excess: float, inversion: Inversion) -> None:
    """Raise an error if air ``changed`` by up to ``excess`` kelvin above the inversion falls faster than dry air."""
    lapse = -np.diff(given.temperature_K[changed]) / np.diff(given.altitude_m[changed])
    room = max(RELAXATION_M * (DRY_LAPSE_K_M - float(np.max(lapse))), 0.0)
    if excess > room:
        most = inversion.strength - (excess - room)
        allowed = f"up to {most:.1f} K; closest valid choice is {np.floor(10.0 * most) / 10.0:g}"
        if most < 0.0:
            allowed = f"a surface_temperature that is about {-most:.0f} K lower, or another profile"
        raise CatalogError(
            f"a jump of {inversion.strength:g} K makes the air above the inversion {excess:.1f} K warmer than that of "
            f"profile '{given.name}', to which it cannot return within {RELAXATION_M / 1e3:g} km; allowed: {allowed}"
        )
