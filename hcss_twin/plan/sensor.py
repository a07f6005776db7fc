"""The sensor of a scenario, built for its bands and its image."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ProviderError, ScenarioError, choose_from
from hcss_twin.cube.sensor_cube import MEASURED_RADIANCE, RADIANCE, measured_variables
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.models.sensor.detector import band_radiance_per_kelvin
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.builder import attribute_to_field, scene_info
from hcss_twin.plan.effects import Effect
from hcss_twin.plan.output import cube_variables
from hcss_twin.plan.sensor_stages import Source, Stage, with_points
from hcss_twin.plan.windows import Window, length, relative
from hcss_twin.providers import Grid, Points, SceneInfo, SensorBand, SensorInputs
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.scenario.bands import sensor_bands
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.sensor import SensorSection

ALL = "all"

INSTANTS_S = 10.0
"""Longest time between instants for which the reach of rays and of the sun's paths is found."""


@dataclass(frozen=True)
class BuiltSensor(Effect):
    """A guarded sensor and its settings.

    Attributes
    ----------
    section : SensorSection
        The user's settings.
    stages : tuple of Stage
        One, or those of a chain.
    variables : tuple of VariableSpec
        Measured radiance and further requested variables.
    inputs : SensorInputs
        Inputs of the provider.
    cube : (slice, slice)
        Rows and columns of the measured image to store.
    from_scene : bool
        Whether its frames include the computed scene around the cube.
    edge_note : str or None
        Note on blur at the edges.
    scene : SceneInfo or None
        What its stages may know of the scene.
    """

    kind = "sensor"

    section: SensorSection
    stages: tuple[Stage, ...]
    variables: tuple[VariableSpec, ...]
    inputs: SensorInputs
    cube: Window
    from_scene: bool = False
    edge_note: str | None = None
    scene: SceneInfo | None = None

    def measuring(self, names: tuple[str, ...]) -> BuiltSensor:
        """Return the sensor with the measured radiance and the named variables, whatever was requested."""
        return replace(self, variables=measured_variables(names))

    def reseeded(self, seed: int) -> BuiltSensor:
        """Return the same sensor with other random numbers in all stages."""
        stages = tuple(stage.model_copy(update={"seed": None}) for stage in self.section.stages)
        section = self.section.model_copy(update={"seed": seed, "stages": stages})
        return replace(self, stages=make_sensor(section, self.inputs, scene=self.scene).stages)

    def in_sky(self, scenario: Scenario, catalog: Catalog, assembly: Assembly, times_s: Array) -> BuiltSensor:
        """Return the sensor of the same scene under another sky, that of a scenario, in frames at some times.

        Raises
        ------
        ScenarioError
            If a generator has no clouds at an instant that the sensor asks for.
        """
        section = scenario.sensor or self.section
        inputs = replace(self.inputs, seed=scenario.seed, catalog=catalog)
        stages = make_sensor(section, inputs, scene=self.scene).stages
        sensor = replace(self, section=section, inputs=inputs, stages=stages)
        require_instants(sensor, assembly, float(times_s[0]), float(times_s[-1]))
        return sensor

    @staticmethod
    def radiance_per_kelvin(band: SensorBand, temperature_K: float) -> float:
        """Return the change of the radiance of a black body in a band with its temperature, W m-2 sr-1 K-1."""
        return band_radiance_per_kelvin(band, temperature_K)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes for users."""
        notes = [note for stage in self.stages for note in stage.provider.declares.notes]
        notes += [
            f"{stage.entry.label} asks for the scene {stage.instants[0]:g} to {stage.instants[1]:g} s after each "
            "frame: every instant is computed as a frame is"
            for stage in self.stages
            if stage.instants is not None
        ]
        return (*dict.fromkeys(notes), *(() if self.edge_note is None else (self.edge_note,)))

    @property
    def remembers(self) -> bool:
        """Whether a measurement depends on earlier frames."""
        return any(stage.provider.declares.remembers for stage in self.stages)

    @property
    def asking(self) -> list[Stage]:
        """Stages that may ask for the scene at other times than those of frames."""
        return [stage for stage in self.stages if stage.instants is not None]

    @property
    def instants(self) -> tuple[float, float]:
        """Earliest and latest time of the scene that all stages together need, s after a frame."""
        known = [stage.instants for stage in self.stages if stage.instants is not None]
        # a stage measures both at the time of the frame and at the instants of later stages
        return sum(min(low, 0.0) for low, _ in known), sum(max(high, 0.0) for _, high in known)

    def reached_s(self, times_s: Array) -> Array:
        """Return times between which the scene is needed, close to one another, for frames at some times (F,)."""
        low, high = self.instants
        instants = np.linspace(low, high, 2 + math.ceil((high - low) / INSTANTS_S)) if high > low else np.zeros(1)
        return np.unique(times_s[:, None] + instants)

    @property
    def reach(self) -> int:
        """Distance in pixels within which other pixels contribute to a pixel; 0 also if unknown."""
        return sum(stage.provider.declares.reach_pixels or 0 for stage in self.stages)

    @property
    def given(self) -> Window:
        """Rows and columns of the measured image."""
        return _extent(self.inputs)

    @property
    def title(self) -> str:
        """Title for users."""
        return ", then ".join(stage.title for stage in self.stages)

    def measure(
        self, radiance: NDArray[np.float32], frame: int, time_s: float, points: Points | None = None
    ) -> dict[str, NDArray[Any]]:
        """Return each variable of a frame (B, y, x) in its type, for the pixels of the cube.

        Parameters
        ----------
        radiance : ndarray of float32 (B, y, x)
            Radiance of the whole measured area.
        points : Points, optional
            Small elements, which the radiance lacks; in the pixels that hold them for stages that know no points.

        Raises
        ------
        ProviderError
            If the sensor violates its contract.
        """
        given: NDArray[Any] = radiance
        found = dict[str, tuple[NDArray[Any], Entry]]()
        for stage in self.stages:
            measured, points = stage.measure(given, frame, time_s, points)
            given = measured.radiance
            names = (RADIANCE, *stage.provider.variables)
            found |= {name: (getattr(measured, name), stage.entry) for name in names}
        if points is not None:
            found[RADIANCE] = with_points(given, points), found[RADIANCE][1]
        inner = relative(self.cube, self.given)
        return {
            spec.name: _stored(found[spec.name][0][:, *inner], spec, found[spec.name][1]) for spec in self.variables
        }

    def described(self) -> Mapping[str, Any]:
        """Return the settings."""
        return {"sensor": self.as_dict()}

    def as_dict(self) -> dict[str, Any]:
        """Plain values for plan and provenance."""
        origin, notes = "scene" if self.from_scene else "cube", list(self.notes)
        if len(self.stages) == 1:
            return {**self.stages[0].as_dict(measured_from=origin), "notes": notes}
        stages = [stage.as_dict() for stage in self.stages]
        return {"title": self.title, "measured_from": origin, "stages": stages, "notes": notes}


class NoSensor(BuiltSensor):
    """No sensor, which measures nothing."""

    varies = False

    def in_sky(self, scenario: Scenario, catalog: Catalog, assembly: Assembly, times_s: Array) -> BuiltSensor:
        """Return itself."""
        return self


def make_sensor(
    section: SensorSection, inputs: SensorInputs, source: Source | None = None, scene: SceneInfo | None = None
) -> BuiltSensor:
    """Build the sensor of a section for frames without surroundings.

    Parameters
    ----------
    inputs : SensorInputs
        With the scenario's seed, which the section may override.
    source : callable, optional
        The scene at other instants.
    scene : SceneInfo, optional
        For sensors that take it.

    Raises
    ------
    ScenarioError
        Names the invalid key.
    ProviderError
        If the sensor model is broken.
    """
    stages = Stage.build(section, inputs, source, scene)
    variables = measured_variables(_wanted(section.variables, stages))
    return BuiltSensor(section, stages, variables, inputs, _extent(inputs), scene=scene)


def _extent(inputs: SensorInputs) -> Window:
    (row, column), grid = inputs.corner, inputs.grid
    return slice(row, row + grid.rows), slice(column, column + grid.columns)


def _wanted(asked: tuple[str, ...], stages: Sequence[Stage]) -> tuple[str, ...]:
    """Names of the variables other than radiance."""
    given = tuple(dict.fromkeys(name for stage in stages for name in stage.provider.variables))
    for name in asked:
        if name not in (*given, ALL, MEASURED_RADIANCE.name):
            whose = f"the sensor '{stages[0].entry.name}'" if len(stages) == 1 else "any stage of the sensor"
            message = f"'{name}' is not an output of {whose} with these parameters"
            raise ScenarioError([Problem("sensor.variables", f"{message}; {choose_from(name, (*given, ALL))}")])
    return given if ALL in asked else tuple(name for name in given if name in asked)


def _stored(array: NDArray[Any], spec: VariableSpec, entry: Entry) -> NDArray[Any]:
    if array.dtype == np.float64 and float(np.abs(array).max(initial=0.0)) > float(np.finfo(spec.dtype).max):
        raise ProviderError(f"{entry.label}: {spec.name} is too large for {spec.dtype}")
    return np.ascontiguousarray(array, dtype=spec.dtype)


def planned_sensor(scenario: Scenario, assembly: Assembly, catalog: Catalog, extent: Window) -> BuiltSensor:
    """Build the sensor of a scenario for the frames of the cube alone.

    Parameters
    ----------
    extent : (slice, slice)
        Rows and columns of the image in the cube.

    Raises
    ------
    ScenarioError
        If a key of the section is invalid, or no variable of the frames is requested.
    """
    inputs = SensorInputs(
        bands=sensor_bands(assembly.bands),
        grid=Grid(length(extent[0]), length(extent[1]), assembly.grid.pixel_size_m),
        platform_speed_m_s=assembly.motion.platform_speed_m_s,
        frame_interval_s=assembly.motion.frame_interval_s,
        seed=scenario.seed,
        catalog=catalog,
        corner=(extent[0].start, extent[1].start),
    )
    if scenario.sensor is None:
        return NoSensor(SensorSection.model_validate({}), (), (), inputs, extent)
    if all(spec.kind == "geometry" for spec in cube_variables(scenario, assembly, waves=True)):
        message = '[sensor] measures frames, of which no variable is requested; allowed: a list with "radiance"'
        raise ScenarioError([Problem("output.variables", message)])
    return make_sensor(scenario.sensor, inputs, scene=scene_info(scenario))


def require_instants(sensor: BuiltSensor, assembly: Assembly, first_s: float, last_s: float) -> None:
    """Check that the scene is known at every instant that the stages may ask for.

    Parameters
    ----------
    first_s, last_s : float
        Times of the first and the last frame.

    Raises
    ------
    ScenarioError
        If a generator has no clouds at such an instant.
    """
    if sensor.instants == (0.0, 0.0):
        return
    pixel = slice(0, 1), slice(0, 1)
    for generator in (candidate for candidate in assembly.generators if candidate.declares.tileable):
        for time_s in (first_s + sensor.instants[0], last_s + sensor.instants[1]):
            with attribute_to_field(f"{sensor.asking[0].field}.model"):
                generator.thickness_m(time_s, *pixel)


def asking(sensor: BuiltSensor, source: Source) -> BuiltSensor:
    """Return a sensor whose stages can ask for the scene at other instants; itself if none does."""
    if not sensor.asking:
        return sensor
    built = make_sensor(sensor.section, sensor.inputs, source, sensor.scene)
    return replace(sensor, stages=built.stages)
