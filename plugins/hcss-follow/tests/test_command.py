"""``hcss follow`` from files to a scenario that the engine takes, and the clear sky of a scene that is known."""

from pathlib import Path

import netCDF4
import numpy as np
import pytest
from click.testing import CliRunner
from conftest import field
from hcss_follow.clear_sky import _clear, _clear_K, fit_clear_sky
from hcss_follow.command import follow
from hcss_follow.images import named, zenith_and_azimuth_deg
from hcss_follow.scenario import toml_of
from hcss_follow.state import read_state

import hcss_twin

SCENE = {
    "time": "2020-09-06T00:15:00Z",
    "place": {"latitude": 5.0, "longitude": -20.0},
    "view": {"zenith": 25.0},
    "accuracy": 0.01,
    "bands": ["lwir-10.8", "lwir-12.0"],
}


def write_images(path, side=64):
    """Two images 15 min apart with latitude and longitude, first row north."""
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("y", side)
        file.createDimension("x", side)
        degrees = np.arange(side) * 3000.0 / 111_195.0
        for name, values in (
            ("latitude", 5.0 - degrees[:, None] + 0 * degrees),
            ("longitude", degrees - 20.0 + 0 * degrees[:, None]),
        ):
            file.createVariable(name, "f8", ("y", "x"))[:] = values
            file[name].units = "degrees_north" if name == "latitude" else "degrees_east"
        for minute in (0, 15):
            variable = file.createVariable(f"IR_108_{minute:02}", "f4", ("y", "x"))
            variable[:] = field(side, shift=(minute / 10, minute / 15))[::-1] + 3.0
            variable.units = "K"
            variable.long_name = f"brightness temperature, 2020-09-06 00:{minute:02} UTC"


def test_a_file_and_its_variable(tmp_path):
    path = tmp_path / "a:b.nc"
    path.touch()
    assert named(str(path)) == (path, None)
    assert named("c.nc:IR_108") == (Path("c.nc"), "IR_108")


@pytest.mark.parametrize(
    ("latitude", "longitude", "zenith", "azimuth"),
    [(0.0, 0.0, 0.0, None), (0.0, 60.0, 68.057, 270.0), (0.0, -60.0, 68.057, 90.0), (60.0, 0.0, 68.057, 180.0)],
)
def test_view_of_a_geostationary_satellite(latitude, longitude, zenith, azimuth):
    """At 60 degrees from the point below it: tan z = sin 60 / (cos 60 - R / r)."""
    found = zenith_and_azimuth_deg(latitude, longitude, 0.0)
    assert found[0] == pytest.approx(zenith, abs=0.01)
    if azimuth is not None:
        assert found[1] == pytest.approx(azimuth, abs=1e-6)


def test_scenarios_are_valid_toml():
    import tomllib

    raw = {"title": 'a "b"', "bands": [{"name": "x", "response": "c\\d.csv"}], "image": {"rows": 3}}
    assert tomllib.loads(toml_of(raw)) == raw


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--time", "2020-09-06T00:00Z"], "--time: 1 given; allowed: one for each of the 2 images"),
        (["--time", "soon"], "'soon' is no time"),
        (["--start", "2020-09-05T00:00Z"], "allowed: 0 to 21600"),
    ],
)
def test_wrong_options_say_what_is_allowed(tmp_path, options, message):
    write_images(tmp_path / "i.nc")
    given = [f"{tmp_path}/i.nc:IR_108_00", f"{tmp_path}/i.nc:IR_108_15", *options, "-o", str(tmp_path / "t.toml")]
    result = CliRunner().invoke(follow, given)
    assert result.exit_code != 0
    assert message in result.output + str(result.exception)


@pytest.mark.long
def test_from_files_to_a_plan(tmp_path):
    write_images(tmp_path / "i.nc")
    given = [f"{tmp_path}/i.nc:IR_108_00", f"{tmp_path}/i.nc:IR_108_15", "-o", str(tmp_path / "t.toml")]
    result = CliRunner().invoke(follow, given, catch_exceptions=False)
    assert result.exit_code == 0
    state = read_state(tmp_path / "t.state.nc")
    assert state.pixel_size_m == pytest.approx(3000.0, rel=0.01)
    assert (state.latitude, state.longitude) == (pytest.approx(4.15, abs=0.02), pytest.approx(-19.15, abs=0.02))
    np.testing.assert_allclose(state.kelvin, field(64, shift=(1.5, 1.0)) + 3.0, atol=1e-4)
    loaded = hcss_twin.Scenario.load(str(tmp_path / "t.toml"))
    assert loaded.image.rows == 64


@pytest.mark.long
def test_a_known_sea_and_vapour_are_found():
    """An identical twin: brightness temperatures of a known sea and vapour, without error."""
    _, measured = _clear_K(_clear(SCENE, 299.5, 0.8))
    found = fit_clear_sky(SCENE, measured.tolist(), 5000)
    low, high = np.percentile(found.draws, [2.5, 97.5], axis=0)
    assert low[0] < 299.5 < high[0]
    assert low[1] < 0.8 < high[1]
    np.testing.assert_allclose(found.predicted_K.mean(axis=0), measured, atol=0.2)
    assert np.corrcoef(found.draws.T)[0, 1] > 0.3  # one trades for the other
    assert not found.notes
    few = fit_clear_sky(SCENE, measured.tolist(), 999)
    assert "999 clear pixels; expected: 1000" in few.notes[0]
