"""The main job: laws of whole cubes."""

import json

import numpy as np
import pytest
from cheap import APART, CHEAP
from reference_agreement import assert_tables_agree_with_the_reference_path

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.stream import stream
from hcss_twin.models.radiance.as_printed import AsPrinted
from hcss_twin.models.radiance.physical.terms import TERMS
from hcss_twin.models.radiance.spectral_grid import SpectralGrid

THREE_LINES = """
time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
clouds.type = "stratus"
"""

DEFAULT = {"image.rows": 48, "image.columns": 64, "frames.count": 4}
"""A small scene of the default models."""
SMALL = {**DEFAULT, **CHEAP}
COARSE = {"accuracy": 1e-2}
"""For laws of the default models that hold at any accuracy: 4 s of processor time in place of 17."""
NARROW = {"bands": ["mwir-3.7", "lwir-10.8"]}
"""For laws of the default models that hold in any band: one with sunlight and one without."""
SHIPPED = ["baseline", "cirrus", "cumulus", "simulated", "stratus"]


@pytest.fixture(scope="module")
def stratus(tmp_path_factory):
    """A cube of the default models."""
    overrides = {**DEFAULT, **COARSE, **NARROW, "output.variables": ["radiance", "terms"], "output.certificate": 0}
    with simulate(Scenario.load("stratus", overrides), tmp_path_factory.mktemp("stratus") / "cube.nc") as cube:
        yield cube


def test_three_lines_run():
    cube = simulate(Scenario.from_toml(THREE_LINES, DEFAULT | COARSE))
    assert dict(cube.sizes)["time"] == 4
    assert cube.radiance.dims == ("time", "band", "y", "x")
    assert np.all(np.isfinite(cube.radiance))
    assert np.all(cube.radiance > 0)


@pytest.mark.parametrize("name", [*SHIPPED, "cirrus-over-cumulus"])
def test_shipped_scenarios_run(name):
    assert_runs(name, SMALL)


def assert_runs(name, models):
    cube = simulate(Scenario.load(name, {**models, "frames.count": 2, "output.variables": ["all"]}))
    assert set(cube.band.values) == {"swir-2.7-3.0", "mwir", "lwir"}
    cloudy = cube.cloud_mask.values == 1
    assert np.all(np.isfinite(cube.cloud_top_temperature.values[cloudy]))
    assert np.all(np.isnan(cube.cloud_top_temperature.values[~cloudy]))
    assert np.all(cube.cloud_thickness.values[cloudy] > 0)


@pytest.mark.parametrize("models", ["default", "cheap"])
def test_terms_sum_to_the_total(models, stratus):
    cheap = Scenario.load("stratus", {**SMALL, "output.variables": ["radiance", "terms"]})
    cube, terms = (stratus, TERMS) if models == "default" else (simulate(cheap), AsPrinted.terms)
    named = {name.removeprefix("radiance_") for name in cube if name.startswith("radiance_")}
    assert named == set(terms)
    total = sum(cube[name].astype(np.float64) for name in cube if name.startswith("radiance_"))
    np.testing.assert_allclose(total, cube.radiance, rtol=1e-6)  # single precision, changed by texture and shadows


def test_same_seed_same_cube_and_another_seed_another():
    one, two = (simulate(Scenario.load("cumulus", {**SMALL, "seed": 5})) for _ in range(2))
    other = simulate(Scenario.load("cumulus", {**SMALL, "seed": 6}))
    np.testing.assert_array_equal(one.radiance, two.radiance)
    assert np.any(one.cloud_mask.values != other.cloud_mask.values)


def test_other_frame_ranges_hold_the_same_pixels():
    whole = simulate(Scenario.load("stratus", {**SMALL, "output.variables": ["cloud_thickness", "radiance"]}))
    late = simulate(
        Scenario.load(
            "stratus",
            {**SMALL, "frames.first": 2, "frames.count": 2, "output.variables": ["cloud_thickness", "radiance"]},
        )
    )
    np.testing.assert_array_equal(whole.cloud_thickness[2:], late.cloud_thickness)
    # Tables are placed for the frames asked for: equal within the tables' tolerance.
    np.testing.assert_allclose(whole.radiance[2:], late.radiance, rtol=1e-4)


THREE = {"frames.count": 3, "frames.interval": 90.0}
"""The ends of three minutes, where tables may be placed, and the middle, which lies between them."""


def anywhere(random, thickness_m):
    """Any pixels."""
    return random.integers(0, len(thickness_m), 12)


# Every scene at a fine accuracy, water and ice at the others too.
@pytest.mark.parametrize(
    ("name", "accuracy"),
    [(name, 1e-4) for name in SHIPPED]
    + [("cirrus", 1e-2), ("stratus", 1e-2), ("cumulus", 1e-3), ("cirrus", 1e-3)]
    + [
        pytest.param(name, 1e-5, marks=pytest.mark.long if name == "cirrus" else pytest.mark.campaign)
        for name in SHIPPED
    ],
)
def test_tables_agree_with_the_reference_path(name, accuracy):
    plan = make_plan(Scenario.load(name, {**SMALL, **THREE, "accuracy": accuracy}))
    assert_tables_agree_with_the_reference_path(plan, anywhere, 1.25)


