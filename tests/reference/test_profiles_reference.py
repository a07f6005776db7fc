"""Profiles, water vapour and climatology against published figures."""

from datetime import UTC, datetime

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.climatology import Climatology
from hcss_twin.models.atmosphere.moist_air import (
    altitude_of_pressure,
    saturation_pressure_Pa,
    water_vapour_column_kg_m2,
)
from hcss_twin.models.atmosphere.profile_file import load_profile

# Surface temperature (K) and column water vapour (g cm-2) of the AFGL models as tabulated with LOWTRAN7 and MODTRAN;
# tropopause: coldest level below 20 km (km).
AFGL = {
    "tropical": (299.7, 4.11, 17),
    "midlatitude-summer": (294.2, 2.92, 14),
    "midlatitude-winter": (272.2, 0.85, 19),
    "subarctic-summer": (287.2, 2.08, 12),
    "subarctic-winter": (257.2, 0.42, 19),
    "us-standard-1976": (288.2, 1.42, 20),
}


@pytest.mark.parametrize("name", AFGL)
def test_afgl_surface_temperature_and_column_water(name):
    profile = load_profile(name, Catalog())
    temperature, water, _ = AFGL[name]
    assert profile.temperature_K[0] == temperature
    assert water_vapour_column_kg_m2(profile) / 10 == pytest.approx(water, abs=0.012)
    assert profile.altitude_m.size == 50
    assert profile.altitude_m[-1] == 120_000


@pytest.mark.parametrize("name", AFGL)
def test_afgl_heights_follow_from_pressure_and_temperature(name):
    profile = load_profile(name, Catalog())
    low = profile.altitude_m <= 30_000
    found = altitude_of_pressure(profile.pressure_Pa[low], profile.temperature_K[low], profile.mixing_ratio["h2o"][low])
    # The models' pressures have four digits and their levels are 1 km apart.
    np.testing.assert_allclose(found, profile.altitude_m[low], atol=65)


def test_saturation_over_water():
    """Murphy and Koop (2005), table C1."""
    kelvin = [180.0, 210.0, 240.0, 273.15, 273.16, 300.0]
    pascal = [0.011239, 1.2335, 37.667, 611.213, 611.657, 3536.8]
    np.testing.assert_allclose(saturation_pressure_Pa(np.array(kelvin)), pascal, rtol=5e-5)


def test_heights_of_the_standard_atmosphere():
    """U.S. Standard Atmosphere (1976): geopotential 11, 20, 32, 47, 51, 71 km; table I gives geometric altitudes."""
    pressure = np.array([101325.0, 22632.06, 5474.889, 868.0187, 110.9063, 66.93887, 3.956420])
    temperature = np.array([288.15, 216.65, 216.65, 228.65, 270.65, 270.65, 214.65])
    geometric = np.array([0, 11_019, 20_063, 32_162, 47_350, 51_413, 71_802])
    # Between the base levels temperature is linear in geopotential height: fill in the nodes.
    fine_p, fine_t = [pressure[0]], [temperature[0]]
    for low in range(6):
        t = np.linspace(temperature[low], temperature[low + 1], 60)[1:]
        if temperature[low] == temperature[low + 1]:
            p = np.geomspace(pressure[low], pressure[low + 1], 60)[1:]
        else:
            power = np.log(pressure[low + 1] / pressure[low]) / np.log(temperature[low + 1] / temperature[low])
            p = pressure[low] * (t / temperature[low]) ** power
        fine_p.extend(p)
        fine_t.extend(t)
    found = altitude_of_pressure(np.array(fine_p), np.array(fine_t), np.zeros(len(fine_p)))
    np.testing.assert_allclose(found[::59], geometric, atol=6)


# Annual mean temperature of the surface water in the climatological atlas of Levitus (1982), 1 degree cells: another
# compilation (hydrographic casts and bathythermographs, not ships' reports).
LEVITUS_C = {
    (0.5, 180.5): 28.00,
    (35.5, 150.5): 20.14,
    (40.5, -150.5): 14.64,
    (60.5, 0.5): 9.53,
    (50.5, -30.5): 11.78,
    (25.5, -45.5): 24.45,
    (-20.5, -90.5): 21.21,
    (-40.5, 100.5): 12.04,
    (10.5, 65.5): 28.31,
    (36.5, 18.5): 19.95,
}


@pytest.mark.parametrize("place", LEVITUS_C)
def test_annual_mean_sea_temperature_against_another_atlas(place):
    climatology = Climatology(Catalog())
    months = [datetime(2023, month, 15, 12, tzinfo=UTC) for month in range(1, 13)]
    mean = np.mean([climatology.look_up("sea_surface_temperature", *place, time).value for time in months]) - 273.15
    assert mean == pytest.approx(LEVITUS_C[place], abs=0.6)


def test_seasons_of_the_north_sea_and_the_north_atlantic_wind():
    """North of Shetland the sea is coldest in March, near 7 degC, and warmest in August, near 13 degC."""
    climatology = Climatology(Catalog())
    times = [datetime(2023, month, 15, 12, tzinfo=UTC) for month in range(1, 13)]
    sea = [climatology.look_up("sea_surface_temperature", 60, 0, time).value - 273.15 for time in times]
    assert int(np.argmin(sea)) + 1 == 3
    assert int(np.argmax(sea)) + 1 == 8
    assert min(sea) == pytest.approx(7, abs=0.5)
    assert max(sea) == pytest.approx(13, abs=0.5)
    wind = [climatology.look_up("wind_speed", 60, 0, time).value for time in times]
    assert wind[0] > 9
    assert wind[6] < 7
