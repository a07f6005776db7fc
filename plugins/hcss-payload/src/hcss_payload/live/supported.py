"""What live frames cannot show."""

from __future__ import annotations

from hcss_payload.checks import PayloadError
from hcss_twin.plan.plan import Plan


def require_supported(plan: Plan) -> None:
    """Raise a :class:`PayloadError` that names what live frames cannot show."""
    scenario = plan.scenario
    generators = plan.assembly.generators
    unsupported = {
        "clouds: not one layer": len(plan.layers) != 1,
        "clouds: no coverage": not any(plan.assembly.cloudy_layers),
        "clouds.generator other than 'fractal'": any(not hasattr(generator, "octaves") for generator in generators),
        "clouds.coverage_mode = 'frame', which has no meaning for a moving camera": any(
            layer.coverage_mode != "field" for layer in plan.layers
        ),
        "clouds: tops of their own": plan.tops is not None,
        "sea.waves: resolved waves": plan.waves is not None,
        "surfaces": plan.surfaces is not None,
        "elements: live frames have a target of their own": bool(plan.assembly.elements),
        "sea.temperature_texture": (scenario.sea.temperature_texture or 0.0) > 0.0,
        "atmosphere.water_vapour_texture": scenario.atmosphere.water_vapour_texture > 0.0,
        "radiance.light: light between columns": plan.light is not None,
        "image.window": scenario.image.window is not None,
        "camera: the twin has its own, as live_pass() gives it": not plan.is_grid,
        "slant.shadows": scenario.slant.shadows,
        "slant.parallax: the camera has its own": scenario.slant.parallax,
        "motion.platform_speed: the trajectory moves the camera": scenario.motion.platform_speed != 0.0,
    }
    names = [name for name, present in unsupported.items() if present]
    if names:
        raise PayloadError(f"scenario: {'; '.join(names)}; allowed: scenarios without, for live frames")
