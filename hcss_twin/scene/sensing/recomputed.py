"""A measured cube made anew from its scenario, for comparison."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from hcss_twin.cube.header import CubeHeader
from hcss_twin.cube.sensor_variables import is_replaced
from hcss_twin.errors import CubeError
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.sensing.made_sensor import MadeSensor
from hcss_twin.scene.sensing.provenance import sensor_attributes
from hcss_twin.scene.stream import Frame


def measured_header(plan: Plan, clean: CubeHeader) -> CubeHeader:
    """Return what the measured cube of a plan has, from what its clean one has."""
    sensor = _sensor(plan)
    changed = sensor_attributes(clean.attributes, sensor, plan.catalog.used, "")
    return replace(
        clean,
        variables=(*(spec for spec in clean.variables if not is_replaced(spec.name)), *sensor.variables),
        attributes={
            name: value for name, value in {**clean.attributes, **changed}.items() if value is not None
        },
    )


def measured_frames(plan: Plan, numbers: Sequence[int], clean: Iterable[Frame]) -> Iterator[Frame]:
    """Yield frames with what the plan's sensor measures in place of their radiance.

    Parameters
    ----------
    numbers : sequence of int
        Of the clean frames, from 0.
    """
    sensor = _sensor(plan)
    first = plan.scenario.frames.first
    for number, frame in zip(numbers, clean, strict=True):
        kept = {name: values for name, values in frame.items() if not is_replaced(name)}
        time_s = float(plan.frame_times_s[number])
        yield {**kept, **sensor.measure(frame["radiance"], first + number, time_s)}


def needs_all_frames(plan: Plan) -> bool:
    """Whether a frame can only be measured after all earlier ones."""
    return _sensor(plan).provider.declares.remembers


def _sensor(plan: Plan) -> MadeSensor:
    if plan.sensor is None:
        raise CubeError("it was measured by a sensor, but its scenario has none")
    return plan.sensor
