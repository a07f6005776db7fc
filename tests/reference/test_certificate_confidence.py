"""The share of pixels that can exceed although no checked one does, against closed forms and a search."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import binom

from hcss_twin.engine.certificate.certificate import share_drawn_alike, share_of_all


@pytest.mark.parametrize("count", [1, 24, 300, 3000])
def test_the_share_drawn_alike_is_that_of_which_no_event_has_a_chance_of_5_percent(count):
    assert binom.pmf(0, count, share_drawn_alike(count)) == pytest.approx(0.05, rel=1e-9)


def test_300_pixels_exclude_1_percent_and_none_excludes_nothing():
    assert 0.0099 < share_drawn_alike(300) < 0.01
    assert share_drawn_alike(298) > 0.01
    assert share_drawn_alike(0) == 1.0


@pytest.mark.parametrize("checked", [[30], [10, 20], [3, 9, 27]])
def test_strata_drawn_by_their_size_are_as_good_as_one_draw_of_all(checked):
    checked = np.array(checked)
    assert share_of_all(1000 * checked, checked) == pytest.approx(share_drawn_alike(checked.sum()), rel=1e-12)


@pytest.mark.parametrize(
    ("pixels", "checked"), [([900, 100], [5, 19]), ([100_000, 500, 20_000], [8, 4, 12]), ([500, 500], [1, 40])]
)
def test_no_shares_of_exceedances_that_stay_hidden_as_often_add_up_to_more(pixels, checked):
    """A search over all of them, by sequential quadratic programming from several starts."""
    pixels, checked = np.array(pixels), np.array(checked)
    weight = pixels / pixels.sum()
    hidden = {"type": "ineq", "fun": lambda p: checked @ np.log1p(-p) - np.log(0.05)}
    found = [
        -minimize(
            lambda p: -weight @ p,
            np.full(pixels.size, start),
            bounds=[(0.0, 1.0 - 1e-12)] * pixels.size,
            constraints=[hidden],
            method="SLSQP",
            options={"ftol": 1e-12, "maxiter": 500},
        ).fun
        for start in (0.001, 0.01, 0.03)
    ]
    assert share_of_all(pixels, checked) == pytest.approx(max(found), rel=1e-5)


def test_a_stratum_that_was_not_seen_may_exceed_everywhere_and_one_seen_whole_nowhere():
    assert share_of_all(np.array([70, 30]), np.array([70, 0])) == pytest.approx(0.3)
    assert share_of_all(np.array([70, 30]), np.array([70, 30])) == 0.0
    assert share_of_all(np.array([10**6, 5]), np.array([20, 5])) == pytest.approx(share_drawn_alike(20), rel=1e-5)
    assert share_of_all(np.array([0, 0]), np.array([0, 0])) == 0.0


def test_exceedances_above_the_share_are_found_at_least_19_times_of_20():
    random, pixels, checked = np.random.default_rng(1), np.array([600, 300, 100]), np.array([8, 8, 8])
    share = share_of_all(pixels, checked)
    for spread in ([1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.6, 0.3, 0.1]):
        bad = np.minimum(np.ceil(share * 1000 * np.array(spread)).astype(int) + 1, pixels)
        if bad.sum() < share * 1000:
            continue
        drawn = np.stack(
            [random.hypergeometric(b, n - b, k, 4000) for b, n, k in zip(bad, pixels, checked, strict=True)]
        )
        assert np.mean(drawn.sum(axis=0) == 0) < 0.05 + 0.015
