"""``hcss bench``: what it measures and tells, what it refuses, and what it leaves behind."""

import json
import re

import pytest
from cheap_scene import CHEAP
from click.testing import CliRunner
from hcss_bench.command import bench as command
from PIL import Image

from hcss_twin.core.errors import ScenarioError

SMALL = [
    *(word for key, value in CHEAP.items() for word in ("--set", f"{key}={value}")),
    *("--set", 'bands=["mwir-3.7", "lwir-10.8"]', "--set", "accuracy=2e-2"),  # for which the reference is planned
    *("--set", "image.rows=20", "--set", "image.columns=30", "--set", "frames.count=2"),
    *("--rounds", "1", "--pixels", "8", "--reference-level", "0", "--accuracy", "1e-2", "--accuracy", "1e-4"),
]


def bench(*arguments):
    return CliRunner().invoke(command, [*SMALL, *arguments])


def rows(text):
    """Cells of each line by its label; at least two blanks are between them."""
    cells = (re.split(r" {2,}", line.strip()) for line in text.splitlines())
    return {label: rest for label, *rest in cells}


@pytest.fixture(scope="module")
def answer(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    plot = folder / "front.png"
    done = bench("--folder", str(folder), "--json", str(folder / "found.json"), "--plot", str(plot))
    assert done.exit_code == 0, done.output
    (model,) = found = json.loads((folder / "found.json").read_text())
    assert model == "as-printed"
    return folder, done.output, found[model]


@pytest.mark.long
def test_errors_found_keep_the_accuracy_asked_for(answer):
    _, _, found = answer
    assert [accuracy["accuracy"] for accuracy in found["accuracies"]] == [1e-2, 1e-4]
    for accuracy in found["accuracies"]:
        assert 0.0 < accuracy["achieved"] <= accuracy["accuracy"]
        assert accuracy["exceeding"] == 0
        assert accuracy["checked"] == 8


def test_a_whole_run_takes_longer_than_its_parts_and_new_tables_longer_than_kept(answer):
    _, _, found = answer
    for accuracy in found["accuracies"]:
        seconds = accuracy["seconds"]
        assert all(value > 0 for value in seconds.values())
        assert seconds["whole run, new tables"] > seconds["whole run, kept tables"]


def test_errors_are_those_of_the_model_where_tables_and_wavenumbers_err_less(answer):
    _, _, found = answer
    error = {run["wavenumbers"]: run["error"] for run in found["brute_force"]}
    least, *_, most = sorted(error)
    assert error[most] > 0.05
    assert abs(error[least] - error[most]) > 1e-3
    coarse, fine = (max(accuracy["by_band"].values()) for accuracy in found["accuracies"])
    assert coarse == pytest.approx(error[most], abs=0.02)
    assert fine == pytest.approx(error[most], abs=2e-4)
    for run in found["brute_force"]:
        assert run["seconds"] == pytest.approx(run["seconds_per_point"] * found["points"])
    assert found["points"] == 2 * 20 * 30


def test_the_table_has_a_column_for_each_accuracy_and_names_every_stage(answer):
    _, printed, _ = answer
    lines = rows(printed)
    assert lines["requested accuracy"] == ["1e-02", "1e-04"]
    for stage in ("plan", "compile tables", "tables kept earlier", "clouds", "look-up", "write", "certificate"):
        assert len(lines[stage]) == 2


def test_a_picture_is_drawn_and_nothing_else_is_left(answer):
    folder, _, _ = answer
    with Image.open(folder / "front.png") as picture:
        assert picture.size[0] > 1000
    assert sorted(path.name for path in folder.iterdir()) == ["found.json", "front.png"]


@pytest.mark.long
def test_json_in_place_of_the_table_and_nothing_kept_by_the_user_is_used_or_changed(tmp_path, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path / "cache"))
    one = [*SMALL[:-2], "--pixels", "2", "--set", "bands=[[10.5, 10.6]]"]  # of the two accuracies
    done = CliRunner().invoke(command, [*one, "--folder", str(tmp_path), "--json", "-"])
    assert json.loads(done.stdout)["as-printed"]["rounds"] == 1
    assert list(tmp_path.iterdir()) == []


