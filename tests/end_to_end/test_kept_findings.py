"""What a plan finds out is kept between runs, and found out anew where anything it depends on has changed."""

import json

import pytest
from cheap import CHEAP

from hcss_twin import Scenario, ScenarioError, make_plan
from hcss_twin.core import result_cache
from hcss_twin.core.catalog import Catalog
from hcss_twin.models.radiance.as_printed import AsPrinted
from hcss_twin.plan import make_plan as planning
from hcss_twin.plan import scene_analysis
from hcss_twin.plan.description import describe

SMALL = {**CHEAP, "image.rows": 8, "image.columns": 8, "frames.count": 2, "bands": ["mwir-3.7", "lwir-10.8"]}


@pytest.fixture(autouse=True)
def _kept(monkeypatch, tmp_path):
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path / "cache"))


@pytest.fixture
def asked(monkeypatch):
    """What the radiance model was asked for."""
    calls = []
    columns = AsPrinted.columns
    monkeypatch.setattr(AsPrinted, "columns", lambda *each: calls.append(each) or columns(*each))
    return calls


def plan(**changes):
    return make_plan(Scenario.load("stratus", SMALL | {key.replace("__", "."): each for key, each in changes.items()}))


def test_a_second_plan_asks_the_model_for_nothing_and_is_the_same(asked):
    first = plan()
    assert asked
    asked.clear()
    second = plan()
    assert not asked
    assert second.omissions == first.omissions
    assert describe(second) == describe(first)
    assert second.catalog.used == first.catalog.used


@pytest.mark.parametrize(
    "changes",
    [
        {"accuracy": 1e-2},
        {"time": "2024-04-20T16:30:00+10:00"},
        {"output__variables": ["radiance", "terms"]},
        {"sea__temperature": 290.0},
        {"clouds__coverage": 0.0},
        {"clouds__coverage": 1.0},
        {"image__pixel_size": 5.0},
    ],
)
def test_another_scenario_is_found_out_anew(asked, changes):
    plan()
    asked.clear()
    plan(**changes)
    assert asked


@pytest.mark.parametrize(
    "changes",
    [
        {"seed": 5},
        {"clouds__coverage": 0.3},
        {"clouds__edge_taper": 0.4},
        {"title": "another"},
        {"output__certificate": 0},
        {"output__certificate": 4},
        {"image__window": {"rows": [1, 5], "columns": [2, 6]}},
        {"clouds__coverage_mode": "frame"},
        {"clouds__wind_speed": 3.0, "clouds__wind_from": 20.0},
        {"motion__wind_speed": 3.0, "motion__wind_from": 20.0, "motion__evolution_time": 60.0},
    ],
)
def test_what_findings_do_not_depend_on_finds_the_same(asked, changes, monkeypatch):
    plan()
    asked.clear()
    kept = plan(**changes)
    assert not asked
    monkeypatch.setattr("hcss_twin.plan.scene_analysis.kept_result", lambda *each: each[2]())
    anew = plan(**changes)
    assert asked
    assert kept.omissions == anew.omissions
    assert describe(kept) == describe(anew)


def test_findings_do_not_depend_on_where_elements_are(asked):
    def beside(x):
        return plan(elements=[{"parameters": {"tracks": [{"x": x, "y": 0.0, "altitude": 5000.0, "intensity": 1.0}]}}])

    first = beside(0.0)
    assert asked
    asked.clear()
    assert beside(500.0).omissions == first.omissions
    assert not asked


def test_a_changed_file_is_found_out_anew(asked, tmp_path):
    response = tmp_path / "response.csv"
    response.write_text("wavelength_um,response\n3.5,0\n3.7,1\n3.9,0\n")
    bands = [{"name": "own", "response": str(response)}]
    plan(bands=bands)
    asked.clear()
    plan(bands=bands)
    assert not asked
    response.write_text("wavelength_um,response\n3.5,0\n3.8,1\n3.9,0\n")
    plan(bands=bands)
    assert asked


def test_other_code_is_found_out_anew(asked, monkeypatch):
    plan()
    asked.clear()
    monkeypatch.setattr(result_cache, "code_fingerprint", lambda *_: "another")
    plan()
    assert asked


def test_a_plan_that_keeps_nothing_takes_nothing(asked):
    scenario = plan().scenario
    asked.clear()
    make_plan(scenario, keeps_results=False)
    assert asked


def test_what_cannot_be_had_is_not_kept(monkeypatch):
    def refuse(*_):
        raise ScenarioError([])

    monkeypatch.setattr(scene_analysis, "probe_particles", refuse)
    for _ in range(2):
        with pytest.raises(ScenarioError):
            plan()


def test_a_file_of_another_folder_is_not_taken_for_that_of_this_one(asked, monkeypatch, tmp_path):
    """Of a provider that opens its file when it is first asked."""
    columns = AsPrinted.columns

    def lazily(self, states, wavenumber):
        catalog[0].file("factor.txt")
        return columns(self, states, wavenumber)

    catalog = []
    assemble = planning.assemble

    def assembled(scenario, own, slant, *climate):
        catalog[:] = [own]
        return assemble(scenario, own, slant, *climate)

    monkeypatch.setattr(planning, "assemble", assembled)
    monkeypatch.setattr(AsPrinted, "columns", lazily)
    used = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "factor.txt").write_text(name)
        scenario = Scenario.load("stratus", SMALL)
        made = Scenario.from_dict(json.loads(scenario.to_json()), base=tmp_path / name)
        used.append([path for path in make_plan(made).catalog.used if "factor" in path])
    assert used == [[str(tmp_path / name / "factor.txt")] for name in ("a", "b")]


def test_files_that_changed_are_not_recorded_as_read(tmp_path):
    same, changed = tmp_path / "same.csv", tmp_path / "changed.csv"
    for path in (same, changed):
        path.write_text("1")
    first = Catalog(base=tmp_path)
    for path in (same, changed):
        first.file(path.name)
    changed.write_text("2")
    second = Catalog(base=tmp_path)
    assert not second.unchanged(first.used)
    assert not second.used
    assert second.unchanged({name: digest for name, digest in first.used.items() if "same" in name})
    assert [*second.used] == [str(same)]
