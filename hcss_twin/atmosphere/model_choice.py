"""Which of the six AFGL model atmospheres suits a place and date."""

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
"""Temperature of each model at the surface (AFGL-TR-86-0110, tables 1a to 1f)."""

TROPIC_DEG = 23.5
SUBARCTIC_DEG = 50.0

WARM_MONTHS = range(4, 10)
"""April to September: the warm half of the northern year."""


def candidates(latitude_deg: float) -> tuple[str, ...]:
    """Model atmospheres that occur in a belt of latitude.

    Tropical and midlatitude summer up to 23.5 degrees; all but the subarctic ones up to 50; beyond that
    all but the tropical and the midlatitude summer one.
    """
    if abs(latitude_deg) <= TROPIC_DEG:
        return ("tropical", "midlatitude-summer")
    if abs(latitude_deg) <= SUBARCTIC_DEG:
        return ("tropical", "midlatitude-summer", "us-standard-1976", "midlatitude-winter")
    return ("us-standard-1976", "subarctic-summer", "midlatitude-winter", "subarctic-winter")


def closest_model(latitude_deg: float, air_temperature_K: float) -> str:
    """Candidate of the belt whose surface temperature is closest to that of the air."""
    return min(
        candidates(latitude_deg), key=lambda name: abs(SURFACE_TEMPERATURE_K[name] - air_temperature_K)
    )


def calendar_model(latitude_deg: float, month: int) -> str:
    """Model by latitude and half of the year alone, for places without a climatological air temperature.

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
