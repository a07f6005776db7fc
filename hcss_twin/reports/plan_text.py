"""A plan as text for a terminal, on one screen: the scene, the output, and the approximations with their bounds."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from hcss_twin.core.arrays import Array
from hcss_twin.core.plugins import OWN_DISTRIBUTION
from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.plan.accuracy import SHARES
from hcss_twin.plan.builder import numbered
from hcss_twin.plan.description import describe_particles
from hcss_twin.plan.error_budget import COLUMNS, beyond_accuracy, error_budget
from hcss_twin.plan.few_columns import OMISSION_SHARE
from hcss_twin.plan.output import quantization_lines
from hcss_twin.plan.packing import packing_lines
from hcss_twin.plan.plan import Plan
from hcss_twin.plan.provider_cost import provider_costs
from hcss_twin.providers import CloudLayer, Grid
from hcss_twin.providers.registry.discovery import Entry
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.reports.tables import Table, bound_text

_NUMBERED = re.compile(r"(.*?)(\d+)")
_LABEL = 13
_BOUND = 13

Rows = Iterator[tuple[str, str]]


def plan_text(plan: Plan) -> str:
    """Describe the inputs of a scene, the defaults used, and its approximations."""
    title = plan.scenario.title or plan.scenario.origin
    return "\n".join(
        [title, *(Table.labelled(label, text, _LABEL, 0 if label else _BOUND) for label, text in _rows(plan))]
    )


def _rows(plan: Plan) -> Rows:
    yield from _scene(plan)
    yield from _view(plan)
    yield from _clouds(plan)
    yield from _radiation(plan)
    yield from _output(plan)
    for text in default_wind(plan):
        yield "filled in", f"{text} (default: the wind blows from the west)"
    for item in plan.filled_in:
        yield "filled in", f"{item.field} = {item.value} ({item.why})"
    share = f"its share of the accuracy ({OMISSION_SHARE * plan.accuracy.relative:g})"
    told = f"not within: * exceeds {share}" if beyond_accuracy(plan) else f"within {share}"
    yield "approximated", f"or omitted, with the share of a pixel's radiance (more: --json); {told}"
    for bound, text in approximations(plan):
        yield "", f"{bound:<{_BOUND}}{text}"
    yield from _world(plan)
    for cost in provider_costs(plan):
        yield "cost", f"{cost.label}: about {cost.seconds:.2g} s in {cost.calls} calls of {cost.member}"
    for note in plan.notes:
        yield "note", note


def default_wind(plan: Plan) -> Iterator[str]:
    """Yield the keys of the wind's default bearing on which images depend: clouds drift, waves have a direction."""
    scenario, keys = plan.scenario, list[str]()
    follows = any(layer.wind_from is None for layer in scenario.clouds.layers)
    drifts = follows and plan.frame_times_s.size > 1 and scenario.motion.wind_speed > 0.0
    if drifts and "wind_from" not in scenario.motion.model_fields_set:
        keys.append("motion.wind_from")
    if (plan.waves.varies or plan.sun_matters) and "wind_from" not in scenario.sea.model_fields_set:
        keys.append("sea.wind_from")
    if keys:
        yield f"{', '.join(keys)} = {type(scenario.sea).model_fields['wind_from'].default:g} deg"


