"""The boundary layer of a scene: its inversion, and the levels that clouds follow."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from datetime import UTC

import numpy as np

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, ScenarioError
from hcss_twin.models.atmosphere.climatology import NAME, Climatology
from hcss_twin.models.atmosphere.cloud_top import SURFACE_TEMPERATURE_K
from hcss_twin.models.atmosphere.marine_air import NAME as MARINE_AIR
from hcss_twin.models.atmosphere.marine_air import (
    SurfaceAir,
    condensation_level_m,
    free_troposphere_humidity,
    surface_air,
    tropopause_m,
)
from hcss_twin.models.atmosphere.present_sea import warming_K
from hcss_twin.models.atmosphere.profile_field import ProfileField
from hcss_twin.physics.profile import Profile
from hcss_twin.plan.builder import attribute_to_field
from hcss_twin.plan.filled_in import FilledIn
from hcss_twin.scenario.atmosphere import InversionSection
from hcss_twin.scenario.cloud_types import Level, PlaceLevels, load_cloud_type
from hcss_twin.scenario.clouds import Layer
from hcss_twin.scenario.scenario import Scenario

INVERSION_AT_COAST_M, INVERSION_FAR_OFF_M, COAST_REACH_KM = 600.0, 2100.0, 1000.0
"""Altitude of the inversion at the coast and far from it, and the distance in which 63 % of the rise are reached.

595 m were measured 80 km off California (FIRE 1987: P. G. Duynkerke et al., Q. J. R. Meteorol. Soc. 130, 3269 (2004),
by the public set-up DEPHY-SCM FIRE/MESONH). Value far off and reach were fitted to 10 boxes of low cloud in a SEVIRI
image, which ask for 370 to 2390 m: a standard deviation of 500 m about this law, or 3.0 K of the cloud top."""

LEAST_CLOUD_DEPTH_M = 250.0
"""Room for clouds between the condensation level and the usual inversion.

