"""Eqs 21 to 24 of the HCSS paper: by hand, by a plain counting, and against its Tables VIII and IX."""

import math

import numpy as np
import pytest
from hcss_evaluate.measures.histogram_metrics import histogram_metrics
from hcss_evaluate.measures.morphology import Morphology, morphology_errors
from printed_tables import PAPER


def counted(grey, levels):
    """EV, Den and DP as printed, from numpy's own histogram."""
    left, right = grey[:, :-1].ravel(), grey[:, 1:].ravel()
    counts, _, _ = np.histogram2d(left, right, bins=levels, range=[[-0.5, levels - 0.5]] * 2)
    share = counts[counts > 0] / left.size
    level = np.arange(levels)
    density = np.sum(counts / (1.0 + abs(level[:, None] - level))) / left.size
    return -np.sum(share * np.log2(share)), density, np.trace(counts) / (levels - 1)


@pytest.mark.parametrize("shape", [(1, 2), (1, 3), (5, 2), (40, 57), (57, 40)], ids=str)
@pytest.mark.parametrize("levels", [2, 7, 256])
def test_eqs_21_to_23_are_those_of_a_plain_count(shape, levels):
    grey = np.random.default_rng(sum(shape)).integers(0, levels, shape).astype(np.uint8)
    grey[:, : shape[1] // 2] //= 2
    found = histogram_metrics(grey, levels)
    expected = counted(grey, levels)
    np.testing.assert_allclose([found.entropy, found.density, found.diagonal_peak], expected, atol=1e-12)


def test_two_rows_by_hand():
    # Pairs along x: (0, 0), (0, 3) in the first row, (5, 5), (5, 4) in the second: four different ones.
    found = histogram_metrics(np.array([[0, 0, 3], [5, 5, 4]], dtype=np.uint8))
    assert found.entropy == pytest.approx(2.0)
    assert found.density == pytest.approx((1 + 1 / 4 + 1 + 1 / 2) / 4)
    assert found.diagonal_peak == pytest.approx(2 / 255)


def test_a_flat_image_by_hand():
    found = histogram_metrics(np.full((3, 5), 9, dtype=np.uint8), levels=11)
    assert (found.entropy, found.density, found.diagonal_peak) == (0.0, 1.0, 1.2)


def test_pairs_run_along_columns_only():
    stripes = np.tile(np.array([[0], [200]], dtype=np.uint8), (4, 6))
    assert histogram_metrics(stripes).density == 1.0
    assert histogram_metrics(stripes.T).density == pytest.approx(1 / 201)


def of_table(entropy, density, diagonal_peak, fractal_dimension):
    nan = math.nan
    return Morphology(entropy, density / 10.0, diagonal_peak, fractal_dimension, nan, nan, nan, nan, nan)


# Half a unit of the last printed digit in every printed value moves an error by up to .06 % (EV), and the RMSE
# by half of that.
ERROR_PCT, RMSE_PCT = 0.06, 0.03


def test_eq_24_gives_the_errors_and_the_rmse_of_table_viii():
    table = PAPER["table_8"]
    found = morphology_errors(of_table(*table["real"]), of_table(*table["sim"]))
    errors = [found.entropy, found.density, found.diagonal_peak, found.fractal_dimension]
    np.testing.assert_allclose([100 * error for error in errors], table["err_pct"], atol=ERROR_PCT)
    assert 100 * found.rmse == pytest.approx(table["rmse_pct"], abs=RMSE_PCT)


@pytest.mark.parametrize("image", ["Image1", "Image2", "Image3"])
def test_eq_24_gives_the_rmse_of_table_ix(image):
    rows = PAPER["table_9"]["rows"]
    found = morphology_errors(of_table(*rows["real"][1:]), of_table(*rows[image][1:5]))
    assert 100 * found.rmse == pytest.approx(rows[image][5], abs=RMSE_PCT)


def test_the_true_value_in_the_denominator_would_not_give_table_ix():
    rows = PAPER["table_9"]["rows"]
    for image in ("Image1", "Image2", "Image3"):
        turned = morphology_errors(of_table(*rows[image][1:5]), of_table(*rows["real"][1:]))
        assert abs(100 * turned.rmse - rows[image][5]) > 1.5 * RMSE_PCT
