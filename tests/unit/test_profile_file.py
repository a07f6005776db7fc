"""User's profiles and radiosondes: spellings and units, completion, and refusals that name the line."""

import netCDF4
import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.moist_air import relative_humidity, saturation_pressure_Pa
from hcss_twin.models.atmosphere.profile_columns import QUANTITIES, recognised
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.physics.profile import GASES

HEAD = "altitude_km,pressure_hPa,temperature_C,relative_humidity_percent"
ROWS = ["0,1013,15,70", "1,898.8,8.5,60", "2,795,2,55", "4,616.6,-11,40", "8,356.5,-37,30", "12,194,-56.5,10"]


def load(tmp_path, text, name="sonde.csv", **keywords):
    (tmp_path / name).write_text(text, encoding="utf-8")
    return load_profile(name, Catalog(base=tmp_path), **keywords)


def csv(head=HEAD, rows=ROWS):
    return "\n".join([head, *rows]) + "\n"


def refusal(tmp_path, text):
    with pytest.raises(CatalogError) as caught:
        load(tmp_path, text)
    return str(caught.value)


def test_units_in_the_header_are_converted(tmp_path):
    profile = load(tmp_path, csv())
    np.testing.assert_allclose(profile.altitude_m[:6], [0, 1e3, 2e3, 4e3, 8e3, 12e3])
    assert profile.pressure_Pa[0] == pytest.approx(101_300)
    assert profile.temperature_K[5] == pytest.approx(216.65)
    found = relative_humidity(profile.mixing_ratio["h2o"], profile.pressure_Pa, profile.temperature_K)[:6]
    np.testing.assert_allclose(found, [0.7, 0.6, 0.55, 0.4, 0.3, 0.1])


@pytest.mark.parametrize(
    "head",
    [
        "Height [km], Air Pressure (mb), T_degC, RH %",
        "z_km,p_hPa,t_C,rh_%",
        "geometric-altitude_km,air_pressure_mbar,air_temperature_celsius,hur [percent]",
    ],
)
def test_other_spellings_mean_the_same(tmp_path, head):
    one = load(tmp_path, csv())
    if "RH %" in head:
        head = head.replace("RH %", "RH [%]")
    other = load(tmp_path, csv(head))
    np.testing.assert_array_equal(one.pressure_Pa, other.pressure_Pa)
    np.testing.assert_array_equal(one.temperature_K, other.temperature_K)
    np.testing.assert_array_equal(one.mixing_ratio["h2o"], other.mixing_ratio["h2o"])


def test_every_quantity_is_recognised_by_every_spelling_and_unit():
    for quantity in QUANTITIES.values():
        for spelling in quantity.spellings:
            for unit in quantity.units:
                assert recognised(f"{spelling}_{unit}") == (quantity, quantity.units[unit])
                assert recognised(f"{spelling.upper()} [{unit}]") == (quantity, quantity.units[unit])


def test_five_ways_of_giving_humidity_agree(tmp_path):
    pressure, temperature, humidity = 90_000.0, 283.15, 0.6
    vapour = humidity * float(saturation_pressure_Pa(temperature))
    mass = 0.62198 * vapour / (pressure - vapour)
    # Dew point by bisection, so that no inverse formula is shared with the program.
    low, high = 250.0, 283.15
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if float(saturation_pressure_Pa(middle)) < vapour else (low, middle)
    given = {
        "relative_humidity_percent": 100 * humidity,
        "dewpoint_K": low,
        "mixing_ratio_g_kg": 1e3 * mass,
        "specific_humidity_kg_kg": mass / (1 + mass),
        "h2o_ppmv": 1e6 * vapour / pressure,
    }
    for head, value in given.items():
        rows = [f"90000,283.15,{value!r}", "50000,260,0" if "dew" not in head else "50000,260,200"]
        profile = load(tmp_path, csv(f"pressure_Pa,temperature_K,{head}", rows))
        assert profile.mixing_ratio["h2o"][0] == pytest.approx(vapour / pressure, rel=2e-5), head


def test_a_second_humidity_is_set_aside_and_said(tmp_path):
    rows = [f"{row},0.00001" for row in ROWS]
    profile = load(tmp_path, csv(f"{HEAD},h2o", rows))
    assert np.all(profile.mixing_ratio["h2o"][:6] == 0.00001)
    assert any("columns not used: relative_humidity" in note for note in profile.notes)