def _scene(plan: Plan) -> Rows:
    scenario, image, place = plan.scenario, plan.image, plan.scenario.place
    north, east = "N" if place.latitude >= 0 else "S", "E" if place.longitude >= 0 else "W"
    frames = scenario.frames
    count = f"{frames.count} frames {frames.interval:g} s apart" if frames.count > 1 else "one frame"
    first = f", the first at {plan.frame_times_s[0]:g} s" if frames.first else ""
    where = f"{abs(place.latitude):g} {north} {abs(place.longitude):g} {east}"
    yield "scene", f"{where}, {scenario.time.isoformat(' ')}; {count}{first}"
    speed = plan.assembly.motion.platform_speed_m_s
    motion = f", moving {'east' if speed > 0 else 'west'} at {abs(speed):g} m/s" if speed else ""
    if plan.is_grid:
        yield "image", f"{_pixels(image)}{motion}"
    else:  # each pixel has a place and a size of its own
        yield "image", f"{image.rows} rows x {image.columns} columns of about {image.pixel_size_m:.4g} m on the ground"
        yield "plane", f"{_pixels(plan.grid)}{motion}, in which clouds, surfaces and elements are defined"
    if plan.is_window:
        rows, columns = plan.extent
        window = f"rows {rows.start} to {rows.stop - 1} and columns {columns.start} to {columns.stop - 1}"
        yield "window", f"{window} of the image ({plan.pixels[0]} x {plan.pixels[1]} pixels) are computed"
    points = plan.samples_per_pixel
    if points > 1:
        spacing = image.pixel_size_m / points
        apart = f"{spacing:g} m apart" if plan.is_grid else f"about {spacing:.4g} m apart"
        yield "pixel", f"mean of {points} x {points} points, {apart}"


def _pixels(grid: Grid) -> str:
    size = f"{grid.columns * grid.pixel_size_m / 1e3:.4g} x {grid.rows * grid.pixel_size_m / 1e3:.4g} km"
    return f"{grid.rows} rows x {grid.columns} columns of {grid.pixel_size_m:g} m ({size})"


def _view(plan: Plan) -> Rows:
    yield "view", f"zenith {plan.view.zenith_deg:g} deg, azimuth {plan.view.azimuth_deg:g} deg"
    lines = plan.assembly.lines_of_sight
    if lines is not None:
        speed = f"footprint at {plan.assembly.motion.platform_speed_m_s:g} m/s"
        distance = f"{lines.centre_range_m / 1e3:.1f} km from the image centre"
        yield "platform", f"{lines.altitude_m / 1e3:g} km high, {distance}; {speed}"
    for tops in plan.tops:
        low, *_, high = nodes = tops.placed.nodes.tolist()
        count = len(nodes)
        yield "cloud tops", f"{low:.0f} to {high:.0f} m, interpolated between tables for {count} altitudes"
    if plan.views.varies:
        x, y = plan.views.order_x + 1, plan.views.order_y + 1
        yield "views", f"one for each pixel, interpolated between tables for {x} x {y} views over the image"
    zenith, azimuth = plan.sun_zenith_deg, plan.sun_azimuth_deg
    down = int((zenith >= 90.0).sum())
    below = f"; below the horizon in {down} of {zenith.size} frames" if down else ""
    faint = "" if plan.sunlight.is_computed else "; too faint to be computed"
    yield "sun", f"zenith {_span(zenith)} deg, azimuth {_span(azimuth)} deg{below}{faint}"


def _span(values: Array) -> str:
    first, last = f"{values[0]:.3f}", f"{values[-1]:.3f}"
    return first if first == last else f"{first}..{last}"


def _clouds(plan: Plan) -> Rows:
    if not plan.layers:
        yield "clouds", "none"
        return
    entries, generators = plan.assembly.entries, plan.assembly.generators
    for index, (layer, generator) in enumerate(zip(plan.layers, generators, strict=True)):
        entry = entries[numbered(Kind.CLOUDS, index, len(plan.layers))]
        of_image = getattr(generator, "image_coverage", None)
        coverage = f"{layer.coverage:g}" + (" of the sky on average" if layer.coverage_mode == "field" else "")
        if of_image is not None:
            coverage = f"{of_image:.3g} of pixels, as the image or film has it ({layer.coverage:g} stated)"
        thickness = f"{layer.thickness_min_m:g} to {layer.thickness_max_m:g} m thick"
        yield "clouds", f"{layer.name}: coverage {coverage}, {_extent(layer, plan)}, {thickness}; {_named(entry)}"
        if plan.needs_radiance or any("optical" in spec.name for spec in plan.variables):
            yield "particles", _particles(layer, plan)
    motion = plan.scenario.motion
    frozen = motion.evolution_time == "frozen" or not any(generator.declares.evolves for generator in generators)
    time = "165 s per km of wavelength, below 8 km as in turbulence"
    if isinstance(motion.evolution_time, float):
        time = f"{motion.evolution_time:g} s"
    shapes = "shapes are frozen" if frozen else f"shapes change in {time}"
    sections = plan.scenario.clouds.layers
    some = any(section.wind_speed is not None or section.wind_from is not None for section in sections)
    which = "clouds without a wind of their own" if some else "clouds"
    yield "wind", f"moves {which} at {motion.wind_speed:g} m/s from {motion.wind_from:g} deg; {shapes}"


