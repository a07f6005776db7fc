"""Choice of one of the six AFGL model atmospheres for a place and date."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

SURFACE_TEMPERATURE_K: Mapping[str, float] = MappingProxyType(
    {
        "tropical": 299.7,
        "midlatitude-summer": 294.2,
        "us-standard-1976": 288.2,
        "subarctic-summer": 287.2,
        "midlatitude-winter": 272.2,
        "subarctic-winter": 257.2,
    }
)
"""Surface temperature of each model (AFGL-TR-86-0110, tables 1a to 1f)."""

TROPIC_DEG = 23.5
SUBARCTIC_DEG = 50.0

WARM_MONTHS = range(4, 10)
"""April to September: the warm half of the year in the northern hemisphere."""


def candidates(latitude_deg: float) -> tuple[str, ...]:
    """Return the model atmospheres that apply in a latitude belt.

    Up to 23.5 degrees: tropical and midlatitude summer; up to 50: all except the subarctic models; above: all except
    tropical and midlatitude summer.
    """
    if abs(latitude_deg) <= TROPIC_DEG:
        return ("tropical", "midlatitude-summer")
    if abs(latitude_deg) <= SUBARCTIC_DEG:
        return ("tropical", "midlatitude-summer", "us-standard-1976", "midlatitude-winter")
    return ("us-standard-1976", "subarctic-summer", "midlatitude-winter", "subarctic-winter")


def closest_model(latitude_deg: float, air_temperature_K: float) -> str:
    """Return the candidate of the latitude belt whose surface temperature is closest to the air temperature."""
    return min(candidates(latitude_deg), key=lambda name: abs(SURFACE_TEMPERATURE_K[name] - air_temperature_K))


def calendar_model(latitude_deg: float, month: int) -> str:
    """Return the model for a latitude and half-year, where there is no climatological air temperature.

    Parameters
    ----------
    latitude_deg : float
    month : int
        1 to 12.
    """
    if abs(latitude_deg) <= TROPIC_DEG:
        return "tropical"
    warm = (month in WARM_MONTHS) == (latitude_deg >= 0)
    belt = "midlatitude" if abs(latitude_deg) <= SUBARCTIC_DEG else "subarctic"
    return f"{belt}-{'summer' if warm else 'winter'}"
