"""What sides of clouds add is weakened by smoke: Monte Carlo in air with the smoke of a pixel, and smoke everywhere."""

import numpy as np
import pytest
from hcss_light.comparison import SampledClouds
from light_scene import DAY, scene

from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.engine.stream import PartMaker
from hcss_twin.engine.tables.over_point_effect import PointEffectStates
from hcss_twin.plan.make_plan import make_plan

pytest.importorskip("hcss_examples")

CUMULUS = {"type": "cumulus", "generator": "fractal", "coverage": 0.45, "coverage_mode": "field"}
COMMON = {
    "slant": {"shadows": "off", "parallax": "off"}, "sea": {"temperature_texture": 0.0}, "clouds": CUMULUS,
    "time": DAY, "bands": [[3.6, 3.8]], "accuracy": 2e-2, "view": {"zenith": 40.0, "azimuth": 30.0},
    "image": {"rows": 20, "columns": 20, "pixel_size": 100.0},
}  # fmt: skip
RIDGE = {"smoke": {"optical_depth": 1.0, "width": 1000.0}}


def radiance_of(plan):
    window = slice(0, plan.image.rows), slice(0, plan.image.columns)
    return PartMaker(plan, tables_of(plan)).part(0, window)[0]["radiance"][0].astype(float)


def in_same_smoke(plan, value):
    """The plan with the smoke of a value at all points, as its air."""
    (planned,) = plan.point_effects
    return PointEffectStates(plan, planned).plan_in(plan, value)


def plan_of(light, model="physical", **smoke):
    return make_plan(scene(light, model=model, **COMMON, **smoke))


@pytest.mark.parametrize(
    ("light", "model"),
    [("source", "as-printed"), ("source", "physical"), pytest.param("slant", "physical", marks=pytest.mark.campaign)],
)
def test_smoke_that_is_the_same_everywhere_is_that_of_the_air(light, model):
    """Whatever columns emit: those of the model that is not physical take a tenth of the time."""
    everywhere = {"smoke": {"optical_depth": 1.0, "width": 1e6}}
    plan = plan_of(light, model, **everywhere)
    smoky, of_air = radiance_of(plan), radiance_of(in_same_smoke(plan, 1.0))
    np.testing.assert_allclose(smoky, of_air, rtol=5e-3)
    clear = [radiance_of(plan_of(of, model)) for of in (light, "columns")]
    unweakened = radiance_of(plan_of("columns", model, **everywhere)) + clear[0] - clear[1]
    assert np.max(np.abs(unweakened / of_air - 1.0)) > 0.03


def test_clouds_with_sides_in_smoke_agree_with_monte_carlo_in_the_smoke_of_each_pixel():
    """Columns err several times as much, and so does light between columns of the air without smoke."""
    plan = plan_of("source", **RIDGE)
    (planned,) = plan.point_effects
    pixels = [(row, column) for row in (3, 9, 15) for column in (2, 8, 14)]
    found, values = [], PointEffectStates(plan, planned)
    for number, (row, column) in enumerate(pixels):
        value = float(values.values(0.0, (slice(row, row + 1), slice(column, column + 1))).item())
        alone = in_same_smoke(plan, value)
        inputs = LightStage.inputs(alone, tables_of(plan).spectrum.nodes)
        sampled = SampledClouds(alone, inputs)
        mean, _ = sampled.radiance((row, column), 0.0, FrameClouds(alone, 0.0), alone.sun_at(0.0), 1500, number)
        found.append(mean[0, 0])
    made = {of: radiance_of(plan_of(of, **RIDGE)) for of in ("source", "columns")}
    clear = {of: radiance_of(plan_of(of)) for of in made}
    made["unweakened"] = made["columns"] + clear["source"] - clear["columns"]
    error = {of: np.sqrt(np.mean([(seen[at] / mean - 1.0) ** 2 for at, mean in zip(pixels, found, strict=True)]))
             for of, seen in made.items()}  # fmt: skip
    assert error["source"] < 0.4 * error["columns"]
    assert error["source"] < 0.85 * error["unweakened"]
