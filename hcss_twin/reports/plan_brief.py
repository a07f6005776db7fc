"""What ``hcss plan`` says first: size, time and memory, what a user should know, and the details that decide a run."""

from __future__ import annotations

import re
from collections.abc import Iterator

from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.engine.predicted_time import Prediction
from hcss_twin.plan.error_budget import ErrorBudget, error_budget
from hcss_twin.plan.few_columns import OMISSION_SHARE, SWITCHED_OFF, TOO_DEAR, Omission
from hcss_twin.plan.plan import Plan
from hcss_twin.reports.plan_text import default_wind
from hcss_twin.reports.tables import Table, bound_text, class_text

MOST_LINES = 15
"""Lines of the whole text; details that do not fit are left to ``--verbose``."""

_LABEL = 10
_MOST_LISTED = 3

_IN_PART = re.compile(r" in \d+ % of the band")

Rows = Iterator[tuple[str, str]]


def plan_brief(plan: Plan, prediction: Prediction, name: str) -> str:
    """Describe a plan in at most :data:`MOST_LINES` lines.

    Parameters
    ----------
    name : str
        The scenario as the user named it, for the command that runs it.
    """
    lines = [plan.scenario.title or plan.scenario.origin]
    for label, text in _first(plan, prediction):
        lines += Table.labelled(label, text, _LABEL).splitlines()
    last = Table.labelled(
        "next", f"hcss run {name}; hcss plan {name} --verbose has all inputs, omissions and errors", _LABEL
    )
    for label, text in _details(plan):
        row = Table.labelled(label, text, _LABEL).splitlines()
        if len(lines) + len(row) + len(last.splitlines()) <= MOST_LINES:
            lines += row
    return "\n".join([*lines, last])


def _first(plan: Plan, prediction: Prediction) -> Rows:
    yield "size", _size(plan)
    yield "time", prediction.time_text
    yield "memory", prediction.memory_text
    yield "error", _largest_error(plan)
    yield "left out", _largest_omission(plan)
    assumed = [*default_wind(plan), *(f"{item.field} = {item.value}" for item in plan.filled_in)]
    yield "assumed", _listed(assumed, "; ") if assumed else "nothing: the scenario sets all values"


def _size(plan: Plan) -> str:
    rows, columns = plan.pixels
    metres = plan.image.pixel_size_m
    about = "" if plan.is_grid else "about "
    extent = f" ({columns * metres / 1e3:.4g} x {rows * metres / 1e3:.4g} km)" if plan.is_grid else ""
    frames = Table.frames_text(plan.frame_times_s.size)
    bands = f", {len(plan.bands)} band{'s' * (len(plan.bands) > 1)}" if plan.needs_radiance else ""
    unit, factor = next(
        (each for each in (("TB", 1e12), ("GB", 1e9)) if plan.uncompressed_bytes >= each[1]), ("MB", 1e6)
    )
    stored = f"{plan.uncompressed_bytes / factor:.1f} {unit} before compression"
    return f"{rows} x {columns} pixels of {about}{metres:.4g} m{extent}, {frames}{bands}: {stored}"


def _largest_error(plan: Plan) -> str:
    """Say where the models are least accurate, in kelvin, and what causes that."""
    if not plan.needs_radiance:
        return "none to state: no radiance is computed"
    budget = error_budget(plan)
    cell = max(budget.contributions, key=lambda cell: budget.total(cell)[1])
    known = [each for each in budget.contributions[cell] if each.kelvin is not None]
    cause = max(known, key=lambda each: each.kelvin or 0.0)
    names = dict.fromkeys(_IN_PART.sub("", unknown) for unknown in budget.unknown(cell))
    least, unknown = ("at least ", f"; unknown: {', '.join(names)}") if names else ("", "")
    of, band = cell
    total = f"{least}{budget.total(cell)[1]:.2g} K in {class_text(of)}, {band}: mostly {cause.name}"
    return f"{total}{unknown}{_unknown_of_others(budget, of)}"


def _unknown_of_others(budget: ErrorBudget, named: str) -> str:
    """Say what is unknown of the classes that are not named: their error may be the largest."""
    unknown: dict[str, dict[str, None]] = {}
    for of, band in budget.contributions:
        if of != named:
            names = [_IN_PART.sub("", each) for each in budget.unknown((of, band))]
            unknown.setdefault(of, {}).update(dict.fromkeys(names))
    alike: dict[tuple[str, ...], list[str]] = {}
    for of, causes in unknown.items():
        if causes:
            alike.setdefault(tuple(causes), []).append(class_text(of))
    return "".join(f"; unknown in {_listed(classes, ', ')}: {', '.join(causes)}" for causes, classes in alike.items())


