"""Keys of scenarios: changes, and the files that are saved."""

import pytest
from hcss_explore.keys import KeyPathError, as_toml, value_of, with_absolute_paths, with_changes

from hcss_twin import Scenario
from hcss_twin.providers import Catalog

SHIPPED = Catalog().names("scenarios", ".toml")


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_scenario_written_as_a_file_is_the_same_scenario(name):
    raw, base = Scenario.read_file(name)
    assert Scenario.from_toml(as_toml(raw), base=base) == Scenario.from_dict(raw, base=base)


def test_texts_tables_and_lists_come_back_as_they_were():
    import tomllib
    from datetime import UTC, datetime

    raw = {
        "title": 'quotes " and \\ and \n and \x7f and é',
        "yes": True,
        "numbers": [1, 2.5, 1e-9],
        "when": datetime(2024, 4, 20, 12, 30, tzinfo=UTC),
        "tables": {"a key": {"inner": [{"x": 1}, {"x": "2024-04-20T12:30:00+10:00"}]}, "empty": {}},
        "many": [{"a": 1}, {"b": [[1.0, 2.0]]}],
    }
    assert tomllib.loads(as_toml(raw)) == raw


def test_changes_set_and_remove_keys_in_a_copy():
    raw = {"clouds": {"layers": [{"type": "cirrus"}, {"type": "stratus"}]}, "sensor": {"name": "modis"}}
    changed = with_changes(raw, {"clouds.layers[1].coverage": 0.2, "sensor.name": None, "view.zenith": 30})
    assert changed == {
        "clouds": {"layers": [{"type": "cirrus"}, {"type": "stratus", "coverage": 0.2}]},
        "view": {"zenith": 30},
    }
    assert raw["sensor"] == {"name": "modis"}
    assert value_of(changed, "clouds.layers[1].coverage") == 0.2
    assert value_of(changed, "clouds.layers[7].coverage") is value_of(changed, "nothing.here") is None
    assert with_changes(raw, {"nothing.here": None, "clouds.layers[9].type": None}) == raw


@pytest.mark.parametrize("key", ["", "..", "a b", "view.", "clouds.layers[9].type", "seed.inner", "clouds.layers[x]"])
def test_a_key_that_cannot_be_set_is_named(key):
    with pytest.raises(KeyPathError, match=r"allowed|there is no table"):
        with_changes({"seed": 1, "clouds": {"layers": []}}, {key: 1})


def test_names_of_files_beside_the_scenario_become_absolute_and_no_others(tmp_path):
    (tmp_path / "air.csv").write_text("", encoding="utf-8")
    (tmp_path / "stratus").write_text("", encoding="utf-8")
    raw = {"a": {"file": "air.csv", "type": "stratus"}, "b": ["air.csv", "other.csv", "2.5", "", "\0.csv"]}
    path = str((tmp_path / "air.csv").resolve())
    assert with_absolute_paths(raw, tmp_path) == {
        "a": {"file": path, "type": "stratus"},
        "b": [path, "other.csv", "2.5", "", "\0.csv"],
    }
