"""A whole cube by `hcss run`, with day-time sun, so that composite paths are asked for."""

import subprocess
import sys

import netCDF4
import numpy as np
import pytest

SCENARIO = """
place = {latitude = 35.0, longitude = 150.0}
time = 2024-04-20T12:30:00+10:00
clouds.type = "paper-stratus"
atmosphere.profile = "us-standard-1976"
image = {rows = 16, columns = 16}
frames.count = 1
atmosphere.gases.others = "profile"
sea.temperature_texture = 0.0
radiance.model = "as-printed"
sea.model = "cox-munk"
optics.provider = "mie"
"""
"""With the radiance model `physical` a scene asks for many times as many paths, which the Fortran takes long for."""


def hcss(folder, *arguments):
    command = [sys.executable, "-c", "from hcss_twin.cli import main; main()", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)


def radiance(path):
    with netCDF4.Dataset(path) as cube:
        return cube["radiance"][:].data


@pytest.fixture(scope="module")
def folder(tmp_path_factory, compiler):
    folder = tmp_path_factory.mktemp("run")
    (folder / "scenario.toml").write_text(SCENARIO)
    for name in ("table", "lowtran7"):
        done = hcss(folder, "run", "scenario.toml", "-o", f"{name}.nc", "--set", f"atmosphere.provider={name}")
        assert done.returncode == 0, done.stderr
    return folder


def test_cube_is_that_of_the_shipped_table(folder):
    # The table interpolates LOWTRAN7 results of the same atmosphere, with LOWTRAN7's own gases: those of 2024
    # change the radiance by 1 %.
    np.testing.assert_allclose(radiance(folder / "lowtran7.nc"), radiance(folder / "table.nc"), rtol=0.005)


def test_aerosol_changes_the_cube(folder):
    done = hcss(
        folder, "run", "scenario.toml", "-o", "hazy.nc", "--set", "atmosphere.provider=lowtran7",
        "--set", "atmosphere.parameters.aerosol=maritime",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert np.any(radiance(folder / "hazy.nc") != radiance(folder / "lowtran7.nc"))


def test_misspelt_aerosol_is_refused_before_anything_is_compiled(folder):
    done = hcss(
        folder, "run", "scenario.toml", "-o", "bad.nc", "--set", "atmosphere.provider=lowtran7",
        "--set", "atmosphere.parameters.aerosol=martime",
    )  # fmt: skip
    assert done.returncode != 0
    assert "martime" in done.stderr or "maritime" in done.stderr
    assert "Traceback" not in done.stderr
