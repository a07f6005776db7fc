"""The reference of the benchmarks: what a run looks up for columns, and what errors are relative to."""

import numpy as np
import pytest
from cheap_scene import CHEAP
from hcss_bench import reference as reference_module
from hcss_bench.benchmark import random_columns
from hcss_bench.reference import MODELS, PHYSICAL, changed, column_radiance, reference_of, table_radiance, with_streams

from hcss_twin import Scenario, make_plan
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import PartMaker

SMALL = CHEAP | {
    "image.rows": 20,
    "image.columns": 30,
    "frames.count": 1,
    "output.certificate": 0,
    "bands": ["mwir-3.7", "lwir-10.8"],
    "accuracy": 2e-3,
    "sea.temperature_texture": 0.0,  # columns are over one sea
}


@pytest.fixture(scope="module")
def scene():
    return Scenario.load("stratus", SMALL)


@pytest.fixture(scope="module")
def reference(scene):
    return reference_of(scene, random_columns(make_plan(scene), 6), 1)


def test_what_tables_hold_for_columns_is_what_a_run_writes_for_pixels(scene):
    plan = make_plan(scene)
    tables = tables_of(plan)
    frame, _ = PartMaker(plan, tables).part(0, plan.extent)
    thickness = plan.assembly.generators[0].thickness_m(0.0, slice(0, 20), slice(0, 30))
    found = table_radiance(plan, tables, thickness.reshape(-1, 1).astype(np.float64))
    np.testing.assert_array_equal(found.T.reshape(2, 20, 30).astype(np.float32), frame["radiance"])


@pytest.mark.long
def test_the_models_error_is_that_of_its_streams_and_spectrum(scene, reference):
    """At the reference's own level, the spectrum's steps and the closure remain: some 1e-5."""
    same, few = make_plan(changed(scene, PHYSICAL)).at_level(1), make_plan(changed(scene, with_streams(2)))
    errors = [reference.errors(column_radiance(plan, plan.spectral_grid, reference.columns)) for plan in (same, few)]
    assert list(errors[0]) == ["mwir-3.7", "lwir-10.8"]
    assert all(1e-8 < error < 1e-4 for error in errors[0].values())
    assert all(errors[1][band] > 10.0 * errors[0][band] for band in errors[0])


@pytest.mark.long
def test_the_change_of_level_at_few_wavenumbers_is_that_of_all(scene, monkeypatch):
    monkeypatch.setattr(reference_module, "COARSE_LEVEL", 1)
    few, columns = changed(scene, {"bands": [[3.6, 3.75]]}), np.array([[0.0], [50.0], [900.0]])
    composed, plan = reference_of(few, columns, 2), make_plan(changed(few, PHYSICAL))
    coarse, fine = (column_radiance(plan.at_level(level), plan.spectral_grid, columns) for level in (1, 2))
    change = 1.0 - coarse / fine
    assert np.max(np.abs(change)) > 1e-4
    assert composed.level_change == pytest.approx(change, abs=0.01 * np.max(np.abs(change)))
    assert composed.radiance == pytest.approx(fine, rel=3e-4)


def test_errors_are_the_largest_of_any_column_in_each_band(reference):
    wrong = reference.radiance.copy()
    wrong[3] *= (0.9, 1.01)
    wrong[1] *= (1.05, 1.0)
    assert reference.errors(wrong) == pytest.approx({"mwir-3.7": 0.1, "lwir-10.8": 0.01})
    assert reference.errors(wrong, np.arange(6) == 1) == pytest.approx({"mwir-3.7": 0.05, "lwir-10.8": 0.0})


def test_a_scenario_accepts_every_model_to_compare(scene):
    for overrides in MODELS.values():
        assert changed(scene, overrides).radiance.model == overrides["radiance.model"]
