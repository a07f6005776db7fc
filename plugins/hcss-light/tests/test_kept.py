"""Light that is kept while clouds drift: frames against the same frames computed afresh."""

from functools import cache

import numpy as np
import pytest

from hcss_twin import Scenario
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import PartMaker
from hcss_twin.plan.make_plan import make_plan


@cache
def scene(time, band, evolution="frozen", count=40, interval=1.0):
    values = {
        "time": f"2024-04-20T{time}:30:00+10:00",
        "place": {"latitude": 20.0, "longitude": 150.0},
        "view": {"zenith": 45.0},
        "image": {"rows": 24, "columns": 24, "pixel_size": 100.0},
        "frames": {"count": count, "interval": interval},
        "motion": {"wind_speed": 10.0, "wind_from": 250.0, "evolution_time": evolution},
        "accuracy": 0.02,
        "bands": [band],
        "clouds": {"type": "cumulus", "generator": "fractal", "coverage": 0.5},
        "output": {"variables": ["radiance"], "certificate": 0},
        "radiance": {"light": "source"},
    }
    plan = make_plan(Scenario.from_dict(values))
    return plan, tables_of(plan)


@cache
def kept_frame(*given):
    return frame(PartMaker(*scene(*given)), 17)


def frame(maker, number, rows=slice(0, 24), columns=slice(0, 24), time_s=None):
    return maker.part(number, (rows, columns), time_s=time_s)[0]["radiance"][0]


@pytest.mark.parametrize(
    ("time", "band", "evolution", "allowed"),
    [
        ("23", (10.5, 11.0), "frozen", 2e-3),
        pytest.param("23", (3.6, 3.8), 1800.0, 1e-2, marks=pytest.mark.campaign),
        ("14", (3.6, 3.8), 1800.0, 0.12),
    ],
)
def test_frames_between_two_instants_have_the_radiance_of_light_computed_afresh(time, band, evolution, allowed):
    """Clouds have moved by parts of a pixel; by day light on other pixels differs by several percent."""
    # Of frames so far apart no light is kept.
    afresh = PartMaker(*scene(time, band, evolution, count=2, interval=34.0))
    drifted, exact = kept_frame(time, band, evolution), frame(afresh, 0, time_s=17.0)
    assert np.any(drifted != exact)
    assert np.sqrt(np.mean((drifted - exact) ** 2)) < allowed * exact.mean()
    assert abs(np.mean(drifted - exact)) < 0.3 * allowed * exact.mean()


def test_a_window_of_a_frame_between_two_instants_has_the_bits_of_the_frame():
    given = "14", (3.6, 3.8), 1800.0
    part = frame(PartMaker(*scene(*given)), 17, slice(5, 21), slice(9, 24))
    np.testing.assert_array_equal(part, kept_frame(*given)[5:21, 9:24])


def test_light_is_computed_once_while_clouds_drift(monkeypatch):
    from hcss_light import transport

    calls = []
    compute = transport.scattered_source
    maker = PartMaker(*scene("23", (10.5, 11.0), "frozen"))
    frame(maker, 3)

    def counted(slices, density, *rest):
        calls.append(density.shape)
        return compute(slices, density, *rest)

    monkeypatch.setattr(transport, "scattered_source", counted)
    for number in (4, 5, 6):
        frame(maker, number)
    assert calls == []
