"""Live frames of scenes that only cubes showed: the pixels of the cube at its times, from the same stages."""

import json

import numpy as np
import pytest
from camera_scenes import PASS, SCENE, merged, scenario
from hcss_payload import PayloadError, Pose, pose_at
from hcss_payload.build import payload_of
from hcss_payload.live import LiveTwin, PointTarget, live_pass
from payload_scenes import RADIOMETER

import hcss_twin
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.engine.sense import measured_path

INTERVAL_S = 60.0
SHORT = {"frames": {"count": 2, "interval": INTERVAL_S}, "output": {"certificate": 0}}
STRATUS = {"type": "stratus", "coverage": 0.4, "coverage_mode": "field"}
CIRRUS = {"type": "cirrus", "coverage": 0.5, "coverage_mode": "field"}
ALTOSTRATUS = {"type": "altostratus", "coverage": 0.3, "coverage_mode": "field"}
SHIP = {"x": 0.0, "y": 0.0, "altitude": 0.0, "intensity": 2e6}
PLUME = {"x": 300.0, "y": -200.0, "altitude": 9000.0, "intensity": 5e5, "velocity": [900.0, 0.0, 200.0]}
SPAIN = {"place": {"latitude": 36.7, "longitude": -6.42}, "orbit": {"above": [36.7, -3.4]}}
PUSH_BROOM = {"attitude": {"provider": "push-broom", "roll": -20.0}}

SCENES = {
    "two layers": {"clouds": {"layers": [STRATUS, CIRRUS]}},
    "three layers": {"clouds": {"layers": [STRATUS, ALTOSTRATUS, CIRRUS | {"base": 8000.0, "top": 9000.0}]}},
    "no clouds": {"clouds": {"layers": []}},
    "clouds of an image": {
        "image": {"rows": 200, "columns": 200},
        "motion": {"wind_speed": 0.0},
        "clouds": STRATUS | {"generator": "imagery", "parameters": {"image": "image.npy", "method": "coverage"}},
    },
    "a coast": SPAIN | {"surfaces": {"provider": "coast"}},
    "small elements": {"elements": [{"provider": "point-sources", "parameters": {"tracks": [SHIP, PLUME]}}]},
    "shadows": {"slant": {"shadows": "on"}, "time": "2024-04-20T02:30:00Z", "bands": ["mwir"]},
    "texture of the sea": {"sea": {"temperature_texture": 0.3}},
    "lines read in turn": {"camera": {"line_time": 2e-3}},
    "a scene that smears": {"camera": {"integration_time": 0.022, "points": 4}} | PUSH_BROOM,
    "ground beyond 75 degrees": {"camera": {"beyond": "missing", "focal_length": 0.004}},
}
"""Parts of scenarios that fast frames cannot show."""


def scene(name, folder=None):
    """A scene, whose clouds are all that an earlier one's keys do not say."""
    raw = merged(SCENE, PASS, SHORT)
    parts = SCENES[name]
    if "clouds" in parts:
        del raw["clouds"]
    return hcss_twin.Scenario.from_dict(merged(raw, parts), base=folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with an image of clouds."""
    path = tmp_path_factory.mktemp("image")
    waves = np.sin(np.arange(200) / 9.0)[:, None] + np.cos(np.arange(200) / 7.0)
    np.save(path / "image.npy", waves)
    return path


def image(live, *given, **options):
    """The radiance of a frame, in an array that the next one leaves alone."""
    return live.frame(*given, **options).radiance.copy()


@pytest.mark.parametrize("name", SCENES)
def test_a_frame_has_the_bits_of_the_cube(name, folder):
    planned = scene(name, folder)
    cube = hcss_twin.simulate(planned)["radiance"].values
    with live_pass(planned, method="cube", margin_px=0.0) as live:
        # In any order, and at times between, which the cube has not.
        for time_s in (INTERVAL_S, 0.3 * INTERVAL_S, 0.0):
            found = image(live, time_s)
            if time_s in (0.0, INTERVAL_S):
                assert np.array_equal(found, cube[round(time_s / INTERVAL_S)], equal_nan=True)
        listed = {item.what for item in live.omissions}
    assert listed == {item.what for item in hcss_twin.make_plan(planned).omissions if item.bound != 0.0 and item.size}
    assert np.nanstd(cube[0]) > 0.0