def test_wind_and_time_of_a_sounding_are_passed_over(tmp_path):
    rows = [f"{row},{10 * index},5,270" for index, row in enumerate(ROWS)]
    assert load(tmp_path, csv(f"{HEAD},time_s,wind_speed_m_s,wind_direction_deg", rows)).altitude_m.size > 6


def test_what_a_file_leaves_out_comes_from_the_model_and_is_said(tmp_path):
    profile = load(tmp_path, csv())
    standard = load_profile("us-standard-1976", Catalog())
    assert profile.altitude_m[0] == 0
    assert profile.altitude_m[-1] == standard.altitude_m[-1]
    assert np.all(np.diff(profile.altitude_m) > 0)
    assert np.all(np.diff(profile.pressure_Pa) < 0)
    assert set(profile.mixing_ratio) == set(GASES)
    above = profile.altitude_m > 12_000
    np.testing.assert_array_equal(profile.temperature_K[above], standard.temperature_K[standard.altitude_m >= 13_000])
    # Temperatures agree with the standard's, so pressures must go on as the standard's do.
    ratio = profile.pressure_Pa[above] / standard.pressure_Pa[standard.altitude_m >= 13_000]
    np.testing.assert_allclose(ratio, 1.0, atol=2e-3)
    np.testing.assert_allclose(profile.mixing_ratio["co2"], 3.3e-4, rtol=0.9)
    assert any("above 12 km from 'us-standard-1976'" in note for note in profile.notes)
    assert any("co2, o3" in note and "from 'us-standard-1976'" in note for note in profile.notes)


def test_another_model_completes_where_it_is_named(tmp_path):
    profile = load(tmp_path, csv(), above="subarctic-winter")
    winter = load_profile("subarctic-winter", Catalog())
    assert float(profile.temperature_at(50_000.0)) == pytest.approx(float(winter.temperature_at(50_000.0)))
    assert any("'subarctic-winter'" in note for note in profile.notes)


def test_a_short_profile_cannot_complete_another(tmp_path):
    (tmp_path / "short.csv").write_text(csv(), encoding="utf-8")
    with pytest.raises(CatalogError, match=r"short\.csv' cannot complete 'sonde\.csv'"):
        load(tmp_path, csv(), above="short.csv")


def test_a_given_gas_is_kept_and_whole_models_need_no_completion(tmp_path):
    rows = [f"{row},420" for row in ROWS]
    assert load(tmp_path, csv(f"{HEAD},co2_ppmv", rows)).mixing_ratio["co2"][0] == pytest.approx(4.2e-4)
    for name in Catalog().names("atmospheres", ".csv"):
        assert load_profile(name, Catalog()).notes == ()


def test_a_profile_from_deck_height_is_continued_to_the_sea(tmp_path):
    rows = ["0.1,1000,10,80", *ROWS[1:]]
    profile = load(tmp_path, csv(rows=rows))
    assert profile.altitude_m[0] == 0.0
    assert profile.temperature_K[0] == pytest.approx(283.15 + 0.65)
    # 8 m per hPa near the surface.
    assert profile.pressure_Pa[0] == pytest.approx(100_000 * np.exp(100 / 8300), rel=1e-4)
    assert any("continued from 100 m down to the sea" in note for note in profile.notes)


def test_thousands_of_levels_are_thinned_within_the_stated_tolerance(tmp_path):
    altitude = np.arange(0, 25_000, 5.0)
    temperature = np.maximum(288.15 - 0.0065 * altitude, 216.65) + 1.5 * np.sin(altitude / 900)
    temperature[altitude < 600] -= (600 - altitude[altitude < 600]) * 0.004
    humidity = 60 * np.exp(-altitude / 6000) * (1 + 0.3 * np.sin(altitude / 500))
    pressure = [1013.25]
    for index in range(1, altitude.size):
        mean = 0.5 * (temperature[index] + temperature[index - 1])
        pressure.append(pressure[-1] * np.exp(-5.0 * 9.80665 / (287.05 * mean)))
    rows = [
        f"{z},{p:.5f},{t:.4f},{rh:.4f}" for z, p, t, rh in zip(altitude, pressure, temperature, humidity, strict=True)
    ]
    profile = load(tmp_path, csv("altitude_m,pressure_hPa,temperature_K,rh_percent", rows))
    assert 30 < np.count_nonzero(profile.altitude_m <= 25_000) < 600
    assert np.max(np.abs(profile.temperature_at(altitude) - temperature)) <= 0.2 + 1e-9
    np.testing.assert_allclose(profile.pressure_at(altitude), 100 * np.array(pressure), rtol=2.1e-4)
    assert any("levels kept" in note for note in profile.notes)


