"""Report page of a comparison with a real image."""

from __future__ import annotations

import math

from hcss_evaluate.comparison.definitions import DEFINITIONS, MODES, Mode
from hcss_evaluate.comparison.result import TERMS, Evaluation, Side
from hcss_evaluate.pages import evaluation_figures as drawn
from hcss_evaluate.pages.evaluation_text import (
    NOT_COMPARABLE,
    cloud_text,
    distances,
    marked,
    metric_groups,
    metric_rows,
    percent,
    rmse_text,
    signed,
)
from hcss_twin import __version__
from hcss_twin.reports.page import Markup, Page
from hcss_twin.reports.tables import Table

_ERRORS = (("EV", "entropy"), ("Den", "density"), ("DP", "diagonal_peak"), ("FD", "fractal_dimension"))
_LISTED = 4  # number of largest relative differences in the summary
_LONGEST_NAME = 34

_PRINTED_RMSE = (
    "The paper prints 3.09 % (its Table VIII) and 4.18 % (Table IX) for images made to look alike, and 8.73 % and "
    "12.01 % for others."
)


def evaluation_page(evaluation: Evaluation) -> Page:
    """Return the page."""
    sections = [
        Page.Section("In short", _summary(evaluation)),
        Page.Section("Pictures", _pictures(evaluation)),
        Page.Section("Neighbouring grey levels", _pairs(evaluation)),
        Page.Section(f"Histograms of {evaluation.quantity}", _values(evaluation)),
        Page.Section("Spectra and directions", _spectra(evaluation)),
    ]
    if len(evaluation.real.frames) > 1 or len(evaluation.sim.frames) > 1:
        sections.append(Page.Section("Change over time", _over_time(evaluation)))
    sections += [
        Page.Section("All measures", _all_metrics(evaluation)),
        Page.Section("Definitions", _definitions()),
        Page.Section("What was compared", _compared(evaluation)),
    ]
    names = f"simulated: {_short(evaluation.sim.name)} | real: {_short(evaluation.real.name)}"
    return Page("Simulated and real clouds compared", f"{names} | hcss {__version__}", sections)


def _short(name: str) -> str:
    """Return a name short enough for one line on a phone; the full name is at the end of the page."""
    return name if len(name) <= _LONGEST_NAME else f"{name[: _LONGEST_NAME - 3]}..."


def _summary(evaluation: Evaluation) -> list[Markup.Block]:
    content: list[Markup.Block] = [Markup.beside(*(_eq_24(evaluation, mode) for mode in MODES))]
    if not all(evaluation.rmse_compares(mode) for mode in MODES):
        content.append(Markup.paragraph(NOT_COMPARABLE))
    if any(len(error) > 1 for error in evaluation.errors.values()):
        printed, corrected = (rmse_text(evaluation, mode) for mode in ("as-printed", "corrected"))
        content.append(Markup.paragraph(f"RMSE as printed {printed}; corrected {corrected}."))
    texts = (_PRINTED_RMSE, _largest(evaluation), _in_values(evaluation))
    return [*content, *map(Markup.paragraph, texts), *(Markup.note(text, "fair") for text in evaluation.notes)]


def _eq_24(evaluation: Evaluation, mode: Mode) -> Table:
    """Return eq 24 in one definition."""
    errors = evaluation.errors[mode]
    rows = []
    for name, field in _ERRORS:
        metric = evaluation.metric(TERMS[mode][name])
        mean = sum(getattr(error, field) for error in errors) / len(errors) if errors else math.nan
        rows.append(
            [marked(name, metric.comparable), Table.number(metric.real), Table.number(metric.sim), _share(mean)]
        )
    rows.append([marked("RMSE", evaluation.rmse_compares(mode)), "", "", _share(evaluation.rmse(mode))])
    over = "simulated" if mode == "as-printed" else "real"
    caption = f"Eq 24 of the HCSS paper {mode.replace('-', ' ')}: errors relative to the {over} values"
    return Table(["", "real", "simulated", "error"], rows, caption)


