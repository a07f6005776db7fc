"""Air and sea of a scene: values of the scenario, or else of the climatology."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, Problem, ScenarioError
from hcss_twin.models.atmosphere.climatology import NAME, Climate, Climatology
from hcss_twin.models.atmosphere.cloud_top import calendar_model, climatological_cloud_top
from hcss_twin.models.atmosphere.gases import MEANS, amount_note, factor_of, means_of_year, with_factors
from hcss_twin.models.atmosphere.marine_air import marine_air
from hcss_twin.models.atmosphere.moist_air import with_water_vapour
from hcss_twin.models.atmosphere.present_sea import skin_K, warming_K
from hcss_twin.models.atmosphere.profile_field import ProfileField
from hcss_twin.models.atmosphere.profile_file import load_profile, load_profiles
from hcss_twin.models.atmosphere.same_profile import difference
from hcss_twin.physics.profile import Profile
from hcss_twin.plan.boundary_layer import (
    has_usual_inversion,
    levels_of,
    surface_air_of,
    with_inversion_of_scenario,
    with_usual_inversion,
)
from hcss_twin.plan.builder import attribute_to_field
from hcss_twin.plan.errors_of_place import AIR_BY_CLIMATOLOGY, SEA_BY_CLIMATOLOGY
from hcss_twin.plan.filled_in import FilledIn
from hcss_twin.providers import CloudLayer
from hcss_twin.scenario.atmosphere import InversionSection
from hcss_twin.scenario.cloud_types import PlaceLevels
from hcss_twin.scenario.scenario import Scenario

USUAL_AIR_MINUS_SEA_K = (-10.0, 5.0)
"""Air minus sea temperature: 99.8 % of the monthly means of the climatology (COADS, 2 degree cells) lie inside."""


@dataclass(frozen=True)
class Surroundings:
    """Air and sea of a scene.

    Attributes
    ----------
    filled_in : tuple of FilledIn
        Defaults for values that the scenario omits.
    field : ProfileField or None
        Profiles at several places, as given in the file; None for one profile.
    finished : callable
        Applies water vapour, inversion and gases of the scenario to a profile of the field.
    levels : PlaceLevels
        Of the air, for clouds whose altitudes follow them.
    is_bound : bool
        Whether the transmittance provider supports no other profile.
    """

    profile: Profile
    sea_temperature_K: float
    sea_wind_speed_m_s: float
    filled_in: tuple[FilledIn, ...]
    field: ProfileField | None
    finished: Callable[[Profile], Profile]
    levels: PlaceLevels
    is_bound: bool


def surroundings(scenario: Scenario, catalog: Catalog, bound: Profile | None) -> Surroundings:
    """Return profile, sea temperature and sea wind from the scenario, or defaults.

    Parameters
    ----------
    bound : Profile or None
        The only profile that the transmittance provider supports; None if it supports any.

    Raises
    ------
    ScenarioError
        If a profile cannot be read or scaled, or the climatology has no default for an omitted value.
    """
    climatology = Climatology(catalog)
    filled: list[FilledIn] = []
    profile, field = _profile(scenario, catalog, climatology, bound, filled)
    profile = _scaled(scenario, profile, bound)
    levels = levels_of(scenario, catalog, profile, climatology)
    if isinstance(scenario.atmosphere.inversion, InversionSection):
        _refuse_change(scenario, bound, ["atmosphere.inversion"], "temperatures")
        profile = with_inversion_of_scenario(scenario, profile, field, climatology, filled)
    elif has_usual_inversion(scenario, catalog, profile):
        profile = with_usual_inversion(scenario, profile, levels, filled)
    profile = _with_gases(scenario, profile, bound, filled)
    textured = ["atmosphere.water_vapour_texture"] * ((scenario.atmosphere.water_vapour_texture or 0.0) > 0.0)
    _refuse_change(scenario, bound, textured, "water vapour")

    def finished(profile: Profile) -> Profile:
        profile = _scaled(scenario, profile, bound)
        if field is not None and isinstance(scenario.atmosphere.inversion, InversionSection):
            profile = with_inversion_of_scenario(scenario, profile, field, climatology, [])
        return _with_gases(scenario, profile, bound, [])

    temperature, wind = _sea(scenario, climatology, filled)
    return Surroundings(profile, temperature, wind, tuple(filled), field, finished, levels, bound is not None)


def air_unlike_sea(profile: Profile, sea_temperature_K: float) -> tuple[str, ...]:
    """Return a note if the air above the sea is far colder or warmer than the water, as in another season's profile."""
    air = float(profile.temperature_K[0])
    difference = air - sea_temperature_K
    low, high = USUAL_AIR_MINUS_SEA_K
    if low <= difference <= high:
        return ()
    return (
        f"profile '{profile.name}': the air at the surface ({air:.1f} K) is {abs(difference):.1f} K "
        f"{'colder' if difference < 0 else 'warmer'} than the sea ({sea_temperature_K:.1f} K); usual are {low:+g} to "
        f"{high:+g} K: check atmosphere.profile and sea.temperature",
    )


