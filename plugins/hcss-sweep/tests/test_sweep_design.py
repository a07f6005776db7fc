"""What a [sweep] section means, and that everything wrong with it and its points is told at once."""

import pytest
from hcss_sweep.design import Design
from hcss_sweep.points import digest_of, points_of, ranges, require_one_layout

from hcss_twin import Scenario, ScenarioError

RAW = {"time": "2024-04-20T12:30:00+10:00", "place": {"latitude": 35, "longitude": 150}, "clouds": {}}


def design(section, **more):
    return Design.load({**RAW, "sweep": section}, **more)


def points(section, **more):
    return points_of(design(section, **more))


def problems(call):
    with pytest.raises(ScenarioError) as caught:
        call()
    return {problem.field: problem.message for problem in caught.value.problems}


def test_a_product_has_every_combination_and_the_last_key_changes_fastest():
    made = points({"view.zenith": [0, 20], "seed": [7, 8, 9]})
    assert [(p.scenario.view.zenith, p.scenario.seed) for p in made] == [
        (0, 7), (0, 8), (0, 9), (20, 7), (20, 8), (20, 9)
    ]  # fmt: skip
    assert [p.number for p in made] == list(range(6))


def test_a_zip_goes_through_all_keys_together():
    made = points({"view.zenith": [0, 20], "seed": {"count": 2}, "combine": "zip"})
    assert [(p.scenario.view.zenith, p.scenario.seed) for p in made] == [(0, 0), (20, 1)]


def test_quoted_and_nested_keys_are_the_same(tmp_path):
    base = 'time = 2024-04-20T12:30:00+10:00\nplace = {latitude = 35.0, longitude = 150.0}\nclouds.type = "stratus"\n'
    texts = [
        '[sweep]\n"clouds.coverage" = [0.1, 0.9]\n"frames.count" = [1, 2]\n',
        "[sweep]\nclouds.coverage = [0.1, 0.9]\nframes.count = [1, 2]\n",
        "[sweep.clouds]\ncoverage = [0.1, 0.9]\n[sweep.frames]\ncount = [1, 2]\n",
        "[sweep]\nclouds.coverage = {from = 0.1, to = 0.9, steps = 2}\nframes = {count = {count = 2, first = 1}}\n",
    ]
    digests = set()
    for text in texts:
        (tmp_path / "sweep.toml").write_text(base + text)
        made = points_of(Design.load(tmp_path / "sweep.toml"))
        assert [list(point.values.values()) for point in made] == [[0.1, 1], [0.1, 2], [0.9, 1], [0.9, 2]]
        digests.add(digest_of(made))
    assert len(digests) == 1


def test_values_are_those_of_the_scenario_in_plain_units():
    (made,) = points({"image.pixel_size": ["1 km"], "time": ["2024-04-20T12:00:00Z"], "bands": [["mwir"]]})
    assert made.values == {"image.pixel_size": 1000.0, "time": "2024-04-20T12:00:00Z", "bands": ["mwir"]}


def test_keys_given_beside_the_file_replace_those_of_the_file():
    made = points({"view.zenith": [0, 20]}, over={"view.zenith": [30], "seed": [1]}, overrides={"frames.count": 3})
    assert [(p.scenario.view.zenith, p.scenario.seed, p.scenario.frames.count) for p in made] == [(30, 1, 3)]


def test_a_scenario_can_be_swept_as_it_is():
    scenario = Scenario.load("stratus", {"clouds.coverage": 0.25})
    made = points_of(Design.load(scenario, over={"seed": [1, 2]}))
    assert [p.scenario.clouds.layers[0].coverage for p in made] == [0.25, 0.25]
    assert made[0].scenario == scenario


