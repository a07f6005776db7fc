"""Runs of cases: continued with the same bits, nothing half written, and errors that name field and value."""

import itertools
import subprocess
import sys

import netCDF4
import numpy as np
import pytest
from click.testing import CliRunner
from hcss_skies.command import skies
from hcss_skies.les.case import read_case, shipped
from hcss_skies.les.clouds import picture
from hcss_skies.les.model import Model
from hcss_skies.les.run import Times, simulate_case
from hcss_skies.les.statistics import series
from les_cases import CLOUDY, case

from hcss_twin.providers import CatalogError, HcssError

OUTPUT = {"hours": 0.2, "spin_up_hours": 0.0, "picture_s": 60.0, "statistics_s": 120.0}


def through(times, _count):
    return iter(times)


def killed_after(times):
    """Progress that ends like a killed process: the state is saved at each time, nothing else is done."""

    def progress(left, _count):
        yield from itertools.islice(left, times)
        raise KeyboardInterrupt

    return progress


@pytest.fixture
def small():
    return read_case("bomex", grid={"columns": [8, 8], "spacing_m": 100.0}, output=OUTPUT)


def test_a_killed_run_is_continued_with_the_same_bits(small, tmp_path, monkeypatch):
    whole = simulate_case(small, tmp_path / "whole.nc", through)
    monkeypatch.setattr("hcss_skies.les.run.SAVE_EVERY_S", -1.0)
    for times in (3, 5):
        with pytest.raises(KeyboardInterrupt):
            simulate_case(small, tmp_path / "parts.nc", killed_after(times))
        assert not (tmp_path / "parts.nc").exists()
    parts = simulate_case(small, tmp_path / "parts.nc", through)
    assert parts.steps == whole.steps
    for name, field in whole.fields.items():
        np.testing.assert_array_equal(field, parts.fields[name])
    with netCDF4.Dataset(tmp_path / "whole.nc") as one, netCDF4.Dataset(tmp_path / "parts.nc") as other:
        assert set(one.variables) == set(other.variables)
        for name, variable in one.variables.items():
            np.testing.assert_array_equal(variable[:].filled(-1), other[name][:].filled(-1))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["parts.nc", "whole.nc"]


