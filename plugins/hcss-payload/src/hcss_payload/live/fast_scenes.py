"""What fast frames cannot show, so that frames of the stages of cubes do."""

from __future__ import annotations

from hcss_payload.build import Payload
from hcss_twin import Scenario
from hcss_twin.plan.combinations import Excluded
from hcss_twin.plan.plan import Plan

EFFECT = "fast frames"


def excluded_by_scenario(scenario: Scenario) -> tuple[Excluded, ...]:
    """Return what a scenario has that fast frames cannot show: beyond one layer of cloud over the sea, nearly all."""
    sea, slant, count = scenario.sea, scenario.slant, len(scenario.clouds.layers)
    vapour = (scenario.atmosphere.water_vapour_texture or 0.0) > 0.0
    speed = scenario.motion.platform_speed != 0.0
    return (
        Excluded("clouds.layers", count != 1, f"{count} layers of cloud", "one layer"),
        Excluded("sea.waves", sea.waves == "on", "a sea of resolved waves", "'auto' or 'off'"),
        Excluded("surfaces", scenario.surfaces is not None, "a map of the ground", "sea everywhere"),
        Excluded("elements", bool(scenario.elements), "elements", "the target of the frames"),
        Excluded("atmosphere.water_vapour_texture", vapour, "texture of vapour", "0"),
        Excluded("image.window", scenario.image.window is not None, "a part of an image", "to leave it out"),
        Excluded("slant.shadows", slant.shadows == "on", "shadows", "'auto' or 'off'"),
        Excluded("slant.parallax", slant.parallax == "on", "parallax of flat layers", "'auto' or 'off'"),
        Excluded("motion.platform_speed", speed, "motion of another platform", "0"),
    )


def excluded_by_plan(plan: Plan) -> tuple[Excluded, ...]:
    """Return what else fast frames cannot show, which the plan of a scenario knows."""
    assembly, clear = plan.assembly, not any(plan.assembly.cloudy_layers)
    fractal = all(hasattr(generator, "octaves") for generator in assembly.generators)
    frames = any(layer.coverage_mode != "field" for layer in plan.layers)
    return (
        Excluded("clouds.layers", len(plan.layers) == 1 and clear, "a layer without coverage", "some coverage"),
        Excluded("clouds.generator", not fractal, "clouds that are no fractal field", "'fractal'"),
        Excluded("clouds.coverage_mode", frames, "'frame', one coverage of every image,", "'field'"),
        Excluded("clouds.generator", assembly.tops_vary, "cloud tops that vary with the generator", "one without"),
        Excluded("atmosphere", bool(plan.air_by_place), "a field of several profiles", "one profile"),
        Excluded("radiance.light", plan.light.name != "columns", "light between columns", "'columns'"),
        *(
            Excluded(planned.effect.name, True, "an effect of points", "to leave it out")
            for planned in plan.point_effects
        ),
    )


def excluded_by_payload(payload: Payload) -> tuple[Excluded, ...]:
    """Return what a camera has that fast frames cannot show."""
    beyond, climate = f"camera.beyond = '{payload.beyond}'", f"camera.climate = '{payload.climate}'"
    return (
        Excluded("camera.line_time", payload.line_s != 0.0, "lines that are read in turn", "0"),
        Excluded("camera.beyond", payload.beyond != "refuse", beyond, "'refuse'"),
        Excluded("camera.climate", payload.climate != "place", climate, "'place'"),
    )
