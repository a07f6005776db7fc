"""A followed scene through the whole chain: plan, radiance, sensor's band, cube."""

import numpy as np
import pytest
from conftest import TIME, field, state_of
from hcss_follow.analysis import Image

import hcss_twin

SIDE = 16


@pytest.mark.long
def test_the_cube_of_lead_0_is_the_image(tmp_path):
    """From thin to deep cloud, in the band of the inversion, so that nothing else differs."""
    kelvin = field(64, fine=6.0)
    kelvin = np.where(kelvin < 286.0, kelvin - 40.0 * (286.0 - kelvin) / 8.0, kelvin)
    state_of([Image(kelvin, TIME)]).write(tmp_path / "sky.nc")
    raw = {
        "time": TIME.isoformat(), "place": {"latitude": 5.0, "longitude": -20.0}, "bands": [[10.3, 11.3]],
        "accuracy": 0.002, "view": {"zenith": 0.0}, "sea": {"temperature": 299.0},
        "image": {"rows": SIDE, "columns": SIDE, "pixel_size": 3000.0}, "frames": {"count": 1},
        "motion": {"platform_speed": 0.0, "wind_speed": 0.0}, "slant": {"parallax": "off", "shadows": "off"},
        "clouds": {
            "type": "deep-convection", "base": 500.0, "top": 1500.0, "water_content": 0.6, "thickness_min": 0.01,
            "generator": "followed", "parameters": {"state": str(tmp_path / "sky.nc")},
        },
        "output": {"variables": ["brightness_temperature"]},
    }  # fmt: skip
    with hcss_twin.simulate(hcss_twin.Scenario.from_dict(raw)) as cube:
        seen = np.asarray(cube.brightness_temperature)[0, 0]
    middle = slice(32 - SIDE // 2, 32 + SIDE // 2)
    error = seen - kelvin[middle, middle]
    assert np.ptp(kelvin[middle, middle]) > 30.0
    assert np.sqrt(np.mean(error**2)) < 0.15
    assert np.mean(np.abs(error) < 0.3) > 0.99
