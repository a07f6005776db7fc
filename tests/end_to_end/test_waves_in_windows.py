"""Waves of a clear scene are in every window of a frame."""

from functools import partial

import numpy as np
from cheap import NARROW

from hcss_twin import Scenario, make_plan
from hcss_twin.engine import stream
from hcss_twin.engine.compile import tables_of
from hcss_twin.plan.windows import windows

SCENE = {
    "time": "2024-04-20T12:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "image": {"rows": 30, "columns": 40, "pixel_size": 10.0},
    "frames": {"count": 1},
    "bands": NARROW[1:],
    "accuracy": 1e-2,
    "radiance": {"model": "as-printed"},
    "sea": {"waves": "on", "model": "rough-sea", "wind_speed": 10.0},
    "output": {"variables": ["radiance"], "certificate": 0},
}


def test_a_clear_scene_of_several_windows_keeps_the_waves_of_each(monkeypatch):
    plan = make_plan(Scenario.from_dict(SCENE))
    tables = tables_of(plan)
    whole = next(stream.stream(plan, tables))["radiance"]
    monkeypatch.setattr(stream, "windows", partial(windows, most_points=300))
    strips = next(stream.stream(plan, tables))["radiance"]
    np.testing.assert_allclose(strips, whole, rtol=1e-6)
    assert np.all(strips.std(axis=2) > 0.0)
