"""Climatological air: the model atmosphere of a place and date, and the temperature at the top of a cloud there.

The latter is that of the air at the sea surface, cooled along the model atmosphere.

The HCSS paper takes cloud temperatures from MOD08_M3, monthly means of MODIS, which are not shipped. This is the
estimate that the shipped data allow; its scatter is stated with it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from types import MappingProxyType

import numpy as np

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.climatology import Climatology
from hcss_twin.models.atmosphere.profile_file import load_profile

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


HIGHEST_M = 10_000.0


@dataclass(frozen=True)
class CloudTop:
    """Cloud-top temperature by climatology.

    Attributes
    ----------
    temperature_K : float
    scatter_K : float
        Standard deviation, over the six model atmospheres, of the fall of temperature from the surface to the top. It
        does not contain inversions, which the model atmospheres lack: marine stratocumulus is several kelvin colder.
    profile : str
        Model atmosphere whose fall of temperature is used.
    """

    temperature_K: float
    scatter_K: float
    profile: str


def climatological_cloud_top(
    latitude_deg: float, longitude_deg: float, time: datetime, top_m: float, catalog: Catalog | None = None
) -> CloudTop:
    """Return the cloud-top temperature at a place, from the air temperature of ship reports and a model's lapse.

    Parameters
    ----------
    latitude_deg, longitude_deg : float
    time : datetime
        With time zone.
    top_m : float
        Altitude of the cloud top, 0 to 10 km.
    catalog : Catalog, optional
        The shipped one by default.

    Raises
    ------
    CatalogError
        If the climatology has no air temperature there, or the top is outside the range.
    """
    if not (math.isfinite(top_m) and 0.0 <= top_m <= HIGHEST_M):
        raise CatalogError(f"top_m: {top_m:g} given, allowed: 0 to {HIGHEST_M:g} m")
    catalog = catalog or Catalog()
    air_K = Climatology(catalog).look_up("air_temperature", latitude_deg, longitude_deg, time).value
    name = closest_model(latitude_deg, air_K)
    falls = {}
    for atmosphere in catalog.names("atmospheres", ".csv"):
        surface_K, top_K = load_profile(atmosphere, catalog).temperature_at(np.array([0.0, top_m]))
        falls[atmosphere] = float(surface_K - top_K)
    return CloudTop(air_K - falls[name], float(np.std(list(falls.values()))), name)