def _share(value: float) -> str:
    return "-" if math.isnan(value) else f"{100 * value:.2f} %"


def _largest(evaluation: Evaluation) -> str:
    """Describe the largest relative differences of comparable metrics."""
    known = [
        metric
        for metric in evaluation.metrics
        if metric.comparable
        and not math.isnan(metric.relative)
        and metric.relative
        and metric.definition != "as-printed"
    ]
    if not known:
        return "No comparable measure differs."
    listed = "; ".join(
        f"{metric.name} {percent(metric.relative)} ({metric.meaning.partition(';')[0].partition(':')[0]})"
        for metric in sorted(known, key=lambda metric: -abs(metric.relative))[:_LISTED]
    )
    return f"Largest differences of comparable measures: {listed}."


def _in_values(evaluation: Evaluation) -> str:
    unit = f" {evaluation.unit}" if evaluation.unit else " levels"
    distance = evaluation.distance
    return (
        f"In {evaluation.quantity} the means differ by {signed(distance('mean_difference'))}{unit}, W1 is "
        f"{Table.number(distance('wasserstein'))}{unit} "
        f"({Table.number(distance('wasserstein_centred'))}{unit} about the means); "
        f"spectra differ by {Table.number(evaluation.spectral_distance_db)} dB rms. {_pairing(evaluation)}"
    )


def _pairing(evaluation: Evaluation) -> str:
    return f"The comparison used {evaluation.pairing}."


def _sides(evaluation: Evaluation) -> tuple[tuple[str, Side], tuple[str, Side]]:
    return ("Real", evaluation.real), ("Simulated", evaluation.sim)


def _pictures(evaluation: Evaluation) -> list[Markup.Block]:
    values, levels = [], []
    for title, side in _sides(evaluation):
        frame = f"{title}, {_short(side.pictured.label)}"
        caption = f"{frame}: {evaluation.quantity} on one scale for both; missing pixels are blue."
        values.append(
            Markup.picture(drawn.draw_values(evaluation, side), f"{title} image, {evaluation.quantity}", caption)
        )
        cloud = f"cloud is {cloud_text(side)}. {100 * side.pictured_coverage:.1f} % of the pixels are cloudy."
        caption = f"{title}, as used in eqs 21 to 23: {cloud}"
        levels.append(Markup.picture(drawn.draw_levels(side), f"{title} image, grey levels of cloud", caption))
    content: list[Markup.Block] = [Markup.beside(*values), Markup.beside(*levels)]
    if len(evaluation.sim.frames) > 1:
        content.insert(0, Markup.paragraph("Of the simulated frames the one with the median RMSE is shown."))
    return content


def _pairs(evaluation: Evaluation) -> list[Markup.Block]:
    sides = _sides(evaluation)
    most = max(float(side.pictured.pairs.max() / max(1, side.pictured.pairs.sum())) for _, side in sides)
    return [
        Markup.paragraph(
            "How often grey level g is left of g'. EV is the entropy of this histogram, Den its nearness to the "
            "diagonal, DP the height of the diagonal. The corner is clear sky beside clear sky; along the axes are the "
            "edges of clouds."
        ),
        Markup.beside(
            *(
                Markup.picture(
                    drawn.draw_pairs(side, most),
                    f"{title}: two-dimensional histogram of neighbours",
                    f"{title}: {int(side.pictured.pairs.sum())} pairs, on one logarithmic scale for both.",
                )
                for title, side in sides
            )
        ),
    ]


def _values(evaluation: Evaluation) -> list[Markup.Block]:
    counted, summed = drawn.draw_histograms(evaluation)
    return [
        Markup.beside(
            Markup.picture(counted, "histograms of both sides", "All pixels of all frames."),
            Markup.picture(summed, "cumulative histograms of both sides", "W1 is the area between both lines."),
        ),
        distances(evaluation),
    ]


