"""Cubes in the hands of others, as docs/how-to/reports-and-export.md says: its examples, and what HDF5 shows."""

import re
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import pytest
from cheap import CHEAP, NARROW

from hcss_twin import Scenario, simulate

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "reports-and-export.md"
EXAMPLES = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8").split("## Read a cube")[1], re.DOTALL)


@pytest.fixture(scope="module")
def cube(tmp_path_factory):
    path = tmp_path_factory.mktemp("cube") / "cube.nc"
    small = {"image.rows": 12, "image.columns": 16, "frames.count": 2, "bands": NARROW, **CHEAP}
    simulate(Scenario.load("stratus", {**small, "output.variables": ["radiance", "cloud_top_altitude"]}), path).close()
    return path


def test_there_is_an_example_of_each_reader():
    assert [re.search(r"^import (\w+)", text, re.MULTILINE).group(1) for text in EXAMPLES] == [
        "xarray",
        "hcss_twin",
        "h5py",
    ]


@pytest.mark.parametrize("example", EXAMPLES, ids=["xarray", "hcss_twin", "h5py"])
def test_the_examples_of_the_page_read_the_same_image(cube, example, monkeypatch, capsys):
    monkeypatch.chdir(cube.parent)
    exec(compile(example, str(PAGE), "exec"), {})
    with netCDF4.Dataset(cube) as file:
        brightest = file["radiance"][0, list(file["band_name"][:]).index("mwir")].max()
    assert capsys.readouterr().out == f"(12, 16) W m-2 sr-1 {float(brightest)}\n"


def test_hdf5_shows_the_names_of_the_page(cube):
    text = PAGE.read_text(encoding="utf-8")
    with h5py.File(cube) as file:
        nameless = {
            name
            for name, data in file.items()
            if data.attrs.get("NAME", b"").startswith(b"This is a netCDF dimension but not")
        }
        assert nameless == {"band", "bound", "vertex"}
        ours = {name for name, data in file.items() if name not in nameless}
        hidden = {
            key
            for name in file
            for key in file[name].attrs
            if key in ("DIMENSION_LIST", "REFERENCE_LIST") or key.startswith("_Netcdf4")
        }
        assert [scale[0].name for scale in file["radiance"].dims] == ["/time", "/band", "/y", "/x"]
        assert file["time"].attrs["units"] == b"seconds since 2024-04-20 02:30:00"
        for name in ("scale_factor", "add_offset"):
            assert all(name not in data.attrs for data in file.values())
    with netCDF4.Dataset(cube) as netcdf:
        assert ours == set(netcdf.variables)
    for name in nameless | hidden:
        assert f"`{name}`" in text


def test_what_does_not_exist_is_nan_in_hdf5(cube):
    with h5py.File(cube) as file, netCDF4.Dataset(cube) as netcdf:
        masked = np.ma.getmaskarray(netcdf["cloud_top_altitude"][:])
        np.testing.assert_array_equal(np.isnan(file["cloud_top_altitude"][:]), masked)
        assert masked.any()