def test_all_problems_of_the_section_are_told_at_once():
    found = problems(
        lambda: design(
            {"view.zenith": 3, "seed": {"cuont": 4}, "combine": "zipp", "clouds": [{}], "clouds.coverage": [1]}
            | {"vieew.zenith": [1]},
            overrides={"view": {}},
        )
    )
    assert set(found) == {
        "sweep.view.zenith", "sweep.seed", "sweep.combine", "sweep.clouds.coverage", "sweep.vieew.zenith"
    }  # fmt: skip
    assert "closest is 'zip'" in found["sweep.combine"]
    assert "closest is 'view'" in found["sweep.vieew.zenith"]


@pytest.mark.parametrize(
    ("section", "field", "words"),
    [
        ({}, "sweep", "no key is swept"),
        ([1], "sweep", "not a table"),
        ({"seed": [1, 2, 1]}, "sweep.seed", "1 is given twice; allowed: each value once, or sweep.combine = 'zip'"),
        ({"clouds.type": {"choice": ["stratus"]}}, "sweep.clouds.type", "lacks samples"),
        ({"seed": [1, 2], "view.zenith": [1], "combine": "zip"}, "sweep.combine", "seed has 2, view.zenith has 1"),
        ({"seed": {"count": 1000}, "view.zenith": {"from": 0, "to": 9, "steps": 1000}}, "sweep", "1000000 points"),
        ({"clouds.coverage": [0.1], "clouds.layers.0.coverage": [0.2]}, "sweep.clouds.layers.0.coverage", "overlaps"),
        ({"seed": [1], "dataset": "../all.nc"}, "sweep.dataset", "a name in"),
        ({"seed": [1], "dataset": "point-0000.nc"}, "sweep.dataset", "a name in"),
    ],
)  # fmt: skip
def test_a_wrong_section_is_told_with_what_is_allowed(section, field, words):
    assert words in problems(lambda: design(section))[field]


def test_problems_of_points_are_told_once_with_the_points_that_have_them():
    found = problems(lambda: points({"view.zenith": [0, 95], "clouds.coverage": [0.5, 1.5], "clouds.colour": ["red"]}))
    assert set(found) == {"view.zenith", "clouds.coverage", "clouds.colour"}
    assert "(points 2 to 3, view.zenith = 95" in found["view.zenith"]
    assert "(points 1, 3, clouds.coverage = 1.5" in found["clouds.coverage"]
    assert "unknown key" in found["clouds.colour"]
    assert "point" not in found["clouds.colour"]


def test_a_scenario_with_a_sweep_is_no_scene_and_says_what_to_do():
    found = problems(lambda: Scenario.from_dict({**RAW, "sweep": {"seed": [1]}}))
    assert "hcss sweep" in found["sweep"]


def test_the_hash_of_a_sweep_knows_its_points_and_keys():
    first = digest_of(points({"seed": [1, 2]}))
    assert first == digest_of(points({"seed": {"count": 2, "first": 1}}))
    assert first != digest_of(points({"seed": [2, 1]}))
    assert first != digest_of(points({"seed": [1, 2]}, overrides={"view.zenith": 10}))


@pytest.mark.parametrize(
    ("section", "field"),
    [
        ({"seed": [1, 2], "combine": "zip"}, "sweep.combine"),
        ({"image.rows": [10, 20]}, "sweep: image.rows"),
        ({"image": [{"pixel_size": 10}, {"pixel_size": 20}]}, "sweep: image.pixel_size"),
        ({"frames.interval": [1, 2]}, "sweep: frames"),
        ({"bands": [["mwir"], ["lwir"]]}, "sweep: bands"),
    ],
)
def test_points_of_different_layout_are_refused_for_a_dataset(section, field):
    made = design(section)
    assert field in problems(lambda: require_one_layout(made, points_of(made)))


def test_numbers_are_told_as_ranges_and_not_more_than_a_few():
    assert ranges([0, 3, 4, 5, 9]) == "0, 3 to 5, 9"
    assert ranges(range(0, 40, 2)) == "0, 2, 4, 6, 8 and 15 more"


def test_more_points_than_can_be_made_are_refused():
    text = problems(lambda: design({"seed": {"count": 100_000}, "sea.temperature": [280.0, 290.0]}))["sweep"]
    assert "200000 points" in text
    assert "100000" in text
