"""Whether coverage is that of each frame or of the sky, where a layer does not say."""

from __future__ import annotations

from typing import TypeVar

from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.clouds import Layer
from hcss_twin.scenario.models import ScenarioModel
from hcss_twin.scenario.section_types import selected

_Model = TypeVar("_Model", bound=ScenarioModel)


def with_coverage_modes(scenario: _Model, registry: Registry) -> _Model:
    """Return a valid scenario whose layers all have a coverage mode.

    A threshold of each frame shifts between frames and then changes pixels that no cloud moved into, which looks like
    targets. Layers of several frames that differ therefore have one threshold for the sky, if their generator can.
    """
    layers = tuple(
        layer if layer.coverage_mode else layer.model_copy(update={"coverage_mode": _mode(scenario, layer, registry)})
        for layer in scenario.clouds.layers
    )
    return scenario.model_copy(update={"clouds": scenario.clouds.model_copy(update={"layers": layers})})


def _mode(scenario: ScenarioModel, layer: Layer, registry: Registry) -> str:
    motion = scenario.motion
    wind = motion.wind_speed if layer.wind_speed is None else layer.wind_speed
    still = motion.evolution_time == "frozen" and motion.platform_speed == wind == 0.0
    if scenario.frames.count == 1 or still:
        return "frame"
    entry = registry.resolve(Kind.CLOUDS, selected(layer, "generator"))
    # All generators of this package can; their code is not loaded here.
    honours = entry.is_own or "coverage_mode" in getattr(registry.provider_class(entry), "honours", ())
    return "field" if honours else "frame"
