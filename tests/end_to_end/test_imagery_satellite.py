"""Real satellite images become plausible clouds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sample_data import sample_file
from scipy.stats import spearmanr

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.models.clouds.imagery.generator import ImageryClouds
from hcss_twin.models.clouds.imagery.parameters import ImageryParameters
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.providers import CloudInputs, CloudLayer, Grid, Microphysics, Motion

MICROPHYSICS = Microphysics("ice", 2.0, 0.1, 1.0, 1e5, (1.0, 500.0))
LAYER = CloudLayer("test", 1000.0, 11_000.0, "base", 100.0, 0.5, None, MICROPHYSICS)


def _clouds(path: Path, grid: Grid, **parameters) -> ImageryClouds:
    motion = Motion(0.0, (0.0, 0.0), np.inf, 1.0)
    inputs = CloudInputs(LAYER, grid, motion, 0, Catalog(base=path.parent))
    return ImageryClouds(inputs, ImageryParameters(image=path.name, **parameters))


@pytest.fixture
def seviri() -> Path:
    """Brightness temperatures at 10.8 um of the North Atlantic, 160 x 256 pixels of 35 km."""
    sample = pytest.importorskip("iris_sample_data")
    return Path(sample.path) / "toa_brightness_stereographic.nc"


@pytest.mark.parametrize("method", ["otsu", "local", "coverage"])
def test_cold_pixels_of_the_infrared_image_are_thick_clouds(seviri, method):
    image = read_image(seviri)
    assert not image.bright_is_cloud
    assert image.units == "K"
    assert image.pixel_size_m == pytest.approx(35_492, abs=10)
    clouds = _clouds(seviri, Grid(160, 256, image.pixel_size_m), method=method, missing="clear")
    thickness = clouds.thickness_m(0.0, slice(None), slice(None))[::-1]
    assert 0.1 < clouds.image_coverage < 0.9
    cloudy = thickness > 0
    temperature = image.values[cloudy]
    assert temperature.max() <= image.values[~cloudy & np.isfinite(image.values)].min()
    # Up to the clipped thousandth the order of thickness is that of coldness.
    below_top = thickness[cloudy] < LAYER.thickness_max_m
    rank = spearmanr(thickness[cloudy][below_top], -temperature[below_top]).statistic
    assert rank == pytest.approx(1.0, abs=1e-6)
    assert np.mean(below_top) > 0.998


def test_coldest_pixel_of_the_infrared_image_is_the_thickest_in_its_place(seviri):
    image = read_image(seviri)
    clouds = _clouds(seviri, Grid(160, 256, image.pixel_size_m), missing="clear")
    coldest = np.unravel_index(np.nanargmin(image.values), image.values.shape)
    thickness = clouds.thickness_m(0.0, slice(None), slice(None))
    assert thickness[159 - coldest[0], coldest[1]] == LAYER.thickness_max_m


def test_scene_with_another_pixel_size_is_told_what_to_set(seviri):
    with pytest.raises(ScenarioError, match=r"pixel_size = 35491\.9 or parameters\.reinterpret_pixel_size"):
        _clouds(seviri, Grid(100, 200, 20.0))
    clouds = _clouds(seviri, Grid(50, 50, 20.0), reinterpret_pixel_size=True)
    assert any("are taken for pixels of 20 m" in note for note in clouds.declares.notes)


def test_hurricane_in_the_near_infrared():
    path = sample_file("images/OR_ABI-L2-CMIPM2-M3C03_G16_s2017266134*.nc")
    image = read_image(path)
    assert image.values.shape == (1000, 1000)
    assert image.bright_is_cloud
    assert image.pixel_size_m == pytest.approx(1002.0, abs=0.1)
    assert image.pixel_size_is_nominal
    assert np.count_nonzero(np.isnan(image.values)) == 1  # the file counts one pixel out of range
    clouds = _clouds(path, Grid(800, 800, 1000.0))
    assert 0.4 < clouds.image_coverage < 0.6
    thickness = clouds.thickness_m(0.0, slice(None), slice(None))[::-1]
    grey = image.values[100:900, 100:900]
    assert spearmanr(thickness[thickness > 0], grey[thickness > 0]).statistic > 0.9999
    assert np.all(grey[thickness == 0] <= grey[thickness > 0].min())
    # Open sea in the south-west, eye wall in the middle, the (darker) eye within it.
    assert np.mean(thickness[650:, 200:] > 0) < 0.01
    assert np.mean(thickness[450:490, 350:450] > 0) > 0.99


def test_local_threshold_adds_thin_clouds_over_the_open_sea():
    path = sample_file("images/OR_ABI-L2-CMIPM2-M3C03_G16_s2017266134*.nc")
    otsu, local = (_clouds(path, Grid(800, 800, 1002.0), method=method) for method in ("otsu", "local"))
    assert otsu.image_coverage + 0.05 < local.image_coverage < 0.75
