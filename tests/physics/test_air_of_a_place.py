"""Air, sea and altitudes of clouds that follow from place and date, beside published values and measured images."""

import json
import os
import re
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from hcss_twin import Scenario, column_spectra, make_plan
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.models.atmosphere.climatology import Climatology
from hcss_twin.models.atmosphere.marine_air import (
    SurfaceAir,
    condensation_level_m,
    free_troposphere_humidity,
    marine_air,
    surface_air,
    tropopause_m,
)
from hcss_twin.models.atmosphere.moist_air import (
    from_relative_humidity,
    relative_humidity,
    saturation_pressure_Pa,
    water_vapour_column_kg_m2,
)
from hcss_twin.models.atmosphere.present_sea import skin_K, warming_K
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.physics.planck import planck
from hcss_twin.plan.error_budget import ALTITUDE, error_budget

CATALOG = Catalog()
CLIMATE = Climatology(CATALOG)
MONTHS = [datetime(2020, month, 15, tzinfo=UTC) for month in (1, 4, 7, 10)]
SEAS = [
    (-30.0, -20.0),
    (-15.0, -5.0),
    (0.0, -30.0),
    (5.0, 150.0),
    (20.0, -60.0),
    (30.0, -40.0),
    (45.0, -30.0),
    (50.0, 180.0),
]


def air_at(latitude, longitude, time):
    surface = surface_air(CLIMATE, latitude, longitude, time, warming_K(time.year))
    return surface, marine_air(surface, latitude, time, CATALOG)


@pytest.mark.parametrize("place", SEAS)
def test_air_of_a_place_has_the_climatology_at_the_sea_and_is_nowhere_supersaturated(place):
    for time in MONTHS:
        surface, air = air_at(*place, time)
        assert float(air.temperature_K[0]) == pytest.approx(surface.temperature_K, abs=0.01)
        known = CLIMATE.look_up("air_temperature", *place, time).value
        assert surface.temperature_K - known == pytest.approx(warming_K(2020))
        below = air.altitude_m < tropopause_m(air)
        humidity = relative_humidity(air.mixing_ratio["h2o"], air.pressure_Pa, air.temperature_K)
        assert np.all(humidity[below] <= 1.0 + 1e-6)


def test_air_warmer_than_all_model_atmospheres_is_said_to_be_extrapolated():
    """Shares below 0 and above 100 % are how it is computed, not what a reader should have to understand."""
    for kelvin, said in ((301.0, "extrapolated beyond tropical, by"), (297.0, "% midlatitude-summer and")):
        (note,) = marine_air(SurfaceAir(kelvin, 0.02), 20.0, MONTHS[2], CATALOG).notes
        assert said in note
        assert all(0.0 <= float(share) <= 100.0 for share in re.findall(r"(-?\d+) %", note))


def test_vapour_columns_follow_the_published_relation_to_sea_temperature():
    """G. L. Stephens, J. Climate 3, 634 (1990): 17.5 kg m-2 exp(.064 (T - 288 K)), monthly means over the oceans."""
    ratios = []
    for place in SEAS:
        for time in MONTHS:
            sea = CLIMATE.look_up("sea_surface_temperature", *place, time).value + warming_K(2020)
            ratios.append(water_vapour_column_kg_m2(air_at(*place, time)[1]) / (17.5 * np.exp(0.064 * (sea - 288.0))))
    assert np.exp(np.mean(np.log(ratios))) == pytest.approx(1.0, abs=0.15)
    assert np.std(np.log(ratios)) < 0.25


@pytest.mark.parametrize("humidity", [0.5, 0.7, 0.85])
def test_condensation_level_is_that_of_lifted_air(humidity):
    """D. Bolton, Mon. Weather Rev. 108, 1046 (1980), eq 22, with dry adiabatic ascent."""
    kelvin, pressure = 295.0, 101_325.0
    h2o = float(from_relative_humidity(np.array(humidity), np.array(pressure), np.array(kelvin)))
    condensation_K = 1.0 / (1.0 / (kelvin - 55.0) - np.log(humidity) / 2840.0) + 55.0
    lifted_m = (kelvin - condensation_K) / 9.8e-3
    assert condensation_level_m(SurfaceAir(kelvin, h2o), pressure) == pytest.approx(lifted_m, rel=0.05)
    assert condensation_level_m(SurfaceAir(kelvin, float(saturation_pressure_Pa(kelvin) / pressure)), pressure) < 1.0


