"""Construction of the air of a scene: its provider at the image centre, and at other places of the image."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any, cast

import numpy as np

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.core.result_cache import OwnMemory
from hcss_twin.models.parameters import COEFFICIENTS
from hcss_twin.models.radiance.spectral_grid import SpectralBand
from hcss_twin.physics.geodesy import to_geographic
from hcss_twin.physics.profile import Profile
from hcss_twin.plan.air_over_field import AirOverField
from hcss_twin.plan.builder import Builder
from hcss_twin.plan.surroundings import Surroundings, surroundings
from hcss_twin.providers import AtmosphereDeclaration, AtmosphereInputs, TransmittanceProvider
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.section_types import selected

AIRS = 4
"""Number of places of the image whose air is kept in memory."""


def _atmosphere_parameters(scenario: Scenario) -> dict[str, Any]:
    """Return the parameters of the atmosphere provider, with the file of named coefficients."""
    named = scenario.coefficients
    file = {} if named is None else {"file": COEFFICIENTS[named]}
    return {**scenario.atmosphere.parameters, **file}


def build_atmosphere(
    builder: Builder, scenario: Scenario, catalog: Catalog, bands: list[SpectralBand]
) -> tuple[Surroundings | None, TransmittanceProvider | None]:
    """Return air and sea around the scene and the provider; None where a problem was collected."""
    around: Surroundings | None = None
    transmittance: TransmittanceProvider | None = None
    atmosphere = scenario.atmosphere
    with builder.collect_problems("atmosphere.provider", atmosphere.parameters):
        name = selected(atmosphere, "provider")
        parameters = _atmosphere_parameters(scenario)
        around = surroundings(scenario, catalog, builder.bound_profile(name, parameters, catalog))
        inputs = AtmosphereInputs(around.profile, catalog, around.sea_wind_speed_m_s)
        transmittance = builder.build(Kind.ATMOSPHERE, name, inputs, parameters)
        owner = f"atmosphere provider '{name}'"
        require_bands_inside(bands, transmittance.declares.valid, owner)
        _require_view_inside(scenario, transmittance.declares, owner)
    return around, transmittance


def memory_of_air(builder: Builder, around: Surroundings, catalog: Catalog) -> OwnMemory:
    """Return where scenes with the same air keep it; a single scene keeps small arrays only, for its views."""
    if catalog.shelf.air is None:
        return OwnMemory(None, b"", {})
    built, profile = builder.built[str(Kind.ATMOSPHERE)], around.profile
    code = built.code(catalog.shelf)
    gases = sorted(profile.mixing_ratio)
    parts = code, built.parameters, around.sea_wind_speed_m_s, sorted(catalog.used.items()), profile.name, gases
    content = hashlib.sha256(repr(parts).encode())
    arrays = profile.altitude_m, profile.pressure_Pa, profile.temperature_K
    for array in (*arrays, *(profile.mixing_ratio[gas] for gas in gases)):
        content.update(array.tobytes())
    key = content.digest()
    return OwnMemory(catalog.shelf.air, key, catalog.shelf.get_or_compute(("air", key), dict))


def air_with_provider(
    builder: Builder, scenario: Scenario, catalog: Catalog, around: Surroundings, profile: Profile
) -> AirOverField.Air:
    """Return air of another profile, with the provider of the scenario."""
    name, parameters = selected(scenario.atmosphere, "provider"), _atmosphere_parameters(scenario)
    inputs = AtmosphereInputs(profile, catalog, around.sea_wind_speed_m_s)
    return AirOverField.Air(profile, builder.build(Kind.ATMOSPHERE, name, inputs, parameters))


def build_air_over_field(
    builder: Builder, scenario: Scenario, catalog: Catalog, around: Surroundings, transmittance: TransmittanceProvider
) -> AirOverField:
    """Return the air over the image.

    Raises
    ------
    CatalogError
        If the profiles do not cover the image, or one of those needed is invalid.
    """
    field, place, grid = around.field, scenario.place, scenario.image
    centre_deg, centre = (place.latitude, place.longitude), AirOverField.Air(around.profile, transmittance)
    if field is None:
        everywhere = replace(centre, memory=memory_of_air(builder, around, catalog))
        return AirOverField(centre_deg, lambda *_: everywhere, lambda: iter(()), varies=False)

    def with_provider(profile: Profile) -> AirOverField.Air:
        return air_with_provider(builder, scenario, catalog, around, around.finished(profile))

    @lru_cache(maxsize=AIRS)
    def at(latitude_deg: float, longitude_deg: float) -> AirOverField.Air:
        if (latitude_deg, longitude_deg) == centre_deg:
            return centre
        return with_provider(field.at(latitude_deg, longitude_deg))

    def left_out() -> Iterator[tuple[float, AirOverField.Air, AirOverField.Air]]:
        for factor, exact, guess in field.left_out(*centre_deg):
            yield factor, with_provider(exact), with_provider(guess)

    x, y = (0.5 * grid.pixel_size * count * np.array([-1.0, 0.0, 1.0]) for count in (grid.columns, grid.rows))
    east, north = (coordinates.ravel() for coordinates in np.meshgrid(x, y))
    for latitude, longitude in zip(
        *(angles_deg.tolist() for angles_deg in to_geographic(east, north, *centre_deg)), strict=True
    ):
        field.at(latitude, longitude)
    return AirOverField(centre_deg, cast(Callable[[float, float], AirOverField.Air], at), left_out)


def require_bands_inside(bands: list[SpectralBand], ranges: Mapping[str, tuple[float, float]], owner: str) -> None:
    """Raise ScenarioError with the bands that are outside the range of a provider."""
    valid = ranges.get("wavenumber_cm1")
    if valid is None:
        return
    shortest, longest = 1e4 / valid[1], 1e4 / valid[0]
    # Wavelength limits computed from round wavenumbers do not convert back exactly.
    slack = 1e-9
    problems = [
        Problem(
            f"bands[{index}]",
            f"'{band.name}', {band.lower_um:g} to {band.upper_um:g} um, is outside what the {owner} "
            f"covers; allowed: {shortest:.5g} to {longest:.5g} um",
        )
        for index, band in enumerate(bands)
        if band.lower_um < shortest * (1 - slack) or band.upper_um > longest * (1 + slack)
    ]
    if problems:
        raise ScenarioError(problems)


def _require_view_inside(scenario: Scenario, declares: AtmosphereDeclaration, owner: str) -> None:
    valid = declares.valid.get("view_zenith")
    if valid is not None and not valid[0] <= scenario.view.zenith <= valid[1]:
        low, high = valid
        raise ScenarioError(
            [
                Problem(
                    "view.zenith",
                    f"{scenario.view.zenith:g} deg; the {owner} allows {low:g} to {high:g}; "
                    f"closest valid choice is {min(max(scenario.view.zenith, low), high):g}",
                )
            ]
        )