def _particles(layer: CloudLayer, plan: Plan) -> str:
    about = describe_particles(layer)
    at_top = f"{float(plan.assembly.profile.temperature_at(layer.top_m)):.4g} K at the top"
    temperature = at_top if layer.temperature_K is None else f"{layer.temperature_K:g} K"
    return (
        f"{about['name']}: {about['material']}, effective radius {about['effective_radius_um']:.4g} um, variance "
        f"{about['effective_variance']:.3g}, {about['water_content_g_m3']:.3g} g m-3, extinction "
        f"{about['large_particle_extinction_m1']:.3g} m-1; {temperature}"
    )


def _extent(layer: CloudLayer, plan: Plan) -> str:
    """Return where the base and the top of each column are."""
    for tops in plan.tops:
        if plan.layers[tops.layer] is layer:
            return f"tops {tops.placed.axis.low:g} to {tops.placed.axis.high:g} m"
    if layer.anchor == "base":
        return f"base {layer.base_m:g} m, tops to {layer.top_m:g} m"
    return f"top {layer.top_m:g} m, bases to {layer.base_m:g} m"


def _radiation(plan: Plan) -> Rows:
    assembly, entries = plan.assembly, plan.assembly.entries
    if plan.needs_radiance:
        waves = "resolved waves" if plan.waves.varies else "statistical waves"
        wind = f"wind {assembly.sea_wind_speed_m_s:.4g} m/s from {plan.scenario.sea.wind_from:g} deg"
        yield "sea", f"{assembly.sea_temperature_K:.5g} K, {wind}, {waves}; {_named(entries['sea'])}"
        yield from _surfaces(plan)
        yield "atmosphere", f"{assembly.profile.name}; {_named(entries['atmosphere'])}"
    if plan.needs_radiance or any("band" in spec.dims for spec in plan.variables):
        yield "bands", ", ".join(f"{band.name} ({band.lower_um:g}-{band.upper_um:g} um)" for band in assembly.bands)
    if plan.needs_radiance:
        names = [_named(entries.get(f"optics[{n}]") or entries["optics"]) for n in range(len(plan.layers))]
        if len(set(names)) > 1:
            names = [f"{name} ({layer.name})" for name, layer in zip(names, plan.layers, strict=True)]
        optics = f", optics {', '.join(dict.fromkeys(names))}" if names else ""
        known = assembly.spectral_grid.wavenumber_cm1.size
        yield "radiance", f"{_named(entries['radiance'])}{optics}; a few weighted wavenumbers represent {known}"
        if light := _light(plan):
            yield "light", light


def _light(plan: Plan) -> str:
    """Return which light between columns a scene has, why, and its expected error; empty if nothing chose it."""
    light = plan.light
    if not light.choice:
        return ""
    errors = ", ".join(f"{band} {100.0 * error:.2g} %" for band, error in light.expected_rms.items())
    expected = (
        f"expected error (rms over pixels) {errors}"
        if errors
        else f"its error is that of '{COLUMNS}' in the error budget"
    )
    return f"{light.name}{f' [{light.provider}]' if light.provider else ''}, {light.choice}; {expected}"


