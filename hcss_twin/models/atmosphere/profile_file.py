"""Profiles by catalog name or from a user's file.

Which of the six AFGL model atmospheres suits a place and date.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.profile_building import build_profile
from hcss_twin.models.atmosphere.sounding import read_sounding
from hcss_twin.physics.profile import Profile

STANDARD = "us-standard-1976"
"""Model that completes profiles where nothing else is asked for."""


def load_profile(name: str, catalog: Catalog, above: str = STANDARD) -> Profile:
    """Read a profile by catalog name or from a user's CSV or NetCDF file (docs/atmosphere-profiles.md).

    Parameters
    ----------
    name : str
        Catalog name or path.
    catalog : Catalog
    above : str
        Profile, by name or path, that gives the gases a file leaves out and the air above its last level;
        it must reach 100 km.

    Raises
    ------
    CatalogError
        If a file is missing or malformed, or its levels are not physical; with the line or level.
    """

    def model() -> Profile:
        def incomplete() -> Profile:
            raise CatalogError(f"'{above}' cannot complete '{name}': it has gaps itself; allowed: whole profiles")

        return build_profile(read_sounding(catalog.find(above, "atmospheres", ".csv"), above), incomplete)

    return build_profile(read_sounding(catalog.find(name, "atmospheres", ".csv"), name), model)


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
    return min(candidates(latitude_deg), key=lambda name: abs(SURFACE_TEMPERATURE_K[name] - air_temperature_K))


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
