"""Sea ice with a map of temperature: the kit, a linear map, and a scene."""

import shutil
from dataclasses import replace
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from hcss_author import SurfaceContract, assert_registered, sample_surface_inputs
from hcss_examples.ice_map import IceMap, Parameters

from hcss_twin import Scenario, simulate
from hcss_twin.providers import Catalog, ProviderError

SCENARIO = Path(__file__).parents[1] / "scenarios" / "sea-ice.toml"
CHEAP = {"radiance.model": "as-printed", "output.certificate": 0}


def write_ice(folder, latitude, longitude):
    """Ice north of the centre, colder toward the east by 10 K per degree."""
    north, east = np.linspace(latitude - 1, latitude + 1, 9), np.linspace(longitude - 1, longitude + 1, 5)
    with netCDF4.Dataset(folder / "ice.nc", "w") as file:
        for name, values in (("latitude", north), ("longitude", east)):
            file.createDimension(name, values.size)
            file.createVariable(name, "f8", (name,))[:] = values
        share = np.clip(0.5 + 10.0 * (north - latitude), 0.0, 1.0)[:, None] * np.ones(east.size)
        kelvin = 262.0 - 10.0 * (east - longitude) * np.ones((north.size, 1))
        for name, values in (("concentration", share), ("temperature", kelvin)):
            file.createVariable(name, "f8", ("latitude", "longitude"))[:] = values


@pytest.fixture
def inputs(tmp_path):
    write_ice(tmp_path, 35.0, 150.0)
    return replace(sample_surface_inputs(), catalog=Catalog(base=tmp_path))


class TestIceMap(SurfaceContract):
    @pytest.fixture
    def inputs(self, tmp_path):
        write_ice(tmp_path, 35.0, 150.0)
        return replace(sample_surface_inputs(), catalog=Catalog(base=tmp_path))

    def make_provider(self, inputs):
        return IceMap(inputs, Parameters(file="ice.nc"))


def test_is_found_when_installed():
    assert_registered("surfaces", "ice-map", distribution="hcss-examples")


def test_the_map_is_linear_between_its_points(inputs):
    window = slice(0, 48), slice(0, 64)
    found = IceMap(inputs, Parameters(file="ice.nc")).surface(0.0, *window)
    latitude, longitude = inputs.ground(0.0, *window)
    np.testing.assert_allclose(found.temperature_K, 262.0 - 10.0 * (longitude - 150.0), atol=1e-9)
    np.testing.assert_array_equal(found.number, latitude >= 35.0)


def test_an_image_beyond_the_file_is_refused(tmp_path):
    write_ice(tmp_path, 36.5, 150.0)
    away = replace(sample_surface_inputs(), catalog=Catalog(base=tmp_path))
    with pytest.raises(ProviderError, match=r"reaches latitude 34.* allowed: that of ice.nc, 35.50 to 37.50"):
        IceMap(away, Parameters(file="ice.nc")).surface(0.0, slice(0, 4), slice(0, 4))


def test_the_scenario_shows_colder_ice_in_the_east(tmp_path):
    shutil.copy(SCENARIO, tmp_path)
    write_ice(tmp_path, 45.0, 145.0)
    simulate(Scenario.load(tmp_path / SCENARIO.name, CHEAP), tmp_path / "c.nc").close()
    with netCDF4.Dataset(tmp_path / "c.nc") as cube:
        ice, kelvin, radiance = cube["surface_class"][0] == 1, cube["surface_temperature"][0], cube["radiance"][0]
    assert 0.4 < ice.mean() < 0.6
    assert np.all(kelvin[~ice] == np.float32(271.3))
    assert np.all(np.diff(kelvin[-1]) < 0.0)
    # Rows count toward the north: the last is ice, the first sea.
    assert np.all(np.diff(radiance[1, -1]) < 0.0)
    assert radiance[1][ice].max() < radiance[1][~ice].min()