@pytest.mark.parametrize("missing", ["", "nan"])
def test_a_level_without_a_value_is_left_out_and_told(tmp_path, missing):
    profile = load(tmp_path, csv(rows=[*ROWS[:2], f"2,795,2,{missing}", *ROWS[3:]]))
    without = load(tmp_path, csv(rows=[*ROWS[:2], *ROWS[3:]]))
    np.testing.assert_array_equal(profile.temperature_K, without.temperature_K)
    assert "profile 'sonde.csv': 1 levels without a value not used (line 4)" in profile.notes


def test_levels_may_come_from_the_top_down(tmp_path):
    np.testing.assert_array_equal(
        load(tmp_path, csv(rows=ROWS[::-1])).temperature_K, load(tmp_path, csv()).temperature_K
    )


class TestRefusals:
    @pytest.mark.parametrize("bad", ["inf", "-9999", "9999", "warm"])
    def test_impossible_temperature(self, tmp_path, bad):
        text = refusal(tmp_path, csv(rows=[*ROWS[:2], f"2,795,{bad},55", *ROWS[3:]]))
        assert "line 4" in text
        assert "temperature_C" in text
        assert bad in text

    def test_limits_are_told_in_the_unit_of_the_file(self, tmp_path):
        assert "allowed: -173.15 to 1226.85" in refusal(tmp_path, csv(rows=[*ROWS[:2], "2,795,-999,55", *ROWS[3:]]))

    def test_supersaturation_names_the_level_and_the_amount(self, tmp_path):
        text = refusal(tmp_path, csv(rows=[*ROWS[:3], "4,616.6,-11,108", *ROWS[4:]]))
        assert "line 5" in text
        assert "108.0 % over water" in text
        assert "105 %" in text
        load(tmp_path, csv(rows=[*ROWS[:3], "4,616.6,-11,104.9", *ROWS[4:]]))

    def test_unsorted_levels(self, tmp_path):
        text = refusal(tmp_path, csv(rows=[*ROWS[:2], ROWS[3], ROWS[2], *ROWS[4:]]))
        assert "line 5" in text
        assert "795 hPa" in text

    def test_altitude_that_does_not_rise(self, tmp_path):
        text = refusal(tmp_path, csv(rows=[*ROWS[:2], "1,795,2,55", *ROWS[3:]]))
        assert "line 4" in text
        assert "does not exceed" in text

    def test_a_gap_of_more_than_5_km_below_15_km(self, tmp_path):
        text = refusal(tmp_path, csv(rows=[ROWS[0], ROWS[1], "6.5,440.6,-27,30", ROWS[5]]))
        assert "line 4" in text
        assert "5.5 km" in text

    def test_pressure_in_another_unit_than_the_header_says(self, tmp_path):
        text = refusal(tmp_path, csv("altitude_ft,pressure_hPa,temperature_C,relative_humidity_percent"))
        assert "altitude" in text
        text = refusal(tmp_path, csv(rows=["0,1013,15,70", "1,98.8,8.5,60", "2,79.5,2,55"]))
        assert "line 3" in text
        assert "check the units" in text

    def test_a_column_without_unit(self, tmp_path):
        text = refusal(tmp_path, csv("altitude_km,pressure,temperature_C,rh_percent"))
        assert "'pressure' has no unit" in text
        assert "hpa" in text

    def test_an_unknown_unit_and_an_unknown_column(self, tmp_path):
        assert "closest is 'degc'" in refusal(tmp_path, csv(HEAD.replace("_C", "_degCC")))
        assert "closest is 'temperature'" in refusal(tmp_path, csv(HEAD.replace("temperature", "temprature")))

    def test_missing_quantities(self, tmp_path):
        assert "humidity is missing" in refusal(tmp_path, csv("altitude_km,pressure_hPa,temperature_C,wind_speed_m_s"))
        assert "temperature is missing" in refusal(tmp_path, csv("altitude_km,pressure_hPa,wind_from_deg,rh_percent"))

    def test_the_same_quantity_twice(self, tmp_path):
        text = refusal(tmp_path, csv("altitude_km,pressure_hPa,temperature_C,T_K"))
        assert "'temperature_C' and 'T_K' both hold temperature" in text

    def test_fields_and_rows(self, tmp_path):
        assert "line 3: 3 fields, the header has 4" in refusal(tmp_path, csv(rows=[ROWS[0], "1,898,8"]))
        assert "at least 2" in refusal(tmp_path, csv(rows=ROWS[:1]))
        assert "no row of column names" in refusal(tmp_path, "# nothing\n")

    def test_a_launch_from_a_mountain(self, tmp_path):
        assert "lowest level is at 1000 m" in refusal(tmp_path, csv(rows=ROWS[1:]))
        rows = [row.split(",", 1)[1] for row in ROWS[2:]]
        text = refusal(tmp_path, csv(HEAD.split(",", 1)[1], rows))
        assert "line 2" in text
        assert "795 hPa" in text
        assert "850 to 1100 hPa" in text


