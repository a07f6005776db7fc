"""The scene beyond the edges of an image, which the blur of a sensor needs: how far it is computed."""

from __future__ import annotations

from dataclasses import replace

from hcss_twin.core.plugins import OWN_DISTRIBUTION
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.clouds import sums_up
from hcss_twin.plan.sensor import BuiltSensor, make_sensor
from hcss_twin.plan.windows import Window, length
from hcss_twin.providers.registry.specs import Kind

MAX_MARGIN = 512
"""Maximum rows and columns computed beyond an edge."""

MIRROR_NOTE = (
    "blur at the edges of the image takes the scene beyond them for its mirror image: pixels no farther from an edge "
    "than the blur reaches are not those of a larger image"
)


def with_margin(sensor: BuiltSensor, assembly: Assembly, waves: bool, views: bool) -> BuiltSensor:
    """Return a sensor built for the cube and the surrounding scene within its reach.

    Around a window this is the rest of the image, for all clouds. Beyond the image the scene is computed if all of
    its components are defined there.

    Parameters
    ----------
    waves, views : bool
        Whether clear pixels show resolved waves, and whether view angles vary over the image.
    """
    reach, cube, grid = sensor.reach, sensor.cube, assembly.grid
    if reach == 0:
        return replace(sensor, from_scene=True)
    ends, margin = _where_it_ends(assembly, waves, views), min(reach, MAX_MARGIN)
    sizes = (grid.rows, grid.columns) if ends is not None else (None, None)
    rows, columns = (_around(pixels, margin, size) for pixels, size in zip(cube, sizes, strict=True))
    note = _edge_note((rows, columns), cube, reach, ends)
    return replace(_built_for((rows, columns), sensor), cube=cube, from_scene=True, edge_note=note)


def _where_it_ends(assembly: Assembly, waves: bool, views: bool) -> str | None:
    """Return the reason why the scene is unknown beyond the image; None if it is known."""
    if views:
        return "pixels have views of their own, which are known within the image"
    if waves and assembly.entries[str(Kind.SEA)].distribution != OWN_DISTRIBUTION:
        return "the waves of this sea model are known within the image"
    for layer, generator, cloudy in zip(assembly.layers, assembly.generators, assembly.cloudy_layers, strict=True):
        gives_windows = generator.declares.tileable or sums_up(generator)
        if cloudy and not (gives_windows and hasattr(generator, "thickness_around_m")):
            return f"the clouds of '{layer.name}' are known within the image"
    return None


def _around(pixels: slice, margin: int, size: int | None) -> slice:
    """Pixels with a margin, limited to an image of this size; None: unlimited."""
    first, end = pixels.start - margin, pixels.stop + margin
    if size is not None:
        return slice(max(first, 0), min(end, size))
    if margin < MAX_MARGIN:
        # far blurs are transforms, which take up to 6 times as long if a size has a large prime factor
        from scipy.fft import next_fast_len

        end = first + next_fast_len(end - first)
    return slice(first, end)


def _edge_note(given: Window, cube: Window, reach: int, ends: str | None) -> str:
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
    why = f"more than {MAX_MARGIN} are not computed" if ends is None else ends
    if max(margins) == 0:
        return f"{MIRROR_NOTE} ({why})"
    return (
        f"blur at the edges reaches {reach} pixels: it sees the scene up to {max(margins)} rows and columns beyond "
        f"them, as computed, and farther out takes it for its mirror image ({why})"
    )


def alone(sensor: BuiltSensor) -> BuiltSensor:
    """Return a sensor built for the cube alone, with mirror boundaries."""
    sensor = _built_for(sensor.cube, sensor) if sensor.from_scene else sensor
    return replace(sensor, edge_note=MIRROR_NOTE if sensor.reach else None)


def _built_for(given: Window, sensor: BuiltSensor) -> BuiltSensor:
    rows, columns = given
    grid = replace(sensor.inputs.grid, rows=length(rows), columns=length(columns))
    inputs = replace(sensor.inputs, grid=grid, corner=(rows.start, columns.start))
    return make_sensor(sensor.section, inputs, scene=sensor.scene)
