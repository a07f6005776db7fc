"""The sensor of a scenario that is yet to be run."""

from __future__ import annotations

from hcss_twin.catalog import Catalog
from hcss_twin.errors import Problem, ScenarioError
from hcss_twin.providers import Grid, SensorInputs
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scene.building.assembly import Assembly
from hcss_twin.scene.cube_variables import cube_variables
from hcss_twin.scene.footprint import Window, length
from hcss_twin.scene.sensing.made_sensor import MadeSensor, make_sensor, sensor_bands


def planned_sensor(
    scenario: Scenario, assembly: Assembly, catalog: Catalog, extent: Window
) -> MadeSensor | None:
    """Make the sensor of a scenario, if it has one, for the frames of its cube alone.

    Parameters
    ----------
    extent : (slice, slice)
        Rows and columns of the image that the cube has.

    Raises
    ------
    ScenarioError
        If a key of the section is wrong, or the scenario asks for no radiance.
    """
    if scenario.sensor is None:
        return None
    variables = cube_variables(scenario, assembly, waves=True)
    if "radiance" not in {spec.name for spec in variables}:
        message = 'a [sensor] measures radiance, which is not asked for; allowed: with "radiance" among them'
        raise ScenarioError([Problem("output.variables", message)])
    inputs = SensorInputs(
        bands=sensor_bands(assembly.bands),
        grid=Grid(length(extent[0]), length(extent[1]), assembly.grid.pixel_size_m),
        platform_speed_m_s=assembly.motion.platform_speed_m_s,
        frame_interval_s=assembly.motion.frame_interval_s,
        seed=scenario.seed,
        catalog=catalog,
        corner=(extent[0].start, extent[1].start),
    )
    return make_sensor(scenario.sensor, inputs)