def _surfaces(plan: Plan) -> Rows:
    if not plan.surfaces:
        where = f"sea everywhere; {100.0 * plan.land_share:.3g} % of the image is land" if plan.land_share else "sea"
        yield "surface", where
        return
    (surfaces,), classes = plan.surfaces, []
    for class_, axis, share in zip(surfaces.classes, surfaces.axes, surfaces.shares, strict=True):
        kelvin = f"{class_.low_K:.5g} K"
        if class_.low_K < class_.high_K:
            kelvin = f"{class_.low_K:.5g} to {class_.high_K:.5g} K, tables for {axis.nodes.size} temperatures"
        classes.append(f"{class_.name} {100.0 * share:.3g} % ({kelvin})")
    yield "surface", f"{', '.join(classes)}; {_named(plan.assembly.entries['surfaces'])}"


def _measured(of_band: Mapping[str, Any]) -> str:
    """Return noise, range and blur of a band of a sensor, as far as its model says them."""
    parts = []
    if "nedt" in of_band:
        parts.append(f"NEDT {of_band['nedt']:.3g} K at {of_band['nedt_temperature']:g} K")
    if "saturation_temperature" in of_band:
        parts.append(f"saturates at {of_band['saturation_temperature']:.4g} K")
    if "radiance_per_number" in of_band:
        parts.append(f"one number is {of_band['radiance_per_number']:.3g} W m-2 sr-1")
    if "mtf_nyquist_y" in of_band:
        mtf = [f"{of_band[f'mtf_nyquist_{axis}']:.2g}" for axis in "xy"]
        parts.append(f"MTF {' and '.join(dict.fromkeys(mtf))} at half a cycle per pixel")
    return ", ".join(parts)


def _named(entry: Entry) -> str:
    """Return the name of a provider, with its package if that is not this one."""
    return entry.name if entry.distribution == OWN_DISTRIBUTION else f"{entry.name} [{entry.origin}]"


def _output(plan: Plan) -> Rows:
    output = plan.scenario.output
    count = plan.uncompressed_bytes
    size = next((f"{count / factor:.1f} {unit}" for unit, factor in (("TB", 1e12), ("GB", 1e9)) if count >= factor), "")
    size = size or f"{count / 1e6:.1f} MB"
    stored = f" before compression, compressed at level {output.compression}" if output.compression else ""
    checked = f"; certificate of {PixelSample(plan).size} pixels" if output.certificate else "; no certificate"
    names = ", ".join(spec.name for spec in plan.variables)
    yield "output", f"{names}: {size}{stored}{checked if plan.needs_radiance else ''}"
    for index, provider in enumerate(plan.assembly.derived):
        entry = plan.assembly.entries[numbered(Kind.VARIABLES, index, len(plan.assembly.derived))]
        given = ", ".join(spec.name for spec in plan.variables if spec.name in provider.variables)
        yield "derived", f"{given} from {', '.join(provider.needs)}; {_named(entry)}"
    for line in quantization_lines(plan.variables, output.compression > 0):
        yield "rounding", line
    for line in packing_lines(plan.variables, [band.name for band in plan.bands]):
        yield "packing", line
    if plan.sensor.stages:
        measured = ", ".join(spec.name for spec in plan.sensor.variables)
        models = ", then ".join(_named(stage.entry) for stage in plan.sensor.stages)
        yield "sensor", f"{plan.sensor.title} ({models}); separate cube: {measured}"
        for stage in plan.sensor.stages:
            worked_out: Mapping[str, Any] = getattr(stage.provider, "worked_out", {})
            for band, of_band in worked_out.get("bands", {}).items():
                if text := _measured(of_band):
                    yield "sensor", f"{band}: {text}"
        for note in plan.sensor.notes:
            yield "sensor", f"note: {note}"
    if plan.needs_radiance:
        yield "accuracy", f"{plan.accuracy}; error budget: {_budget(plan)}"
        yield "numerics", _numerics(plan)


