"""No pixel of forty scenes changes by more than its bound if an omission is switched on."""

import json
import math
from dataclasses import replace
from pathlib import Path

import omission_scenes as scenes
import pytest

RESULTS = json.loads((Path(__file__).parent / "results.json").read_text())
SMALL = {"image.rows": 24, "image.columns": 24, "bands": [[10.5, 11.0]], "sea.model": "cox-munk"}
PARALLAX = ("parallax of clouds",)


def rows(what):
    return [row for own in RESULTS.values() for row in own if row["what"] == what]


def test_the_committed_run_has_200_000_pixels_of_forty_scenes():
    assert len(RESULTS) == scenes.SCENES
    assert scenes.SCENES * scenes.PIXELS**2 >= 200_000
    assert {what for what in scenes.SWITCHES if len(rows(what)) >= 5} == set(scenes.SWITCHES)


@pytest.mark.parametrize("what", scenes.SWITCHES)
def test_no_bound_was_broken(what):
    assert [row for row in rows(what) if row["beyond"]] == []


def test_estimates_mean_what_they_say():
    for row in rows("waves as shapes"):
        # of a sea of few long waves, pixels are alike: the share of one image scatters
        assert row["within_estimate"] >= 0.97, row
    shares = [row["within_estimate"] for row in rows("waves as shapes")]
    assert sum(shares) / len(shares) >= 0.989
    # an image smaller than its clouds may change as a whole: the estimate is for many images
    ratios = [row["rms"] / row["estimate"] for row in rows("parallax of clouds")]
    assert math.sqrt(sum(each**2 for each in ratios) / len(ratios)) <= 1.0
    assert sum(each > 1.0 for each in ratios) <= 1


def test_scenes_are_the_same_each_time_and_unlike_each_other():
    assert scenes.scene(3) == scenes.scene(3) != scenes.scene(4)


def test_a_pixel_beyond_its_bound_is_seen(monkeypatch):
    planned = scenes.make_plan

    def promising_less(scenario):
        plan = planned(scenario)
        return replace(plan, omissions=tuple(replace(each, bound=each.bound and 1e-4) for each in plan.omissions))

    (kept,) = scenes.check(0, PARALLAX, **SMALL)
    assert kept.beyond == 0
    monkeypatch.setattr(scenes, "make_plan", promising_less)
    (broken,) = scenes.check(0, PARALLAX, **SMALL)
    assert broken.beyond > 0
