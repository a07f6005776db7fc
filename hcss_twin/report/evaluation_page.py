"""The page of a comparison with a real image."""

from __future__ import annotations

import math

from hcss_twin.analysis.comparison.result import TERMS, Evaluation, Metric, Side
from hcss_twin.analysis.measures.morphology import DEFINITIONS, MODES, Mode
from hcss_twin.report import evaluation_figures as drawn
from hcss_twin.report.evaluation_text import (
    DISTANCES,
    cloud_in_words,
    name_of,
    number,
    percent,
    rmse_text,
    signed,
    with_spread,
)
from hcss_twin.report.page.page import Page, Section, beside, bullets, element, facts, folded, note, paragraph, table
from hcss_twin.report.page.pictures import picture
from hcss_twin.version import __version__

_ERRORS = (("EV", "entropy"), ("Den", "density"), ("DP", "diagonal_peak"), ("FD", "fractal_dimension"))

# So many of the largest relative differences are told at the top.
_TOLD = 4

_LONGEST_NAME = 34

_MARKED = "~ depends on the size or the number of pixels, which both sides do not (or are not known to) have in common."

_PRINTED_RMSE = (
    "The paper prints 3.09 % (its Table VIII) and 4.18 % (Table IX) for images made to look alike, and 8.73 % and "
    "12.01 % for others."
)


def evaluation_page(found: Evaluation) -> Page:
    """Return the page."""
    sections = [
        Section("In short", _summary(found)),
        Section("Pictures", _pictures(found)),
        Section("Neighbouring grey levels", _pairs(found)),
        Section(f"Histograms of {found.quantity}", _values(found)),
        Section("Spectra and directions", _spectra(found)),
    ]
    if len(found.real.frames) > 1 or len(found.sim.frames) > 1:
        sections.append(Section("Change over time", _over_time(found)))
    sections += [
        Section("All measures", _all_metrics(found)),
        Section("Definitions", _definitions()),
        Section("What was compared", _compared(found)),
    ]
    return Page(
        "Simulated and real clouds compared",
        f"simulated: {_short(found.sim.name)} | real: {_short(found.real.name)} | hcss {__version__}",
        sections,
    )


def _short(name: str) -> str:
    """Return a name that a telephone can show in one line; the whole stands at the end of the page."""
    return name if len(name) <= _LONGEST_NAME else f"{name[: _LONGEST_NAME - 3]}..."


def _summary(found: Evaluation) -> list[str]:
    over = {"as-printed": "simulated", "corrected": "real"}
    content: list[str] = [
        beside(
            *(
                table(
                    ["", "real", "simulated", "error"],
                    _eq_24(found, mode),
                    f"Eq 24 of the HCSS paper {mode.replace('-', ' ')}: errors relative to the {over[mode]} values",
                )
                for mode in MODES
            )
        )
    ]
    if not all(found.rmse_compares(mode) for mode in MODES):
        content.append(paragraph(_MARKED))
    if any(len(each) > 1 for each in found.errors.values()):
        content.append(
            paragraph(f"RMSE as printed {rmse_text(found, 'as-printed')}; corrected {rmse_text(found, 'corrected')}.")
        )
    content += [paragraph(_PRINTED_RMSE), paragraph(_farthest(found)), paragraph(_in_values(found))]
    return [*content, *(note(each, "fair") for each in found.notes)]


def _eq_24(found: Evaluation, mode: Mode) -> list[list[str]]:
    """Return the rows of eq 24 in one definition."""
    errors = found.errors[mode]
    rows = []
    for name, field in _ERRORS:
        metric = found.metric(TERMS[mode][name])
        mean = sum(getattr(each, field) for each in errors) / len(errors) if errors else math.nan
        rows.append([_marked(name, metric.comparable), number(metric.real), number(metric.sim), _share(mean)])
    return [*rows, [_marked("RMSE", found.rmse_compares(mode)), "", "", _share(found.rmse(mode))]]


