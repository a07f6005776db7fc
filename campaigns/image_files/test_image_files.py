"""A sample of the campaign: good images are read as independent readers do, and faults of bad ones are named."""

import pytest
from bad_images import bad_cases
from good_images import good_cases
from image_verdicts import judge_bad, judge_good, verdict

EVERY = 10
"""One case in this many runs by default."""


def sample(cases):
    return [pytest.param(*case, id=case[0]) for case in cases[::EVERY]]


@pytest.mark.parametrize(("name", "build"), sample(good_cases()))
def test_a_good_image_is_read_as_independent_readers_do(name, build):
    known = "questioned" if name == "npy-12-bit-counts-like-kelvin" else "right"
    assert verdict(name, build, judge_good)[0] == known


@pytest.mark.parametrize(("name", "build"), sample(bad_cases()))
def test_what_is_wrong_with_a_bad_image_is_named(name, build):
    known = "accepted" if name == "fill-kelvin-nc-f4-9.96921e+36" else "named"  # the library's own fill value
    assert verdict(name, build, judge_bad)[0] == known
