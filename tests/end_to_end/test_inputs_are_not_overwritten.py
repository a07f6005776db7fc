"""A run never writes onto a file that it reads."""

import os

import numpy as np
import pytest
from cheap import CHEAP
from click.testing import CliRunner

from hcss_twin import CubeError, Scenario, make_plan, sense, simulate
from hcss_twin.cli.main import cli
from hcss_twin.core.catalog import Catalog
from hcss_twin.engine.simulate import run

SMALL = {
    **CHEAP,
    "image.rows": 8,
    "image.columns": 8,
    "frames.count": 1,
    "output.certificate": 0,
    "bands": ["lwir-10.8"],
}
CLOUDS = {"clouds.generator": "imagery", "clouds.parameters": {"image": "clouds.npy"}}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.save("clouds.npy", np.random.default_rng(1).random((24, 24)))
    (tmp_path / "air.csv").write_bytes((Catalog().root / "atmospheres" / "us-standard-1976.csv").read_bytes())
    return tmp_path


def refused(plan, name, match):
    before = {path.name: path.read_bytes() for path in plan.catalog.base.iterdir() if path.is_file()}
    with pytest.raises(CubeError, match=match):
        run(plan, name)
    assert {path.name: path.read_bytes() for path in plan.catalog.base.iterdir() if path.is_file()} == before


def planned(folder, **changes):
    text = Scenario.load("stratus").to_json()
    (folder / "scene.json").write_text(text)
    return make_plan(Scenario.load("scene.json", {**SMALL, **changes}))


def test_an_image_a_profile_and_the_scenario_itself(folder):
    refused(planned(folder, **CLOUDS), "clouds.npy", r"clouds\.npy.*clouds\.layers\[0\]\.parameters\.image")
    refused(planned(folder, **{"atmosphere.profile": "air.csv"}), "air.csv", r"air\.csv.*atmosphere\.profile")
    refused(planned(folder), "scene.json", r"cannot write scene\.json: it is an input")


def test_other_names_of_the_same_file(folder):
    os.link("air.csv", "hard.nc")
    os.symlink("air.csv", "soft.nc")
    plan = planned(folder, **{"atmosphere.profile": "air.csv"})
    for name in ("hard.nc", "soft.nc", str(folder / "air.csv")):
        refused(plan, name, "is an input")


def test_a_store_that_holds_an_input(folder):
    (folder / "cube.zarr").mkdir()
    (folder / "air.csv").rename(folder / "cube.zarr" / "air.csv")
    plan = planned(folder, **{"atmosphere.profile": "cube.zarr/air.csv"})
    with pytest.raises(CubeError, match="is an input"):
        run(plan, "cube.zarr")
    assert (folder / "cube.zarr" / "air.csv").is_file()


def test_the_measured_cube_of_a_sensor(folder):
    (folder / "air.csv").rename(folder / "scene.sensor.csv")
    plan = planned(folder, **{"atmosphere.profile": "scene.sensor.csv", "sensor": {"model": "radiometer"}})
    refused(plan, "scene.csv", r"scene\.sensor\.csv: it is an input")


def test_the_default_name_of_the_command_is_no_exception(folder):
    (folder / "air.csv").rename(folder / "scene.nc.csv")
    os.link("scene.nc.csv", "scene.nc")
    planned(folder)
    words = [word for key, value in SMALL.items() if key != "bands" for word in ("--set", f"{key}={value}")]
    words += ["--set", 'bands=["lwir-10.8"]', "--set", "atmosphere.profile=scene.nc.csv"]
    before = (folder / "scene.nc").read_bytes()
    done = CliRunner().invoke(cli, ["run", "scene.json", "--force", *words])
    assert isinstance(done.exception, CubeError)
    assert "is not replaced" in str(done.exception)  # it is no NetCDF, whatever reads it
    assert (folder / "scene.nc").read_bytes() == before


def test_a_sensor_file_is_not_overwritten_by_what_it_measures(folder):
    simulate(Scenario.load("stratus", SMALL), "cube.nc").close()
    before = (Catalog().root / "instruments" / "generic-mwir.toml").read_bytes()
    (folder / "mine.toml").write_bytes(before)
    with pytest.raises(CubeError, match="is an input"):
        sense("cube.nc", "mine.toml", "mine.toml")
    assert (folder / "mine.toml").read_bytes() == before
