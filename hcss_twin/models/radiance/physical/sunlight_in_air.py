"""Sunlight outside the atmosphere, beside the emission of the sea, and scattered once by the air into the view."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_by_spectrum
from hcss_twin.models.radiance.physical.columns import SceneColumns
from hcss_twin.models.radiance.physical.directions import ColumnDirections
from hcss_twin.physics.geometry import sun_zenith_along
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import SolarIrradiance, Sun, TransmittanceProvider

MAX_SUN_ZENITH_DEG = 88.0
"""Beyond this zenith angle, sunlight scattered in the air is omitted: paths to the sun graze the Earth."""

_COLD_SEA_K = 263.15
"""Sunlight that is faint beside the emission of colder water is solved in closed form over any sea: solved clouds do
not depend on the sea's temperature, and radiance is a smooth function of it."""

_MIN_EARTH_RADIUS_M = 6356752.0
"""Polar radius; in providers with a larger radius the sun is no lower."""

_SPECTRA = 4
"""Sets of wavenumbers, views and suns for which scattered sunlight is held in memory."""


def received(solar_irradiance: SolarIrradiance, directions: ColumnDirections, wavenumber_cm1: Array) -> Array:
    """Return solar irradiance (V,) on a horizontal plane outside the atmosphere; 0 without a sun."""
    if directions.sun is None:
        return np.zeros_like(wavenumber_cm1)
    irradiance = solar_irradiance(wavenumber_cm1)
    return directions.mu_sun * irradiance / directions.sun.distance_au**2


def sun_share(
    solar_irradiance: SolarIrradiance, sea_temperature_K: float, directions: ColumnDirections, wavenumber_cm1: Array
) -> Array:
    """Return sunlight (V,) reflected by a white plane, relative to the Planck radiance of a cold sea."""
    cold = planck(wavenumber_cm1, min(sea_temperature_K, _COLD_SEA_K))
    return received(solar_irradiance, directions, wavenumber_cm1) / (np.pi * cold)


ScatteredAbove = Callable[[Array, float, Sun | None, float], Callable[[float], Array]]
"""Maps wavenumbers, the view's zenith, the sun and its relative azimuth to sunlight scattered above an altitude."""


def scattered_in(transmittance: TransmittanceProvider, profile: Profile) -> ScatteredAbove:
    """Return :func:`scattered_once` of one air, whose last results are shared by columns over different seas."""

    def of_air(
        wavenumber_cm1: Array, view_zenith_deg: float, sun: Sun | None, relative_azimuth: float
    ) -> Callable[[float], Array]:
        return scattered_once(transmittance, profile, view_zenith_deg, sun, relative_azimuth, wavenumber_cm1)

    return cached_by_spectrum(of_air, maxsize=_SPECTRA)


def scattered_once(
    transmittance: TransmittanceProvider,
    profile: Profile,
    view_zenith_deg: float,
    sun: Sun | None,
    relative_azimuth: float,
    wavenumber_cm1: Array,
) -> Callable[[float], Array]:
    """Return sunlight (V,) scattered once into a view above an altitude, sr-1, for each unit of solar irradiance.

    0 without a sun, if the provider has none, and if the sun is near the horizon at any point of the (long) slant path
    between sea and sensor.

    Parameters
    ----------
    relative_azimuth : float
        Radians, as :func:`hcss_twin.physics.geometry.relative_azimuth_rad`.
    """
    solar_path_radiance, top_m = getattr(transmittance, "solar_path_radiance", None), float(profile.altitude_m[-1])
    if solar_path_radiance is None or sun is None:
        return lambda altitude_m: np.zeros_like(wavenumber_cm1)
    highest = sun_zenith_along(view_zenith_deg, sun.zenith_deg, relative_azimuth, top_m, _MIN_EARTH_RADIUS_M)
    if max(sun.zenith_deg, highest) > MAX_SUN_ZENITH_DEG:
        return lambda altitude_m: np.zeros_like(wavenumber_cm1)

    @cache
    def above(altitude_m: float) -> Array:
        paths, azimuth_deg = [to_space(altitude_m, view_zenith_deg)], float(np.degrees(relative_azimuth))
        radiance: Array = solar_path_radiance(wavenumber_cm1, paths, sun.zenith_deg, azimuth_deg)[0]
        return radiance

    return above


def seen_scattered(columns: SceneColumns, scattered: Callable[[float], Array]) -> Array:
    """Return sunlight (S,) scattered once into the view by air; it crosses higher clouds twice, unscattered."""
    result = np.zeros_like(columns.received)
    if columns.directions.sun is None:
        return result
    lower = [*(slab.top_m for slab in columns.slabs), columns.sea_level_m]
    above = np.stack([np.concatenate([scattered(altitude) for altitude in heights]) for heights in lower])
    through = np.ones_like(result)
    for index, between in enumerate(np.diff(above, axis=0, prepend=0.0)):
        result += through * np.maximum(between, 0.0)
        if index < len(columns.slabs):
            through = through * columns.slabs[index].to_lower_air
    return result * columns.received / columns.directions.mu_sun
