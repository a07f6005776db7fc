"""The coverage mode of layers that do not state one: the sky has one threshold where frames differ."""

import datetime
import json

import pytest

from hcss_twin import Scenario

GIVEN = {"place": {"latitude": 0.0, "longitude": 0.0}, "time": datetime.datetime(2024, 1, 1, tzinfo=datetime.UTC)}

FIELD, FRAME = "field", "frame"
STILL = {"motion": {"wind_speed": 0.0, "evolution_time": "frozen"}}


@pytest.mark.parametrize(
    ("keys", "layer", "expected"),
    [
        ({}, {}, FIELD),
        ({}, {"coverage_mode": "frame"}, FRAME),
        ({"frames": {"count": 1}}, {}, FRAME),
        (STILL, {}, FRAME),
        (STILL, {"wind_speed": 5.0}, FIELD),
        (STILL | {"platform": {"altitude": 7e5, "mode": "push-broom"}}, {}, FIELD),
    ],
)
def test_frames_that_differ_have_one_threshold_for_the_sky(keys, layer, expected):
    scenario = Scenario.from_dict({**GIVEN, **keys, "clouds": {"layers": [layer, {"type": "cirrus"} | layer]}})
    assert [each.coverage_mode for each in scenario.clouds.layers] == [expected, expected]
    again = Scenario.from_dict(json.loads(scenario.to_json()), {"frames.count": 1})
    assert [each.coverage_mode for each in again.clouds.layers] == [expected, expected]