def _marked(name: str, compares: bool) -> str:
    return name if compares else f"{name} ~"


def _share(value: float) -> str:
    return "-" if math.isnan(value) else f"{100 * value:.2f} %"


def _farthest(found: Evaluation) -> str:
    """Name the largest relative differences of what compares."""
    known = [
        each
        for each in found.metrics
        if each.comparable and not math.isnan(each.relative) and each.definition != "as-printed"
    ]
    ranked = sorted(known, key=lambda each: -abs(each.relative))
    told = [each for each in ranked if each.relative][:_TOLD]
    if not told:
        return "No measure that compares differs."
    listed = "; ".join(f"{each.name} {percent(each.relative)} ({_lower(each)})" for each in told)
    return f"Farthest apart, of what compares: {listed}."


def _lower(metric: Metric) -> str:
    return metric.meaning.partition(";")[0].partition(":")[0]


def _in_values(found: Evaluation) -> str:
    unit = f" {found.unit}" if found.unit else " levels"
    return (
        f"In {found.quantity} the means differ by {signed(found.distance('mean_difference'))}{unit}, W1 is "
        f"{number(found.distance('wasserstein'))}{unit} ({number(found.distance('wasserstein_centred'))}{unit} without "
        f"the means); spectra differ by {number(found.spectral_distance_db)} dB rms. Compared was {found.pairing}."
    )


def _sides(found: Evaluation) -> tuple[tuple[str, Side], tuple[str, Side]]:
    return ("Real", found.real), ("Simulated", found.sim)


def _pictures(found: Evaluation) -> list[str]:
    values = [
        picture(
            drawn.draw_values(found, side),
            f"{title} image, {found.quantity}",
            f"{title}, {_short(side.pictured.label)}: {found.quantity} on one scale for both; missing pixels are blue.",
        )
        for title, side in _sides(found)
    ]
    levels = [
        picture(
            drawn.draw_levels(side),
            f"{title} image, grey levels of cloud",
            f"{title}, as eqs 21 to 23 see it: cloud is {cloud_in_words(side)}. {100 * side.pictured_coverage:.1f} % "
            "of the pixels are cloudy.",
        )
        for title, side in _sides(found)
    ]
    several = len(found.sim.frames) > 1
    told = "Of the simulated frames the one with the median RMSE is shown." if several else ""
    return [*([paragraph(told)] if told else []), beside(*values), beside(*levels)]


def _pairs(found: Evaluation) -> list[str]:
    most = max(float(side.pictured.pairs.max() / max(1, side.pictured.pairs.sum())) for _, side in _sides(found))
    return [
        paragraph(
            "How often grey level g stands left of g'. EV is the entropy of this histogram, Den its nearness to the "
            "diagonal, DP the height of the diagonal. The corner is clear sky beside clear sky; along the axes are the "
            "edges of clouds."
        ),
        beside(
            *(
                picture(
                    drawn.draw_pairs(side, most),
                    f"{title}: two-dimensional histogram of neighbours",
                    f"{title}: {int(side.pictured.pairs.sum())} pairs, on one logarithmic scale for both.",
                )
                for title, side in _sides(found)
            )
        ),
    ]


def _values(found: Evaluation) -> list[str]:
    counted, summed = drawn.draw_histograms(found)
    unit = found.unit or "levels"
    rows = [[meaning, number(found.distance(name)), unit if has_unit else "1"] for name, meaning, has_unit in DISTANCES]
    return [
        beside(
            picture(counted, "histograms of both sides", "All pixels of all frames."),
            picture(summed, "cumulative histograms of both sides", "W1 is the area between both lines."),
        ),
        table(["distance", "value", "unit"], rows, "Distances of the histograms, mean over frames"),
    ]