def _numerics(plan: Plan) -> str:
    """Return how the sizes of the numerical solution were chosen."""
    numerics, grid, last = plan.numerics, plan.grid_refinement, plan.assembly.model.declares.numerical_levels - 1
    step = {-1: "every second wavenumber", 0: "the wavenumbers"}.get(
        grid.refinement, f"{2**grid.refinement} times the wavenumbers"
    )
    text = f"spectral grid: {step} of the atmosphere's, error {grid.error:.2g}"
    if last > 0:
        finer = f", for sunlight {numerics.level + numerics.sunlight_steps}" if numerics.sunlight_steps else ""
        text = f"level {numerics.level} of 0 to {last} of the radiance model{finer}, error {numerics.error:.2g}; {text}"
    return text if numerics.enough else f"{text}; finer levels would be needed, but there are none"


def _budget(plan: Plan) -> str:
    """Return the fraction of the accuracy allotted to each approximation of the scene."""
    cloudy = plan.assembly.cloudy_layers
    over_time = plan.sun_matters and plan.frame_times_s.size > 1
    used = {
        "thickness": any(cloudy),
        "layers": sum(cloudy) > 1,
        "faint_sunlight": not plan.sunlight.is_computed,
        "waves": plan.waves.varies,
        "views": plan.views.varies,
        "shadows": plan.has_shadows,
        "time": over_time,
        "other_instants": over_time and any(cloudy),
    }
    return ", ".join(
        f"{100 * share:g} % {name.replace('_', ' ')}" for name, share in SHARES.items() if used.get(name, True)
    )


def approximations(plan: Plan) -> Rows:
    """Yield bound and text of each approximation, largest bound first; ``--json`` has the complete text."""
    # with several layers the omissions also name the layer
    of_generators = {
        (what if len(plan.layers) == 1 else f"{layer.name}: {what}"): what
        for layer, generator in zip(plan.layers, plan.assembly.generators, strict=True)
        for what, _ in getattr(generator, "skipped", ())
    }
    bounded = sorted(
        (item for item in plan.omissions if item.bound != 0.0 and item.size), key=lambda item: -(item.size or 0.0)
    )
    unknown = [item for item in plan.omissions if item.bound is None and not item.size]
    for item in [*bounded, *(item for item in unknown if item.what not in of_generators)]:
        matters = item.exceeds(OMISSION_SHARE * plan.accuracy.relative)
        exceeds = matters and not item.decision
        sense = f" ({item.sense})" if item.sense else ""
        why = f"needs {item.needs}" if exceeds else item.why.partition(";")[0]
        if matters and item.decision:
            why = f"{item.decision}; {item.needs}" + " computes it" * (not item.needs.endswith("no key computes it"))
        yield bound_text(item.size) + " *" * exceeds, f"{item.what}{sense}: {why}"
    if plan.needs_radiance:
        for text in error_budget(plan).beyond(plan.accuracy.relative):
            yield "on request", text
    # the reason without the list that may follow it
    nothing = [f"{item.what} ({re.split('[;:]', item.why)[0]})" for item in plan.omissions if item.bound == 0.0]
    if nothing:
        yield "nothing", "; ".join(nothing)
    details = [of_generators[item.what] for item in unknown if item.what in of_generators]
    if details:
        yield "statistical", f"(nearly) equal in distribution, not pixel by pixel: {'; '.join(_grouped(details))}"


def _world(plan: Plan) -> Rows:
    """Yield the total error, models included."""
    if plan.needs_radiance:
        first, *others = error_budget(plan).totals
        yield "error", f"total, models included (more: --json): {first}"
        yield from (("error", line) for line in others)


def _grouped(details: list[str]) -> Iterator[str]:
    """Merge details, such as ``interpolation of octave 5 along x``, into one per range of octaves."""
    groups: dict[str, set[str]] = {}
    for what in details:
        match = _NUMBERED.fullmatch(what.partition(" along ")[0])
        name, number = match.groups() if match else (what, "")
        groups.setdefault(name, set()).add(number)
    for name, numbers in groups.items():
        first, *rest = sorted(numbers, key=lambda number: int(number or 0))
        yield f"{name}{first} to {rest[-1]}" if rest else name + first
