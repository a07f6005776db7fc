"""``hcss bench cases``: what it lists and scores, and what it refuses; scenes keep their short form."""

import builtins
import json

import netCDF4
import numpy as np
import pytest
from click.testing import CliRunner
from hcss_bench.command import bench

from hcss_twin.core.errors import OptionError, ScenarioError

light = pytest.importorskip("hcss_light.cases", reason="hcss-light has the cases")
NAME = "step-night"


def cases(*arguments):
    return CliRunner().invoke(bench, ["cases", *map(str, arguments)])


def results(path, case, factor=1.0):
    with netCDF4.Dataset(path, "w") as file:
        for name, size in zip(("band", "view", "x", "y"), case.radiance.shape, strict=True):
            file.createDimension(name, size)
        variable = file.createVariable("radiance", "f8", ("band", "view", "x", "y"))
        variable.units = "W m-2 sr-1 um-1"
        variable[:] = factor * case.radiance


def test_all_cases_are_listed_with_the_folder_of_their_files():
    done = cases()
    assert done.exit_code == 0, done.output
    for name in light.case_names():
        assert f"\n{name} " in f"\n{done.output}"
    assert str(light.FOLDER) in done.output
    listed = json.loads(cases("--json", "-").output)
    assert [each["name"] for each in listed] == light.case_names()


def test_our_models_are_scored():
    done = cases(NAME, "--model", "columns", "--model", "source", "--json", "-")
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert {each["model"] for each in found} == {"columns", "source"}
    assert len(found) == 2 * 2 * 2
    assert all(abs(each["bias_K"]) < 2.0 for each in found)


def test_a_table_in_markdown_has_a_row_for_each_band_and_view():
    done = cases(NAME, "--model", "columns", "--markdown")
    lines = done.stdout.strip().splitlines()
    assert lines[1] == "| --- | --- | --- | --- | --- |"
    assert len(lines) == 2 + 4


@pytest.mark.parametrize("whole_folder", [False, True])
def test_results_of_a_user_are_scored(tmp_path, whole_folder):
    case, path = light.load_case(NAME), tmp_path / (f"{NAME}.nc" if whole_folder else "mine.nc")
    results(path, case, 1.01)
    done = cases(NAME, "--results", tmp_path if whole_folder else path, "--json", tmp_path / "found.json")
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "found.json").read_text())
    np.testing.assert_allclose([each["bias"] for each in found], 0.01, rtol=1e-6)
    assert {each["model"] for each in found} == {tmp_path.name if whole_folder else "mine"}


def test_what_cannot_be_scored_is_refused(tmp_path):
    path = tmp_path / "mine.nc"
    results(path, light.load_case(NAME))
    several = cases(NAME, "cumulus-night", "--results", path)
    assert isinstance(several.exception, OptionError)
    assert "allowed: one CASE, or a folder" in str(several.exception)
    unnamed = cases("--model", "columns")
    assert isinstance(unnamed.exception, OptionError)
    assert "need a CASE" in str(unnamed.exception)
    assert "case: 'cloud'; allowed: cumulus-day" in str(cases("cloud").exception)


def test_the_package_that_has_the_cases_is_named_if_it_is_missing(monkeypatch):
    real = builtins.__import__

    def without_light(name, *arguments, **keywords):
        if name.partition(".")[0] == "hcss_light":
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return real(name, *arguments, **keywords)

    monkeypatch.setattr(builtins, "__import__", without_light)
    done = cases()
    assert isinstance(done.exception, OptionError)
    assert "pip install ./plugins/hcss-light" in str(done.exception)


@pytest.mark.parametrize("words", [[], ["scene"]])
def test_a_scene_may_be_named_without_its_command(words):
    done = CliRunner().invoke(bench, [*words, "no-such-scene"])
    assert isinstance(done.exception, ScenarioError)
    assert "no-such-scene" in str(done.exception)
