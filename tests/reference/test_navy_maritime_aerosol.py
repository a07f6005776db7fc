"""The wind-dependent Navy maritime aerosol, against the LOWTRAN7 Fortran program and Mie theory."""

from pathlib import Path

import netCDF4
import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog, catalog_root
from hcss_twin.core.errors import ProviderError
from hcss_twin.models.atmosphere.band_model.navy_maritime import SeaAir, coefficients_km1, read_navy_maritime
from hcss_twin.models.atmosphere.band_model.provider import BandModelTransmittance
from hcss_twin.models.optics.spheres import mie_efficiencies
from hcss_twin.models.parameters import BandModelParameters
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.profile import GASES, Profile
from hcss_twin.providers import AtmosphereInputs

FORTRAN = Path(__file__).parent.parent / "data" / "navy-maritime-lowtran7.csv"
CATALOG = Catalog()
TABLES = read_navy_maritime(CATALOG.find("navy-maritime", "atmospheres", ".nc"))


def lowtran7_profile(model):
    """Model atmosphere of LOWTRAN7 at its levels."""
    with netCDF4.Dataset(catalog_root() / "atmospheres" / "lowtran7-band-model.nc") as file:
        file.set_auto_mask(False)
        with netCDF4.Dataset(FORTRAN.parent / "lowtran7-reference.nc") as levels:
            at = np.searchsorted(file["altitude_km"][:], levels["level_altitude_km"][:])
        column = {name: np.asarray(file[name][model - 1], float)[at] for name in ("pressure_mb", "temperature_K")}
        gases = {gas: 1e-6 * np.asarray(file[f"{gas}_ppmv"][model - 1], float)[at] for gas in GASES}
        altitude = 1e3 * np.asarray(file["altitude_km"][:], float)[at]
    return Profile(f"model {model}", altitude, 100.0 * column["pressure_mb"], column["temperature_K"], gases)


def provider(model=6, wind=7.0, **parameters):
    inputs = AtmosphereInputs(lowtran7_profile(model), CATALOG, wind)
    return BandModelTransmittance(
        inputs, BandModelParameters(file="lowtran7-band-model", aerosol="navy-maritime", **parameters)
    )


def test_transmittance_is_that_of_the_fortran():
    table = np.loadtxt(FORTRAN, delimiter=",")
    cases = FORTRAN.read_text().splitlines()[2].lstrip("# ").split(", ")
    for case, expected in zip(cases, table.T[1:], strict=True):
        model, visibility, wind, day, character = (float(value) for value in case.split("/"))
        own = provider(
            int(model),
            wind,
            visibility_km=visibility or None,
            wind_24h_m_s=day,
            air_mass_character=int(character),
            season="fall-winter" if model == 3 else "spring-summer",
            earth_radius_m=6_378_390.0 if model == 1 else 6_371_230.0,
        )
        found = own.transmittance(table[:, 0], [to_space(0.0, 60.0)])[0]
        np.testing.assert_allclose(found, expected, atol=1e-4, err_msg=case)


@pytest.mark.parametrize(("mode", "radius_um"), [(1, 0.24), (2, 2.0)])
def test_size_modes_and_their_growth_are_those_of_mie_theory(mode, radius_um):
    # At 98 % humidity the droplets are nearly pure water, whose refractive index is independent of the tables.
    growth = ((2.0 - 0.98) / (6.0 * (1.0 - 0.98))) ** (1.0 / 3.0)
    x, weight = np.polynomial.legendre.leggauss(200)
    radius, number = growth * radius_um * np.exp(4.0 * x), 4.0 * weight * np.exp(-16.0 * x**2)
    for um in (0.55, 2.5, 3.75, 4.5, 5.0, 8.7, 12.5):
        index = complex(load_refractive_index(CATALOG, "water").at(np.array([1e4 / um]))[0])
        extinction, _, _ = mie_efficiencies(np.full(radius.size, index), 2.0 * np.pi / um * radius)
        column = int(np.argmin(np.abs(TABLES.wavelength_um - um)))
        expected = 10.0 ** TABLES.log10["extinction"][mode, column, 3]
        # Within 1 %, except for the small mode around 9 um, where salt absorbs.
        np.testing.assert_allclose(np.sum(number * extinction * radius**3), expected, rtol=0.05)


def test_salt_and_only_salt_follows_the_wind():
    wavenumber = 1e4 / np.array([12.0, 10.6, 4.0, 3.5])
    path = [to_space(0.0, 60.0)]
    calm, windy = (provider(wind=wind, wind_24h_m_s=5.0).transmittance(wavenumber, path)[0] for wind in (2.0, 18.0))
    assert np.all(windy < calm)
    # Fresh salt alone: the third amplitude grows as 10^(0.06 wind), and optical depths are linear in it.
    at = {wind: coefficients_km1(TABLES, SeaAir(wind, 5.0, 80.0, 3))["extinction"] for wind in (2.0, 10.0, 18.0)}
    ratio = (at[18.0] - at[10.0]) / (at[10.0] - at[2.0])
    np.testing.assert_allclose(ratio, 10.0 ** (0.06 * 8.0), rtol=1e-9)


def test_without_its_wind_or_beyond_it_the_aerosol_is_refused():
    with pytest.raises(ProviderError, match="needs a wind speed"):
        provider(wind=None)
    with pytest.raises(ProviderError, match=r"sea\.wind_speed is 21 m/s.*allows 0 to 20 m/s"):
        provider(wind=21.0)
    moist = lowtran7_profile(1)
    moist.mixing_ratio["h2o"][0] *= 1.3
    parameters = BandModelParameters(aerosol="navy-maritime", wind_24h_m_s=20.0, air_mass_character=10)
    with pytest.raises(ProviderError, match=r"visibility of .* km; allowed: 2 km or more"):
        BandModelTransmittance(AtmosphereInputs(moist, CATALOG, 20.0), parameters)
    with pytest.raises(ValueError, match="air_mass_character 3 has no effect with aerosol 'maritime'"):
        BandModelParameters(air_mass_character=3)
