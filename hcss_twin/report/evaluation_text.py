"""A comparison with a real image as text for a terminal, and its numbers as text for tables."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hcss_twin.analysis.comparison.result import Evaluation, Metric, Side
from hcss_twin.analysis.measures.morphology import MODES

DISTANCES = (
    ("mean_difference", "mean, simulated less real", True),
    ("deviation_ratio", "standard deviation, simulated over real", False),
    ("wasserstein", "Wasserstein distance W1: mean change that turns one histogram into the other", True),
    ("wasserstein_centred", "W1 after both means were subtracted: what shape adds", True),
    ("kolmogorov_smirnov", "Kolmogorov-Smirnov: greatest difference of the cumulative histograms", False),
)
"""Attribute, meaning, and whether it has the unit of the values."""

_NAME, _CELL = 16, 18


def evaluation_text(found: Evaluation) -> str:
    """Return a comparison as a table with what was compared above and what limits it below."""
    return "\n".join(_lines(found))


def _lines(found: Evaluation) -> Iterator[str]:
    for title, side in (("real", found.real), ("simulated", found.sim)):
        yield f"{title:<10} {side_in_words(side)}"
    yield f"{'compared':<10} {found.quantity}{f' ({found.unit})' if found.unit else ''}; {found.pairing}"
    yield ""
    yield f"{'':<{_NAME}} {'real':>{_CELL}} {'simulated':>{_CELL}} {'difference':>11} {'relative':>9}"
    group = ""
    for each in found.metrics:
        if each.group != group:
            group = each.group
            yield group
        yield (
            f"  {name_of(each):<{_NAME - 2}} {with_spread(each.real, each.real_spread):>{_CELL}} "
            f"{with_spread(each.sim, each.sim_spread):>{_CELL}} {signed(each.difference):>11} "
            f"{percent(each.relative):>9}  {each.unit if each.unit != '1' else ''}{_beyond(each)}".rstrip()
        )
    yield "RMSE of eq 24 (EV, Den, DP, FD)"
    for mode in MODES:
        marked = mode if found.rmse_compares(mode) else f"{mode} ~"
        yield f"  {marked:<{_NAME - 2}} {rmse_text(found, mode)}"
    yield f"Distributions of {found.quantity}"
    for name, meaning, has_unit in DISTANCES:
        unit = f" {found.unit}" if has_unit and found.unit else ""
        yield f"  {number(found.distance(name)):>{_NAME - 2}}{unit}  {meaning}"
    yield f"  {number(found.spectral_distance_db):>{_NAME - 2}} dB  rms difference of the spectra"
    if any(not each.comparable for each in found.metrics):
        yield "~ depends on the size or number of pixels, which both sides do not (or are not known to) have in common"
    for title, notes in (("", found.notes), ("real: ", found.real.notes), ("simulated: ", found.sim.notes)):
        yield from (f"note: {title}{each}" for each in notes)


def side_in_words(side: Side) -> str:
    """Say what one side is."""
    size = "" if side.pixel_size_m is None else f" of {side.pixel_size_m:.6g} m"
    frames = len(side.frames)
    return "; ".join(
        part
        for part in (
            f"{side.name}: {frames} frame{'s' if frames > 1 else ''} of {side.part[0]} x {side.part[1]} pixels{size}",
            f"{side.quantity}{f' ({side.units})' if side.units else ''}",
            side.band,
            f"cloud is {cloud_in_words(side)}",
        )
        if part
    )


def cloud_in_words(side: Side) -> str:
    """Say what was taken for cloud."""
    if side.method == "truth":
        return side.mask
    return f"what is {'bright' if side.bright_is_cloud else 'dark'}, by {side.mask}"


def name_of(metric: Metric) -> str:
    """Return the name, marked where both sides do not compare."""
    return metric.name if metric.comparable else f"{metric.name} ~"


def _beyond(metric: Metric) -> str:
    """Name the sides whose value nothing of its kind can have."""
    sides = (("real", metric.real), ("simulated", metric.sim))
    beyond = [title for title, value in sides if metric.is_out_of_range(value)]
    if not beyond or metric.limits is None:
        return ""
    return f"out of range, {metric.limits[0]:g} to {metric.limits[1]:g}: {', '.join(beyond)}"


def rmse_text(found: Evaluation, mode: str) -> str:
    """Say the RMSE in one of the definitions."""
    errors = next(each for name, each in found.errors.items() if name == mode)
    if not errors:
        return "none: a value that is divided by is 0"
    values = [each.rmse for each in errors]
    over = "simulated" if mode == "as-printed" else "real"
    several = (
        f", {100 * min(values):.2f} to {100 * max(values):.2f} % over {len(values)} frames" if len(values) > 1 else ""
    )
    return f"{100 * sum(values) / len(values):.2f} %, relative to the {over} values{several}"


def number(value: float) -> str:
    """Return a number with four digits, or a dash where there is none."""
    return "-" if math.isnan(value) else f"{value + 0.0:.4g}"


def with_spread(value: float, spread: float) -> str:
    """Return a mean and, where it is not 0, the standard deviation over frames."""
    return number(value) if not spread > 0.0 else f"{value:.4g} +- {spread:.2g}"


def signed(value: float) -> str:
    """Return a difference with its sign; a plain 0 where there is none."""
    return number(value) if math.isnan(value) or value == 0.0 else f"{value:+.3g}"


def percent(value: float) -> str:
    """Return a share as percent with its sign."""
    return "" if math.isnan(value) else "0 %" if value == 0.0 else f"{100 * value:+.1f} %"
