"""The table of errors that a run prints: all figures, whatever the width of the terminal."""

import pytest

from hcss_twin.plan.error_budget import ErrorBudget
from hcss_twin.plan.error_contributions import Contribution
from hcss_twin.reports.run_text import error_table


def budget(classes, bands):
    """Errors of 0.1 K for the first class and band, 0.1 K more for each later one; particles are unknown."""
    return ErrorBudget({
        (of, band): (
            Contribution("gas", 0.01, 0.1 * (1 + row + column), 1.0, "rms"),
            *([Contribution("particles")] if row else []),
        )
        for row, of in enumerate(classes)
        for column, band in enumerate(bands)
    })  # fmt: skip


@pytest.mark.parametrize("width", [60, 80, 100, 200])
def test_lines_fit_and_nothing_is_lost(width):
    lines = list(error_table(budget(["clear", "stratus"], ["swir-2.7-3.0", "mwir", "lwir"]), width))
    assert max(map(len, lines)) <= width
    words = " ".join(" ".join(lines).split())
    for part in (
        "0.1 ",
        "0.2 ",
        "0.3 ",
        "> 0.2",
        "> 0.3",
        "> 0.4",
        "unknown: particles",
        "swir-2.7-3.0",
        "mwir",
        "lwir",
    ):
        assert part in words


def test_classes_are_named_without_the_paper_whose_clouds_they_have():
    lines = list(error_table(budget(["clear", "paper-stratus"], ["mwir"]), 100))
    assert [line.split()[0] for line in lines[1:]] == ["stratus", "clear"]


def test_what_has_no_row_or_column_counts_with_the_largest_of_the_rest():
    lines = list(error_table(budget(["clear", "a", "b"], ["one", "two", "three", "four", "five"]), 200))
    assert lines[0].split("  largest")[0].split("  ")[-1].strip() == "2 other bands, worst"
    of_class = {line.strip().split("  ")[0]: line for line in lines[1:]}
    assert of_class.keys() == {"b", "2 other classes, worst"}  # b has the largest error
    figures = [float(word) for word in of_class["2 other classes, worst"].split() if word.replace(".", "").isdigit()]
    assert figures[1:] == pytest.approx([0.2, 0.3, 0.4, 0.6])  # of class a; its bands four and five