def _spectra(evaluation: Evaluation) -> list[Markup.Block]:
    shown = [
        Markup.picture(figure, "power spectra of both sides by wavenumber", "Radially averaged, four rings per octave.")
        for figure in drawn.draw_spectra(evaluation)
    ]
    directions = drawn.draw_directions(evaluation)
    if directions is not None:
        caption = (
            "Power by direction in which waves advance, over that of all directions at the same wavenumber; 0 is east, "
            "90 north. Structures are elongated across the direction of most power."
        )
        shown.append(Markup.picture(directions, "relative power of both sides by direction of the waves", caption))
    if not shown:
        return [Markup.paragraph("Neither side has a spectrum; the notes below give the reason.")]
    difference = evaluation.spectral_distance_db
    if math.isnan(difference):
        return [Markup.beside(*shown)]
    rms = Table.number(difference)
    text = f"The spectra differ by {rms} dB rms over their common rings; 10 dB is a factor of ten in power."
    return [Markup.paragraph(text), Markup.beside(*shown)]


def _over_time(evaluation: Evaluation) -> list[Markup.Block]:
    text = (
        f"{_pairing(evaluation)} Correlation is at fixed pixels: motion by wind or platform decreases it, and so does "
        "evolution of the scene."
    )
    shown = [Markup.picture(figure, f"{name} of every frame") for name, figure in drawn.draw_frames(evaluation)]
    correlation = drawn.draw_correlation(evaluation)
    if correlation is not None:
        shown.insert(0, Markup.picture(correlation, "correlation of frames versus the time between them"))
    return [Markup.paragraph(text), Markup.beside(*shown)]


def _all_metrics(evaluation: Evaluation) -> list[Markup.Block]:
    content: list[Markup.Block] = []
    if any(metric.real_spread > 0.0 or metric.sim_spread > 0.0 for metric in evaluation.metrics):
        content.append(Markup.paragraph("Means and standard deviations over frames."))
    if not all(metric.comparable for metric in evaluation.metrics):
        content.append(Markup.paragraph(NOT_COMPARABLE))
    header = ["", "real", "simulated", "difference", "relative"]
    content += [Table(header, metric_rows(evaluation, group), group) for group in metric_groups(evaluation)]
    return [
        *content,
        Markup.folded(
            "What each measure is", Markup.facts((metric.name, metric.meaning) for metric in evaluation.metrics)
        ),
    ]


def _definitions() -> list[Markup.Block]:
    rows = [[definition.name, definition.as_printed, definition.corrected] for definition in DEFINITIONS]
    return [
        Table(["", "as printed", "corrected"], rows, text_columns=3),
        Markup.paragraph(
            "Factors that both images share cancel in eq 24, so that Den and DP have the same errors in both "
            "definitions; only the denominators of the errors differ."
        ),
    ]


def _compared(evaluation: Evaluation) -> list[Markup.Block]:
    content: list[Markup.Block] = []
    for title, side in _sides(evaluation):
        content += [
            Markup.element("h3", title),
            Markup.facts(_facts(side)),
            *([Markup.bullets(side.notes)] if side.notes else []),
        ]
    return content


def _facts(side: Side) -> list[tuple[str, str]]:
    part = "all" if side.part == side.shape else f"the central {side.part[0]} x {side.part[1]}"
    frames, first = len(side.frames), side.frames[0].label
    pairs = [
        ("file", side.name),
        ("values", f"{side.quantity}{f' ({side.units})' if side.units else ''}"),
        ("band", side.band),
        ("pixels", f"{side.shape[0]} rows x {side.shape[1]} columns; compared: {part}"),
        ("pixel size", "unknown" if side.pixel_size_m is None else f"{side.pixel_size_m:.6g} m"),
        ("frame", first) if frames == 1 else ("frames", f"{frames}, {first} to {side.frames[-1].label}"),
        ("cloud is", cloud_text(side)),
    ]
    return [(name, value) for name, value in pairs if value]
