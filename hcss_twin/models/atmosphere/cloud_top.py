"""Climatological cloud-top temperature: air at the sea surface, cooled along a model atmosphere.

The HCSS paper takes cloud temperatures from MOD08_M3, monthly means of MODIS, which are not shipped. This is the
estimate that the shipped data allow; its scatter is stated with it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.climatology import Climatology
from hcss_twin.models.atmosphere.model_choice import closest_model
from hcss_twin.models.atmosphere.profile_file import load_profile

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
    for each in catalog.names("atmospheres", ".csv"):
        surface_K, top_K = load_profile(each, catalog).temperature_at(np.array([0.0, top_m]))
        falls[each] = float(surface_K - top_K)
    return CloudTop(air_K - falls[name], float(np.std(list(falls.values()))), name)
