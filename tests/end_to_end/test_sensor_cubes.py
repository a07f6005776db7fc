"""Pairs of cubes: clean, and as a sensor measures it, from the command line and from Python."""

import json

import netCDF4
import numpy as np
import pytest
import xarray as xr
from cheap import CHEAP_OPTIONS
from click.testing import CliRunner
from written_cubes import loaded

import hcss_twin
from hcss_twin.cli.main import cli
from hcss_twin.cli.options import Stop
from hcss_twin.core.errors import CubeError, ProviderError, ScenarioError
from hcss_twin.models.sensor.radiometer import Radiometer
from hcss_twin.providers.registry.registry import Registry

SCENE = """
title = "a small scene"
time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
seed = 5
bands = ["mwir", {name = "spike", limits = [4.17, 4.2]}]
image = {rows = 20, columns = 28}
frames = {count = 3, first = 2, interval = 0.5}
motion.platform_speed = 1000
clouds.type = "stratus"
output = {variables = ["radiance", "radiance_sea_emission", "truth"], certificate = 2}
"""

SENSOR = """
[sensor]
variables = ["all"]
parameters = {psf = "airy", aperture_diameter = 0.2, pixel_angle = 4e-5, integration_time = 2e-3, noise = "photon", \
well_depth = 1e7, bits = 14}
"""

VARIABLES = {"radiance", "photon_rate", "digital_number", "saturated"}


