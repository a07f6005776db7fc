"""Cost follows what is asked for: counted in columns x wavenumbers of the radiance model, not in seconds."""

import json
from typing import NamedTuple

import numpy as np
import pytest
from cheap import APART, CHEAP

from hcss_twin import Scenario, make_plan
from hcss_twin.cube.reader import open_cube
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.simulate import run
from hcss_twin.engine.stream import stream
from hcss_twin.engine.tables.spectrum import choose_spectrum
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.radiance.as_printed import AsPrinted
from hcss_twin.models.radiance.physical.model import Physical
from hcss_twin.plan.description import describe
from hcss_twin.providers import Sun


class Asked(NamedTuple):
    columns: int
    """Times wavenumbers."""
    sun: Sun | None
    cloudy: bool


SMALL = {"image.rows": 16, "image.columns": 16, "frames.count": 2}
NIGHT_LWIR = {"time": "2024-04-20T00:30:00+10:00", "bands": ["lwir"]}
DEFAULT_MODELS = {"accuracy": 1e-2, **APART}


@pytest.fixture
def asked(monkeypatch):
    """What radiance models are asked for: each clear sky, and the cloudy columns of each setting."""
    found = []
    for model in (AsPrinted, Physical):

        def counted(self, states, wavenumber_cm1, columns=model.columns):
            for _, setting, thickness_m in states.groups():
                cloudy = np.count_nonzero(np.any(thickness_m > 0.0, axis=1))
                found.extend([Asked(wavenumber_cm1.size, setting.sun, False)] * (len(thickness_m) - cloudy))
                found.extend([Asked(wavenumber_cm1.size * cloudy, setting.sun, True)] * int(cloudy > 0))
            return columns(self, states, wavenumber_cm1)

        monkeypatch.setattr(model, "columns", counted)
    return found


def made(path, models=CHEAP, **overrides):
    return run(make_plan(Scenario.load("stratus", {**SMALL, **models, **overrides})), path / "cube.nc")


@pytest.mark.parametrize("models", [CHEAP, DEFAULT_MODELS], ids=["as-printed", "default"])
@pytest.mark.parametrize("variables", [["cloud_mask"], ["truth"]])
def test_without_a_variable_of_radiance_no_radiance_is_computed(tmp_path, asked, models, variables):
    with open_cube(made(tmp_path, models, **{"output.variables": variables})) as cube:
        assert 0.0 < float(cube.cloud_mask.mean()) < 1.0
        assert not any(name.startswith("radiance") for name in cube.variables)
    assert asked == []


@pytest.mark.parametrize("models", [CHEAP, DEFAULT_MODELS], ids=["as-printed", "default"])
def test_at_night_no_model_is_asked_for_sunlight(tmp_path, asked, models):
    made(tmp_path, models, **NIGHT_LWIR)
    assert asked
    assert all(each.sun is None for each in asked)


def test_faint_sunlight_is_asked_for_by_plan_and_certificate_only(asked):
    plan = make_plan(Scenario.load("stratus", {**SMALL, **CHEAP, "bands": ["lwir"], "accuracy": 2e-2}))
    assert not plan.sunlight.is_computed
    assert any(each.sun is not None for each in asked)
    asked.clear()
    list(stream(plan, compile_tables(plan)))
    assert asked
    assert all(each.sun is None for each in asked)


def test_terms_that_are_not_asked_for_are_not_looked_up():
    for variables, quantities in (
        (["radiance"], ("radiance",)),
        (["radiance_sea_emission"], ("radiance", "sea_emission")),
    ):
        plan = make_plan(Scenario.load("stratus", {**SMALL, **CHEAP, "output.variables": variables}))
        tables = compile_tables(plan)
        assert tables.quantities.names == quantities
        dense = tables.at(0.0)
        assert dense.channels == len(quantities) * len(plan.bands)


def spectral_columns(asked, models, **overrides):
    """Columns x wavenumbers that tables are compiled from, and those of them with cloud."""
    plan = make_plan(Scenario.load("stratus", {**SMALL, **models, **overrides}))
    asked.clear()
    compile_tables(plan)
    return sum(each.columns for each in asked), sum(each.columns for each in asked if each.cloudy)


@pytest.mark.parametrize(
    "models", [CHEAP, pytest.param(DEFAULT_MODELS, marks=pytest.mark.long)], ids=["as-printed", "default"]
)
def test_one_band_at_night_takes_less_than_half_and_clear_sky_no_cloud(asked, models):
    day, cloudy = spectral_columns(asked, models)
    assert cloudy > 0.5 * day
    assert spectral_columns(asked, models, **NIGHT_LWIR)[0] < 0.5 * day
    clear, cloudy = spectral_columns(asked, models, **{"clouds": {"layers": []}})
    assert cloudy == 0
    assert clear < 0.3 * day


def test_plan_and_cube_tell_the_same_ledger(tmp_path):
    scenario = Scenario.load("stratus", {**SMALL, **CHEAP})
    plan = make_plan(scenario)
    told = describe(plan)["skipped"]
    with open_cube(run(plan, tmp_path / "cube.nc")) as cube:
        assert json.loads(cube.attrs["hcss_skipped"]) == told
    assert all(set(item) >= {"what", "why", "bound"} for item in told)
    bounds = [item["bound"] for item in told if item["bound"] is not None]
    assert len(bounds) > 6
    assert np.all(np.isfinite(bounds))
    assert min(bounds) >= 0.0


def test_a_layer_that_has_no_cloud_anywhere_is_not_generated(tmp_path, monkeypatch):
    asked, thickness_m = [], FractalClouds.thickness_m

    def counted(self, *where):
        asked.append(where)
        return thickness_m(self, *where)

    monkeypatch.setattr(FractalClouds, "thickness_m", counted)
    plan = make_plan(Scenario.load("stratus", {**SMALL, **CHEAP, "clouds.coverage": 0.0}))
    asked.clear()
    with open_cube(run(plan, tmp_path / "cube.nc")) as cube:
        assert not cube.cloud_mask.any()
    assert not asked


def dense_clear_skies(asked, plan):
    """Suns under which clear skies were asked for at all wavenumbers."""
    every = plan.spectral_grid.wavenumber_cm1.size
    return [each.sun for each in asked if not each.cloudy and each.columns == every]


def test_a_sun_that_hardly_moves_takes_few_clear_skies_at_all_wavenumbers(asked):
    """And what is chosen on them sums the clear sky of every frame."""
    scene = {**SMALL, **CHEAP, "clouds.coverage": 0.0, "frames.count": 9}
    plan = make_plan(Scenario.load("stratus", scene))
    asked.clear()
    nodes = choose_spectrum(plan, plan.budget.wavenumbers).nodes
    assert len(dense_clear_skies(asked, plan)) <= 3
    grid = plan.spectral_grid
    assert nodes.wavenumber_cm1.size < grid.wavenumber_cm1.size
    for time_s in plan.frame_times_s:
        exact, few = (
            np.sum(list(plan.assembly.clear(each.wavenumber_cm1, plan.sun_at(time_s)).values()), axis=0)
            @ each.weights_cm1.T
            for each in (grid, nodes)
        )
        np.testing.assert_allclose(few, exact, rtol=plan.budget.wavenumbers)
    moving = make_plan(Scenario.load("stratus", {**scene, "frames.interval": 600.0}))
    asked.clear()
    choose_spectrum(moving, moving.budget.wavenumbers)
    assert len(dense_clear_skies(asked, moving)) > 10