def with_climatological_top(
    layer: CloudLayer, scenario: Scenario, catalog: Catalog, field: str
) -> tuple[CloudLayer, FilledIn]:
    """Return a layer with the climatology's temperature of its top, and that temperature.

    Raises ScenarioError, at the layer's path ``field``, if there is none at this place or altitude.
    """
    place, field = scenario.place, f"{field}.temperature"
    with attribute_to_field(field):
        found = climatological_cloud_top(place.latitude, place.longitude, scenario.time, layer.top_m, catalog)
    kelvin = round(found.temperature_K, 2)
    why = (
        f"air temperature of the climatology {NAME}, cooled as in {found.profile} up to {layer.top_m:g} m; standard "
        f"deviation of this cooling among the model atmospheres {found.scatter_K:.1f} K"
    )
    return replace(layer, temperature_K=kelvin), FilledIn(field, f"{kelvin:.2f} K", why)


def _profile(
    scenario: Scenario, catalog: Catalog, climatology: Climatology, bound: Profile | None, filled: list[FilledIn]
) -> tuple[Profile, ProfileField | None]:
    """Return the profile at the image centre, and those of other places if there are several."""
    atmosphere, field = scenario.atmosphere, "atmosphere.profile"
    with attribute_to_field(field):
        if atmosphere.profile is not None:
            given = load_profiles(atmosphere.profile, catalog, atmosphere.profile_above, scenario.time.astimezone(UTC))
            if isinstance(given, ProfileField):
                centre = scenario.place.latitude, scenario.place.longitude
                given = given.with_levels_near(*centre)
                return _same_air(scenario, given.at(*centre), bound), given
            return _same_air(scenario, given, bound), None
        if bound is not None:
            why = f"the profile that provider '{atmosphere.provider}' belongs to"
            filled.append(FilledIn(field, bound.name, why))
            return bound, None
        try:
            surface = surface_air_of(scenario, climatology)
        except CatalogError:
            # Over land and ice the model atmosphere follows from latitude and season, which are known everywhere.
            name = calendar_model(scenario.place.latitude, scenario.time.astimezone(UTC).month)
            filled.append(FilledIn(field, name, "by latitude and season; the climatology has no air temperature there"))
            return load_profile(name, catalog), None
        profile = marine_air(surface, scenario.place.latitude, scenario.time, catalog)
        why = f"air of this place and date by {NAME} and the model atmospheres"
        filled.append(FilledIn(field, profile.name, why, AIR_BY_CLIMATOLOGY))
        return profile, None


def _same_air(scenario: Scenario, profile: Profile, bound: Profile | None) -> Profile:
    """Return a given profile if the provider supports it."""
    other = "" if bound is None else difference(profile, bound)
    if bound is not None and other:
        message = (
            f"provider '{scenario.atmosphere.provider}' supports only the profile '{bound.name}', and "
            f"'{scenario.atmosphere.profile}' is other air: {other}; allowed: omit the key, or choose a provider that "
            "supports any profile"
        )
        raise ScenarioError([Problem("atmosphere.profile", message)])
    return profile


