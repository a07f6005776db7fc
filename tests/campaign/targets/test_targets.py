"""A sample of the campaign of targets, and its committed results."""

import csv
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

# Under a name of its own: other campaigns have a run.py, too.
spec = spec_from_file_location("targets_run", Path(__file__).with_name("run.py"))
assert spec is not None
assert spec.loader is not None
run = module_from_spec(spec)
spec.loader.exec_module(run)


@pytest.mark.parametrize("scene", [4, pytest.param(8, marks=pytest.mark.long)])
def test_targets_have_flux_place_and_image_of_closed_forms(scene, tmp_path, monkeypatch):
    monkeypatch.setattr(run.cases, "FRAMES", 2)
    rows = run.rows_of(scene, tmp_path)
    assert len(rows) == 4
    assert run.failures(rows) == []


def test_the_committed_run_has_1000_cases_within_the_limits():
    with run.RESULTS.open() as file:
        rows = list(csv.DictReader(file))
    assert len({(row["scene"], row["frame"]) for row in rows}) == 1000
    assert len(run.failures(rows)) == 0
