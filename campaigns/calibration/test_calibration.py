"""The committed calibration, its page, and what the summary of ranks finds."""

from pathlib import Path

import calibration
import numpy as np
import pytest

ROWS = calibration.read()


def test_ranks_under_known_octaves_are_uniform_and_intervals_hold():
    own = [row for row in ROWS if row["set"] == "prior"]
    assert [int(row["index"]) for row in own] == list(range(400))
    assert sum(1 for row in own if row["refused"]) <= 20
    for name in calibration.KINDS:
        found = calibration.summarise(own, name)
        assert min(found.chi_squared_p, found.kolmogorov_p) > 0.01
        assert 0.85 <= found.inside <= 0.95


@pytest.mark.parametrize("which", ["named", "own", "unnamed", "surrogate", "example"])
def test_intervals_of_every_cloud_type_hold_or_are_doubted(which):
    own = [row for row in ROWS if row["set"] == which]
    for name in calibration.KINDS:
        found = calibration.summarise(own, name)
        if found is not None:
            # One in ten is wrong, with three standard errors of this number of images.
            assert found.wrong_and_sure <= 0.10 + 3.0 * np.sqrt(0.09 / found.ranks.size)


def test_the_page_has_the_table_of_the_results():
    page = Path(__file__).parents[2] / "docs" / "development" / "uncertainty.md"
    assert calibration.table(ROWS) in page.read_text(encoding="utf-8")


def test_images_of_a_type_are_the_same_whether_the_fit_knows_it_or_not():
    truth, image, _ = calibration.draw_images("own", "cirrus", 100.0, 3)
    other_truth, other, _ = calibration.draw_images("unnamed", "cirrus", 100.0, 3)
    assert truth == other_truth
    assert (truth["H"], truth["gamma"], truth["Lx"], truth["Ly"]) == (0.8, 3.0, 50.0, 10.0)
    np.testing.assert_array_equal(image.level, other.level)


@pytest.mark.long
def test_committed_rows_are_computed_again():
    row = next(row for row in ROWS if row["set"] == "own" and row["variogram_inside"])
    again = row | calibration.calibrate_one("own", row["type"], float(row["pixel_m"]), int(row["index"]))
    # Rounding decides about the course of a chain: on another processor its numbers agree within their own noise.
    drawn = {name for name in row if name.endswith(("_rank", "_width", "p_value", "unlikeness")) and row[name]}
    assert {name: again[name] for name in row if name not in drawn} == {
        name: value for name, value in row.items() if name not in drawn
    }
    for name in drawn:
        one, other = float(row[name]), float(again[name])
        if name.endswith("_rank"):
            assert abs(one - other) < 25, name
        elif name.endswith("_width"):
            assert 0.6 < one / other < 1.6, name


def test_ranks_of_true_values_among_draws_of_the_same_distribution_are_uniform():
    """The summary itself: right posteriors pass, posteriors that are too narrow or shifted do not."""
    rng = np.random.default_rng(0)

    def summary(width, shift=0.0):
        rows = []
        for _ in range(200):
            centre = rng.standard_normal()
            truth = centre + rng.standard_normal()
            drawn = centre + shift + width * rng.standard_normal(calibration.DRAWS)
            low, high = np.quantile(drawn, [0.05, 0.95])
            rank, inside = int(np.sum(drawn < truth)), int(low <= truth <= high)
            rows.append({"H_rank": str(rank), "H_inside": str(inside), "H_doubted": "0"})
        return calibration.summarise(rows, "H")

    right = summary(1.0)
    assert right.chi_squared_p > 0.01
    assert 0.85 <= right.inside <= 0.95
    narrow = summary(0.6)
    assert narrow.chi_squared_p < 0.01
    assert narrow.wrong_and_sure > 0.10 + 3.0 * np.sqrt(0.09 / 200)
    assert summary(1.0, 0.5).kolmogorov_p < 0.01
