"""HTML report that compares published and computed numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import compress

from hcss_paper.equations import TITLE
from hcss_paper.index import heading
from hcss_paper.reproduction import Check, Reproduction, Row
from hcss_paper.run import Outcome, relative, totals
from hcss_twin import __version__
from hcss_twin.reports.page import Markup, Page
from hcss_twin.reports.tables import Table

_TONES: dict[str, Markup.Tone] = {
    "reproduced": "good",
    "reproduced with fitted inputs": "fair",
    "not reproducible": "bad",
    "failed": "bad",
}

_ROWS_SHOWN = 40
"""Longer tables are folded."""


def reproduction_page(outcomes: Sequence[Outcome], seed: int) -> Page:
    """Return the report as a page.

    Parameters
    ----------
    outcomes : sequence of Outcome
    seed : int
        Of the random fields.
    """
    return Page(
        "Published and computed",
        f"{TITLE}, computed again by hcss_twin {__version__}, seed {seed}",
        [_summary(outcomes), *(_section(outcome) for outcome in outcomes)],
    )


def _summary(outcomes: Sequence[Outcome]) -> Page.Section:
    rows = [
        [
            Markup.element("a", heading(outcome.item.name), href=f"#{_anchor(outcome)}"),
            Markup.badge(outcome.verdict, _TONES[outcome.verdict]),
            worst_text(outcome).partition(" (")[0],
            f"{outcome.compared}, {len(outcome.free)}, {len(outcome.choices)}",
            outcome.item.title,
        ]
        for outcome in outcomes
    ]
    return Page.Section(
        "Summary",
        [
            Markup.bullets(totals(outcomes)),
            Table(
                ["item", "verdict", "largest difference", "numbers, inputs, choices", "content"], rows, text_columns=5
            ),
            Markup.folded(
                "How to read this",
                Markup.bullets(
                    [
                        "Published: as printed. Computed: with the paper's equations (as-printed), for this report.",
                        "Physical: with the corrected physics, where it differs. It is not fitted to any table.",
                        "Mixture: a clear and an opaque column, mixed with a fitted effective cover. No scene contains "
                        "it, and it decides no verdict; computed values beside it are means of cubes at the printed "
                        "coverage.",
                        "Reproduced: every check holds, without inputs or interpretations fitted to the paper's "
                        "numbers.",
                        "Reproduced with fitted inputs: every check holds with the listed inputs and "
                        "interpretations, which the paper does not state. They do not prove what the authors used.",
                        "Not reproducible: a check fails, or required data are not published; the reason is given.",
                        "Numbers: printed numbers compared with computed ones. Inputs: numbers fitted to printed ones; "
                        "one that serves several items counts once in a total. Choices: interpretations and values in "
                        "words that were chosen because they give printed numbers.",
                        "Largest difference: over all rows, relative to the printed number; for percentages, the "
                        "difference itself.",
                    ]
                ),
            ),
        ],
    )


def _anchor(outcome: Outcome) -> str:
    return Page.Section(heading(outcome.item.name), ()).anchor


def worst_text(outcome: Outcome) -> str:
    """Return the largest relative difference of an item and where it is."""
    row = outcome.worst
    if row is None:
        return "no published numbers"
    share = abs(relative(row) or 0.0)
    return f"{_percent(share)} ({row.label})" if share else "0 %"


def _percent(share: float) -> str:
    percent = 100 * share
    decimals = max(0, 1 - math.floor(math.log10(percent)))
    return f"{percent:.{min(decimals, 6)}f} %"


def _section(outcome: Outcome) -> Page.Section:
    title = heading(outcome.item.name)
    head = Markup.element("p", Markup.badge(outcome.verdict, _TONES[outcome.verdict]), Markup(" "), outcome.item.title)
    if outcome.result is None:
        return Page.Section(title, [head, Markup.note(outcome.error, "bad")])
    result = outcome.result
    content: list[Markup.Block] = [head, Markup.note(result.reason, _TONES[result.verdict])]
    content += _checks(result.checks)
    content += _rows(result)
    if outcome.worst is not None:
        content.append(Markup.paragraph(f"Largest difference: {worst_text(outcome)}."))
    if result.fitted_inputs:
        content += [
            Markup.element("h3", "Fitted or chosen inputs"),
            Markup.bullets(fitted.text for fitted in result.fitted_inputs),
        ]
    if result.notes:
        content += [Markup.element("h3", "Notes"), Markup.bullets(result.notes)]
    for drawing, png in zip(result.drawings, outcome.pictures, strict=True):
        content.append(Markup.picture(png, drawing.alternative, drawing.title))
    return Page.Section(title, content)


def _checks(checks: Sequence[Check]) -> list[Markup.Block]:
    if not checks:
        return []
    rows = [
        [Markup.badge("holds", "good") if check.holds else Markup.badge("fails", "bad"), check.statement]
        for check in checks
    ]
    return [Table(["check", "statement"], rows, text_columns=2)]


def _rows(result: Reproduction) -> list[Markup.Block]:
    if not result.rows:
        return []
    # A column without numbers is omitted.
    names = ["published", "computed", "difference", "mixture", "physical"]
    used = [any(getattr(row, name) is not None for row in result.rows) for name in names]
    header = ["", "unit", *compress(names, used)]
    rows = [[row.label, row.unit, *compress(_numbers(row, _decimals(row, result.rows)), used)] for row in result.rows]
    shown = Table(header, rows, text_columns=2)
    return [Markup.folded(f"All {len(rows)} rows", shown)] if len(rows) > _ROWS_SHOWN else [shown]


def _numbers(row: Row, decimals: int) -> list[str]:
    """Return the cells of a row: the printed number with its decimals, the others with one more."""
    same = row.difference is not None and abs(row.difference) < 1e-12
    finer = decimals if same else decimals + 1
    return [
        "" if row.published is None else f"{row.published:.{decimals}f}",
        "" if row.computed is None else f"{row.computed:.{finer}f}",
        "" if row.difference is None else "0" if same else f"{row.difference:+z.{finer}f}",
        "" if row.mixture is None else f"{row.mixture:.{finer}f}",
        "" if row.physical is None else f"{row.physical:.{finer}f}",
    ]


def _decimals(row: Row, rows: Sequence[Row]) -> int:
    """Return the number of decimals: the most among printed rows of the same unit and magnitude (0.45 is 0.450)."""
    size = _size(row)
    alike = [other for other in rows if other.unit == row.unit and abs(_size(other) - size) <= 2.0]
    printed = [_printed_decimals(other.published) for other in alike if other.published is not None]
    if row.difference is not None and abs(row.difference) < 1e-12 and row.published is not None:
        return _printed_decimals(row.published)
    return max(printed) if printed else max(0, 2 - math.floor(size))


def _size(row: Row) -> float:
    """Return the order of magnitude; 0 if the row has no numbers."""
    numbers = (row.published, row.computed, row.physical)
    value = next((abs(number) for number in numbers if number and math.isfinite(number)), 1.0)
    return math.log10(value)


def _printed_decimals(value: float) -> int:
    return len(f"{value:.6f}".rstrip("0").partition(".")[2])