def _spectra(found: Evaluation) -> list[str]:
    radial = [
        picture(each, "power spectra of both sides by wavenumber", "Radially averaged, four rings per octave.")
        for each in drawn.draw_spectra(found)
    ]
    directions = drawn.draw_directions(found)
    if directions is not None:
        radial.append(
            picture(
                directions,
                "relative power of both sides by direction of the waves",
                "Power by direction in which waves advance, over that of all directions at the same wavenumber; 0 "
                "is east, 90 north. Things are long across the direction of most power.",
            )
        )
    if not radial:
        return [paragraph("Neither side has a spectrum; the notes below say why.")]
    difference = found.spectral_distance_db
    told = (
        f"The spectra differ by {number(difference)} dB rms over the rings that both have; 10 dB is a factor of ten in "
        "power."
    )
    return [*([] if math.isnan(difference) else [paragraph(told)]), beside(*radial)]


def _over_time(found: Evaluation) -> list[str]:
    content: list[str] = [
        paragraph(
            f"Compared was {found.pairing}. Correlation is at fixed pixels: what wind or platform moves through the "
            "field of view takes it away as change does."
        )
    ]
    correlation = drawn.draw_correlation(found)
    pictures = []
    if correlation is not None:
        pictures.append(picture(correlation, "correlation of frames against the time between them"))
    pictures += [picture(each, f"{name} of every frame") for name, each in drawn.draw_frames(found)]
    return [*content, beside(*pictures)]


def _all_metrics(found: Evaluation) -> list[str]:
    groups = dict.fromkeys(each.group for each in found.metrics)
    several = any(each.real_spread > 0.0 or each.sim_spread > 0.0 for each in found.metrics)
    content: list[str] = []
    if several:
        content.append(paragraph("Means and standard deviations over frames."))
    if any(not each.comparable for each in found.metrics):
        content.append(paragraph(_MARKED))
    for group in groups:
        rows = [
            [
                f"{name_of(each)} ({each.unit})" if each.unit not in ("", "1") else name_of(each),
                _value(each, each.real, each.real_spread),
                _value(each, each.sim, each.sim_spread),
                signed(each.difference),
                percent(each.relative),
            ]
            for each in found.metrics
            if each.group == group
        ]
        content.append(table(["", "real", "simulated", "difference", "relative"], rows, group))
    return [*content, folded("What each measure is", facts((each.name, each.meaning) for each in found.metrics))]


def _value(metric: Metric, value: float, spread: float) -> str:
    """Return a value and its spread, marked where nothing of its kind can have it."""
    mark = " (out of range)" if metric.is_out_of_range(value) else ""
    return with_spread(value, spread).replace("+-", "\u00b1") + mark


def _definitions() -> list[str]:
    return [
        table(
            ["", "as printed", "corrected"],
            [[each.name, each.as_printed, each.corrected] for each in DEFINITIONS],
            text_columns=3,
        ),
        paragraph(
            "Factors that both images share cancel in eq 24, so that Den and DP have the same errors in both "
            "definitions; only the denominators of the errors differ."
        ),
    ]


def _compared(found: Evaluation) -> list[str]:
    content: list[str] = []
    for title, side in _sides(found):
        content.append(element("h3", title))
        content.append(facts(_facts(side)))
        if side.notes:
            content.append(bullets(side.notes))
    return content


def _facts(side: Side) -> list[tuple[str, str]]:
    rows, columns = side.shape
    part = "all" if side.part == side.shape else f"the central {side.part[0]} x {side.part[1]}"
    pairs = [
        ("file", side.name),
        ("values", f"{side.quantity}{f' ({side.units})' if side.units else ''}"),
        ("band", side.band),
        ("pixels", f"{rows} rows x {columns} columns; compared: {part}"),
        ("pixel size", "not known" if side.pixel_size_m is None else f"{side.pixel_size_m:.6g} m"),
        ("frames", f"{len(side.frames)}, {side.frames[0].label} to {side.frames[-1].label}"),
        ("cloud is", cloud_in_words(side)),
    ]
    if len(side.frames) == 1:
        pairs[5] = ("frame", side.frames[0].label)
    return [(name, value) for name, value in pairs if value]
