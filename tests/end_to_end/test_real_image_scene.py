"""A static scene from a real satellite image: the SEVIRI 10.8 um scene that iris-sample-data carries."""

from pathlib import Path

import numpy as np
import pytest
from cheap import CHEAP
from scipy.stats import spearmanr

from hcss_twin import Scenario, simulate
from hcss_twin.models.clouds.imagery.reader import read_image

ROWS, COLUMNS = 120, 240


@pytest.fixture(scope="module")
def image_path():
    sample = pytest.importorskip("iris_sample_data")
    return Path(sample.path) / "toa_brightness_stereographic.nc"


@pytest.fixture(scope="module")
def cube(image_path):
    scenario = {
        "time": "2007-12-05T00:00:00+00:00",
        "place": {"latitude": 50.0, "longitude": -20.0},
        "image": {"rows": ROWS, "columns": COLUMNS, "pixel_size": 35_492.0},
        "frames": {"count": 1},
        "motion": {"wind_speed": 0.0},
        "bands": ["lwir-10.8", "mwir"],
        "output": {"variables": ["radiance", "brightness_temperature", "truth"]},
        "clouds": {
            "type": "cumulus",
            "top": 10_000.0,
            "generator": "imagery",
            "parameters": {"image": str(image_path), "missing": "clear"},
        },
    }
    return simulate(Scenario.from_dict(scenario, CHEAP))


def crop(image):
    """The centred part of the image that the scene shows, row 0 in the south."""
    values = image.values[::-1]
    top, left = (values.shape[0] - ROWS) // 2, (values.shape[1] - COLUMNS) // 2
    return values[top : top + ROWS, left : left + COLUMNS]


def test_the_simulated_scene_is_cold_where_the_image_is(cube, image_path):
    measured = crop(read_image(image_path))
    simulated = cube.brightness_temperature.sel(band="lwir-10.8")[0].values
    cloudy = (cube.cloud_mask[0].values == 1) & np.isfinite(measured)
    assert 0.2 < cloudy.mean() < 0.8
    assert spearmanr(measured[cloudy], simulated[cloudy]).statistic > 0.99
    assert simulated[cloudy].mean() < simulated[~cloudy].mean() - 5


def test_clear_pixels_are_all_alike(cube):
    clear = cube.cloud_mask[0].values == 0
    for band in cube.radiance[0].values:
        assert np.ptp(band[clear]) == 0
