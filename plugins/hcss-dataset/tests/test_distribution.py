"""The file of a data set: draws by index, skies, splits, states, and what is refused."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hcss_dataset import rendering
from hcss_dataset.distribution import Distribution, draws_of, without_sky
from hcss_dataset.rendering import Studio
from hcss_dataset.targets import draw_targets
from sets import keys

from hcss_twin import ScenarioError, make_plan


def loaded(**sections):
    return Distribution.load(keys(**sections))


COVER = {"clouds": {"coverage": {"distribution": "uniform", "from": 0.2, "to": 0.8}}}


def test_a_draw_depends_on_its_number_alone():
    first, second = loaded(draw=COVER), loaded(draw=COVER)
    forth = [first.values(draw, 0) for draw in range(20)]
    back = [second.values(draw, 0) for draw in reversed(range(20))]
    assert forth == back[::-1]
    assert len({values["clouds.coverage"] for values, _ in forth}) == 20


def test_a_sky_is_in_one_split_and_splits_have_their_shares():
    distribution = loaded(reuse={"draws_per_sky": 4}, split={"by": "sky", "train": 0.7, "test": 0.3})
    splits = {draw: distribution.split_of(distribution.sky_of(draw)) for draw in range(8000)}
    assert all(len({splits[4 * sky + n] for n in range(4)}) == 1 for sky in range(2000))
    skies = [splits[4 * sky] for sky in range(2000)]
    assert abs(skies.count("test") / 2000 - 0.3) < 3.0 * math.sqrt(0.21 / 2000)
    assert skies.count("val") == 0


def test_draws_of_one_sky_have_its_seed_and_other_noise():
    distribution = loaded(reuse={"draws_per_sky": 2})
    assert distribution.sky_of(4) == distribution.sky_of(5) != distribution.sky_of(6)
    assert distribution.noise_seed(4) != distribution.noise_seed(5)
    assert len({distribution.sky_seed(sky) for sky in range(1000)}) == 1000


def test_states_share_what_tables_depend_on_and_skies_have_their_own_cover():
    draw = {"sea": {"temperature": {"distribution": "uniform", "from": 280.0, "to": 300.0}}, **COVER}
    distribution = loaded(draw=draw, reuse={"states": 3})
    values = [distribution.values(number, 0)[0] for number in range(30)]
    assert len({each["sea.temperature"] for each in values}) == 3
    assert values[0]["sea.temperature"] == values[27]["sea.temperature"]
    assert len({each["clouds.coverage"] for each in values}) == 30


def test_unphysical_draws_are_drawn_again_and_counted():
    draw = {"clouds": {"coverage": {"choice": [1.5, 0.5], "weights": [1, 1]}}}
    studio = Studio(Distribution.load(keys(draw=draw, targets={})))
    refused = [studio.sequence(number).refused for number in range(6)]
    assert any(refused)
    assert all("1.5" in reason and "coverage" in reason for each in refused for reason in each)
    assert all(studio.sequence(number).scenario.clouds.layers[0].coverage == 0.5 for number in range(6))


def test_a_distribution_without_physical_draws_ends_with_the_reason():
    studio = Studio(Distribution.load(keys(draw={"clouds": {"coverage": [1.5]}})))
    with pytest.raises(ScenarioError, match=r"50 draws in a row are refused.*1\.5"):
        studio.sequence(0)


def test_counts_of_targets_and_the_share_of_empty_frames():
    targets = keys()["targets"] | {"empty": 0.5, "strength": {"intensity": 10.0}}
    studio = Studio(Distribution.load(keys(targets=targets, base={"clouds": None, "frames.count": 1})))
    plan = studio.sequence(0).plan
    counts = [len(draw_targets(studio.distribution, number, 0, plan)) for number in range(1000)]
    assert counts.count(0) == 500
    mean = 2.0 / (1.0 - math.exp(-2.0))  # of a Poisson number above 0
    filled = [count for count in counts if count]
    assert abs(sum(filled) / len(filled) - mean) < 3.0 * 1.4 / math.sqrt(len(filled))


@pytest.mark.parametrize("share", [0.0, 0.13, 0.5, 1.0])
def test_the_share_of_empty_draws_is_as_asked_and_their_places_tell_nothing(share):
    targets = keys()["targets"] | {"empty": share, "strength": {"intensity": 10.0}}
    studio = Studio(Distribution.load(keys(targets=targets, base={"clouds": None, "frames.count": 1})))
    plan = studio.sequence(0).plan
    empty = [[not draw_targets(studio.distribution, draw, attempt, plan) for draw in range(400)] for attempt in (0, 3)]
    assert empty[0] == empty[1]  # a refused draw stays what it was
    assert all(abs(sum(empty[0][:count]) - share * count) <= 0.5 for count in range(20, 401, 20))
    if share == 0.5:
        pairs = sum(one == other for one, other in pairwise(empty[0]))
        # neighbours in a block of 20 with 10 of each are alike with 9 / 19
        assert abs(pairs / 399 - 9 / 19) < 3.0 * math.sqrt(0.25 / 399)


@pytest.mark.parametrize(
    ("sections", "words"),
    [
        ({"tragets": {}}, "closest is 'targets'"),
        ({"draw": {"sea": {"temprature": [1]}}, "split": {"by": "frame"}}, "split.by"),
        ({"draw": {"image": {"rows": [32, 64]}}}, "same size"),
        ({"draw": {"elements": [[]]}}, r"allowed: \[targets\]"),
        ({"base": {"seed": 4}}, "seeds follow"),
        ({"split": {"train": 0.5}}, "sum to 0.5"),
        ({"image": {"format": "jpegxk"}}, "image.format.*closest is 'jpegxl'"),
        ({"reuse": {"draws_per_sky": 0}}, "whole number from 1"),
        ({"targets": {"count": 1, "altitude": 0.0, "strength": {"scr": 3, "intensity": 4}}}, "scr and intensity"),
        ({"targets": {"count": 1, "strength": {"scr": 3}}}, "targets.altitude"),
        ({"targets": {"count": 1, "altitude": 0.0, "strength": {"temperature": 300.0}}}, "area"),
    ],
)
def test_mistakes_of_the_file_are_named(sections, words):
    base = sections.pop("base", None)
    with pytest.raises(ScenarioError, match=words):
        Distribution.load(keys(base=base, **sections))


def test_draws_of_a_state_share_its_plans_whichever_came_first(monkeypatch):
    draw = {"sea": {"temperature": {"distribution": "uniform", "from": 280.0, "to": 300.0}}, **COVER}
    given, planned = keys(draw=draw, reuse={"states": 2}, base={"frames.count": 1}), []

    def counted(*arguments, **options):
        planned.append(1)
        return make_plan(*arguments, **options)

    monkeypatch.setattr(rendering, "make_plan", counted)
    studio = Studio(Distribution.load(given))
    in_order = [next(studio.sequence(number).frames()) for number in range(8)]
    assert any(frame.labels["targets"] for frame in in_order)
    of_optics = 2  # whole and of a single target, the same for all
    assert len(planned) <= 2 * 2 + of_optics
    for number in (7, 4):
        alone = next(Studio(Distribution.load(given)).sequence(number).frames())
        assert np.array_equal(alone.image, in_order[number].image)
        assert np.array_equal(alone.clean, in_order[number].clean)
        assert alone.labels == in_order[number].labels


def test_what_draws_say_of_the_sky_is_apart_from_their_state():
    values = {
        "clouds.coverage": 0.3,
        "clouds": {
            "layers": [{"type": "stratus", "coverage": 0.2}, {"edge_taper": 0.4, "parameters": {"coverage": 9}}]
        },
        "clouds.layers.2.coverage": 0.7,
        "sea.temperature": 290.0,
    }
    plain, layers = without_sky(values)
    assert layers == {0: {"coverage": 0.2}, 1: {"edge_taper": 0.4}, 2: {"coverage": 0.7}}
    assert plain["clouds.coverage"] == plain["clouds.layers.2.coverage"] == 0.5
    first, second = plain["clouds"]["layers"]
    assert first == {"type": "stratus", "coverage": 0.5}
    assert second == {"edge_taper": 0.0, "parameters": {"coverage": 9}}
    assert plain["sea.temperature"] == 290.0


def test_a_sequence_is_not_cut():
    assert draws_of(12, 4) == 3
    with pytest.raises(ValueError, match="closest valid choice is 12"):
        draws_of(13, 4)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"base": {"clouds.top": 200e3}}, "clouds.top"),
        ({"targets": {"margin": 400.0}}, "margin = 400 leaves no pixel"),
        ({"targets": {"strength": {"temperature": 300.0, "area": 1e8}}}, "a side of"),
        ({"targets": {"strength": {"temperature": 300.0, "area": 1e9}}}, "area = 1000000000.0; allowed"),
        ({"draw": {"clouds": {"coverage": {"distribution": "beta", "a": 2.0, "c": 1.0}}}}, "scipy.stats.beta"),
    ],
)
def test_mistakes_that_no_draw_changes_are_refused_at_once(monkeypatch, wrong, words):
    given = keys(draw=wrong.get("draw", COVER), base=wrong.get("base", {}))
    given["targets"] |= {"count": 1, **wrong.get("targets", {})}
    studio, attempts = Studio(Distribution.load(given)), []
    attempted = Studio._attempt
    monkeypatch.setattr(Studio, "_attempt", lambda *given: attempts.append(1) or attempted(*given))
    with pytest.raises(ScenarioError) as refused:
        studio.sequence(0)
    assert words in str(refused.value)
    assert "in a row" not in str(refused.value)
    assert len(attempts) <= 2


def test_a_wrong_one_of_several_values_is_drawn_again():
    targets = keys()["targets"] | {"count": 1, "strength": {"temperature": 300.0, "area": [1e9, 10.0]}}
    studio = Studio(Distribution.load(keys(draw=COVER, targets=targets)))
    assert sum(len(studio.sequence(number).refused) for number in range(4)) > 0
