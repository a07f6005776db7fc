"""Cases from soundings: what is read, what is estimated, what is refused."""

import netCDF4
import numpy as np
import pytest
from click.testing import CliRunner
from hcss_skies.command import skies
from hcss_skies.les.model import Model
from hcss_skies.les.run import remarks
from hcss_skies.les.sounding import case_of_sounding, read_sounding

from hcss_twin.providers import CatalogError

TRADES = "height_m,theta_K,water_g_kg,u_m_s,v_m_s\n0,298.7,17,-8,0\n520,298.7,16.3,-8,0\n1480,302.4,10.7,-7,0\n" \
    "2000,308.2,4.2,-6,0\n3000,311.85,3,-4,0\n"  # fmt: skip
STRATUS = "height_m,theta_K,water_g_kg\n0,289,9\n840,289,9\n850,297.5,1.5\n1500,303,1.5\n3000,310,1.5\n"


@pytest.fixture
def sounding(tmp_path):
    def of(text, wind=None):
        path = tmp_path / "mine.csv"
        path.write_text(text, encoding="utf-8")
        return read_sounding(path, 101500.0, wind)

    return of


def test_the_inversion_is_the_steepest_rise(sounding):
    assert sounding(TRADES).inversion_m == pytest.approx(1740.0, abs=20.0)
    assert sounding(STRATUS, (7.0, -5.5)).inversion_m == pytest.approx(845.0, abs=60.0)


def test_temperature_and_humidity_say_the_same_as_theta_and_water(sounding):
    one = sounding(STRATUS, (0.0, 0.0))
    exner = 1.0 - 9.81 * 840.0 / (1005.0 * 289.0) + (1.015 ** (287.04 / 1005.0) - 1.0)
    lines = ["height_m,temperature_K,relative_humidity"]
    heights = (0.0, 840.0, 850.0, 1500.0, 3000.0)
    first = 289.0 * 1.015 ** (287.04 / 1005.0), 289.0 * exner
    kelvin = [*first, 289.5, 287.0, 280.0]
    # total water in cloud is above saturation, humidity is not
    lines += [f"{h},{t:.6f},{min(rh, 1.0):.6f}" for h, t, rh in zip(heights, kelvin, one.humidity, strict=True)]
    other = sounding("\n".join(lines), (0.0, 0.0))
    np.testing.assert_allclose(other.theta_K[:2], one.theta_K[:2], atol=1e-4)
    assert other.water_g_kg[0] == pytest.approx(one.water_g_kg[0], rel=1e-4)
    assert 7.0 < other.water_g_kg[1] < one.water_g_kg[1]


def test_subsidence_balances_the_cooling_above_the_inversion(sounding):
    case, notes = case_of_sounding(sounding(TRADES), 300.0, cooling_K_day=2.0, changed={})
    sinking = -case.forcing.subsidence_m_s[-1][1]
    assert sinking * (311.85 - 308.2) / 1000.0 == pytest.approx(2.0 / 86400.0)
    assert len(notes) == 1
    given, notes = case_of_sounding(sounding(TRADES), 300.0, cooling_K_day=2.0, subsidence_m_s=0.004, changed={})
    assert given.forcing.subsidence_m_s[-1][1] == -0.004
    assert not notes


def test_cloud_below_an_inversion_cools_by_radiation_and_gets_fine_levels(sounding):
    case, notes = case_of_sounding(sounding(STRATUS, (7.0, -5.5)), 292.5, changed={"grid": {"columns": [4, 4]}})
    assert case.radiation is not None
    assert any("two-stream" in note for note in notes)
    model = Model(case)
    at = np.abs(model.mesh.centres_m - 845.0).argmin()
    assert model.mesh.depth_m[at] < 10.0
    assert model.liquid.max() > 0.2


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (TRADES.replace("298.7,17,", "298.7,x,"), "water_g_kg in line 2: 'x' given; allowed: 0 to 40"),
        (TRADES.replace("520,", "-1,"), "height_m in line 3: '-1' given"),
        (TRADES.replace("1480,", "500,"), "ascending"),
        (TRADES.replace("theta_K", "warmth"), "columns height_m, warmth"),
        (TRADES.replace("theta_K,water_g_kg", "theta_K,temperature_K"), "temperature_K.* line 2: '17'"),
        (STRATUS, "--wind"),
        ("", "columns none"),
    ],
)
def test_a_wrong_sounding_is_refused_with_column_line_and_value(sounding, text, named):
    with pytest.raises(CatalogError, match=named):
        sounding(text)


def test_the_command_simulates_a_sounding_and_says_what_it_estimated(tmp_path):
    (tmp_path / "mine.csv").write_text(STRATUS, encoding="utf-8")
    output = tmp_path / "mine.nc"
    command = ["simulate", "--profile", str(tmp_path / "mine.csv"), "--wind", "7", "-5.5", "-o", str(output), "--hours",
               "0.02", "--spin-up", "0", "--columns", "8", "8"]  # fmt: skip
    refused = CliRunner().invoke(skies, command)
    assert refused.exit_code == 2
    assert "--sea" in refused.output
    done = CliRunner().invoke(skies, [*command, "--sea", "292"], catch_exceptions=False)
    assert "estimated: air sinks by" in done.output
    assert "note: the box is 400 m wide" in done.output
    with netCDF4.Dataset(output) as file:
        assert file["mean_liquid_water_path"][0] > 10.0


def test_remarks_name_what_leaves_the_range_of_the_model(sounding):
    cold = "height_m,theta_K,water_g_kg\n0,250,0.9\n840,250,0.9\n850,258,0.1\n3000,268,0.1\n"
    case, _ = case_of_sounding(sounding(cold, (5.0, 0.0)), 262.0, changed={"grid": {"columns": [8, 8]}})
    assert any("would have ice" in remark for remark in remarks(Model(case)))
    clear, _ = case_of_sounding(sounding(TRADES), 300.0, changed={"grid": {"columns": [8, 8]}})
    assert remarks(Model(clear)) == ["there is no cloud at the end"]
