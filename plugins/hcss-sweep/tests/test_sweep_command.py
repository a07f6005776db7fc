"""``hcss sweep``: answers, exit codes and what it refuses."""

import json
import socket

import pytest
from cheap import CHEAP
from click.testing import CliRunner
from hcss_sweep import SweepError, points
from hcss_sweep.points import PointOutcome
from hcss_sweep.run import checked_points

from hcss_twin import ScenarioError, open_cube
from hcss_twin.cli.main import cli

SCENE = {**CHEAP, "image.rows": 4, "image.columns": 4, "frames.count": 1, "output.variables": ["cloud_mask"]}
FILE = """
time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
clouds.type = "stratus"
[sweep]
seed = {count = 2}
"""


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(FILE)


def hcss(*arguments):
    settings = [word for key, value in SCENE.items() for word in ("--set", f"{key}={json.dumps(value)}")]
    return CliRunner().invoke(cli, ["sweep", *arguments, *settings])


def test_it_tells_what_it_did_and_goes_on_where_it_was(tmp_path):
    first = hcss("mine.toml")
    assert first.exit_code == 0, first.output
    assert first.output.startswith("mine-sweep  2 points, ")
    assert "computed 2\n" in first.output
    (tmp_path / "mine-sweep" / "point-0001.nc").unlink()
    answer = json.loads(hcss("mine.toml", "--json").output)
    assert answer["computed"] == [1]
    assert answer["done"] == answer["points"] == 2
    assert answer["index"] == "mine-sweep/index.json"
    assert "computed 0, already computed 2" in hcss("mine.toml").output


def test_the_worst_certificate_is_told_and_is_that_of_the_cube(tmp_path, monkeypatch):
    monkeypatch.setitem(SCENE, "output.variables", ["radiance"])
    done = hcss("mine.toml")
    shares = []
    for number in (0, 1):
        with open_cube(tmp_path / "mine-sweep" / f"point-{number:04d}.nc") as cube:
            errors = json.loads(cube.attrs["hcss_accuracy_achieved"]).values()
            shares.append(max(errors) / cube.attrs["hcss_accuracy_requested"])
    worst = shares.index(max(shares))
    told = f"2 of 2 points; the largest error is {shares[worst]:.2g} of the accuracy (point {worst}, seed = {worst})"
    assert f"computed as specified: {told}" in done.output
    index = json.loads((tmp_path / "mine-sweep" / "index.json").read_text())
    assert [point["certified"] for point in index["points"]] == shares


def test_a_sweep_without_certificates_says_so():
    assert "no certificate: no pixel was checked" in hcss("mine.toml").output  # masks alone


def test_keys_are_swept_from_the_command_line(tmp_path):
    done = hcss("stratus", "--over", "clouds.coverage=[0.2, 0.4]", "--over", "seed={count = 2}", "-o", "out",
                "--dataset", "all.nc")  # fmt: skip
    assert done.exit_code == 0, done.output
    index = json.loads((tmp_path / "out" / "index.json").read_text())
    assert [point["values"] for point in index["points"]] == [
        {"clouds.coverage": coverage, "seed": seed} for coverage in (0.2, 0.4) for seed in (0, 1)
    ]
    assert done.output.splitlines()[-1].startswith("all.nc  ")


def test_a_failed_point_is_told_and_the_exit_code_is_1(monkeypatch):
    monkeypatch.setattr(
        points, "compute", lambda task, shelf: PointOutcome(task.point, error="out of luck" if task.point else None)
    )
    done = hcss("mine.toml")
    assert done.exit_code == 1
    assert "failed: point 1, seed = 1: out of luck" in done.output
    assert "error: 1 of 2 points failed" in done.output


def test_a_file_with_a_sweep_is_told_to_be_swept():
    for command in ("run", "plan"):
        refused = CliRunner().invoke(cli, [command, "mine.toml"])
        assert isinstance(refused.exception, ScenarioError)
        assert "hcss sweep FILE" in str(refused.exception)


def test_problems_come_before_anything_is_written(tmp_path):
    for arguments, words in (
        (["mine.toml", "--over", "clouds.coverage=[0.5, 1.5]"], "(points 1, 3, clouds.coverage = 1.5)"),
        (["stratoss"], "no shipped sweep or scenario of that name"),
        (["stratus"], "no key is swept"),
    ):
        refused = hcss(*arguments, "-o", "out")
        assert isinstance(refused.exception, ScenarioError)
        assert words in str(refused.exception)
    assert not (tmp_path / "out").exists()


def test_wrong_options_are_told():
    assert "allowed: key=value" in hcss("mine.toml", "--over", "seed").output
    assert "allowed: one of the two" in hcss("mine.toml", "--workers", "2", "--scheduler", "tcp://here:1").output


def test_a_scheduler_that_does_not_answer_is_told():
    pytest.importorskip("distributed")
    refused = hcss("mine.toml", "--scheduler", "nonsense://nowhere")
    assert isinstance(refused.exception, SweepError)
    assert "allowed: tcp://HOST:PORT" in str(refused.exception)
    with socket.socket() as nobody:
        nobody.bind(("127.0.0.1", 0))
        refused = hcss("mine.toml", "--scheduler", f"tcp://127.0.0.1:{nobody.getsockname()[1]}")
    assert isinstance(refused.exception, SweepError)
    assert "no Dask scheduler answers" in str(refused.exception)


def test_a_sweep_is_validated_without_being_computed(tmp_path):
    def validate(*arguments):
        return CliRunner().invoke(cli, ["validate", *arguments])

    assert validate("mine.toml").output.splitlines()[-1] == "valid: 2 points, plans of 1 of them"
    assert json.loads(validate("mine.toml", "--json").output) == {"valid": True, "points": 2, "planned": 1}
    shown = []
    checked_points("mine.toml", progress=lambda points, count: shown.append(count) or points)
    assert shown == [1]
    (tmp_path / "mine.toml").write_text(FILE + "view.zenith = [0, 95]\n")
    refused = validate("mine.toml")
    assert isinstance(refused.exception, ScenarioError)
    assert str(refused.exception).endswith("closest valid choice is 85 (points 1, 3, view.zenith = 95)")
    assert not [*tmp_path.glob("*.nc"), *tmp_path.glob("*-sweep")]
