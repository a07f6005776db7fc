"""The plan warns about bands that are narrower than what the coefficients of the band model know."""

from __future__ import annotations

import pytest

from hcss_twin.plan.make_plan import make_plan
from hcss_twin.scenario.scenario import Scenario

SCENE = """
time = 2024-04-20T12:30:00Z
place = {latitude = 35.0, longitude = 150.0}
sea = {temperature = 290.0, wind_speed = 5.0}
atmosphere.profile = "us-standard-1976"
image = {rows = 4, columns = 4}
frames.count = 1
bands = [[13.6, 14.0], [10.0, 10.4]]
"""


@pytest.mark.parametrize(("coefficients", "warned"), [("rrtmgp", ["13.6-14um"]), ("lowtran7", [])])
def test_channels_inside_the_structure_of_carbon_dioxide_are_named(coefficients, warned):
    plan = make_plan(Scenario.from_toml(SCENE, {"atmosphere.coefficients": coefficients}))
    told = [note.split("'")[1] for note in plan.notes if "fitted to whole RRTMGP bands" in note]
    assert told == warned
