"""Ash: the kit, limits of anomalous diffraction, and a scene of ash above stratus with the split window."""

import shutil
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from hcss_author import OpticsContract, assert_registered
from hcss_examples.ash import Ash, Parameters, efficiencies

from hcss_twin import Scenario, simulate

FOLDER = Path(__file__).parents[1] / "scenarios"
CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "output.certificate": 0}


class TestAsh(OpticsContract):
    def make_provider(self, inputs):
        return Ash(inputs, Parameters())


def test_is_found_when_installed():
    assert_registered("optics", "ash", distribution="hcss-examples")


def test_extinction_is_largest_where_van_de_hulst_found_it():
    """Transparent spheres: 3.17 at a phase shift 2 x (n - 1) of 4.09 (van de Hulst 1957, section 11.22)."""
    shift = np.linspace(3.0, 5.0, 2001)
    extinction, _ = efficiencies(shift, 1.5, 1e-9)
    assert extinction.max() == pytest.approx(3.17, abs=0.01)
    assert shift[extinction.argmax()] == pytest.approx(4.09, abs=0.01)


def test_large_spheres_remove_twice_and_absorb_once_what_they_meet():
    extinction, absorption = efficiencies(np.array([1e5]), 1.5, 0.1)
    assert extinction[0] == pytest.approx(2.0, rel=1e-3)
    assert absorption[0] == pytest.approx(1.0, rel=1e-3)


def test_small_spheres_absorb_by_their_volume():
    """Absorption 4 k 2 pi / wavelength times the volume, so the efficiency is 8 x k / 3; nothing else is removed."""
    size = np.array([1e-5, 1e-4])
    extinction, absorption = efficiencies(size, 1.5, 0.2)
    np.testing.assert_allclose(absorption, 8.0 / 3.0 * size * 0.2, rtol=1e-3)
    np.testing.assert_allclose(extinction, absorption, rtol=1e-2)


def test_thin_ash_over_stratus_is_marked_by_the_split_window(tmp_path):
    for name in ("ash-cloud.toml", "ash-type.toml"):
        shutil.copy(FOLDER / name, tmp_path)
    simulate(Scenario.load(tmp_path / "ash-cloud.toml", CHEAP), tmp_path / "c.nc").close()
    with netCDF4.Dataset(tmp_path / "c.nc") as cube:
        kelvin, difference = cube["brightness_temperature"][0], cube["split_window_difference"][0]
        ash = cube["cloud_layer_thickness"][0, 1] > 0.0
        assert list(cube["split_window_class"].flag_meanings.split()) == ["opaque_or_clear", "thin_cloud"]
    np.testing.assert_array_equal(difference, kelvin[0] - kelvin[1])
    assert 0.2 < ash.mean() < 0.6
    assert kelvin[0][ash].mean() < kelvin[0][~ash].mean() - 2.0
