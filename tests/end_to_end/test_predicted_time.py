"""Predicted time and memory of a run: what they grow with, what corrects them, and that no cube knows of them."""

import json

import pytest
from cheap import CHEAP
from click.testing import CliRunner

from hcss_twin import Scenario, make_plan, open_cube
from hcss_twin.cli.main import cli
from hcss_twin.cli.options import Stop
from hcss_twin.core.stages import StageTimes, watched
from hcss_twin.engine.predicted_time import FILE, START_S, expected_planning, learn, learn_planning, predict
from hcss_twin.engine.simulate import run

MANY = '{"ratios": {"tables": [%s]}, "new_s": [], "scenes_s": {}}'
"""A file of times."""

SMALL = {**CHEAP, "image.rows": 8, "image.columns": 8, "frames.count": 1}


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    folder.mkdir(mode=0o700)
    monkeypatch.setenv("HCSS_CACHE_DIR", str(folder))
    return folder


def planned(**changes):
    return make_plan(Scenario.load("stratus", {**SMALL, **{key.replace("__", "."): v for key, v in changes.items()}}))


def times(seconds, start_s=0.0, once_s=0.0):
    """Times of a run, with the start of its process, and with what it computed for the cache while it planned."""
    found = StageTimes()
    found.seconds, found.start_s, found.once_s = dict(seconds), start_s, {"planning": once_s}
    return found


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
    assert after.total_s - after.kernels_s == pytest.approx(before.again_s)


def test_a_slower_machine_is_learnt_from_its_runs():
    plan = planned()
    before = predict(plan)
    for was_kept in (False, True):
        for _ in range(3):
            slow = {stage: 3.0 * taken for stage, taken in before.seconds.items()}
            learn(plan, was_kept, times(slow, 3.0 * START_S))
    after = predict(plan)
    assert after.seconds == pytest.approx({stage: 3.0 * taken for stage, taken in before.seconds.items()})
    assert after.runs == 6


def test_planning_again_takes_what_it_took_but_for_results_in_the_cache(monkeypatch):
    plan, took = planned(), times({"planning": 40.0}, 2.0, 31.0)
    assert predict(plan, times=took).seconds["planning"] == 9.0
    learn_planning(plan, took)
    assert expected_planning(plan.scenario) == {"planning": 9.0}
    monkeypatch.setenv("HCSS_CACHE_MB", "0")
    assert predict(plan, times=took).seconds["planning"] == 40.0


def test_a_new_scene_is_expected_to_take_the_median_of_new_ones_however_long_another_took():
    plan, other = planned(), planned(sea__wind_speed=5.5).scenario
    assert expected_planning(plan.scenario) == {}
    for taken in (6.0, 9.0, 360.0, 7.0):
        learn_planning(plan, times({"planning": taken}, 1.0, taken - 2.0))
    learn_planning(plan, times({"planning": 2.0}, 1.0))  # it was in the cache
    assert expected_planning(other) == {"planning": 7.0}
    assert expected_planning(plan.scenario) == {"planning": 2.0}


def test_only_work_in_the_stage_whose_result_stays_counts_as_done_once(cache):
    took = StageTimes()
    with watched(took):
        planned()
    assert 0.0 < took.once_s["planning"] < took.seconds["planning"] - took.start_s
    again = StageTimes()
    with watched(again):
        planned()
    assert again.once_s == {}


def test_start_and_planning_count_only_in_a_process_of_their_own(cache):
    options = [word for key, value in SMALL.items() for word in ("--set", f"{key}={value}")]
    for own in (False, True):
        done = CliRunner().invoke(cli, ["plan", "stratus", *options], obj=Stop(is_process=own))
        assert done.exit_code == 0, done.output
        assert (cache / FILE).exists() == own
    assert expected_planning(Scenario.load("stratus", SMALL))["planning"] > 0.0


def test_the_speed_of_the_machine_counts_for_stages_of_few_runs():
    plan = planned()
    before = predict(plan)
    for _ in range(2):
        learn_planning(plan, times({"planning": 5.0}, 2.0 * START_S))
    for runs in range(1, 10):
        learn(plan, False, times({"tables": 3.0 * before.seconds["tables"]}))
        after = predict(plan)
        expected = 2.0 * 1.5 ** (runs / (runs + 4))  # the machine's, and more of its own the more runs there are
        assert after.seconds["tables"] / before.seconds["tables"] == pytest.approx(expected)
        assert after.seconds["frames"] == pytest.approx(2.0 * before.seconds["frames"])


@pytest.mark.parametrize("runs", [0, 1, 3])
def test_one_odd_run_changes_little(runs):
    plan = planned()
    before = predict(plan)
    for factor in (*[1.0] * runs, 9.0):
        odd = {stage: factor * taken for stage, taken in before.seconds.items()}
        learn(plan, False, times(odd, factor * START_S))
    assert predict(plan).total_s == pytest.approx(before.total_s, rel=0.0 if runs else 0.6)
    learn(plan, False, times({stage: 50.0 * taken for stage, taken in before.seconds.items()}, 50.0))  # no machine's
    assert predict(plan).total_s == pytest.approx(before.total_s, rel=0.0 if runs else 0.6)


@pytest.mark.parametrize("text", ["", "[]", "{", '{"ratios": 3}', MANY % "1e9, -1", MANY % '"x"'])
def test_a_file_of_times_that_cannot_be_read_changes_nothing(cache, text):
    plan = planned()
    before = predict(plan)
    (cache / FILE).write_text(text)
    assert predict(plan).seconds == before.seconds


def test_without_a_cache_nothing_is_kept(cache, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_MB", "0")
    plan = planned()
    learn(plan, False, times({"tables": 100.0}))
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