@pytest.mark.parametrize(
    ("name", "accuracy"),
    [
        ("stratus", 1e-3),
        pytest.param("cirrus", 1e-3, marks=pytest.mark.campaign),
        pytest.param("cumulus", 1e-4, marks=pytest.mark.campaign),
        pytest.param("cumulus", 1e-3, marks=pytest.mark.campaign),
        pytest.param("stratus", 1e-4, marks=pytest.mark.campaign),
    ],
)
def test_tables_of_the_default_models_agree_with_the_reference_path(name, accuracy):
    few = {"frames.count": 1, "bands": ["mwir-3.7", "lwir-10.8"]}
    plan = make_plan(Scenario.load(name, {**DEFAULT, **APART, **few, "accuracy": accuracy}))
    assert_tables_agree_with_the_reference_path(plan, anywhere, 1.25)


def test_sun_moving_over_hours_is_followed():
    overrides = {**SMALL, "frames.count": 5, "frames.interval": 1800.0, "bands": ["mwir"], "clouds.coverage": 0.0}
    plan = make_plan(Scenario.load("baseline", overrides))
    tables = compile_tables(plan)
    assert len(tables.time_s) > 2
    for time_s, frame in zip(plan.frame_times_s, stream(plan, tables), strict=True):
        setting = plan.assembly.setting(plan.sun_track.at(float(time_s)))
        exact = SpectralGrid.reference_radiance(plan.assembly.model, setting, plan.spectral_grid, [0.0])
        assert frame["radiance"][0, 0, 0] == pytest.approx(exact[0, 0], rel=1e-4)


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("stratus", {"frames.count": 5, "frames.interval": 43_200.0, "motion.platform_speed": 0.0}),
        (
            "cirrus",
            {
                "frames.count": 49,
                "frames.interval": 3600.0,
                "place.latitude": 70.0,
                "time": "2024-06-20T00:00:00Z",
                "motion.platform_speed": 0.0,
            },
        ),
        ("baseline", {"frames.count": 13, "frames.interval": 600.0}),
    ],
)
def test_days_are_not_mistaken_for_moments(name, overrides):
    """Noon, noon and noon agree; what lies between must be computed all the same."""
    small = {"image.rows": 6, "image.columns": 6, "bands": ["mwir"], "clouds.coverage": 0.0, **CHEAP, **overrides}
    plan = make_plan(Scenario.load(name, small))
    tables = compile_tables(plan)
    for time_s, frame in zip(plan.frame_times_s, stream(plan, tables), strict=True):
        sun = plan.sun_track.at(float(time_s))
        setting = plan.assembly.setting(sun if sun.is_up else None)
        exact = SpectralGrid.reference_radiance(plan.assembly.model, setting, plan.spectral_grid, [0.0])
        assert frame["radiance"][0, 0, 0] == pytest.approx(exact[0, 0], rel=1e-4 + 3e-7)


def test_a_cube_can_be_run_again_from_its_own_scenario(tmp_path):
    first = simulate(Scenario.load("cirrus", SMALL), tmp_path / "one.nc")
    again = simulate(Scenario.from_cube(tmp_path / "one.nc"), tmp_path / "two.nc")
    with first, again:
        np.testing.assert_array_equal(first.radiance, again.radiance)
        assert first.attrs["hcss_scenario"] == again.attrs["hcss_scenario"]


def test_same_scenario_gives_the_same_bytes(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    # Nothing is kept between the two. Bits of the default models are those recorded in tests/bits.
    for name in ("one.nc", "two.nc"):
        monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path / f"{name}.kept"))
        simulate(Scenario.load("cirrus", {**SMALL, **NARROW}), tmp_path / name).close()
    assert (tmp_path / "one.nc").read_bytes() == (tmp_path / "two.nc").read_bytes()


def test_provenance_names_what_the_cube_was_made_from(stratus):
    files = json.loads(stratus.attrs["hcss_files_sha256"])
    assert {"optical_constants/water.csv", "solar/astm-e490.csv", "cloud_types/paper-stratus.toml"} <= set(files)
    assert all(len(digest) == 64 for digest in files.values())
    assert json.loads(stratus.attrs["hcss_providers"])["clouds"]["distribution"] == "hcss-twin"
    assert stratus.attrs["hcss_seed"] == "1"
    assert stratus.attrs["hcss_significant_wave_height_m"] == pytest.approx(2.13, abs=0.01)


def test_large_scenes_are_read_lazily():
    # A patch of its own, by which no analysis of the scene changes: those of other tests serve.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hcss_twin.engine.simulate.IN_MEMORY_BYTES", 1000)
        cube = simulate(Scenario.load("stratus", SMALL))
    assert not cube.radiance.variable._in_memory
    assert float(cube.radiance.mean()) > 0
    cube.close()