def test_a_run_interrupted_before_its_first_checkpoint_leaves_nothing(small, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        simulate_case(small, tmp_path / "none.nc", killed_after(1))
    assert not list(tmp_path.iterdir())


def test_a_run_is_not_continued_with_another_case(small, tmp_path, monkeypatch):
    monkeypatch.setattr("hcss_skies.les.run.SAVE_EVERY_S", -1.0)
    with pytest.raises(KeyboardInterrupt):
        simulate_case(small, tmp_path / "a.nc", killed_after(2))
    other = small.model_copy(update={"seed": 2})
    with pytest.raises(CatalogError, match="another case"):
        simulate_case(other, tmp_path / "a.nc", through)
    simulate_case(other, tmp_path / "a.nc", through, restart=True)
    assert (tmp_path / "a.nc").exists()


def test_files_of_others_in_the_folder_of_a_run_are_left(small, tmp_path):
    folder = tmp_path / "a.nc.run"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(HcssError, match="move what is in it"):
        simulate_case(small, tmp_path / "a.nc", through)
    assert (folder / "notes.txt").read_text() == "mine"


def test_the_file_has_pictures_and_statistics_of_all_times(small, tmp_path):
    model = simulate_case(small, tmp_path / "a.nc", through)
    with netCDF4.Dataset(tmp_path / "a.nc") as file:
        assert file["liquid_water_path"].dimensions == ("time", "y", "x")
        np.testing.assert_array_equal(file["time"][:], np.arange(0.0, 721.0, 60.0))
        assert file["cloud_fraction"].shape == (7, model.mesh.levels)
        np.testing.assert_array_equal(file["statistics_time"][:], np.arange(0.0, 721.0, 120.0))
        assert file["mean_theta_l"][0, 0] == pytest.approx(298.7, abs=0.02)


def test_volumes_add_up_to_the_optical_thickness_of_the_pictures(tmp_path):
    cloudy = case(CLOUDY, output={"hours": 0.1, "picture_s": 120.0, "volume_s": 120.0}, grid={"columns": [8, 12]})
    model = simulate_case(cloudy, tmp_path / "a.nc", through)
    with netCDF4.Dataset(tmp_path / "a.nc") as file:
        assert file["extinction"].shape == (4, model.mesh.levels, 12, 8)
        through_all = np.tensordot(file["extinction"][:], model.mesh.depth_m, axes=(1, 0))
        np.testing.assert_allclose(through_all, file["optical_thickness"][:], rtol=1e-5, atol=1e-6)
        assert file["optical_thickness"][:].max() > 1.0
        # top and base enclose the cloud, whose water is that of the mean
        assert np.all(file["cloud_top"][:].compressed() > file["cloud_base"][:].compressed())
        water = file["liquid_water_path"][:].mean((1, 2))
        np.testing.assert_allclose(water[0], file["mean_liquid_water_path"][0], rtol=1e-5)


def test_heights_of_a_high_layer_are_above_the_sea():
    model = Model(read_case("altocumulus", grid={"columns": [4, 4]}))
    seen = picture(model)
    assert 3700.0 < seen["cloud_base"].min() < 3800.0 < 3990.0 < seen["cloud_top"].max() < 4010.0
    assert series(model)["lowest_base"] == seen["cloud_base"].min()
    assert model.reference.pressure_Pa[0] < 70100.0


def test_pictures_begin_after_spin_up_and_statistics_end_with_the_run():
    times = Times.of_case(case(output={"hours": 0.1, "spin_up_hours": 0.05, "statistics_s": 100.0}))
    assert times.pictures == [180.0, 240.0, 300.0, 360.0]
    assert times.statistics == [0.0, 100.0, 200.0, 300.0, 360.0]


def test_a_field_that_is_not_finite_is_named_with_its_place():
    model = Model(case())
    model.run_until(5.0)
    model.fields["theta_l"][3, 4, 5] = np.nan
    with pytest.raises(HcssError, match=r"not|nan") as raised:
        model.run_until(30.0)
    assert "dry air" in str(raised.value)
    assert "allowed: finite" in str(raised.value)


def test_winds_that_allow_no_step_are_refused_with_the_fastest():
    model = Model(case())
    model.u[...] = 1e6
    with pytest.raises(HcssError, match=r"fastest is 1e\+06 m/s"):
        model.run_until(30.0)


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"grid": {"side_m": -1.0}}, r"grid\.side_m: -1\.0 given.*greater than 0"),
        ({"grid": {"columns": [2, 8]}}, r"grid\.columns\.0: 2 given"),
        ({"grid": {"sponge_bottom_m": 9000.0}}, "sponge_bottom_m 9000: must be below top_m 3000"),
        ({"grid": {"spacing_m": 1000.0}}, "spacing_m.*6 to 2000 levels"),
        ({"air": {"water_g_kg": [[0, 50.0]]}}, "water_g_kg at 0 m: 50 given, allowed: 0 to 40"),
        ({"air": {"theta_l_K": [[100, 290.0], [50, 300.0]]}}, r"air\.theta_l_K.*heights must ascend"),
        ({"air": {"humidity": 1.0}}, r"air\.humidity: 1\.0 given; Extra inputs"),
        ({"surface": {"drag": 0.001}}, "flux of stress: friction_velocity_m_s, drag given, allowed: one of"),
        ({"precision": "half"}, "precision: 'half' given"),
        ({"output": {"hours": float("nan")}}, r"output\.hours: nan given"),
    ],
)
def test_a_wrong_value_is_refused_with_its_field_and_what_is_allowed(changed, named):
    with pytest.raises(CatalogError, match=named):
        read_case("bomex", **changed)


def test_an_unknown_case_is_refused_with_the_shipped_ones():
    with pytest.raises(CatalogError, match="bomex"):
        read_case("bomx")


@pytest.mark.parametrize("name", shipped())
def test_shipped_cases_can_be_read_and_name_their_source(name):
    read = read_case(name)
    model = Model(read_case(name, grid={"columns": [4, 4]}))
    model.run_until(10.0)
    assert len(read.source) > 50
    assert model.reference.theta_v_K.min() > 200.0
    assert np.all(np.diff(model.reference.pressure_Pa) < 0.0)


def test_the_command_simulates_a_case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()
    command = [
        "simulate",
        "bomex",
        "--hours",
        "0.02",
        "--spin-up",
        "0",
        "--columns",
        "8",
        "8",
        "--side",
        "0.2 km",
        "--seed",
        "3",
    ]
    done = runner.invoke(skies, command, catch_exceptions=False)
    assert done.exit_code == 0
    assert "bomex.nc: Trade cumulus" in done.output
    with netCDF4.Dataset(tmp_path / "bomex.nc") as file:
        assert '"seed":3' in file.case
        assert '"side_m":200.0' in file.case
    with pytest.raises(CatalogError, match="spin_up_hours 2: must not be above hours 1"):
        runner.invoke(skies, ["simulate", "bomex", "--hours", "1", "-o", "b.nc"], catch_exceptions=False)
    again = runner.invoke(skies, command)
    assert again.exit_code != 0
    assert "--force" in again.output
    listed = runner.invoke(skies, ["cases"])
    assert all(name in listed.output for name in shipped())


def test_a_scene_imports_nothing_of_the_model():
    code = (
        "import sys, hcss_skies, hcss_skies.commands, hcss_skies.command, hcss_skies.generator\n"
        "sys.exit(any(name.startswith('hcss_skies.les') for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_dry_air_at_rest_stays_at_rest():
    model = Model(case(air={"noise_K": 0.0}))
    model.run_until(300.0)
    assert max(np.abs(field).max() for field in (model.u, model.v, model.w)) < 1e-10