def test_existing_files_are_refused_before_anything_is_measured(tmp_path):
    for option, name in (("--json", "a.json"), ("--plot", "a.png")):
        (tmp_path / name).write_text("mine")
        done = bench(option, str(tmp_path / name))
        assert done.exit_code == 1
        assert "--force" in done.output
        assert (tmp_path / name).read_text() == "mine"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--plot", "front.gif"], "closest is front.png"),
        (["--accuracy", "1"], "allowed: 1e-06 to 0.1"),
        (["--accuracy", "0.1 C"], "closest is 'K'"),
        (["--accuracy", "1 %"], "twice"),
        (["--accuracy", "1e-2"], "twice"),
        (["--plot", "nowhere/front.png"], "no folder"),
    ],
)
def test_wrong_options_are_named(tmp_path, monkeypatch, arguments, told):
    monkeypatch.chdir(tmp_path)
    done = bench(*arguments)
    assert done.exit_code != 0
    assert told in f"{done.output}{done.exception}"


def test_every_accuracy_of_the_default_list_is_told_beside_the_scenarios_own(monkeypatch):
    from hcss_bench.benchmark import ACCURACIES, asked_for

    from hcss_twin import Scenario

    def of(accuracy):
        return asked_for(Scenario.load("stratus", {"accuracy": accuracy}), None)

    assert of(1e-3) == ACCURACIES
    assert of("2 %") == (1e-1, 2e-2, 1e-2, 1e-3, 1e-4, 1e-5)
    assert of("100 mK") == (*ACCURACIES, "0.1 K")
    assert asked_for(Scenario.load("stratus"), ["1 %", "50 mK"]) == (1e-2, "0.05 K")


@pytest.mark.long
def test_kelvin_are_kept_the_scenarios_own_is_marked_and_progress_goes_to_stderr(tmp_path):
    scene = ("--set", 'accuracy="0.5 K"', "--set", 'bands=[{name="lwir", limits=[10.5, 11.0]}]')
    asked = ("--pixels", "2", "--accuracy", "1e-3", "--accuracy", "500 mK")
    files = ("--folder", str(tmp_path), "--json", str(tmp_path / "found.json"))
    done = CliRunner().invoke(command, [*SMALL[:-4], *scene, *asked, *files])
    assert done.exit_code == 0, done.output
    share, kelvin = json.loads((tmp_path / "found.json").read_text())["as-printed"]["accuracies"]
    assert (share["asked"], share["own"], share["achieved_K"]) == ("0.001", False, None)
    assert (kelvin["asked"], kelvin["own"]) == ("0.5 K", True)
    assert 0.0 < kelvin["achieved_K"] <= 0.5
    # Wien's law: c2 / (lambda T^2) per kelvin, between 14 um at 310 K and 8 um at 280 K.
    assert 0.5 * 14388 / (14 * 310**2) < kelvin["accuracy"] < 0.5 * 14388 / (8 * 280**2)
    lines = rows(done.stdout)
    assert lines["requested accuracy"] == ["1e-03", "0.5 K*"]
    assert "* the scenario's own accuracy" in done.stdout.splitlines()
    first, *told = done.stderr.splitlines()
    assert "2 frames of 20 x 30 pixels, 1 bands" in first
    assert "accuracies 0.001, 0.5 K; 1 round; errors of 2 pixels" in first
    steps = [re.search(r"step (\d+) of (\d+): ", line).groups() for line in told]
    assert steps == [(str(number), str(len(told))) for number in range(1, len(told) + 1)]
    assert any("round 1 of 1, accuracy 0.5 K" in line for line in told)
    assert not any("round" in line and "accuracy 0.5 K:" in line for line in done.stdout.splitlines())


def test_an_accuracy_that_the_scene_cannot_have_is_refused_before_anything_is_measured(tmp_path, monkeypatch):
    monkeypatch.setattr("hcss_twin.plan.accuracy.MIN_ACCURACY", 1e-4)
    done = bench("--folder", str(tmp_path), "--accuracy", "1 mK")
    assert "'0.001 K'" in str(done.exception)
    assert isinstance(done.exception, ScenarioError)
    assert "round 1" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_scene_without_radiance_is_refused_by_field(tmp_path):
    done = bench("--folder", str(tmp_path), "--set", 'output.variables=["cloud_mask"]')
    assert isinstance(done.exception, ScenarioError)
    assert "output.variables" in str(done.exception)
    assert list(tmp_path.iterdir()) == []


def test_texture_of_clear_sky_is_refused():
    done = bench("--set", "sea.temperature_texture=0.5")
    (problem,) = done.exception.problems
    assert problem.field == "sea.temperature_texture"
    assert problem.message.startswith("0.5 given, but reference columns have no texture")
