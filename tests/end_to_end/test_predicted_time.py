"""Predicted time and memory of a run: what they grow with, what corrects them, and that no cube knows of them."""

import json

import pytest
from cheap import CHEAP
from click.testing import CliRunner

from hcss_twin import Scenario, make_plan, open_cube
from hcss_twin.cli.main import cli
from hcss_twin.cli.options import Stop
from hcss_twin.engine.predicted_time import FILE, expected_planning, learn, learn_planning, predict
from hcss_twin.engine.simulate import run

SMALL = {**CHEAP, "image.rows": 8, "image.columns": 8, "frames.count": 1}


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    folder.mkdir(mode=0o700)
    monkeypatch.setenv("HCSS_CACHE_DIR", str(folder))
    return folder


def planned(**changes):
    return make_plan(Scenario.load("stratus", {**SMALL, **{key.replace("__", "."): v for key, v in changes.items()}}))


@pytest.mark.parametrize("larger", [{"frames__count": 8}, {"image__rows": 2000, "image__columns": 2000}])
def test_more_frames_and_pixels_take_more_time_and_no_less_memory(larger):
    small, large = (predict(planned(**changes)) for changes in ({}, larger))
    assert large.seconds["frames"] > small.seconds["frames"]
    assert large.memory_bytes >= small.memory_bytes


def test_a_scene_whose_tables_are_in_the_cache_takes_less_time(tmp_path):
    plan = planned()
    before = predict(plan)
    run(plan, tmp_path / "c.nc")
    after = predict(plan)
    assert (before.is_kept, after.is_kept) == (False, True)
    assert after.total_s < before.total_s
    assert after.total_s == pytest.approx(before.again_s)


def test_a_slower_machine_is_learnt_from_its_runs():
    plan = planned()
    before = predict(plan)
    for was_kept in (False, True):
        for _ in range(3):
            learn(plan, was_kept, {stage: 3.0 * taken for stage, taken in before.seconds.items()})
    after = predict(plan)
    assert after.seconds == pytest.approx({stage: 3.0 * taken for stage, taken in before.seconds.items()})
    assert after.runs == 3


def test_planning_is_not_learnt_from_a_run_that_analysed_the_scene():
    plan = planned()
    before = predict(plan)
    learn(plan, False, {stage: 3.0 * taken for stage, taken in before.seconds.items()})
    assert predict(plan).seconds["planning"] == before.seconds["planning"]


def test_the_next_planning_is_expected_to_take_what_that_of_other_new_scenes_did():
    plan = planned()
    assert expected_planning() == {}
    for taken in (6.0, 9.0, 7.0):
        learn(plan, False, {"planning": taken})
    learn_planning(plan, {"planning": 0.1})  # it was in the cache
    assert expected_planning() == {"planning": 7.0}
    learn(plan, True, {"planning": 30.0})
    assert expected_planning() == {"planning": 7.0}


def test_start_and_planning_count_only_in_a_process_of_their_own(cache):
    options = [word for key, value in SMALL.items() for word in ("--set", f"{key}={value}")]
    for own in (False, True):
        done = CliRunner().invoke(cli, ["plan", "stratus", *options], obj=Stop(is_process=own))
        assert done.exit_code == 0, done.output
        assert (cache / FILE).exists() == own
    assert expected_planning()["planning"] > 0.0


def test_the_speed_of_the_machine_counts_for_stages_of_few_runs():
    plan = planned()
    before = predict(plan)
    for runs in range(1, 10):
        learn(plan, False, {"tables": 3.0 * before.seconds["tables"]})
        learn(plan, True, {"planning": 2.0 * before.seconds["planning"]})
        after = predict(plan)
        expected = 2.0 * 1.5 ** (runs / (runs + 4))  # the machine's, and more of its own the more runs there are
        assert after.seconds["tables"] / before.seconds["tables"] == pytest.approx(expected)
        assert after.seconds["frames"] == pytest.approx(2.0 * before.seconds["frames"])


def test_one_odd_run_changes_little():
    plan = planned()
    before = predict(plan)
    for factor in (1.0, 1.0, 1.0, 50.0):
        learn(plan, False, {stage: factor * taken for stage, taken in before.seconds.items()})
    assert predict(plan).total_s == pytest.approx(before.total_s)


@pytest.mark.parametrize("text", ["", "[]", "{", '{"tables": ["x"]}', '{"tables": [1e9, -1]}', '{"tables": 3}'])
def test_a_file_of_times_that_cannot_be_read_changes_nothing(cache, text):
    plan = planned()
    before = predict(plan)
    (cache / FILE).write_text(text)
    assert predict(plan).seconds == before.seconds


def test_without_a_cache_nothing_is_kept(cache, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_MB", "0")
    plan = planned()
    learn(plan, False, {"tables": 100.0})
    assert not (cache / FILE).exists()


def test_a_run_is_learnt_from_and_its_cube_does_not_know(cache, tmp_path):
    options = [word for key, value in SMALL.items() for word in ("--set", f"{key}={value}")]
    cubes = []
    for name in ("a.nc", "b.nc", "c.nc"):
        done = CliRunner().invoke(cli, ["run", "stratus", "-o", str(tmp_path / name), "--json", *options])
        assert done.exit_code == 0, done.output
        assert set(json.loads(done.stdout)["processor_s"]) == {"planning", "tables", "frames", "certificate"}
        with open_cube(tmp_path / name) as cube:
            cubes.append(
                {key: text for key, text in cube.attrs.items() if key not in ("id", "date_created", "history")}
            )
    assert (cache / FILE).exists()
    assert cubes[1] == cubes[2]
    assert not any(FILE in str(text) for text in cubes[2].values())