def write_netcdf(path, **changes):
    """The CSV above as CF NetCDF; ``changes`` replace values or units by variable."""
    table = np.array([[float(field) for field in row.split(",")] for row in ROWS]).T
    variables = {
        "z": ("altitude", "km", table[0]),
        "plev": ("air_pressure", "hPa", table[1]),
        "temp": ("air_temperature", "degC", table[2]),
        "hum": ("relative_humidity", "%", table[3]),
    }
    with netCDF4.Dataset(path, "w") as dataset:
        dataset.createDimension("time", 1)
        dataset.createDimension("level", table.shape[1])
        dataset.createVariable("wind", "f8", ("level",))[:] = 5.0
        for name, (standard_name, units, values) in variables.items():
            variable = dataset.createVariable(name, "f8", ("time", "level"), fill_value=-999.0)
            variable.standard_name = standard_name
            variable.units = changes.get(f"{name}_units", units)
            variable[0] = changes.get(name, values)


class TestNetCDF:
    def test_netcdf_and_csv_give_the_same_profile(self, tmp_path):
        write_netcdf(tmp_path / "sonde.nc")
        one, other = load(tmp_path, csv()), load_profile("sonde.nc", Catalog(base=tmp_path))
        np.testing.assert_allclose(one.altitude_m, other.altitude_m)
        np.testing.assert_allclose(one.pressure_Pa, other.pressure_Pa)
        np.testing.assert_allclose(one.mixing_ratio["h2o"], other.mixing_ratio["h2o"])

    def test_a_missing_value_names_level_and_variable(self, tmp_path):
        write_netcdf(tmp_path / "sonde.nc", hum=np.ma.masked_equal([70, 60, 55, 40, 0, 10], 0))
        with pytest.raises(CatalogError, match=r"level 5: hum is missing"):
            load_profile("sonde.nc", Catalog(base=tmp_path))

    def test_units_are_required_and_checked(self, tmp_path):
        write_netcdf(tmp_path / "sonde.nc", plev_units="furlong")
        with pytest.raises(CatalogError, match=r"'plev': unknown unit 'furlong'"):
            load_profile("sonde.nc", Catalog(base=tmp_path))
        write_netcdf(tmp_path / "sonde.nc", plev_units="")
        with pytest.raises(CatalogError, match=r"'plev' has no unit"):
            load_profile("sonde.nc", Catalog(base=tmp_path))

    def test_not_netcdf(self, tmp_path):
        with pytest.raises(CatalogError, match="not a readable NetCDF file"):
            load(tmp_path, csv(), name="sonde.nc")

    def test_more_than_one_column_of_air(self, tmp_path):
        with netCDF4.Dataset(tmp_path / "many.nc", "w") as dataset:
            dataset.createDimension("x", 3)
            dataset.createDimension("level", 4)
            variable = dataset.createVariable("temperature", "f8", ("x", "level"))
            variable.units = "K"
            variable[:] = 280.0
        with pytest.raises(CatalogError, match=r"shape \(3, 4\)"):
            load_profile("many.nc", Catalog(base=tmp_path))