They were 240 m deep in DYCOMS-II (B. Stevens et al., Mon. Weather Rev. 133, 1443 (2005)), about 350 m in FIRE."""

LOWEST_INVERSION_M, HIGHEST_INVERSION_M = 200.0, 3000.0

USUAL_STRENGTHS_K = (10.0, 8.0, 6.0, 4.0, 2.0, 0.0)
"""The usual jump, and smaller ones where the air above would fall too fast from it."""


FREEZING_K = 273.15


def surface_air_of(scenario: Scenario, climatology: Climatology) -> SurfaceAir:
    """Return the air at the sea of a scene, warmed since the climatology; CatalogError where that has none."""
    place, time = scenario.place, scenario.time
    return surface_air(climatology, place.latitude, place.longitude, time, warming_K(time.astimezone(UTC).year))


def levels_of(scenario: Scenario, catalog: Catalog, profile: Profile, climatology: Climatology) -> PlaceLevels:
    """Return the levels of the air; its inversion lies as the scenario says, at given tops of clouds, or as usual."""
    place, section = scenario.place, scenario.atmosphere.inversion
    under = [layer for layer, level in _that_follow(scenario, catalog) if level == "inversion"]
    tops = [layer.top for layer in under if layer.top is not None]
    lowest = SurfaceAir(float(profile.temperature_K[0]), float(profile.mixing_ratio.get("h2o", np.zeros(1))[0]))
    low = any(level != "tropopause" for _, level in _that_follow(scenario, catalog))
    if low and scenario.atmosphere.profile in SURFACE_TEMPERATURE_K:
        # Model atmospheres are means over land and sea: that of 1976 is so dry that clouds would begin at 1450 m.
        with suppress(CatalogError):
            lowest = surface_air_of(scenario, climatology)
    condensation_m = condensation_level_m(lowest, float(profile.pressure_Pa[0]))
    if isinstance(section, InversionSection):
        inversion_m = section.height
    elif tops:
        inversion_m = max(tops)
    elif not under:  # nothing follows it, and the climatology need not be read
        inversion_m = INVERSION_FAR_OFF_M
    else:
        share = math.exp(-climatology.coast_km(place.latitude, place.longitude) / COAST_REACH_KM)
        inversion_m = round(INVERSION_FAR_OFF_M - (INVERSION_FAR_OFF_M - INVERSION_AT_COAST_M) * share)
        inversion_m = max(inversion_m, round(condensation_m + LEAST_CLOUD_DEPTH_M))
    frozen = np.flatnonzero(profile.temperature_K < FREEZING_K)
    return PlaceLevels(
        condensation_m=condensation_m,
        melting_m=float(profile.altitude_m[max(frozen[0] - 1, 0)]) if frozen.size else 0.0,
        inversion_m=float(inversion_m),
        tropopause_m=tropopause_m(profile),
    )


def _that_follow(scenario: Scenario, catalog: Catalog) -> Iterator[tuple[Layer, Level]]:
    """Yield the layers whose type follows a level of the air, unless the user puts them above any inversion.

    Types that cannot be read are reported with their layer.
    """
    for layer in scenario.clouds.layers:
        with suppress(CatalogError, ScenarioError):
            level = load_cloud_type(layer.type, catalog).layer.level
            if level is not None and not (level == "inversion" and (layer.top or 0.0) > HIGHEST_INVERSION_M):
                yield layer, level


def has_usual_inversion(scenario: Scenario, catalog: Catalog, profile: Profile) -> bool:
    """Whether clouds ask for an inversion in the air of the place, which the scenario leaves as it is."""
    air = scenario.atmosphere
    return (
        profile.name == MARINE_AIR
        and air.inversion is None
        and air.water_vapour_column is None
        and any(level == "inversion" for _, level in _that_follow(scenario, catalog))
    )


def with_usual_inversion(scenario: Scenario, profile: Profile, levels: PlaceLevels, filled: list[FilledIn]) -> Profile:
    """Return the air of the place with the inversion at the top of its clouds, as strong as it usually is or can be."""
    from hcss_twin.models.atmosphere.inversion import with_inversion  # few scenes have one

    height = min(max(levels.inversion_m, LOWEST_INVERSION_M), HIGHEST_INVERSION_M)
    free = round(free_troposphere_humidity(scenario.place.latitude, scenario.time), 3)
    for strength in USUAL_STRENGTHS_K:
        section = InversionSection(
            height=height,
            strength=strength,
            cloud_base=min(levels.condensation_m, height),
            humidity_above=free,
            surface_temperature=None,
        )
        try:
            changed = with_inversion(profile, section, float(profile.temperature_K[0]))
        except CatalogError as error:
            refused = str(error)
        else:
            why = "the clouds lie under one: altitude by the distance from the coast, within 500 m"
            filled.append(FilledIn("atmosphere.inversion", f"{strength:g} K at {height:g} m", why))
            return changed
    filled.append(FilledIn("atmosphere.inversion", "off", refused))
    return profile


def with_inversion_of_scenario(
    scenario: Scenario,
    profile: Profile,
    of_places: ProfileField | None,
    climatology: Climatology,
    filled: list[FilledIn],
) -> Profile:
    """Return the profile with the scenario's inversion, by default over air of the climatology's temperature.

    A profile of several (``of_places``) has its own.
    """
    from hcss_twin.models.atmosphere.inversion import with_inversion  # few scenes have one

    section, field = scenario.atmosphere.inversion, "atmosphere.inversion"
    assert isinstance(section, InversionSection)
    kelvin = section.surface_temperature
    if kelvin is None:
        kelvin, why = float(profile.temperature_K[0]), "of the profile; the climatology has none there"
        if of_places is not None:
            why = "of the profile at the image centre; other places have that of theirs"
        else:
            with suppress(CatalogError):
                kelvin = round(surface_air_of(scenario, climatology).temperature_K, 2)
                why = f"the climatology {NAME}, {warming_K(scenario.time.astimezone(UTC).year):+.2f} K since then"
        filled.append(FilledIn(f"{field}.surface_temperature", f"{kelvin:.2f} K", why))
    with attribute_to_field(f"{field}.strength"):
        return with_inversion(profile, section, kelvin)
