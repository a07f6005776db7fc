"""LES clouds: the kit, and the water of the file against closed forms."""

import shutil
from dataclasses import replace
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from conftest import CELL_M, CELLS, water_kg_m3
from hcss_author import CloudGeneratorContract, assert_registered, sample_cloud_inputs
from hcss_examples.les_clouds import LesClouds, Parameters, water_content_kg_m3

from hcss_twin import Scenario, simulate
from hcss_twin.providers import Catalog, Grid, Motion, ProviderError

SCENARIO = Path(__file__).parents[1] / "scenarios" / "les-clouds.toml"
CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie", "output.certificate": 0}


def inputs_of(les_file, **layer):
    """Inputs whose layer holds the water of the file."""
    inputs = sample_cloud_inputs(catalog=Catalog(base=les_file.parent))
    return replace(inputs, layer=replace(inputs.layer, **{"base_m": 400.0, "top_m": 1200.0, **layer}))


class TestLesClouds(CloudGeneratorContract):
    @pytest.fixture(autouse=True)
    def _file(self, les_file):
        self.les_file = les_file

    def make_inputs(self, coverage=0.5, seed=1):
        return inputs_of(self.les_file)

    def make_provider(self, inputs):
        return LesClouds(inputs, Parameters(file="les.nc"))


def test_is_found_when_installed():
    assert_registered("clouds", "les", distribution="hcss-examples")


def test_droplets_of_a_gamma_distribution_hold_its_closed_third_moment(les_file):
    """n(r) = a r^6 exp(-b r): the mean of r^3 is 9 8 7 / b^3."""
    cloud = inputs_of(les_file).layer.microphysics
    expected = 1000.0 * 4.0 / 3.0 * np.pi * cloud.number_density_m3 * 9 * 8 * 7 / cloud.b**3 * 1e-18
    assert water_content_kg_m3(cloud) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("time", [0.0, 300.0, 1200.0])
def test_every_cell_holds_the_water_path_of_the_file(les_file, time):
    """One pixel per cell, the image centre at a corner of the file; between two times, the mean of both."""
    inputs = replace(inputs_of(les_file, thickness_min_m=1e-3), grid=Grid(CELLS, CELLS, CELL_M))
    inputs = replace(inputs, motion=Motion(0.0, (0.0, 0.0), np.inf, 1.0))
    _, water = water_kg_m3()
    path = 20.0 * water.sum(axis=1)
    expected = {0.0: path[0], 300.0: 0.5 * (path[0] + path[1]), 1200.0: path[2]}[time]
    field = LesClouds(inputs, Parameters(file="les.nc")).thickness_m(time, slice(0, CELLS), slice(0, CELLS))
    found = np.roll(field, (CELLS // 2, CELLS // 2), (0, 1)) * water_content_kg_m3(inputs.layer.microphysics)
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6)


def test_wind_carries_the_field_by_whole_cells(les_file):
    motion = Motion(0.0, (10.0, -20.0), np.inf, 1.0)
    inputs = replace(inputs_of(les_file), grid=Grid(30, 30, CELL_M), motion=motion)
    moved = LesClouds(inputs, Parameters(file="les.nc"))
    still = LesClouds(replace(inputs, motion=Motion(0.0, (0.0, 0.0), np.inf, 1.0)), Parameters(file="les.nc"))
    window = slice(5, 12), slice(3, 20)
    back = slice(5 + 4, 12 + 4), slice(3 - 2, 20 - 2)
    np.testing.assert_array_equal(moved.thickness_m(20.0, *window), still.thickness_m(20.0, *back))


def test_clouds_around_the_image_repeat_those_of_the_file(les_file):
    inputs = replace(inputs_of(les_file), grid=Grid(CELLS, CELLS, CELL_M), motion=Motion(0.0, (0.0, 0.0), np.inf, 1.0))
    clouds = LesClouds(inputs, Parameters(file="les.nc"))
    whole = clouds.thickness_m(0.0, slice(0, CELLS), slice(0, CELLS))
    around = clouds.thickness_around_m(0.0, slice(-CELLS, 2 * CELLS), slice(-CELLS, CELLS), None)
    np.testing.assert_array_equal(around, np.tile(whole, (3, 2)))


@pytest.mark.parametrize(
    ("layer", "message"),
    [
        ({"base_m": 500.0}, "les: water at 410 to .* m; allowed: 500 to 1200 m, the layer"),
        ({"top_m": 450.0}, "allowed: 400 to 450 m, the layer"),
    ],
)
def test_water_outside_the_layer_is_refused(les_file, layer, message):
    with pytest.raises(ProviderError, match=message):
        LesClouds(inputs_of(les_file, **layer), Parameters(file="les.nc"))


def test_more_water_than_the_layer_can_hold_is_refused(les_file):
    inputs = inputs_of(les_file)
    few = replace(inputs.layer.microphysics, number_density_m3=1e7)
    with pytest.raises(ProviderError, match=r"as much water as .* m of this cloud; allowed: up to .* 800 m"):
        LesClouds(replace(inputs, layer=replace(inputs.layer, microphysics=few)), Parameters(file="les.nc"))


def test_times_outside_the_file_are_refused(les_file):
    with pytest.raises(ProviderError, match="les: time 1201 s; allowed: those of the file, 0 to 1200 s"):
        LesClouds(inputs_of(les_file), Parameters(file="les.nc")).thickness_m(1201.0, slice(0, 2), slice(0, 2))


def test_the_scenario_shows_clouds_that_grow(les_file, tmp_path):
    shutil.copy(SCENARIO, tmp_path)
    shutil.copy(les_file, tmp_path)
    wanted = {"output.variables": ["radiance", "truth"]}
    simulate(Scenario.load(tmp_path / SCENARIO.name, {**CHEAP, **wanted}), tmp_path / "c.nc").close()
    with netCDF4.Dataset(tmp_path / "c.nc") as cube:
        mask, thickness = cube["cloud_mask"][:], cube["cloud_thickness"][:]
        assert "les.nc" in cube.hcss_files_sha256
    assert np.all(np.diff(thickness.mean(axis=(1, 2))) > 0.0)
    assert 0.05 < mask.mean() < 0.9