def _scaled(scenario: Scenario, profile: Profile, bound: Profile | None) -> Profile:
    atmosphere = scenario.atmosphere
    factor, column = atmosphere.water_vapour_scale, atmosphere.water_vapour_column
    if factor is None and column is None:
        return profile
    field = f"atmosphere.{'water_vapour_column' if factor is None else 'water_vapour_scale'}"
    _refuse_change(scenario, bound, [field], "water vapour")
    with attribute_to_field(field):
        return with_water_vapour(profile, factor=factor, column_kg_m2=column)


def _with_gases(scenario: Scenario, profile: Profile, bound: Profile | None, filled: list[FilledIn]) -> Profile:
    """Return the profile with the given amounts of gases, and with the means of the scene's year."""
    section, field = scenario.atmosphere.gases, "atmosphere.gases"
    given = section.given()
    asked = [*map(str.upper, given), *["others"] * section.asks_for_year]
    _refuse_change(scenario, bound, [f"{field}.{name}" for name in asked], "gases")
    if bound is not None:
        return profile
    factors: dict[str, float] = {}
    for gas, amount in given.items():
        with attribute_to_field(f"{field}.{gas.upper()}"):
            factors[gas] = factor_of(profile, gas, amount)
    if factors:
        profile = with_factors(profile, factors)
        profile = replace(profile, notes=(*profile.notes, amount_note(profile, factors)))
    if section.others == "profile":
        return profile
    year = scenario.time.astimezone(UTC).year
    means = {gas: mean for gas, mean in means_of_year(year).items() if gas in profile.model_gases - set(given)}
    if not means:
        return profile
    factors = {gas: mean / float(profile.mixing_ratio[gas][0]) for gas, mean in means.items()}
    known = min(max(year, min(MEANS)), max(MEANS))
    why = f"global means of {known}" + ("" if known == year else f", the year closest to {year} with known means")
    values = ", ".join(f"{gas.upper()} {1e6 * mean:.4g}" for gas, mean in means.items()) + " ppm"
    filled.append(FilledIn(field, values, f"{why}, NOAA"))
    return with_factors(profile, factors)


def _refuse_change(scenario: Scenario, bound: Profile | None, fields: list[str], what: str) -> None:
    """Raise an error if keys change the only profile that a provider supports."""
    if bound is not None and fields:
        message = (
            f"provider '{scenario.atmosphere.provider}' supports only the profile '{bound.name}' with its {what}; "
            "allowed: omit the key, or choose a provider that supports any profile"
        )
        raise ScenarioError([Problem(field, message) for field in fields])


def _sea(scenario: Scenario, climatology: Climatology, filled: list[FilledIn]) -> tuple[float, float]:
    """Return temperature and wind of the sea, K and m/s; the climatology's where the scenario says nothing."""
    place, problems = scenario.place, []
    found: dict[str, Climate] = {}
    for key, quantity in (("temperature", "sea_surface_temperature"), ("wind_speed", "wind_speed")):
        if getattr(scenario.sea, key) is None:
            try:
                found[key] = climatology.look_up(quantity, place.latitude, place.longitude, scenario.time)
            except CatalogError as error:
                problems.append(Problem(f"sea.{key}", str(error)))
    if problems:
        raise ScenarioError(problems)
    temperature, wind = scenario.sea.temperature, scenario.sea.wind_speed
    if wind is None:
        climate = found["wind_speed"]
        wind = climate.value
        filled.append(FilledIn("sea.wind_speed", f"{wind:.2f} m/s", _source(scenario, climate)))
    if temperature is None:
        climate = found["temperature"]
        warmer, skin = warming_K(scenario.time.astimezone(UTC).year), skin_K(wind)
        temperature = climate.value + warmer + skin
        why = f"{_source(scenario, climate)}, {warmer:+.2f} K since then, {skin:+.2f} K from the water to its surface"
        filled.append(FilledIn("sea.temperature", f"{temperature:.2f} K", why, SEA_BY_CLIMATOLOGY))
    return temperature, wind


def _source(scenario: Scenario, climate: Climate) -> str:
    day = scenario.time.astimezone(UTC)
    text = f"the climatology {NAME}, {day:%B} {day.day}"
    return f"{text}, from reports {climate.distance_km:.0f} km away" if climate.distance_km else text
