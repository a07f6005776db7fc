"""Rolling shutter: the kit, and a source that moves while the rows are read."""

import shutil
from pathlib import Path

import netCDF4
import numpy as np
from hcss_author import SensorContract, assert_registered
from hcss_examples.rolling_shutter import Parameters, RollingShutter

from hcss_twin import Scenario, simulate

SCENARIO = Path(__file__).parents[1] / "scenarios" / "rolling-shutter.toml"
CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "output.certificate": 0}


class TestRollingShutter(SensorContract):
    def make_provider(self, inputs):
        return RollingShutter(inputs, Parameters())


def test_is_found_when_installed():
    assert_registered("sensors", "rolling-shutter", distribution="hcss-examples")


def test_a_row_shows_where_the_source_was_when_it_was_read(tmp_path):
    """The aircraft is in row 16, read 80 ms after the frame: 250 m/s carry it 20 m, two pixels, further."""
    shutil.copy(SCENARIO, tmp_path)
    simulate(Scenario.load(tmp_path / SCENARIO.name, CHEAP), tmp_path / "c.nc").close()
    columns = []
    for name in ("c.nc", "c.sensor.nc"):
        with netCDF4.Dataset(tmp_path / name) as cube:
            brightest = [np.unravel_index(frame[0].argmax(), frame[0].shape) for frame in cube["radiance"][:]]
        columns.append([column for _, column in brightest])
        assert {row for row, _ in brightest} == {16}
    assert np.array_equal(np.subtract(*columns[::-1]), [2, 2])
