"""A sample of the campaign of targets."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

# Under a name of its own: other campaigns have a run.py, too.
spec = spec_from_file_location("targets_run", Path(__file__).with_name("run.py"))
assert spec is not None
assert spec.loader is not None
run = module_from_spec(spec)
spec.loader.exec_module(run)


@pytest.mark.long
def test_targets_have_flux_place_and_image_of_closed_forms(tmp_path, monkeypatch):
    monkeypatch.setattr(run.cases, "FRAMES", 2)
    rows = run.rows_of(4, tmp_path)
    assert len(rows) == 4
    assert run.failures(rows) == []
