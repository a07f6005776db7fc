"""What scenes of one process share: read once, read again where it changed, and the same cubes."""

import pytest
from cheap import CHEAP

from hcss_twin import Scenario, make_plan
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.result_cache import MAX, ResultCache
from hcss_twin.engine.simulate import run

SMALL = CHEAP | {"image.rows": 8, "image.columns": 8, "frames.count": 1, "bands": ["lwir-10.8"]}


def catalog_with(shelf, base):
    catalog = Catalog(base=base)
    catalog.shelf = shelf
    return catalog


def test_a_thing_is_made_once_until_it_is_forgotten():
    shelf, made = ResultCache(), []
    for number in (1, 2, 1, 2):
        assert shelf.get_or_compute(number, lambda number=number: made.append(number) or number) == number
    assert made == [1, 2]
    for number in range(3, MAX + 2):
        shelf.get_or_compute(number, lambda: 0)
    shelf.get_or_compute(2, lambda: made.append(2))
    shelf.get_or_compute(1, lambda: made.append("again"))
    assert made == [1, 2, "again"]


def test_what_cannot_be_made_is_tried_again():
    shelf = ResultCache()
    with pytest.raises(ZeroDivisionError):
        shelf.get_or_compute("x", lambda: 1 // 0)
    assert shelf.get_or_compute("x", lambda: 1) == 1


def test_a_changed_file_is_read_again_and_recorded_as_it_is(tmp_path):
    shelf, path = ResultCache(), tmp_path / "table.csv"
    path.write_text("a,b\n1,2\n")
    first = catalog_with(shelf, tmp_path)
    assert first.columns(first.file("table.csv"))["b"] == [2.0]
    path.write_text("a,b\n1,25\n")
    second = catalog_with(shelf, tmp_path)
    assert second.columns(second.file("table.csv"))["b"] == [25.0]
    assert second.used != first.used


def test_what_a_scene_changes_in_what_it_read_is_not_seen_by_the_next(tmp_path):
    shelf = ResultCache()
    (tmp_path / "table.csv").write_text("a,b\n1,2\n")
    (tmp_path / "table.toml").write_text("[a]\nb = [1]\n")
    for _ in range(2):
        catalog = catalog_with(shelf, tmp_path)
        columns = catalog.columns(catalog.file("table.csv"))
        table = catalog.toml(catalog.file("table.toml"))
        assert columns["a"][0] == 1.0
        assert table == {"a": {"b": [1]}}
        columns["a"][0] = 9.0
        table["a"]["b"].append(2)


def test_scenes_that_share_make_the_same_bytes_as_scenes_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    shelf = ResultCache()
    # The second type needs other files of the catalog than the first: each cube names its own.
    for name in ("stratus", "cirrus", "stratus"):
        scenario = Scenario.load(name, SMALL)
        run(make_plan(scenario, shelf=shelf), tmp_path / "shared.nc")
        run(make_plan(scenario), tmp_path / "alone.nc")
        assert (tmp_path / "shared.nc").read_bytes() == (tmp_path / "alone.nc").read_bytes()
