"""What a plan leaves out, as a short table: the largest first, what loses nothing in one line.

The plan as text for a terminal: what is looked at, what comes out, and how far it can be trusted, on a screen.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator

from hcss_twin.plan.accuracy import SHARES
from hcss_twin.plan.description import describe_particles
from hcss_twin.plan.few_columns import Omission
from hcss_twin.plan.output import quantization_lines
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.sensor import BuiltSensor
from hcss_twin.providers import CloudLayer
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.registry import OWN_DISTRIBUTION

_NUMBERED = re.compile(r"(.*?)(\d+)")


def left_out(plan: Plan) -> Iterator[tuple[str, str]]:
    """Yield bound and text of each line; what ``hcss plan --json`` says at length is cut to its first clause."""
    # Of several layers the ledger names the layer, too.
    own = {
        (what if len(plan.layers) == 1 else f"{layer.name}: {what}"): what
        for layer, generator in zip(plan.layers, plan.assembly.generators, strict=True)
        for what, _ in getattr(generator, "skipped", ())
    }
    bounded = [item for item in plan.omissions if item.bound]
    for item in sorted(bounded, key=lambda item: -(item.bound or 0.0)):
        yield _share(item.bound or 0.0), _told(item)
    for item in plan.omissions:
        if item.bound is None and item.what not in own:
            yield "unknown", _told(item)
    nothing = [item for item in plan.omissions if item.bound == 0.0]
    if nothing:
        yield "nothing", "; ".join(f"{item.what} ({_reason(item.why)})" for item in nothing)
    details = [own[item.what] for item in plan.omissions if item.bound is None and item.what in own]
    if details:
        yield "in law", f"equal in law or nearly, not by pixel: {'; '.join(_gathered(details))}"


def _told(item: Omission) -> str:
    return f"{item.what}: {_first_clause(item.why)}"


def _first_clause(why: str) -> str:
    return why.partition(";")[0]


def _reason(why: str) -> str:
    """First clause without the list that may follow it."""
    return _first_clause(why).partition(":")[0]


def _share(bound: float) -> str:
    """Write a share of the radiance."""
    return f"{bound:.2g} x" if bound >= 1.0 else f"{100.0 * bound:.2g} %"


def _gathered(details: list[str]) -> Iterator[str]:
    """Gather what is said of several octaves, as ``interpolation of octave 5 along x``, from the first to the last."""
    groups: dict[str, list[str]] = {}
    for what in details:
        match = _NUMBERED.fullmatch(what.partition(" along ")[0])
        name, number = match.groups() if match else (what, "")
        groups.setdefault(name, []).append(number)
    for name, numbers in groups.items():
        distinct = sorted(set(numbers), key=lambda number: int(number or 0))
        yield name + (distinct[0] if len(distinct) == 1 else f"{distinct[0]} to {distinct[-1]}")


WIDTH = 120
_LABEL = 13
_BOUND = 11


def plan_text(plan: Plan) -> str:
    """Describe what a scene needs, what was filled in and what is left out."""
    title = plan.scenario.title or plan.scenario.origin
    return "\n".join([title, *(_wrapped(label, text) for label, text in _rows(plan))])


def _wrapped(label: str, text: str) -> str:
    start = f"  {label:<{_LABEL}}"
    after = " " * (len(start) + (_BOUND if not label else 0))
    return textwrap.fill(text, WIDTH, initial_indent=start, subsequent_indent=after, break_on_hyphens=False)


def _rows(plan: Plan) -> Iterator[tuple[str, str]]:
    yield from _scene(plan)
    yield from _clouds(plan)
    entries = plan.assembly.entries
    if plan.needs_radiance:
        sea = plan.scenario.sea
        waves = "averaged" if plan.waves is None else "drawn"
        yield (
            "sea",
            f"{plan.assembly.sea_temperature_K:.5g} K, wind {plan.assembly.sea_wind_speed_m_s:.4g} m/s from "
            f"{sea.wind_from:g} deg, waves {waves}; {_named(entries['sea'])}",
        )
        yield "atmosphere", f"{plan.assembly.profile.name}; {_named(entries['atmosphere'])}"
    if plan.needs_radiance or any("band" in spec.dims for spec in plan.variables):
        bands = (f"{band.name} ({band.lower_um:g}-{band.upper_um:g} um)" for band in plan.bands)
        yield "bands", ", ".join(bands)
    if plan.needs_radiance:
        optics = f", optics {_named(entries['optics'])}" if plan.layers else ""
        known = plan.spectral_grid.wavenumber_cm1.size
        yield "radiance", f"{_named(entries['radiance'])}{optics}; a few weighted wavenumbers of {known}"
    yield from _output(plan)
    for item in plan.filled_in:
        yield "filled in", f"{item.field} = {item.value} ({item.why})"
    yield "left out", "and the share of the radiance of any pixel that it is at most (more of each: --json)"
    for bound, text in left_out(plan):
        yield "", f"{bound:<{_BOUND}}{text}"
    for note in plan.notes:
        yield "note", note


def _scene(plan: Plan) -> Iterator[tuple[str, str]]:
    scenario, grid, place = plan.scenario, plan.grid, plan.scenario.place
    north, east = "N" if place.latitude >= 0 else "S", "E" if place.longitude >= 0 else "W"
    frames = scenario.frames
    count = f"{frames.count} frames {frames.interval:g} s apart" if frames.count > 1 else "one frame"
    first = f", the first at {plan.frame_times_s[0]:g} s" if frames.first else ""
    yield (
        "scene",
        f"{abs(place.latitude):g} {north} {abs(place.longitude):g} {east}, {scenario.time.isoformat(' ')}; "
        f"{count}{first}",
    )
    speed = plan.assembly.motion.platform_speed_m_s
    motion = f", moving {'east' if speed > 0 else 'west'} at {abs(speed):g} m/s" if speed else ""
    size = f"{grid.columns * grid.pixel_size_m / 1e3:.4g} x {grid.rows * grid.pixel_size_m / 1e3:.4g} km"
    yield "image", f"{grid.rows} rows x {grid.columns} columns of {grid.pixel_size_m:g} m ({size}){motion}"
    if plan.is_window:
        rows, columns = plan.extent
        yield (
            "window",
            f"of it rows {rows.start} to {rows.stop - 1} and columns {columns.start} to {columns.stop - 1} "
            f"({plan.pixels[0]} x {plan.pixels[1]} pixels) are computed",
        )
    points = plan.samples_per_pixel
    if points > 1:
        yield "pixel", f"mean of {points} x {points} points, {grid.pixel_size_m / points:g} m apart"
    yield "view", f"zenith {plan.view.zenith_deg:g} deg, azimuth {plan.view.azimuth_deg:g} deg"
    lines = plan.assembly.lines_of_sight
    if lines is not None:
        yield (
            "platform",
            f"{lines.altitude_m / 1e3:g} km high, {lines.centre_range_m / 1e3:.1f} km from the image centre; "
            f"footprint at {plan.assembly.motion.platform_speed_m_s:g} m/s",
        )
    if plan.views is not None:
        x, y = plan.views.order_x + 1, plan.views.order_y + 1
        yield "views", f"each pixel has its own, from tables toward {x} x {y} over the image"
    zenith, azimuth = plan.sun_zenith_deg, plan.sun_azimuth_deg
    down = int((zenith >= 90.0).sum())
    where = "" if not down else f"; below the horizon in {down} of {zenith.size} frames"
    faint = "; too faint to be computed" if plan.faint_sunlight is not None else ""
    yield (
        "sun",
        f"zenith {_span(zenith[0], zenith[-1])} deg, azimuth {_span(azimuth[0], azimuth[-1])} deg{where}{faint}",
    )


def _span(first: float, last: float) -> str:
    return f"{first:.3f}" if f"{first:.3f}" == f"{last:.3f}" else f"{first:.3f}..{last:.3f}"


def _clouds(plan: Plan) -> Iterator[tuple[str, str]]:
    if not plan.layers:
        yield "clouds", "none"
        return
    entries = plan.assembly.entries
    for index, (layer, generator) in enumerate(zip(plan.layers, plan.assembly.generators, strict=True)):
        entry = entries["clouds" if len(plan.layers) == 1 else f"clouds[{index}]"]
        of_image = getattr(generator, "image_coverage", None)
        coverage = f"{layer.coverage:g}" + (" of the sky in the mean" if layer.coverage_mode == "field" else "")
        if of_image is not None:
            coverage = f"{of_image:.3g}, as the image has it"
        thickness = f"{layer.thickness_min_m:g} to {layer.thickness_max_m:g} m thick"
        yield (
            "clouds",
            f"{layer.name}: coverage {coverage}, {layer.base_m:g}..{layer.top_m:g} m, {thickness}; {_named(entry)}",
        )
        if plan.needs_radiance or any("optical" in spec.name for spec in plan.variables):
            yield "particles", _particles(layer, plan)
    motion = plan.scenario.motion
    shapes = "shapes are frozen"
    if motion.evolution_time != "frozen":
        shapes = f"shapes change in {motion.evolution_time:g} s"
    if not any(generator.declares.evolves for generator in plan.assembly.generators):
        shapes = "shapes are frozen"
    yield "wind", f"carries clouds at {motion.wind_speed:g} m/s from {motion.wind_from:g} deg; {shapes}"


def _particles(layer: CloudLayer, plan: Plan) -> str:
    about = describe_particles(layer)
    if layer.temperature_K is None:
        temperature = f"{float(plan.assembly.profile.temperature_at(layer.top_m)):.4g} K at the top"
    else:
        temperature = f"{layer.temperature_K:g} K"
    return (
        f"{about['name']}: {about['phase']}, effective radius {about['effective_radius_um']:.4g} um, variance "
        f"{about['effective_variance']:.3g}, {about['water_content_g_m3']:.3g} g m-3, extinction "
        f"{about['large_particle_extinction_m1']:.3g} m-1; {temperature}"
    )


def _output(plan: Plan) -> Iterator[tuple[str, str]]:
    output = plan.scenario.output
    stored = f", compressed at level {output.compression}" if output.compression else ""
    size = f"{_size(plan.uncompressed_bytes)}{' before compression' if stored else ''}{stored}"
    checked = ""
    if plan.needs_radiance:
        pixels = output.certificate
        checked = f"; certificate of {pixels} pixels" if pixels else "; no certificate"
    yield "output", f"{', '.join(spec.name for spec in plan.variables)}: {size}{checked}"
    for line in quantization_lines(plan.variables, output.compression > 0):
        yield "rounding", line
    if plan.sensor is not None:
        yield from _sensor(plan.sensor)
    if plan.needs_radiance:
        yield "accuracy", f"{plan.accuracy}; of it {_shares(plan)}"


def _sensor(sensor: BuiltSensor) -> Iterator[tuple[str, str]]:
    measured = ", ".join(spec.name for spec in sensor.variables)
    yield "sensor", f"{sensor.title} ({_named(sensor.entry)}); a cube of its own: {measured}"
    for note in sensor.notes:
        yield "sensor", f"note: {note}"


def _named(entry: Entry) -> str:
    """Name a provider, and who brought it if that is somebody else."""
    return entry.name if entry.distribution == OWN_DISTRIBUTION else f"{entry.name} [{entry.origin}]"


def _shares(plan: Plan) -> str:
    """What each approximation that the scene makes may have of the accuracy."""
    several = sum(plan.assembly.cloudy_layers) > 1
    made = {
        "thickness": any(plan.assembly.cloudy_layers),
        "two_layers": several,
        "faint_sunlight": plan.faint_sunlight is not None,
        "waves": plan.waves is not None,
        "views": plan.views is not None,
        "shadows": plan.scenario.slant.shadows,
        "time": plan.sun_matters and plan.frame_times_s.size > 1,
        "other_instants": plan.sun_matters and plan.frame_times_s.size > 1 and any(plan.assembly.cloudy_layers),
    }
    shares = (f"{100 * share:g} % {name.replace('_', ' ')}" for name, share in SHARES.items() if made.get(name, True))
    return ", ".join(shares)


def _size(count: int) -> str:
    for unit, factor in (("TB", 1e12), ("GB", 1e9)):
        if count >= factor:
            return f"{count / factor:.1f} {unit}"
    return f"{count / 1e6:.1f} MB"
