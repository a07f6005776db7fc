"""Air and sea by latitude and date, for images that show a whole side of the Earth.

Temperatures, the logarithms of pressures and those of the amounts of gases are polynomials of the latitude through five
model atmospheres (AFGL-TR-86-0110): tropical at the equator, midlatitude at 45 and subarctic at 60 degrees north and
south. Those of a latitude are mixed from summer and winter by a cosine of the year, whose extremes are in the middle of
January and July. The sea has the zonal means of the climatology (COADS) at that date, as a polynomial.

Polynomials have no kinks, which interpolation between the places of a disk could not follow.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from functools import lru_cache

import numpy as np

from hcss_twin.models.atmosphere.climatology import Climatology
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.plan.air_over_field import AirOverField
from hcss_twin.providers import Catalog, CatalogError, Profile, SeaModel

ZONES_DEG = (-60.0, -45.0, 0.0, 45.0, 60.0)
"""Latitudes of the model atmospheres."""

FARTHEST_DEG = 75.0
"""Latitude beyond which air and sea are those of this one."""

COLDEST_SEA_K, _SOFT_K = 271.35, 2.0
"""Freezing point of the sea, and the width within which temperatures near it bend toward it."""

_AIRS = 4
"""Latitudes whose air is kept in memory."""

_SEA_ORDER, _SEA_STEP_DEG = 6, 4.0
"""Order of the polynomial of the sea's temperature, and step of the latitudes and longitudes it is fitted to."""


class ZonalClimate:
    """Air and sea by latitude; implements :data:`hcss_twin.plan.air_over_field.Climate`.

    Parameters
    ----------
    time : datetime
        With a time zone.
    centre_deg : (float, float)
        Latitude and longitude of the scene.
    """

    def __init__(self, catalog: Catalog, time: datetime, centre_deg: tuple[float, float] = (0.0, 0.0)) -> None:
        self._centre_deg = centre_deg
        self._zones = [_zone(latitude, catalog, time) for latitude in ZONES_DEG]
        self._sea = _zonal_sea(catalog, time)

    def __call__(
        self, air_of: Callable[[Profile], AirOverField.Air], sea_of: Callable[[float], SeaModel]
    ) -> AirOverField:
        """Return the air and sea of all places."""

        @lru_cache(maxsize=_AIRS)
        def at_latitude(latitude_deg: float) -> AirOverField.Air:
            kelvin = self.sea_temperature_K(latitude_deg)
            return replace(air_of(self.profile(latitude_deg)), sea=sea_of(kelvin), sea_temperature_K=kelvin)

        def at(latitude_deg: float, longitude_deg: float) -> AirOverField.Air:
            return at_latitude(latitude_deg)

        return AirOverField(self._centre_deg, at, lambda: iter(()))

    def profile(self, latitude_deg: float) -> Profile:
        """Return the profile at a latitude."""
        latitude = min(max(latitude_deg, -FARTHEST_DEG), FARTHEST_DEG)
        weights = np.array(
            [
                np.prod([(latitude - other) / (zone_deg - other) for other in ZONES_DEG if other != zone_deg])
                for zone_deg in ZONES_DEG
            ]
        )
        return replace(Profile.mixed(self._zones, weights), name=f"model atmospheres at latitude {latitude:.4g}")

    def sea_temperature_K(self, latitude_deg: float) -> float:
        """Return the temperature of the sea at a latitude, never below its freezing point."""
        latitude = min(max(latitude_deg, -FARTHEST_DEG), FARTHEST_DEG)
        above = (float(self._sea(latitude)) - COLDEST_SEA_K) / _SOFT_K
        return COLDEST_SEA_K + _SOFT_K * float(np.logaddexp(0.0, above))


def _zone(latitude_deg: float, catalog: Catalog, time: datetime) -> Profile:
    """Return the model atmosphere of a zone at a date."""
    if latitude_deg == 0.0:
        return load_profile("tropical", catalog)
    belt = "midlatitude" if abs(latitude_deg) < 50.0 else "subarctic"
    july = 0.5 - 0.5 * np.cos(2.0 * np.pi * (time.astimezone(UTC).timetuple().tm_yday - 15.0) / 365.25)
    summer = july if latitude_deg > 0.0 else 1.0 - july
    return Profile.mixed(
        [load_profile(f"{belt}-{season}", catalog) for season in ("summer", "winter")], np.array([summer, 1.0 - summer])
    )


def _zonal_sea(catalog: Catalog, time: datetime) -> np.polynomial.Polynomial:
    """Return the temperature of the sea, K, as a polynomial of the latitude."""
    climatology = Climatology(catalog)
    places, means = [], []
    for latitude in np.arange(-FARTHEST_DEG, FARTHEST_DEG + 1.0, _SEA_STEP_DEG).tolist():
        found = []
        for longitude in np.arange(0.0, 360.0, 5.0 * _SEA_STEP_DEG).tolist():
            try:
                found.append(climatology.look_up("sea_surface_temperature", latitude, longitude, time).value)
            except CatalogError:  # land or ice
                continue
        if found:
            places.append(latitude)
            means.append(float(np.mean(found)))
    return np.polynomial.Polynomial.fit(places, means, _SEA_ORDER, domain=[-FARTHEST_DEG, FARTHEST_DEG])
