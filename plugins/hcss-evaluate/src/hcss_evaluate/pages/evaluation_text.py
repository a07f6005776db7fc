"""Comparison with a real image as text for a terminal; the page shows the same rows."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hcss_evaluate.comparison.definitions import MODES
from hcss_evaluate.comparison.result import Evaluation, Metric, Side
from hcss_twin.reports.tables import Table

NOT_COMPARABLE = "~ depends on the size or the number of pixels, which differ between the sides or are unknown."

_DISTANCES = (
    ("mean_difference", "mean, simulated less real", True),
    ("deviation_ratio", "standard deviation, simulated over real", False),
    ("wasserstein", "Wasserstein distance W1: mean change that turns one histogram into the other", True),
    ("wasserstein_centred", "W1 of the histograms about their means: difference of shape", True),
    ("kolmogorov_smirnov", "Kolmogorov-Smirnov: greatest difference of the cumulative histograms", False),
)
"""Attribute, meaning, and whether its unit is that of the values."""


def evaluation_text(evaluation: Evaluation) -> str:
    """Return a comparison as a table, with the compared data above and the limitations below."""
    return "\n".join(_lines(evaluation))


def _lines(evaluation: Evaluation) -> Iterator[str]:
    sides = (("real", evaluation.real), ("simulated", evaluation.sim))
    yield from (Table.labelled(title, side_text(side), 10) for title, side in sides)
    unit = f" ({evaluation.unit})" if evaluation.unit else ""
    yield Table.labelled("compared", f"{evaluation.quantity}{unit}; {evaluation.pairing}", 10)
    yield ""
    rows: list[list[str]] = [["", "real", "simulated", "difference", "relative"]]
    for group in metric_groups(evaluation):
        rows += [[group], *metric_rows(evaluation, group)]
    yield from Table.aligned(rows)
    yield "RMSE of eq 24 (EV, Den, DP, FD)"
    yield from Table.aligned(
        [[marked(mode, evaluation.rmse_compares(mode)), rmse_text(evaluation, mode)] for mode in MODES], 2
    )
    yield f"Distributions of {evaluation.quantity}"
    spectra = [Table.number(evaluation.spectral_distance_db), "dB", "rms difference of the spectra"]
    yield from Table.aligned([[row[1], row[2], row[0]] for row in distances(evaluation).rows] + [spectra], 3)
    if not all(metric.comparable for metric in evaluation.metrics):
        yield NOT_COMPARABLE
    notes = (("", evaluation.notes), ("real: ", evaluation.real.notes), ("simulated: ", evaluation.sim.notes))
    yield from (f"note: {title}{note}" for title, listed in notes for note in listed)


def side_text(side: Side) -> str:
    """Describe one side."""
    size = "" if side.pixel_size_m is None else f" of {side.pixel_size_m:.6g} m"
    frames = f"{len(side.frames)} frame{'s' if len(side.frames) > 1 else ''}"
    units = f" ({side.units})" if side.units else ""
    parts = (
        f"{side.name}: {frames} of {side.part[0]} x {side.part[1]} pixels{size}",
        f"{side.quantity}{units}",
        side.band,
        f"cloud is {cloud_text(side)}",
    )
    return "; ".join(part for part in parts if part)


def cloud_text(side: Side) -> str:
    """Describe which pixels count as cloud."""
    if side.method == "truth":
        return side.mask
    return f"what is {'bright' if side.bright_is_cloud else 'dark'}, by {side.mask}"


def metric_groups(evaluation: Evaluation) -> list[str]:
    """Return the headings of the metrics in order."""
    return list(dict.fromkeys(metric.group for metric in evaluation.metrics))


def metric_rows(evaluation: Evaluation, group: str) -> list[list[str]]:
    """Return name, both values, difference and relative difference of each metric in a group."""
    return [
        [
            marked(metric.name, metric.comparable) + (f" ({metric.unit})" if metric.unit not in ("", "1") else ""),
            _value(metric, metric.real, metric.real_spread),
            _value(metric, metric.sim, metric.sim_spread),
            signed(metric.difference),
            percent(metric.relative),
        ]
        for metric in evaluation.metrics
        if metric.group == group
    ]


def _value(metric: Metric, value: float, spread: float) -> str:
    """Return a mean, its standard deviation over frames unless 0, and a mark if the value is out of range."""
    text = f"{value:.4g} ± {spread:.2g}" if spread > 0.0 else Table.number(value)
    if metric.limits is None or not metric.is_out_of_range(value):
        return text
    return f"{text} (out of range {metric.limits[0]:g} to {metric.limits[1]:g})"


def distances(evaluation: Evaluation) -> Table:
    """Return the distances of the histograms, means over frames."""
    unit = evaluation.unit or "levels"
    rows = [
        [meaning, Table.number(evaluation.distance(name)), unit if has_unit else "1"]
        for name, meaning, has_unit in _DISTANCES
    ]
    return Table(["distance", "value", "unit"], rows, "Distances of the histograms, mean over frames")


def marked(name: str, comparable: bool) -> str:
    """Return the name, marked if the two sides are not comparable."""
    return name if comparable else f"{name} ~"


def rmse_text(evaluation: Evaluation, mode: str) -> str:
    """Return the RMSE in one definition."""
    errors = next(errors_of_mode for name, errors_of_mode in evaluation.errors.items() if name == mode)
    if not errors:
        return "none: a divisor is 0"
    values = [100 * error.rmse for error in errors]
    several = f", {min(values):.2f} to {max(values):.2f} % over {len(values)} frames" if len(values) > 1 else ""
    over = "simulated" if mode == "as-printed" else "real"
    return f"{sum(values) / len(values):.2f} %, relative to the {over} values{several}"


def signed(value: float) -> str:
    """Return a signed difference; a plain 0 if there is none."""
    return Table.number(value) if math.isnan(value) or value == 0.0 else f"{value:+.3g}"


def percent(value: float) -> str:
    """Return a fraction as a signed percentage."""
    return "" if math.isnan(value) else "0 %" if value == 0.0 else f"{100 * value:+.1f} %"
