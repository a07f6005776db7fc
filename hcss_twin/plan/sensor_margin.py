"""What a sensor sees beyond the edges of a cube: computed with the scene where it can be, mirrored where not."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from hcss_twin.plan.clouds import sums_up
from hcss_twin.plan.sensor import MadeSensor, make_sensor
from hcss_twin.plan.windows import Window, length
from hcss_twin.providers.registry.registry import OWN_DISTRIBUTION
from hcss_twin.providers.registry.specs import Kind

if TYPE_CHECKING:
    from hcss_twin.plan.plan import Plan


MAX = 512
"""Rows, and columns, that are computed beyond an edge, however far a sensor reaches."""

MIRROR_NOTE = (
    "blur at the edges of the image takes the scene beyond them for its mirror image: pixels no farther from an edge "
    "than the blur reaches are not those of a larger image"
)


def with_margin(plan: Plan) -> MadeSensor | None:
    """Return the sensor of a plan, made for as much of the scene around the cube as it reaches.

    Around a window that is the rest of the image, whatever clouds there are. Beyond the image it is computed where
    everything that the scene is made of goes on there.
    """
    sensor = plan.sensor
    if sensor is None:
        return None
    reach = sensor.reach
    if reach == 0:
        return replace(sensor, from_scene=True)
    ends, margin = _where_it_ends(plan), min(reach, MAX)
    sizes = (plan.grid.rows, plan.grid.columns) if ends is not None else (None, None)
    rows, columns = (_around(pixels, margin, size) for pixels, size in zip(plan.extent, sizes, strict=True))
    given = rows, columns
    note = _note(given, plan.extent, reach, ends)
    return replace(_made_for(given, sensor), cube=plan.extent, from_scene=True, edge_note=note)


def _where_it_ends(plan: Plan) -> str | None:
    """Say what is not known beyond the image; None where everything is."""
    if plan.views is not None:
        return "pixels have views of their own, which are known within the image"
    if plan.waves is not None and plan.assembly.entries[str(Kind.SEA)].distribution != OWN_DISTRIBUTION:
        return "the waves of this sea model are known within the image"
    for layer, generator, cloudy in zip(plan.layers, plan.generators, plan.cloudy_layers, strict=True):
        summed_up = generator.declares.tileable or sums_up(generator)
        if cloudy and not (summed_up and hasattr(generator, "thickness_around_m")):
            return f"the clouds of '{layer.name}' are known within the image"
    return None


def _around(pixels: slice, margin: int, size: int | None) -> slice:
    """Pixels with a margin, as far as an image of this size goes; None has no end."""
    first, end = pixels.start - margin, pixels.stop + margin
    return slice(first, end) if size is None else slice(max(first, 0), min(end, size))


def _note(given: Window, cube: Window, reach: int, ends: str | None) -> str:
    margins = [
        size
        for around, inner in zip(given, cube, strict=True)
        for size in (inner.start - around.start, around.stop - inner.stop)
    ]
    if min(margins) >= reach:
        return (
            f"blur at the edges sees the scene as it goes on beyond them: {reach} rows and columns on each side are "
            "computed for it"
        )
    why = f"more than {MAX} are not computed" if ends is None else ends
    if max(margins) == 0:
        return f"{MIRROR_NOTE} ({why})"
    return (
        f"blur at the edges reaches {reach} pixels: it sees the scene up to {max(margins)} rows and columns beyond "
        f"them, as computed, and farther out takes it for its mirror image ({why})"
    )


def alone(sensor: MadeSensor) -> MadeSensor:
    """Return the sensor of a cube of which nothing more is known."""
    return replace(sensor, edge_note=MIRROR_NOTE if sensor.reach else None)


def without_margin(plan: Plan) -> MadeSensor | None:
    """Return the sensor of a plan as one that measures its cube alone."""
    sensor = plan.sensor
    if sensor is None:
        return None
    return alone(_made_for(plan.extent, sensor))


def _made_for(given: Window, sensor: MadeSensor) -> MadeSensor:
    rows, columns = given
    grid = replace(sensor.inputs.grid, rows=length(rows), columns=length(columns))
    return make_sensor(sensor.section, replace(sensor.inputs, grid=grid, corner=(rows.start, columns.start)))
