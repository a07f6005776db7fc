"""Tables that an earlier run compiled."""

import numpy as np
import pytest
from cheap import CHEAP, NARROW
from click.testing import CliRunner

from hcss_twin.cli.main import cli
from hcss_twin.engine import compile
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.simulate import simulate
from hcss_twin.engine.tables.table_key import table_key
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.scenario.scenario import Scenario

SMALL = CHEAP | {"image.rows": 16, "image.columns": 16, "frames.count": 2, "bands": NARROW}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path))
    return tmp_path / "tables"


@pytest.fixture(scope="module")
def usual():
    return table_key(plan())


def plan(**changes):
    overrides = SMALL | {key.replace("__", "."): value for key, value in changes.items()}
    return make_plan(Scenario.load("stratus", overrides))


@pytest.fixture
def no_compiler(monkeypatch):
    def refuse(plan):
        raise AssertionError("compiled again")

    return lambda: monkeypatch.setattr(compile, "compile_tables", refuse)


def test_a_second_run_has_the_same_tables_to_the_bit_without_compiling(folder, no_compiler):
    first = tables_of(plan())
    no_compiler()
    again = plan()
    second = tables_of(again)
    assert second.time_s == first.time_s
    assert second.estimated_error == first.estimated_error
    assert second.tables[0].clear.tobytes() == first.tables[0].clear.tobytes()
    assert second.tables[0].columns.cores[0].tobytes() == first.tables[0].columns.cores[0].tobytes()
    assert second.axes[0].dense_m.tobytes() == first.axes[0].dense_m.tobytes()


def test_cubes_from_kept_tables_have_the_same_provenance(folder, no_compiler):
    scenario = Scenario.load("stratus", SMALL)
    first = simulate(scenario)
    no_compiler()
    second = simulate(scenario)
    np.testing.assert_array_equal(first.radiance, second.radiance)
    for name in ("hcss_files_sha256", "hcss_table_error_estimated", "hcss_wavenumbers_used"):
        assert first.attrs[name] == second.attrs[name]


@pytest.mark.parametrize(
    "changes",
    [
        {"seed": 7},
        {"title": "another"},
        {"image__rows": 32},
        {"image__pixel_size": 5.0},
        {"clouds__coverage": 0.123},
        {"clouds__edge_taper": 0.4},
        {"output__variables": ["radiance", "truth"]},
    ],
)
def test_what_tables_do_not_depend_on_finds_the_same(changes, usual):
    assert table_key(plan(**changes)) == usual


@pytest.mark.parametrize(
    "changes",
    [
        {"view__zenith": 21.0},
        {"time": "2024-04-20T12:31:00+10:00"},
        {"frames__count": 3},
        {"accuracy": 1e-2},
        {"sea__temperature": 291.5},
        {"sea__wind_speed": 9.0},
        {"clouds__coverage": 0.0},
        {"clouds__top": 900.0},
        {"clouds__effective_radius": 9.0},
        {"output__variables": ["terms"]},
        {"bands": ["mwir"]},
        {"radiance__parameters": {"glint_scale": 0.5}},
        {"atmosphere__parameters": {"aerosol": "maritime"}},
        {"place__latitude": 35.1},
    ],
)
def test_what_tables_depend_on_finds_others(changes, usual):
    assert table_key(plan(**changes)) != usual


def test_tables_do_not_depend_on_the_image_that_decides_where_clouds_are(tmp_path):
    keys = set()
    for seed in (1, 2):
        path = tmp_path / f"{seed}.npy"
        np.save(path, np.random.default_rng(seed).uniform(size=(32, 32)))
        changed = plan(clouds__generator="imagery", clouds__parameters={"image": str(path)}, frames__count=1)
        assert str(path) in changed.catalog.used
        keys.add(table_key(changed))
    assert len(keys) == 1


def test_a_damaged_file_is_made_again(folder):
    first = tables_of(plan())
    [kept] = folder.iterdir()
    kept.write_bytes(kept.read_bytes()[:100])
    again = tables_of(plan())
    assert again.tables[0].clear.tobytes() == first.tables[0].clear.tobytes()
    assert kept.stat().st_size > 1000


def test_the_tables_of_another_scene_under_this_name_are_not_taken(folder):
    first = tables_of(plan())
    tables_of(plan(sea__temperature=291.5))
    [kept] = folder.glob(f"{table_key(plan())}*")
    [other] = set(folder.iterdir()) - {kept}
    kept.write_bytes(other.read_bytes())
    assert tables_of(plan()).tables[0].clear.tobytes() == first.tables[0].clear.tobytes()


def test_the_command_says_what_is_kept_and_clears_it(folder):
    tables_of(plan())
    shown = CliRunner().invoke(cli, ["cache"])
    assert shown.exit_code == 0
    assert "tables         1 files" in shown.output
    cleared = CliRunner().invoke(cli, ["cache", "clear", "tables"])
    assert cleared.output.startswith("tables: 1 files removed")
    assert not list(folder.iterdir())
    assert '"files": 0' in CliRunner().invoke(cli, ["cache", "--json"]).output
