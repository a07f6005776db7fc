"""The variables of a scene's cube."""

from __future__ import annotations

from hcss_twin.cube.variables import VariableSpec, expand
from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scene.building.assembly import Assembly


def cube_variables(
    scenario: Scenario, assembly: Assembly, waves: bool, wanted: tuple[str, ...] | None = None
) -> tuple[VariableSpec, ...]:
    """Return the variables of a scenario, or those wanted instead of what it asks for.

    Parameters
    ----------
    waves : bool
        Whether waves are drawn.

    Raises
    ------
    ScenarioError
        If there is no such variable.
    """
    layers, shadows = len(assembly.layers), scenario.slant.shadows
    wanted = tuple(scenario.output.variables) if wanted is None else wanted
    try:
        altitude = scenario.platform.altitude is not None
        moves = assembly.motion.platform_speed_m_s != 0.0
        return tuple(expand(wanted, assembly.model.terms, layers, shadows, waves, altitude, moves))
    except ValueError as error:
        raise ScenarioError([Problem("output.variables", str(error))]) from error


def wants_radiance(variables: tuple[VariableSpec, ...]) -> bool:
    """Whether any of the variables needs radiance."""
    return any(spec.needs_radiance for spec in variables)
