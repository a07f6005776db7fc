"""``hcss reproduce``: what it writes, tells and refuses."""

import json
from html import escape

import pytest
from click.testing import CliRunner
from hcss_paper import tables_1_and_3
from hcss_paper.inputs import fitted_inputs
from hcss_paper.reproduction import Check, Reproduction, Row

from hcss_twin.cli.main import cli
from hcss_twin.version import __version__

NO_NUMBER = {"text": "", "name": None, "value": None, "unit": None}


def reproduce(*arguments):
    return CliRunner().invoke(cli, ["reproduce", *map(str, arguments)])


@pytest.fixture
def paths(tmp_path):
    return tmp_path / "report.html", tmp_path / "report.json"


def test_one_page_and_one_file_of_numbers_are_written(paths):
    page, numbers = paths
    done = reproduce("table-3", "-o", page, "--json", numbers)
    assert done.exit_code == 0, done.output
    assert "table-3" in done.output
    assert "reproduced" in done.output
    found = json.loads(numbers.read_text())
    assert list(found) == ["table-3"]
    assert found["table-3"]["verdict"] == "reproduced"
    assert len(found["table-3"]["rows"]) == 32
    assert all(row["difference"] == 0 for row in found["table-3"]["rows"])
    text = page.read_text()
    assert "Table III" in text
    assert text.count("Simulated, top") == 1
    assert "http" not in text


def test_an_item_that_fails_ends_in_code_1_and_the_report_says_so(paths, monkeypatch):
    def broken(seed):
        raise ValueError("no clouds today")

    monkeypatch.setattr(tables_1_and_3, "table_3", broken)
    page, numbers = paths
    done = reproduce("table-3", "table-1", "-o", page, "--json", numbers)
    assert done.exit_code == 1
    assert "ValueError: no clouds today" in done.output
    found = json.loads(numbers.read_text())
    assert found["table-3"]["verdict"] == "failed"
    assert found["table-1"]["verdict"] == "reproduced"
    assert "no clouds today" in page.read_text()


def test_the_list_computes_and_writes_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = reproduce("--list")
    assert done.exit_code == 0
    names = [line.split()[0] for line in done.output.splitlines()]
    assert names[:2] == ["headline", "table-1"]
    assert len(names) >= 16
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "closest"), [("tabel-3", "table-3"), ("Table XII", "table-10"), ("XX", "table-10"), ("Fig. 8", "figure-9")]
)
def test_an_unknown_item_is_told_the_closest(paths, name, closest):
    done = reproduce(name, "-o", paths[0])
    assert done.exit_code == 2
    assert f"closest is '{closest}'" in done.output
    assert not paths[0].exists()


def test_existing_files_are_kept_unless_forced(paths):
    page, numbers = paths
    for kept, arguments in ((page, ()), (numbers, ("--json", numbers))):
        kept.write_text("mine")
        done = reproduce("table-3", "-o", page, *arguments)
        assert done.exit_code == 1
        assert "--force" in done.output
        assert kept.read_text() == "mine"
        kept.unlink()
    page.write_text("<p>mine</p>")
    assert reproduce("table-3", "-o", page, "--force").exit_code == 0
    assert "Table III" in page.read_text()


def test_a_folder_that_is_not_there_is_found_out_before_computing(tmp_path):
    done = reproduce("table-3", "-o", tmp_path / "no" / "report.html")
    assert done.exit_code == 1
    assert "there is no folder" in done.output


def test_the_seed_is_what_items_are_computed_with(paths, monkeypatch):
    def drawn(seed):
        rows = [Row("seed", "1", 1.0, float(seed))] * 32
        return Reproduction("reproduced", "Yes.", rows, [Check("it is drawn", True)])

    monkeypatch.setattr(tables_1_and_3, "table_3", drawn)
    page, numbers = paths
    assert reproduce("table-3", "-o", page, "--json", numbers, "--seed", 23).exit_code == 0
    found = json.loads(numbers.read_text())["table-3"]
    assert found["rows"][0]["computed"] == 23.0
    assert found["seed"] == 23
    assert found["hcss_twin"] == __version__


def test_fitted_inputs_are_numbers_with_units_and_choices_are_words(paths):
    page, numbers = paths
    assert reproduce("table-8", "-o", page, "--json", numbers).exit_code == 0
    fitted = json.loads(numbers.read_text())["table-8"]["fitted_inputs"]
    known = fitted_inputs()["coverage of Table VIII"]
    assert list(fitted[0]) == ["text", "name", "value", "unit"]
    assert fitted[0] == {"text": known.assumed.text, "name": known.name, "value": known.value, "unit": "1"}
    assert [{**fitted_input, "text": ""} for fitted_input in fitted[1:]] == [NO_NUMBER] * (len(fitted) - 1)
    assert len(fitted) > 1
    assert all(f"<li>{escape(fitted_input['text'])}</li>" in page.read_text() for fitted_input in fitted)
