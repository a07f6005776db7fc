"""Light between clouds with tops of their own: against Monte Carlo, and against a layer where all have one top."""

import json

import pytest
from hcss_light.comparison import compare
from light_scene import NIGHT, scene

pytest.importorskip("hcss_skies")

CLOUDS = {
    "type": "stratocumulus", "generator": "example", "coverage": 0.5, "thickness_min": 10.0,
    "parameters": {"example": "closed-cells-1", "tops": "example"},
}  # fmt: skip
IMAGE = {"rows": 12, "columns": 12, "pixel_size": 200.0}


@pytest.mark.parametrize(("zenith", "parallax"), [(0.0, "off"), (45.0, "on")])
def test_clouds_with_their_own_tops_agree_with_monte_carlo(zenith, parallax):
    """Independent columns do not, seen from the side."""
    given = {"time": NIGHT, "clouds": CLOUDS, "image": IMAGE, "bands": [[3.6, 3.8]]}
    given |= {"slant": {"shadows": "off", "parallax": parallax}, "view": {"zenith": zenith, "azimuth": 30.0}}
    found = compare(scene("source", **given), pixels=16, photons=1500, frame=0, seed=3)
    (band,) = found["bands"]
    print(zenith, json.dumps(band["errors"]), band["noise"])
    assert abs(band["errors"]["cube"]["bias"]) < 0.01 + 2.0 * band["noise"]
    assert band["errors"]["cube"]["rms"] < 0.02