@pytest.mark.parametrize(
    ("name", "published_m"), [("us-standard-1976", 11_000.0), ("tropical", 17_000.0), ("midlatitude-summer", 13_000.0)]
)
def test_tropopauses_are_those_of_the_model_atmospheres(name, published_m):
    """AFGL-TR-86-0110, tables 1a, 1b, 1f: the level at which temperature stops to fall."""
    assert tropopause_m(load_profile(name, CATALOG)) == pytest.approx(published_m, abs=1000.0)


def test_subtropics_are_drier_aloft_than_the_tropics_and_follow_the_season():
    july, january = MONTHS[2], MONTHS[0]
    assert free_troposphere_humidity(-20.0, july) < 0.5 * free_troposphere_humidity(5.0, july)
    # The dry belt of the north lies farther north in summer (Peixoto and Oort 1996).
    latitudes = np.arange(10.0, 60.0)
    driest = [
        latitudes[np.argmin([free_troposphere_humidity(at, time) for at in latitudes])] for time in (january, july)
    ]
    assert 20.0 <= driest[0] < driest[1] <= 40.0


def test_the_skin_of_the_sea_is_a_few_tenths_colder_in_any_wind():
    """C. J. Donlon et al., J. Climate 15, 353 (2002), eq 2: -.14 K in wind, -.44 K in calm air."""
    assert skin_K(0.0) == pytest.approx(-0.44)
    assert skin_K(30.0) == pytest.approx(-0.14, abs=1e-3)
    assert warming_K(2020) == pytest.approx(0.60)
    assert warming_K(1970) == 0.0


def plan_of(cloud_type, latitude, longitude, air=None, **keys):
    return make_plan(
        Scenario.from_dict(
            {
                "time": "2024-07-15T06:00:00Z",
                "atmosphere": air or {},
                "place": {"latitude": latitude, "longitude": longitude},
                "view": {"zenith": 0.0, "azimuth": 0.0},
                "image": {"rows": 8, "columns": 8, "pixel_size": 200.0},
                "frames": {"count": 1},
                "bands": [[10.3, 11.3]],
                "clouds": {"layers": [{"type": cloud_type, "coverage": 0.5, **keys}]},
                "accuracy": 1e-2,
            }
        )
    )


ALTITUDES = {
    # type, place and date: published base and top, m
    "trade cumulus, Barbados": ("cumulus", (13.0, -59.0), (400.0, 800.0), (1500.0, 2500.0)),
    # RICO and BOMEX: bases 500 to 700 m, tops 1500 to 2500 m (Siebesma et al. 2003; van Zanten et al. 2011)
    "stratocumulus, Chile": ("stratocumulus", (-20.0, -75.0), (700.0, 1200.0), (1000.0, 1600.0)),
    # VOCALS: inversion 1000 m at the coast, 1600 m at 1500 km (Bretherton et al. 2010)
    "stratus, California": ("stratus", (31.5, -121.7), (300.0, 900.0), (700.0, 1050.0)),
    # DYCOMS-II: base 600 m, inversion 840 m (Stevens et al. 2005)
    "stratocumulus, San Nicolas Island": ("stratocumulus", (33.25, -119.5), (200.0, 500.0), (500.0, 750.0)),
    # FIRE: base 250 m, inversion 595 m (Duynkerke et al. 2004)
    "cirrus, tropics": ("cirrus", (5.0, 150.0), (9000.0, 13_000.0), (13_000.0, 16_000.0)),
    "cirrus, 50 north": ("cirrus", (50.0, -30.0), (4000.0, 9000.0), (8000.0, 11_500.0)),
    # CloudSat and CALIPSO: tops 14 to 15 and 9 to 11 km (Sassen et al. 2008)
    "deep convection": ("deep-convection", (5.0, 150.0), (4000.0, 7000.0), (12_000.0, 16_000.0)),
    # anvil tops 12 to 15 km (Yuan and Houze 2010)
}


@pytest.mark.parametrize("name", ALTITUDES)
def test_clouds_lie_where_they_are_measured(name):
    cloud_type, place, bases, tops = ALTITUDES[name]
    (layer,) = plan_of(cloud_type, *place).layers
    assert bases[0] <= layer.base_m <= bases[1]
    assert tops[0] <= layer.top_m <= tops[1]


