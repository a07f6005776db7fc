"""What a refusal allows and what an omission needs: a scenario that follows the advice is planned, with the effect."""

import copy

import pytest
from benchmark_module import benchmark_module
from distributions import need

from hcss_twin import Scenario, make_plan

pairs = benchmark_module("feature_pairs")

OFF = {
    "slant.shadows": "off",
    "slant.parallax": "off",
    "sea.waves": "off",
    "sea.temperature_texture": 0.0,
    "image.pixel_size": 100.0,
}
LEFT_OUT = [
    ("clouds of an image",),
    ("large-eddy clouds",),
    ("low sun",),
    ("two layers",),
    ("coast",),
    ("view to the glint", "points within a pixel"),
    ("night", "field of profiles"),
]
"""Scenes that leave something out."""

REFUSED = [
    ("clouds of an image", "shadows"),
    ("waves", "slanted rays"),
    ("coast", "scattered light"),
    ("source", "slanted rays"),
    ("slanted rays", "all variables"),
    ("inversion", "table of air"),
    ("field of profiles", "table of air"),
    ("three layers", "int16"),
    ("source", "int16"),
    ("digital numbers", "mask alone"),
    ("clouds of an image", "camera"),
    ("window", "camera"),
    ("altitude", "camera, push-broom"),
]


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    folder = tmp_path_factory.mktemp("inputs")
    pairs.write_inputs(folder)
    return pairs.features(folder)


def chosen(known, names):
    """The features of some names; skips the test if the package of one is not installed."""
    for name in names:
        if package := known[name].package:
            need(package)
    return [known[name] for name in names]


@pytest.mark.parametrize("names", LEFT_OUT, ids=" + ".join)
def test_keys_that_an_omission_needs_compute_it(known, names):
    assert pairs.wrong_advice(pairs.scene(chosen(known, names))) == []


def test_keys_that_switched_off_effects_need_compute_them():
    raw = pairs.scene([], OFF)
    plan = make_plan(Scenario.from_dict(copy.deepcopy(raw)))
    assert sum(omission.decision == "switched off" for omission in plan.omissions) >= 3
    assert pairs.wrong_advice(raw) == []


@pytest.mark.parametrize("names", REFUSED, ids=" + ".join)
def test_what_a_refusal_allows_is_planned(known, names):
    assert pairs.wrong_advice(pairs.scene(chosen(known, names))) == []


def test_advice_that_changes_nothing_is_found(monkeypatch):
    """The control of the tests above: of an effect that is left out, and of a refusal."""
    monkeypatch.setattr(pairs, "advised", lambda raw, advice: raw)
    assert len(pairs.wrong_advice(pairs.scene([], OFF))) >= 3
    assert pairs.wrong_advice(pairs.scene([], {"output.packing": "int16", "output.quantization": 1e-3}))
