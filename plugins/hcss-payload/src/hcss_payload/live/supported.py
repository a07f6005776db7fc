"""What live frames cannot show."""

from __future__ import annotations

from hcss_twin.plan.combinations import Excluded, require_none
from hcss_twin.plan.plan import Plan


def require_supported(plan: Plan) -> None:
    """Refuse a scene that live frames cannot show.

    Raises
    ------
    ScenarioError
        Names the field of everything that they cannot show.
    """
    require_none("live frames", excluded_beside_live_frames(plan))


def excluded_beside_live_frames(plan: Plan) -> tuple[Excluded, ...]:
    """Return what live frames cannot show: beyond one layer of fractal clouds over the sea, nearly all."""
    scenario, assembly = plan.scenario, plan.assembly
    sea, slant, clear = scenario.sea, scenario.slant, not any(assembly.cloudy_layers)
    fractal = all(hasattr(generator, "octaves") for generator in assembly.generators)
    frames = any(layer.coverage_mode != "field" for layer in plan.layers)
    vapour, texture = scenario.atmosphere.water_vapour_texture > 0.0, (sea.temperature_texture or 0.0) > 0.0
    speed = scenario.motion.platform_speed != 0.0
    return (
        Excluded("clouds.layers", len(plan.layers) != 1, f"{len(plan.layers)} layers of cloud", "one layer"),
        Excluded("clouds.layers", len(plan.layers) == 1 and clear, "a layer without coverage", "some coverage"),
        Excluded("clouds.generator", not fractal, "clouds that are no fractal field", "'fractal'"),
        Excluded("clouds.coverage_mode", frames, "'frame', one coverage of every image,", "'field'"),
        Excluded("clouds.generator", assembly.tops_vary, "cloud tops that vary with the generator", "one without"),
        Excluded("sea.waves", plan.waves is not None, "a sea of resolved waves", "'off'"),
        Excluded("surfaces", assembly.surfaces is not None, "a map of the ground", "sea everywhere"),
        Excluded("elements", bool(assembly.elements), "elements", "the target of the frames"),
        Excluded("sea.temperature_texture", texture, "texture of the sea", "0"),
        Excluded("atmosphere.water_vapour_texture", vapour, "texture of vapour", "0"),
        Excluded("radiance.light", plan.light is not None, "light between columns", "'columns'"),
        Excluded("image.window", scenario.image.window is not None, "a part of an image", "to leave it out"),
        Excluded("camera", not plan.is_grid, "another camera", "that of live_pass()"),
        Excluded("slant.shadows", slant.shadows == "on", "shadows", "'auto' or 'off'"),
        Excluded("slant.parallax", slant.parallax == "on", "parallax of flat layers", "'auto' or 'off'"),
        Excluded("motion.platform_speed", speed, "motion of another platform", "0"),
    )