@pytest.mark.parametrize("place", [(24.0, 62.0), (26.0, 52.0), (-13.0, 131.0), (43.0, 49.0)])
def test_low_clouds_have_room_under_the_inversion_of_dry_coasts(place):
    """There air condenses above usual inversions; DYCOMS-II had 240 m of cloud (Stevens et al. 2005)."""
    (layer,) = plan_of("stratocumulus", *place).layers
    assert layer.top_m - layer.base_m >= 249.0


@pytest.mark.parametrize(
    ("cloud_type", "keys", "name", "unknown"),
    [
        ("stratocumulus", {}, "altitude of low cloud by place", False),
        ("cumulus", {}, ALTITUDE, True),
        ("cirrus", {}, ALTITUDE, True),
        ("cirrus", {"base": 9000.0, "top": 11_000.0}, "", False),
    ],
)
def test_the_budget_counts_altitudes_by_place_and_says_which_are_unmeasured(cloud_type, keys, name, unknown):
    budget = error_budget(plan_of(cloud_type, 13.0, -59.0, **keys))
    ((cell, contributions),) = ((cell, own) for cell, own in budget.contributions.items() if cell[0] == cloud_type)
    assert [each.name for each in contributions if "by place" in each.name] == [name] * bool(name)
    assert (ALTITUDE in budget.unknown(cell)) is unknown


def test_a_given_altitude_goes_before_that_of_the_place_and_takes_the_inversion_with_it():
    plan = plan_of("stratocumulus", -20.0, -75.0, top=900.0)
    (layer,) = plan.layers
    assert (layer.base_m, layer.top_m) == (pytest.approx(554.0, abs=60.0), 900.0)
    profile = plan.assembly.profile
    assert float(profile.temperature_at(1000.0) - profile.temperature_at(900.0)) > 5.0


def test_clouds_in_a_model_atmosphere_begin_where_air_from_the_sea_condenses():
    """That of 1976 has 46 % relative humidity at the ground, whose condensation level is 1450 m."""
    place = (35.0, 150.0)
    bases = [plan_of("cumulus", *place, air).layers[0].base_m for air in (None, {"profile": "us-standard-1976"})]
    assert bases[0] == bases[1] < 800.0


def test_a_base_above_the_inversion_of_the_place_is_refused():
    with pytest.raises(ScenarioError, match=r"base: 2500 m is not below the top; allowed: below 1\d{3}, that of type"):
        plan_of("stratocumulus", -20.0, -75.0, base=2500.0)


def test_no_inversion_where_the_user_gives_the_air_or_switches_it_off():
    for air in ({"profile": "tropical"}, {"inversion": "off"}):
        profile = plan_of("stratocumulus", -20.0, -75.0, air).assembly.profile
        assert np.all(np.diff(profile.temperature_K[profile.altitude_m < 3000.0]) < 0.0)


SEVIRI = Path(os.environ.get("HCSS_SAMPLE_DATA", "")) / "seviri"


@pytest.mark.skipif(not (SEVIRI / "boxes-dev.json").is_file(), reason="needs measured boxes beside the checkout")
@pytest.mark.parametrize(
    ("kind", "cloud_type", "most_K"), [("clear sea", None, 0.3), ("opaque low cloud", "stratocumulus", 1.0)]
)
def test_default_scenes_have_the_temperature_that_a_satellite_measured(kind, cloud_type, most_K):
    boxes = [box for box in json.loads((SEVIRI / "boxes-dev.json").read_text())["boxes"] if box["kind"] == kind]
    off = []
    for box in boxes:
        raw = {
            "time": "2020-09-06T00:45:00Z",
            "place": {"latitude": float(box["latitude"]), "longitude": float(box["longitude"])},
            "view": {"zenith": box["view_zenith_deg"], "azimuth": 0.0},
            "image": {"rows": 8, "columns": 8, "pixel_size": 3000.0},
            "frames": {"count": 1},
            "bands": [{"name": "10.8", "response": str(SEVIRI / "responses" / "IR_108.csv")}],
            "clouds": {"layers": [] if cloud_type is None else [{"type": cloud_type, "coverage": 1.0}]},
            "accuracy": 1e-2,
        }
        spectra = column_spectra(Scenario.from_dict(raw))
        kelvin = np.linspace(200.0, 320.0, 1201)
        band = planck(spectra.wavenumber_cm1[None], kelvin[:, None]) @ spectra.weights_cm1[0]
        off.append(
            np.interp(spectra.weights_cm1[0] @ spectra.radiance[-1], band, kelvin) - box["measured_K"]["10.8 um"]
        )
    assert abs(np.mean(off)) < most_K
