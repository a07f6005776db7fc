"""Plans of a scene under other skies, against planning the same scenarios anew."""

import json

import numpy as np
import pytest
from cheap import CHEAP, NARROW

from hcss_twin import Scenario, ScenarioError, make_plan
from hcss_twin.core.errors import OptionError
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import PartMaker
from hcss_twin.engine.tables.table_key import table_key
from hcss_twin.plan import make_plan as make_plan_module

TRACK = {"x": 50.0, "y": -20.0, "altitude": 6000.0, "velocity": [100.0, 50.0, 0.0], "intensity": {"mwir": 5.0}}
TRACK["intensity"]["lwir"] = 20.0
BODY = {"x": -80.0, "y": 10.0, "altitude": 3000.0, "temperature": 320.0, "area": 200.0}

SCENE = CHEAP | {
    "time": "2024-04-20T12:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "image": {"rows": 24, "columns": 20, "pixel_size": 20.0},
    "frames": {"count": 2, "interval": 2.0},
    "view.zenith": 20.0,
    "bands": NARROW,
    "clouds.layers": [{"type": "stratus", "coverage": 0.6}, {"type": "cirrus", "coverage": 0.4, "edge_taper": 0.1}],
    "elements": [{"parameters": {"tracks": [TRACK]}}],
    "sensor.parameters": {"psf": "gaussian", "psf_sigma": 0.7, "noise": "nedt", "nedt": 0.05},
}

WHOLE = {"slant.shadows": "on", "slant.parallax": "on", "sea.temperature_texture": 0.2}
WAVES = {"sea.model": "rough-sea", "sea.waves": "on"}


def scenario(**changes):
    return Scenario.from_dict({}, SCENE | changes)


def frames(plan):
    """Return radiance and truth of elements of all frames, and what the sensor makes of the radiance."""
    maker, found = PartMaker(plan, tables_of(plan)), []
    for index, time_s in enumerate(plan.frame_times_s):
        arrays, _ = maker.part(index, plan.sensor.given if plan.sensor.stages else plan.extent)
        found += [arrays[name] for name in sorted(arrays)]
        if plan.sensor.stages:
            found += plan.sensor.measure(arrays["radiance"], index, float(time_s)).values()
    return found


def again(plan):
    """Plan the scenario of a plan anew."""
    return make_plan(Scenario.from_dict(json.loads(plan.scenario.to_json())))


def same(one, other):
    return len(one) == len(other) and all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("changes", [{}, WHOLE, WAVES], ids=["columns", "slant paths and texture", "waves"])
def test_a_redrawn_plan_computes_what_its_scenario_computes(changes):
    plan = make_plan(scenario(**changes))
    layers = [{"coverage": 0.3}, {"edge_taper": 0.5}]
    redrawn = plan.redrawn(77, layers, [{"tracks": [BODY, TRACK]}], sensor_seed=5)
    assert redrawn.scenario.seed == 77
    assert redrawn.scenario.sensor.seed == 5
    assert redrawn.scenario.clouds.layers[1].coverage == 0.4
    found = frames(redrawn)
    assert same(found, frames(again(redrawn)))
    assert same(found, frames(again(redrawn).redrawn(1).redrawn(77)))
    before = frames(plan)
    assert not any(np.array_equal(a, b) for a, b in zip(found, before, strict=True) if a.shape == b.shape and a.any())


def test_it_shares_tables_and_plans_nothing_again(monkeypatch):
    plan = make_plan(scenario())
    monkeypatch.setattr("hcss_twin.plan.make_plan._make_plan", None)
    assert table_key(plan.redrawn(3, [{"coverage": 0.9}])) == table_key(plan)
    with pytest.raises(TypeError):
        plan.redrawn(3, [{"coverage": 0.0}, {"coverage": 0.0}])


def test_scenes_of_one_process_that_differ_in_seeds_alone_are_planned_once(monkeypatch):
    shelf, planned, plans = ResultCache(several=True), [], make_plan_module._make_plan
    monkeypatch.setattr(make_plan_module, "_make_plan", lambda *given: planned.append(given[0].seed) or plans(*given))
    scenes = [scenario(**WAVES), scenario(**WAVES, seed=3), scenario(**WAVES, seed=4, **{"sensor.seed": 7})]
    shared = [make_plan(scene, shelf=shelf) for scene in scenes]
    assert len(planned) == 1
    for plan, scene in zip(shared, scenes, strict=True):
        assert plan.scenario is scene
        fresh = make_plan(scene)
        assert same(frames(plan), frames(fresh))
        assert (plan.notes, plan.filled_in, plan.omissions) == (fresh.notes, fresh.filled_in, fresh.omissions)
    make_plan(scenario(**WAVES, **{"sea.temperature": 289.0}), shelf=shelf)
    assert len(planned) == 5


@pytest.mark.parametrize("coverage", [0.0, 1.0])
def test_a_sky_without_clouds_or_without_gaps_is_planned_anew(coverage):
    plan = make_plan(scenario())
    redrawn = plan.redrawn(9, [{"coverage": coverage}, {"coverage": coverage}])
    fresh = again(redrawn)
    assert redrawn.assembly.has_cloud == fresh.assembly.has_cloud == bool(coverage)
    assert redrawn.omissions == fresh.omissions
    assert same(frames(redrawn), frames(fresh))


def test_what_a_scenario_may_not_say_is_refused_by_name():
    plan = make_plan(scenario())
    with pytest.raises(ScenarioError, match=r"clouds.layers\[1\].coverage"):
        plan.redrawn(1, [{}, {"coverage": 1.5}])
    with pytest.raises(ScenarioError, match=r"elements\[0\].*altitude"):
        plan.redrawn(1, elements=[{"tracks": [TRACK | {"altitude": -5.0}]}])
    with pytest.raises(OptionError, match=r"type.*allowed: coverage, edge_taper"):
        plan.redrawn(1, [{"type": "cirrus"}])
    with pytest.raises(OptionError, match=r"elements: 2 given.*has 1"):
        plan.redrawn(1, elements=[{}, {}])
    with pytest.raises(OptionError, match=r"layers: 3 given.*has 2"):
        plan.redrawn(1, [{}, {}, {}])