def _largest_omission(plan: Plan) -> str:
    """Name the largest omission with the key that computes it, and how many others exceed their share."""
    sized = [each for each in plan.omissions if each.bound != 0.0 and each.size]
    if not sized:
        return "nothing that changes a pixel"
    limit = OMISSION_SHARE * plan.accuracy.relative
    large = sorted((each for each in sized if each.exceeds(limit)), key=lambda each: -(each.size or 0.0))
    largest = large[0] if large else max(sized, key=lambda each: each.size or 0.0)
    text = f"{largest.what}, {bound_text(largest.size)}{f' ({largest.sense})' if largest.sense else ''}"
    if not large:
        return f"{text}: within its share of the accuracy, as is all else"
    others = f"; {len(large) - 1} more exceed {100.0 * limit:.2g} %" if len(large) > 1 else ""
    return f"{text}: {_remedy(largest)}{others}"


def _remedy(omission: Omission) -> str:
    decision = {SWITCHED_OFF: "switched off; ", TOO_DEAR: "not computed, to save time; "}.get(omission.decision, "")
    computes = "" if omission.needs.endswith("no key computes it") else " computes it"
    return f"{decision}{omission.needs}{computes}"


def _details(plan: Plan) -> Rows:
    """Yield what decides a run, the most important first."""
    place, when = plan.scenario.place, plan.scenario.time.isoformat(" ", "minutes")
    where = f"{abs(place.latitude):g} {'NS'[place.latitude < 0]} {abs(place.longitude):g} {'EW'[place.longitude < 0]}"
    yield "scene", f"{where}, {when}, {_sun(plan)}; view zenith {plan.view.zenith_deg:.3g} deg"
    yield from _clouds(plan)
    if plan.needs_radiance:
        checked = PixelSample(plan).size
        certificate = f"checked in {checked} random pixels" if checked else "NOT CHECKED: output.certificate is 0"
        yield "accuracy", f"{plan.accuracy} (numerical error, not that of the models), {certificate}"
    if plan.needs_radiance:
        waves = "resolved waves" if plan.waves.varies else "statistical waves"
        speed = f"wind {plan.assembly.sea_wind_speed_m_s:.3g} m/s"
        yield "sea", f"{plan.assembly.sea_temperature_K:.5g} K, {speed}, {waves}; air: {plan.assembly.profile.name}"
        yield "bands", _listed([f"{band.name} ({band.lower_um:g}-{band.upper_um:g} um)" for band in plan.bands], ", ")
    if plan.sensor.stages:
        yield "sensor", f"{plan.sensor.title}: a second cube, as measured"


def _clouds(plan: Plan) -> Rows:
    layers = [
        f"{layer.name}, cover {_cover(layer.coverage, generator)}, {layer.base_m:g} to {layer.top_m:g} m"
        for layer, generator in zip(plan.layers, plan.assembly.generators, strict=True)
    ]
    yield "clouds", (_listed(layers, "; ") if layers else "none") + _light(plan)


def _light(plan: Plan) -> str:
    """Name the light between columns, and its expected error, where the scenario asks for another than the default."""
    light = plan.light
    if not light.choice:
        return ""
    largest = max(light.expected_rms.values(), default=None)
    expected = "" if largest is None else f", expected error {100.0 * largest:.2g} %"
    return f"; light: {light.name}{expected}"


def _cover(stated: float, generator: object) -> str:
    """Say what share of pixels has cloud: an image, and pixels that clouds fill in part, have their own."""
    found = getattr(generator, "image_coverage", None)
    return f"{stated:.3g}" if found is None else f"{found:.3g} of pixels ({stated:.3g} stated)"


def _sun(plan: Plan) -> str:
    zenith = plan.sun_zenith_deg
    if zenith.min() >= 90.0:
        return "night"
    low, high = f"{zenith.min():.3g}", f"{zenith.max():.3g}"
    return f"sun zenith {low if low == high else f'{low} to {high}'} deg"


def _listed(texts: list[str], between: str) -> str:
    """Join the first few texts without their remarks in brackets where that makes one line, and count the others."""
    shown = texts[:_MOST_LISTED]
    more = f"{between}and {len(texts) - len(shown)} more" if len(texts) > len(shown) else ""
    text = between.join(shown) + more
    return text if len(text) <= 100 else between.join(re.sub(r" \(.*?\)", "", each) for each in shown) + more
