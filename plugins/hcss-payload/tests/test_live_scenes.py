"""Live frames of scenes that only cubes showed: the pixels of the cube at its times, from the same stages."""

import json

import numpy as np
import pytest
from camera_scenes import PASS, merged, scenario
from hcss_payload import PayloadError, Pose, pose_at
from hcss_payload.build import payload_of
from hcss_payload.live import LiveTwin, PointTarget, live_pass
from payload_scenes import RADIOMETER

import hcss_twin
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.engine.sense import measured_path

SHORT = {"frames": {"count": 2, "interval": 60.0}, "output": {"certificate": 0}}
STRATUS = {"type": "stratus", "coverage": 0.4, "coverage_mode": "field"}
CIRRUS = {"type": "cirrus", "coverage": 0.5, "coverage_mode": "field"}
ALTOSTRATUS = {"type": "altostratus", "coverage": 0.3, "coverage_mode": "field"}
SHIP = {"latitude": 30.0, "longitude": 150.0, "altitude": 0.0, "intensity": {"lwir": 2e6}}
PLUME = {"latitude": 30.01, "longitude": 150.01, "altitude": 9000.0, "intensity": {"lwir": 5e5}}
SMEAR = {"integration_time": 0.012, "points": 4}

SCENES = {
    "two layers": {"clouds": {"layers": [STRATUS, CIRRUS]}},
    "three layers": {"clouds": {"layers": [STRATUS, ALTOSTRATUS, CIRRUS]}},
    "no clouds": {"clouds": {"layers": []}},
    "clouds of an image": {"clouds": STRATUS | {"generator": "scattered"}},
    "a coast": {"place": {"latitude": 33.6, "longitude": 135.5}, "surfaces": {"provider": "coast"}},
    "small elements": {"elements": [{"provider": "point-sources", "parameters": {"tracks": [SHIP, PLUME]}}]},
    "lines read in turn": {"camera": PASS["camera"] | {"line_time": 2e-3}},
    "a scene that smears": {"camera": PASS["camera"] | SMEAR, "attitude": {"provider": "push-broom", "roll": -20.0}},
    "the limb": {"camera": PASS["camera"] | {"beyond": "missing", "focal_length": 0.004}},
}
"""Parts of scenarios that fast frames cannot show."""
