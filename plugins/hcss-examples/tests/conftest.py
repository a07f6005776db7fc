import os

import netCDF4
import numpy as np
import pytest

TIMES_S = np.array([0.0, 600.0, 1200.0])
CELL_M, CELLS = 100.0, 40


def water_kg_m3():
    """Water content (time, z, y, x): turrets on a base of 400 m that grow with time, with gaps between them."""
    z = np.arange(10.0, 1000.0, 20.0)
    y, x = np.mgrid[:CELLS, :CELLS] * 2.0 * np.pi / CELLS
    turret = np.sin(2.0 * x + 0.3) * np.sin(y) + 0.4 * np.cos(3.0 * y - x)
    top = 400.0 + 100.0 * np.maximum(turret, 0.0) * (1.0 + TIMES_S[:, None, None] / 1200.0)
    wet = (z[:, None, None] > 400.0) & (z[:, None, None] < top[:, None])
    return z, np.where(wet, 4.5e-7 * (z[:, None, None] - 400.0), 0.0)


@pytest.fixture(scope="session")
def les_file(tmp_path_factory):
    """A folder with les.nc."""
    folder = tmp_path_factory.mktemp("les")
    z, water = water_kg_m3()
    distance = (np.arange(CELLS) + 0.5) * CELL_M
    with netCDF4.Dataset(folder / "les.nc", "w") as file:
        for name, values, units in (("time", TIMES_S, "s"), ("z", z, "m"), ("y", distance, "m"), ("x", distance, "m")):
            file.createDimension(name, values.size)
            file.createVariable(name, "f8", (name,))[:] = values
            file[name].units = units
        file.createVariable("lwc", "f8", ("time", "z", "y", "x"))[:] = water
        file["lwc"].units = "kg m-3"
    return folder / "les.nc"


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory):
    """Keep the user's cache as it is, unless another folder is given."""
    with pytest.MonkeyPatch.context() as patch:
        if "HCSS_CACHE_DIR" not in os.environ:
            patch.setenv("HCSS_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        yield
