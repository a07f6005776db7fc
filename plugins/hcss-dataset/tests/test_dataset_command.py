"""``hcss dataset``: answers, draws as scenarios, what it refuses; the example."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from hcss_dataset.command import dataset_command
from hcss_dataset.distribution import Distribution
from hcss_dataset.rendering import Studio
from sets import keys

from hcss_twin import Scenario, ScenarioError
from hcss_twin.cli.main import cli

EXAMPLE = Path(__file__).parents[1] / "examples" / "small-targets.toml"


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    small = keys({"image.rows": 20, "image.columns": 20, "sensor": None}, targets={}, shards={"frames": 4})
    Path("mine.json").write_text(json.dumps(small))


def run(*arguments):
    return CliRunner().invoke(dataset_command, ["mine.json", *arguments])


def test_it_tells_what_it_made_and_what_is_missing():
    first = run("--frames", "8", "--shard", "1")
    assert first.exit_code == 0, first.output
    assert "mine  4 frames, " in first.output
    assert "1 shards are missing" in first.output
    answer = json.loads(run("--frames", "8", "--json").output)
    assert (answer["frames"], answer["missing"], answer["refused"]) == (4, 0, 0)
    assert json.loads(run("--frames", "8", "--json").output)["frames"] == 0


def test_validate_checks_the_file_and_its_first_draw():
    valid = CliRunner().invoke(cli, ["validate", "mine.json"])
    assert valid.output.startswith("valid: data set, "), valid.output
    assert ", 2 frames a draw" in valid.output
    raw = json.loads(Path("mine.json").read_text())
    for section, content, field in (
        ("split", {"trian": 1.0}, "split.trian"),
        ("draw", {"sea.temperature": {"distribution": "uniform", "from": 800.0, "to": 900.0}}, "draw"),
    ):
        Path("wrong.json").write_text(json.dumps(raw | {section: content}))
        refused = CliRunner().invoke(cli, ["validate", "wrong.json"]).exception
        assert isinstance(refused, ScenarioError)
        assert refused.problems[0].field == field
    refused = CliRunner().invoke(cli, ["validate", "mine.json", "--set", "seed=3"]).exception
    assert "below [base]" in str(refused)


def test_a_draw_is_shown_as_a_scenario():
    shown = Scenario.from_dict(json.loads(run("--show", "17").output))
    distribution = Distribution.load("mine.json")
    assert shown.seed == distribution.sky_seed(17)
    assert shown == Studio(distribution).sequence(17).scenario


def test_what_cannot_be_made_is_refused_before_anything_is_written():
    cases = (["--frames", "7"], "closest valid choice is 8"), (["--frames", "8", "--shard", "2"], "allowed: 0 to 1")
    for arguments, words in cases:
        refused = run(*arguments)
        assert isinstance(refused.exception, ScenarioError)
        assert words in str(refused.exception)
    assert "allowed: one of the two" in run("--workers", "2", "--scheduler", "tcp://x:1").output
    assert not Path("mine").exists()


def test_the_example_is_a_distribution_whose_draws_are_scenarios():
    distribution = Distribution.load(EXAMPLE)
    assert distribution.states == 6
    for draw in range(3):
        values, state = distribution.values(draw, 0)
        assert state == draw
        scenario = Scenario.from_dict(distribution.scenario, {**distribution.overrides, **values})
        assert scenario.frames.count == 4
