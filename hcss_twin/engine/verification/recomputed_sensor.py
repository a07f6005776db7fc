"""A measured cube made anew from its scenario, for comparison."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.header import CubeHeader
from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE, is_replaced
from hcss_twin.engine.cube_sensor import SceneAround, sensor_attributes
from hcss_twin.engine.stream import Frame
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.sensor import BuiltSensor, alone


def as_measured(plan: Plan, attributes: Mapping[str, Any]) -> Plan:
    """Return the plan of a measured cube with its sensor given what it was given then.

    That is the scene around the cube where a run measured it, and nothing where it was measured later.

    Parameters
    ----------
    attributes : mapping
        Global attributes of the measured cube.

    Raises
    ------
    CubeError
        If they do not say what its sensor is.
    """
    try:
        about = json.loads(attributes[SENSOR_ATTRIBUTE])
        whole = about.get("measured_from") == "scene"
    except (ValueError, TypeError, AttributeError) as error:
        raise CubeError(f"the global attribute {SENSOR_ATTRIBUTE} is malformed: {error}") from error
    return plan if whole or plan.sensor is None else replace(plan, sensor=alone(plan.sensor))


def measured_header(plan: Plan, clean: CubeHeader) -> CubeHeader:
    """Return what the measured cube of a plan has, from what its clean one has."""
    sensor = _sensor(plan)
    changed = sensor_attributes(clean.attributes, sensor, plan.catalog.used, "")
    return replace(
        clean,
        variables=(*(spec for spec in clean.variables if not is_replaced(spec.name)), *sensor.variables),
        attributes={name: value for name, value in {**clean.attributes, **changed}.items() if value is not None},
    )


def measured_frames(
    plan: Plan, tables: RadianceTables | None, numbers: Sequence[int], clean: Iterable[Frame]
) -> Iterator[Frame]:
    """Yield frames with what the plan's sensor measures in place of their radiance.

    Parameters
    ----------
    numbers : sequence of int
        Of the clean frames, from 0.
    """
    sensor = _sensor(plan)
    around, first = SceneAround(plan, tables, sensor), plan.scenario.frames.first
    for number, frame in zip(numbers, clean, strict=True):
        kept = {name: values for name, values in frame.items() if not is_replaced(name)}
        time_s = float(plan.frame_times_s[number])
        radiance = around.frame(number, frame["radiance"])
        yield {**kept, **sensor.measure(radiance, first + number, time_s)}


def needs_all_frames(plan: Plan) -> bool:
    """Whether a frame can only be measured after all earlier ones."""
    return _sensor(plan).provider.declares.remembers


def _sensor(plan: Plan) -> BuiltSensor:
    if plan.sensor is None:
        raise CubeError("it was measured by a sensor, but its scenario has none")
    return plan.sensor
