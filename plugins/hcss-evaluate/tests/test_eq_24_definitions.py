"""Both definitions of eqs 21 to 24 on the printed entries of the HCSS paper's Tables VIII and IX."""

import json
import math
from pathlib import Path

import pytest
from hcss_evaluate.comparison.definitions import DEFINITIONS, eq_24, four_measures
from hcss_evaluate.measures.morphology import Morphology

TABLES = Path(__file__).parents[2] / "hcss-paper" / "src" / "hcss_paper" / "data" / "tables.json"
PAPER = json.loads(TABLES.read_text(encoding="utf-8"))
NAMES = ("entropy", "density", "diagonal_peak", "fractal_dimension")

# Half a unit of the last printed digit in every value moves the RMSE by up to this, percent.
ROUNDING_PCT = 0.03


def printed(entropy, density, diagonal_peak, fractal_dimension):
    rest = (math.nan,) * 5
    return Morphology(entropy, density / 10.0, diagonal_peak, fractal_dimension, *rest)


PAIRS = [(PAPER["table_8"]["real"], PAPER["table_8"]["sim"], PAPER["table_8"]["rmse_pct"])] + [
    (PAPER["table_9"]["rows"]["real"][1:], row[1:5], row[5])
    for name, row in PAPER["table_9"]["rows"].items()
    if name != "real"
]


@pytest.mark.parametrize(("real", "sim", "rmse_pct"), PAIRS)
def test_as_printed_gives_the_printed_rmse_and_corrected_another(real, sim, rmse_pct):
    as_printed = eq_24(printed(*real), printed(*sim), "as-printed")
    corrected = eq_24(printed(*real), printed(*sim), "corrected")
    assert 100 * as_printed.rmse == pytest.approx(rmse_pct, abs=ROUNDING_PCT)
    by_hand = [abs(a - b) / a for a, b in zip(real, sim, strict=True)]
    assert corrected.rmse == pytest.approx(math.sqrt(sum(e**2 for e in by_hand) / 4), rel=1e-12)
    assert abs(100 * corrected.rmse - rmse_pct) > ROUNDING_PCT


def test_factors_that_both_images_share_change_no_error():
    real, sim = (printed(*pair) for pair in PAIRS[0][:2])
    for mode in ("as-printed", "corrected"):
        one, other = four_measures(real, mode), four_measures(sim, mode)
        errors = eq_24(real, sim, mode)
        for name in NAMES:
            a, b = getattr(one, name), getattr(other, name)
            below = b if mode == "as-printed" else a
            assert getattr(errors, name) == pytest.approx(abs(a - b) / below, rel=1e-12)


def test_the_printed_den_is_ten_times_eq_22_and_dp_has_another_divisor():
    measured = printed(*PAIRS[0][0])
    as_printed, corrected = four_measures(measured, "as-printed"), four_measures(measured, "corrected")
    assert as_printed.density == pytest.approx(PAPER["table_8"]["real"][1]) == 10 * corrected.density
    assert as_printed.diagonal_peak / corrected.diagonal_peak == pytest.approx(256 / 255)
    assert as_printed.entropy == corrected.entropy
    assert as_printed.fractal_dimension == corrected.fractal_dimension
    assert [definition.name for definition in DEFINITIONS] == ["EV", "Den", "DP", "FD", "RMSE"]


def test_either_definition_of_an_image_against_itself_is_zero():
    image = printed(*PAIRS[0][0])
    assert eq_24(image, image, "as-printed").rmse == eq_24(image, image, "corrected").rmse == 0.0