def hcss(*words):
    result = CliRunner().invoke(cli, [str(word) for word in words], obj=Stop())
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with ``pair.nc`` and ``pair.sensor.nc``, and ``alone.nc`` of the same scene without a sensor."""
    folder = tmp_path_factory.mktemp("sensor")
    (folder / "pair.toml").write_text(SCENE + SENSOR, encoding="utf-8")
    (folder / "alone.toml").write_text(SCENE, encoding="utf-8")
    for name in ("pair", "alone"):
        told = hcss("run", folder / f"{name}.toml", "-o", folder / f"{name}.nc", "--json", *CHEAP_OPTIONS)
        assert told.exit_code == 0, told.output
        measured = json.loads(told.stdout).get("sensor_cube")
        assert measured == (str(folder / "pair.sensor.nc") if name == "pair" else None)
    return folder


def test_a_sensor_leaves_the_clean_cube_as_it_is(folder):
    one, other = loaded(folder / "pair.nc"), loaded(folder / "alone.nc")
    xr.testing.assert_identical(one.drop_attrs(), other.drop_attrs())
    assert not (folder / "alone.sensor.nc").exists()
    assert {name for name in other.attrs if one.attrs.get(name) != other.attrs[name]} <= {
        "hcss_scenario",
        "history",
        "date_created",
        "id",
    }
    assert "sensor" not in json.loads(other.attrs["hcss_scenario"])


def test_the_pair_has_the_same_axes_and_truth(folder):
    clean, measured = loaded(folder / "pair.nc"), loaded(folder / "pair.sensor.nc")
    truth = set(clean.data_vars) - {"radiance", "radiance_sea_emission"}
    assert set(measured.data_vars) == truth | VARIABLES
    assert "cloud_top_altitude" in truth
    xr.testing.assert_identical(clean[sorted(truth)].drop_attrs(), measured[sorted(truth)].drop_attrs())
    for name in (*clean.coords, *truth):
        assert str(clean[name].attrs) == str(measured[name].attrs)
    assert measured.radiance.dims == clean.radiance.dims


def test_what_is_measured_is_what_the_sensor_makes_of_the_clean_frames(folder):
    clean, measured = loaded(folder / "pair.nc"), loaded(folder / "pair.sensor.nc")
    about = json.loads(measured.attrs["hcss_sensor"])
    assert about["model"] == "radiometer"
    assert about["seed"] == 5
    assert about["worked_out"]["smear_pixels"] == pytest.approx(1000.0 * 2e-3 / 20.0)
    band = about["worked_out"]["bands"]["mwir"]
    rate = measured.photon_rate.sel(band="mwir").to_numpy()
    # Given the cube alone, whose mirror image keeps the mean.
    alone = hcss_twin.sense(folder / "pair.nc", hcss_twin.Scenario.load(folder / "pair.toml"))
    np.testing.assert_allclose(
        alone.photon_rate.sel(band="mwir").mean(),
        clean.radiance.sel(band="mwir").to_numpy().mean() * band["photons_per_radiance"],
        rtol=1e-5,
    )
    noise = measured.radiance.sel(band="mwir").to_numpy() - rate / band["photons_per_radiance"]
    electrons = rate.mean() * 2e-3
    expected = np.sqrt(electrons + (1e7 / (2**14 - 1)) ** 2 / 12.0) / band["electrons_per_radiance"]
    assert noise.std() == pytest.approx(expected, rel=0.1)
    assert measured.digital_number.dtype == np.int32
    assert measured.digital_number.max() < 2**14


def test_a_cube_measured_later_is_the_one_of_the_run_but_for_blur_at_its_edges(folder, tmp_path):
    section = json.loads(loaded(folder / "pair.sensor.nc").attrs["hcss_scenario"])["sensor"]
    run, there = loaded(folder / "pair.sensor.nc"), hcss_twin.sense(folder / "alone.nc", section)
    assert set(run.variables) == set(there.variables)
    for name in set(run.variables) - VARIABLES:
        xr.testing.assert_identical(run[name].drop_attrs(), there[name].drop_attrs())
    assert not run.photon_rate.equals(there.photon_rate)
    sharp = json.loads(json.dumps(section))
    sharp["parameters"] |= {"psf": "none", "smear": False}
    changed = ("--set", 'sensor.parameters.psf="none"', "--set", "sensor.parameters.smear=false")
    words = ("-o", tmp_path / "sharp.nc", *changed, *CHEAP_OPTIONS)
    assert hcss("run", folder / "pair.toml", *words).exit_code == 0
    xr.testing.assert_identical(
        loaded(tmp_path / "sharp.sensor.nc").drop_attrs(), hcss_twin.sense(folder / "alone.nc", sharp).drop_attrs()
    )


def test_a_cube_is_measured_alike_however_it_is_given(folder, tmp_path):
    section = json.loads(loaded(folder / "pair.sensor.nc").attrs["hcss_scenario"])["sensor"]
    there = hcss_twin.sense(folder / "alone.nc", section)
    with hcss_twin.open_cube(folder / "alone.nc") as cube:
        xr.testing.assert_identical(hcss_twin.sense(cube, section).drop_attrs(), there.drop_attrs())
        scenario = hcss_twin.Scenario.load(folder / "pair.toml")
        xr.testing.assert_identical(hcss_twin.sense(cube, scenario).drop_attrs(), there.drop_attrs())
        # also of some of the frames and bands, in any order
        part = hcss_twin.sense(cube.isel(time=[2, 0], band=[1]), section)
    np.testing.assert_array_equal(part.digital_number, there.digital_number.isel(time=[2, 0], band=[1]))
    with hcss_twin.sense(folder / "alone.nc", section, tmp_path / "kept.nc") as kept:
        xr.testing.assert_identical(kept.drop_attrs().load(), there.drop_attrs())


def test_storage_is_that_of_the_clean_cube(folder, tmp_path):
    words = ("-o", tmp_path / "packed.nc", "--set", "output.compression=2", *CHEAP_OPTIONS)
    assert hcss("run", folder / "pair.toml", *words).exit_code == 0
    with netCDF4.Dataset(tmp_path / "packed.sensor.nc") as file:
        assert {file[name].filters()["complevel"] for name in VARIABLES} == {2}
    xr.testing.assert_identical(
        loaded(tmp_path / "packed.sensor.nc").drop_attrs(), loaded(folder / "pair.sensor.nc").drop_attrs()
    )


def test_a_measured_cube_can_be_verified(folder, tmp_path):
    told = hcss("verify", folder / "pair.sensor.nc")
    assert told.output.splitlines()[0].endswith("bit-identical (all 3 frames)")
    assert "attribute" not in told.output
    assert hcss("verify", folder / "pair.nc", "--frames", 1).exit_code == 0
    changed = tmp_path / "changed.nc"
    changed.write_bytes((folder / "pair.sensor.nc").read_bytes())
    with netCDF4.Dataset(changed, "a") as file:
        file["digital_number"][1, 0, 3, 4] += 1
    told = hcss("verify", changed)
    assert told.exit_code == 1
    assert "digital_number: 1 of 3360" in told.output


def test_hcss_sense_names_a_sensor_and_changes_it(folder, tmp_path):
    output = tmp_path / "later.nc"
    words = ("sense", folder / "alone.nc", "--sensor", "generic-mwir", "-o", output)
    change = ("--set", "parameters.photon_temperature=250.0", "--set", 'variables=["saturated"]')
    told = hcss(*words, *change, "--json")
    assert told.exit_code == 0, told.output
    about = json.loads(told.stdout)
    assert about["sensor"]["title"] == "generic staring mid-wave imager"
    assert about["sensor"]["parameters"]["photon_temperature"] == 250.0
    assert "saturated" in about["variables"]
    assert "digital_number" not in about["variables"]
    assert hcss(*words).exit_code == 1  # it is there
    assert "imager" in hcss(*words, "--force").output
    assert hcss("verify", output).exit_code == 0


def test_a_users_sensor_with_a_kernel_is_found_from_where_the_user_works(folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "kernel.txt").write_text("1 2 1\n2 4 2\n1 2 1\n", encoding="utf-8")
    (tmp_path / "mine.toml").write_text(
        'title = "bench"\nparameters = {psf = "file", psf_file = "kernel.txt"}\n'
        '[sources]\npsf = "bench"\npsf_file = "bench"\n',
        encoding="utf-8",
    )
    assert hcss("sense", folder / "alone.nc", "--sensor", "mine.toml", "-o", "later.nc").exit_code == 0
    files = json.loads(loaded(tmp_path / "later.nc").attrs["hcss_files_sha256"])
    assert {"./kernel.txt", "./mine.toml"} <= set(files)
    assert hcss("verify", "later.nc").exit_code == 0


def test_a_run_does_not_replace_a_measured_cube(folder, tmp_path):
    (tmp_path / "pair.sensor.nc").write_text("mine", encoding="utf-8")
    told = hcss("run", folder / "pair.toml", "-o", tmp_path / "pair.nc", *CHEAP_OPTIONS)
    assert told.exit_code == 1
    assert "pair.sensor.nc exists" in told.output
    assert not (tmp_path / "pair.nc").exists()


def test_plan_and_preview_know_the_sensor(folder, tmp_path):
    # Lines are wrapped.
    told = " ".join(hcss("plan", folder / "pair.toml", "--verbose", *CHEAP_OPTIONS).output.split())
    assert "sensor radiometer" in told
    assert "note: blur at the edges sees the scene as it goes on beyond them" in told
    plan = json.loads(hcss("plan", folder / "pair.toml", "--json", *CHEAP_OPTIONS).stdout)
    assert plan["sensor"]["parameters"]["bits"] == 14
    assert not any("blur" in note for note in plan["notes"])  # of the clean cube
    pictures = json.loads(hcss("preview", folder / "pair.sensor.nc", "-o", tmp_path, "--no-animation", "--json").output)
    names = [path.rpartition("/")[2] for path in pictures]
    assert names == ["pair.sensor_mwir_kelvin.png", "pair.sensor_spike_kelvin.png"]


def test_a_sensor_that_fails_leaves_the_clean_cube_and_no_half_of_its_own(folder, tmp_path, monkeypatch):
    clean = tmp_path / "clean.nc"
    clean.write_bytes((folder / "alone.nc").read_bytes())
    measure = Radiometer.measure

    def fails(self, radiance, frame, time_s):
        if frame == 4:
            raise ZeroDivisionError("of the sensor")
        return measure(self, radiance, frame, time_s)

    monkeypatch.setattr(Radiometer, "measure", fails)
    with pytest.raises(ProviderError, match=r"measure\(\) raised ZeroDivisionError: of the sensor"):
        hcss("sense", clean, "--sensor", "generic-mwir")
    assert [path.name for path in tmp_path.iterdir()] == ["clean.nc"]


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda r: np.full(r.shape, np.nan), "expected finite values"),
        (lambda r: r[:1], "expected shape"),
        (lambda r: r.astype(complex), "expected real numbers"),
        (lambda r: r.astype(float) * 1e300, r"expected values in \[-3\.4"),
    ],
)
def test_what_a_sensor_returns_is_checked(folder, monkeypatch, made, message):
    from hcss_twin.providers import Measured

    monkeypatch.setattr(Radiometer, "measure", lambda self, radiance, *_: Measured(made(radiance)))
    with pytest.raises(ProviderError, match=message):
        hcss_twin.sense(folder / "alone.nc", {})


def test_what_is_no_clean_cube_is_refused(folder, tmp_path):
    with pytest.raises(CubeError, match="already a sensor cube; a clean cube is needed"):
        hcss_twin.sense(folder / "pair.sensor.nc", "generic-mwir")
    with hcss_twin.open_cube(folder / "alone.nc") as cube:
        with pytest.raises(CubeError, match="has no radiance"):
            hcss_twin.sense(cube.drop_vars("radiance"), {})
        with pytest.raises(CubeError, match="x is not evenly spaced"):
            hcss_twin.sense(cube.isel(x=[0, 1, 5]), {})
        with pytest.raises(CubeError, match="times do not match its scenario"):
            hcss_twin.sense(cube.assign_coords(time=cube.time + np.timedelta64(100, "ms")), {})
    with pytest.raises(CubeError, match="it is the clean cube"):
        hcss_twin.sense(folder / "alone.nc", {}, folder / "alone.nc")
    with pytest.raises(ScenarioError, match="sensor: is missing; a scenario with a sensor is needed"):
        hcss_twin.sense(folder / "alone.nc", hcss_twin.Scenario.load(folder / "alone.toml"))
    with pytest.raises(ScenarioError, match=r"sensor\.nmae: unknown key"):
        hcss_twin.sense(folder / "alone.nc", {"nmae": "modis"})
    with pytest.raises(ScenarioError, match=r"sensor\.name: 'nobody' is neither in catalogs/instruments"):
        hcss_twin.sense(folder / "alone.nc", "nobody")


def test_without_a_section_no_sensor_is_made(folder, monkeypatch):
    def refuse(*_):
        raise AssertionError("a sensor is made")

    monkeypatch.setattr(Radiometer, "__init__", refuse)
    assert hcss("plan", folder / "alone.toml", *CHEAP_OPTIONS).exit_code == 0
    own = [entry.name for entry in Registry.discover().entries("sensors") if entry.is_own]
    assert own == ["radiometer"]
