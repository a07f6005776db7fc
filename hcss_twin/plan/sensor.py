"""The sensor that a scenario's section selects, made for its bands and image.

The sensor of a scenario that is yet to be run.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ValidationError

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import Problem, ProviderError, ScenarioError, choose_from
from hcss_twin.cube.sensor_cube import MEASURED_RADIANCE, measured_variables
from hcss_twin.cube.variables import VariableSpec
from hcss_twin.models.radiance.spectral_grid import SpectralBand
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.builder import attribute_to_field
from hcss_twin.plan.output import cube_variables
from hcss_twin.plan.windows import Window, length, relative
from hcss_twin.providers import Grid, Measured, SensorBand, SensorInputs
from hcss_twin.providers import Sensor as SensorModel
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.guard import guard
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.scenario.problems import problems_from
from hcss_twin.scenario.scenario import Scenario
from hcss_twin.scenario.sensor import NamedSensor, SensorSection, choose_sensor, load_sensor

ALL = "all"


@dataclass(frozen=True)
class MadeSensor:
    """A sensor, built and guarded.

    Attributes
    ----------
    section : SensorSection
        What the user asked for.
    named : NamedSensor or None
        The file it names.
    entry : Entry
        Who brings the model.
    parameters : mapping
        All of them, with defaults; empty where the model has none.
    provider : hcss_twin.providers.Sensor
    variables : tuple of VariableSpec
        Measured radiance and what was asked for beside it.
    seed : int
    inputs : SensorInputs
        What the provider was made from.
    cube : (slice, slice)
        Rows and columns of the image that are kept of what is measured.
    from_scene : bool
        Whether it is given frames with the scene around them, as it is computed, and not those of a cube alone.
    edge_note : str or None
        What users should know about blur at the edges.
    """

    section: SensorSection
    named: NamedSensor | None
    entry: Entry
    parameters: Mapping[str, Any]
    provider: SensorModel
    variables: tuple[VariableSpec, ...]
    seed: int
    inputs: SensorInputs
    cube: Window
    from_scene: bool = False
    edge_note: str | None = None

    @property
    def notes(self) -> tuple[str, ...]:
        """What users should know about it."""
        return (*self.provider.declares.notes, *(() if self.edge_note is None else (self.edge_note,)))

    @property
    def reach(self) -> int:
        """Pixels around a pixel that have a share in it; 0 also where that is not known."""
        return self.provider.declares.reach_pixels or 0

    @property
    def given(self) -> Window:
        """Rows and columns of the image that it measures."""
        return _extent(self.inputs)

    @property
    def title(self) -> str:
        """What people call it."""
        return self.entry.name if self.named is None else self.named.title

    def measure(self, radiance: NDArray[np.float32], frame: int, time_s: float) -> dict[str, NDArray[Any]]:
        """Return each variable of a frame in its type, (B, y, x) of the cube.

        Parameters
        ----------
        radiance : ndarray of float32 (B, y, x)
            Of all that the sensor is given.

        Raises
        ------
        ProviderError
            If the sensor breaks its contract.
        """
        clean = radiance.astype(np.float64)
        clean.flags.writeable = False
        measured: Measured = self.provider.measure(clean, frame, time_s)
        kept = relative(self.cube, self.given)
        return {spec.name: _stored(getattr(measured, spec.name)[:, *kept], spec, self.entry) for spec in self.variables}

    def as_dict(self) -> dict[str, Any]:
        """Plain values for the plan and for the cube's provenance."""
        named = self.named
        return {
            "name": self.section.name,
            "title": self.title,
            "model": self.entry.name,
            "distribution": self.entry.distribution,
            "version": self.entry.version,
            "seed": self.seed,
            "measured_from": "scene" if self.from_scene else "cube",
            "parameters": dict(self.parameters),
            "worked_out": dict(getattr(self.provider, "worked_out", {})),
            "sources": {} if named is None else dict(named.sources),
            "notes": list(self.notes),
        }


def make_sensor(section: SensorSection, inputs: SensorInputs) -> MadeSensor:
    """Build the sensor of a section, for frames that are measured as they are.

    Parameters
    ----------
    inputs : SensorInputs
        With the scenario's seed, which the section may replace.

    Raises
    ------
    ScenarioError
        Naming the key that is wrong.
    ProviderError
        If the model is broken.
    """
    with attribute_to_field("sensor.name"):
        if section.name is not None:
            load_sensor(section.name, inputs.catalog)
        choice = choose_sensor(section, inputs.catalog)
    registry = Registry.discover()
    with attribute_to_field("sensor.model", choice.parameters):
        entry = registry.resolve(Kind.SENSORS, choice.model)
        parameters = _parameters(registry.parameters_model(entry), choice.parameters)
        seed = inputs.seed if section.seed is None else section.seed
        inputs = replace(inputs, seed=seed)
        provider = guard(entry, registry.create(entry, inputs, parameters), inputs)
    dumped = {} if parameters is None else parameters.model_dump(mode="json")
    try:
        json.dumps(dict(getattr(provider, "worked_out", {})))
    except (TypeError, ValueError) as error:
        raise ProviderError(f"{entry.label}: worked_out cannot be written as JSON: {error}") from error
    variables = measured_variables(_wanted(section.variables, provider.variables, entry))
    return MadeSensor(section, choice.named, entry, dumped, provider, variables, seed, inputs, _extent(inputs))


def _extent(inputs: SensorInputs) -> Window:
    (row, column), grid = inputs.corner, inputs.grid
    return slice(row, row + grid.rows), slice(column, column + grid.columns)


def _parameters(model: type[BaseModel] | None, given: Mapping[str, Any]) -> BaseModel | None:
    if model is None:
        if given:
            raise ScenarioError([Problem("sensor.parameters", "the model takes none; allowed: none")])
        return None
    try:
        return model.model_validate(dict(given))
    except ValidationError as error:
        raise ScenarioError(problems_from(error, model, prefix="sensor.parameters", raw=given)) from error


def _wanted(asked: tuple[str, ...], given: tuple[str, ...], entry: Entry) -> tuple[str, ...]:
    """Names of the variables beside radiance."""
    for name in asked:
        if name not in (*given, ALL, MEASURED_RADIANCE.name):
            message = f"'{name}' is not among what the sensor '{entry.name}' gives with these parameters"
            raise ScenarioError([Problem("sensor.variables", f"{message}; {choose_from(name, (*given, ALL))}")])
    return given if ALL in asked else tuple(name for name in given if name in asked)


def _stored(array: NDArray[Any], spec: VariableSpec, entry: Entry) -> NDArray[Any]:
    if array.dtype.kind == "f" and float(np.abs(array).max(initial=0.0)) > float(np.finfo(spec.dtype).max):
        raise ProviderError(f"{entry.label}: {spec.name} is too large for {spec.dtype}")
    return np.ascontiguousarray(array, dtype=spec.dtype)


def sensor_bands(bands: Sequence[SpectralBand]) -> tuple[SensorBand, ...]:
    """Return bands as sensors get them."""
    return tuple(SensorBand(band.name, band.wavelength_um, band.response) for band in bands)


def planned_sensor(scenario: Scenario, assembly: Assembly, catalog: Catalog, extent: Window) -> MadeSensor | None:
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
