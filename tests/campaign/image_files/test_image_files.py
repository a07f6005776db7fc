"""A sample of the campaign: good images are read as independent readers do, and faults of bad ones are named."""

import csv
from collections import Counter
from pathlib import Path

import pytest
from bad_images import bad_cases
from good_images import good_cases
from image_verdicts import judge_bad, judge_good, verdict

HERE = Path(__file__).parent
EVERY = 10
"""One case in this many runs by default."""


def rows(name):
    with (HERE / f"{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def sample(cases):
    return [
        pytest.param(*each, id=each[0], marks=() if number % EVERY == 0 else pytest.mark.campaign)
        for number, each in enumerate(cases)
    ]


@pytest.mark.parametrize(("name", "build"), sample(good_cases()))
def test_a_good_image_is_read_as_independent_readers_do(name, build):
    known = "questioned" if name == "npy-12-bit-counts-like-kelvin" else "right"
    assert verdict(name, build, judge_good)[0] == known


@pytest.mark.parametrize(("name", "build"), sample(bad_cases()))
def test_what_is_wrong_with_a_bad_image_is_named(name, build):
    known = "accepted" if name == "fill-kelvin-nc-f4-9.96921e+36" else "named"  # the library's own fill value
    assert verdict(name, build, judge_bad)[0] == known


def test_the_committed_verdicts_meet_the_limits_and_the_first_ones_did_not():
    for name, passes in (("results", True), ("results_at_first", False)):
        count = Counter((row["kind"], row["verdict"].partition(" ")[0]) for row in rows(name))
        good, bad = (sum(number for (kind, _), number in count.items() if kind == each) for each in ("good", "bad"))
        assert (good, bad) == (len(good_cases()), len(bad_cases()))
        no_good_one_is_wrong = count["good", "right"] + count["good", "questioned"] == good
        few_are_questioned = count["good", "questioned"] <= 0.02 * good
        bad_ones_are_named = count["bad", "named"] >= 0.98 * bad
        assert (no_good_one_is_wrong and few_are_questioned and bad_ones_are_named) is passes
