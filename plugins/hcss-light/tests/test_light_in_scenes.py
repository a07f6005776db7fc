"""Tiers through scenarios: uniform limit, the same bits in windows, certificate, what is refused, the command."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner
from hcss_light.command import reference
from hcss_light.comparison import compare, write_to_cube
from hcss_light.transport import SlantLight, SourceLight
from hcss_light.voxels import LightError
from light_scene import DAY, NIGHT, scene

from hcss_twin import simulate
from hcss_twin.core.errors import ScenarioError
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.predicted_time import predict
from hcss_twin.engine.stages.light import LightStage
from hcss_twin.plan import choose_light
from hcss_twin.plan.error_budget import error_budget
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.reports.plan_brief import plan_brief
from hcss_twin.reports.plan_text import plan_text


@pytest.mark.parametrize(
    ("tier", "time"),
    [
        (SlantLight, NIGHT),
        (SourceLight, DAY),
        pytest.param(SlantLight, DAY, marks=pytest.mark.campaign),
        pytest.param(SourceLight, NIGHT, marks=pytest.mark.campaign),
    ],
)
def test_uniform_cloud_keeps_the_radiance_of_the_tables(tier, time):
    plan = make_plan(scene("columns", time=time, bands=[[3.6, 3.7]]))
    tables = tables_of(plan)
    instant = tier(LightStage.inputs(plan, tables.spectrum.nodes)).at(plan.sun_at(0.0))
    for thickness in (10.0, 87.0, 400.0):
        amount, share, change = instant.correct(np.full((3, 4), thickness, np.float32))
        np.testing.assert_allclose(amount, thickness, rtol=1e-5)
        assert np.all(np.abs(change) < 2e-3 * tables.tables[0].clear[0, 0])
        np.testing.assert_allclose(share, 1.0, atol=5e-3)


def test_clouds_do_not_shade_sunlight_that_the_air_above_them_scatters():
    """At 2.7-3.0 um it is a fifth of the radiance."""
    image = {"rows": 12, "columns": 12, "pixel_size": 200.0}
    both = {"time": DAY, "bands": [[2.7, 3.0]], "image": image}
    columns, source = (simulate(scene(light, **both)).radiance.values for light in ("columns", "source"))
    assert source.min() > 0.95 * columns.min()


def test_vertical_rays_through_columns_change_nothing_in_the_tier_slant():
    plan = make_plan(scene("columns", view={"zenith": 0.0}))
    tables = tables_of(plan)
    thickness = np.random.default_rng(2).uniform(10.0, 400.0, (6, 5)).astype(np.float32)
    amount, _, change = SlantLight(LightStage.inputs(plan, tables.spectrum.nodes)).at(None).correct(thickness)
    np.testing.assert_allclose(amount, thickness, rtol=1e-5)
    assert np.all(np.abs(change) < 2e-3 * tables.tables[0].clear[0, 0])


@pytest.mark.parametrize("tier", [pytest.param("slant", marks=pytest.mark.campaign), "source"])
def test_a_window_has_the_bits_of_the_image_and_the_certificate_passes(tier):
    whole = simulate(scene(tier, 4, time=DAY))
    image = {"rows": 40, "columns": 30, "pixel_size": 100.0, "window": {"rows": [21, 40], "columns": [3, 17]}}
    part = simulate(scene(tier, time=DAY, image=image))
    np.testing.assert_array_equal(part.radiance.values, whole.radiance.values[:, :, 21:40, 3:17])
    assert "computed as specified" in whole.attrs["hcss_certificate"]
    assert json.loads(whole.attrs["hcss_light"])["name"] == tier
    assert "independent columns" in whole.attrs["hcss_notes"]
    sides = json.loads(whole.attrs["hcss_monte_carlo"])
    assert sides["pixels"] == 4
    (comparison,) = sides["bands"].values()
    assert abs(comparison["bias"]) < 0.02
    assert 0.0 < comparison["noise"] < 0.005
    assert "against Monte Carlo of 4 random pixels" in whole.attrs["hcss_certificate"]
    columns = simulate(scene("columns", 4, time=DAY))
    assert "hcss_light" not in columns.attrs
    assert "hcss_monte_carlo" not in columns.attrs
    assert np.any(columns.radiance.values != whole.radiance.values)


@pytest.mark.parametrize(
    ("changes", "message"),
    [({"image": {"rows": 4, "columns": 4, "pixel_size": 1.0}, "view": {"zenith": 75.0}}, "needs .* slices")],
)
def test_scenes_that_cannot_be_computed_are_refused_by_name(changes, message):
    with pytest.raises(ScenarioError, match=message):
        make_plan(scene(**changes))


def test_a_tier_that_is_not_installed_is_refused_with_the_command_that_installs_it(monkeypatch):
    with pytest.raises(ScenarioError, match=r"'sorce' is unknown.*source"):
        make_plan(scene("sorce"))
    monkeypatch.setattr(choose_light, "installed", lambda group: iter(()))
    for name, what in {"source": "is not installed.*It comes", "sides": "is unknown.*Others come"}.items():
        with pytest.raises(ScenarioError, match=rf"'{name}' {what} with hcss-light: pip install \./plugins/hcss-light"):
            make_plan(scene(name))


def test_a_profile_without_light_is_refused():
    with pytest.raises(ScenarioError, match="light_profile"):
        make_plan(scene("columns", radiance={"light_profile": "adiabatic"}))


def test_the_command_finds_the_tier_nearer_to_monte_carlo_than_columns_and_writes_it_into_the_cube(tmp_path):
    given = scene(view={"zenith": 60.0}, clouds={"type": "paper-cumulus", "coverage": 0.45})
    file, result, cube = (tmp_path / name for name in ("scene.json", "result.json", "cube.nc"))
    file.write_text(given.to_json(), encoding="utf-8")
    simulate(given).to_netcdf(cube)
    run = CliRunner().invoke(
        reference,
        [str(file), "--pixels", "6", "--photons", "1000", "--json", str(result), "--cube", str(cube)],
        catch_exceptions=False,
    )
    assert run.exit_code == 0, run.output
    (band,) = json.loads(result.read_text())["bands"]
    cube_rms, columns = (band["errors"][name]["rms"] for name in ("cube", "columns"))
    assert cube_rms < 0.015
    assert cube_rms < 0.3 * columns
    with xr.open_dataset(cube) as written:
        stated = json.loads(written.attrs["hcss_monte_carlo"])
    assert stated["bands"][band["name"]] == {
        "bias": band["errors"]["cube"]["bias"],
        "rms": cube_rms,
        "noise": band["noise"],
    }
    with pytest.raises(LightError, match="another scenario"):
        write_to_cube(cube, scene(), json.loads(result.read_text()))


def test_the_command_names_the_value_with_which_monte_carlo_computes_a_scene():
    small = {"rows": 8, "columns": 8, "pixel_size": 5.0}
    with pytest.raises(LightError, match=r"sea\.waves: .*; allowed: 'off'"):
        compare(scene("columns", accuracy=0.001, image=small, sea={"waves": "on"}), 1, 100, 0, 1)


def test_the_plan_notes_columns_that_err_by_more_than_the_scene_allows():
    cumulus = {"clouds": {"type": "paper-cumulus", "coverage": 0.45}, "view": {"zenith": 60.0}}
    for allowed, noted in ((0.01, True), (0.9, False)):
        plan = make_plan(scene(**cumulus, radiance={"light": "columns", "light_accuracy": allowed}))
        assert any("radiance.light_accuracy" in note for note in plan.notes) == noted


def test_the_budget_has_the_error_of_the_tier_instead_of_that_of_columns():
    plan = make_plan(scene(clouds={"type": "paper-cumulus", "coverage": 0.45}))
    (cloudy,) = [
        contribution for (of, _), contribution in error_budget(plan).contributions.items() if of == "paper-cumulus"
    ]
    names = {error.name: error.relative for error in cloudy}
    assert "plane-parallel clouds" not in names
    assert 0.0 < names["clouds with sides"] < 0.03


@pytest.mark.parametrize(
    ("band", "zenith", "time", "allowed", "chosen"),
    [
        ([10.5, 11.0], 0.0, NIGHT, 0.01, "columns"),
        ([10.5, 11.0], 60.0, NIGHT, 0.01, "slant"),
        ([3.6, 3.8], 0.0, NIGHT, 0.02, "source"),
        ([3.6, 3.8], 60.0, DAY, 0.12, "source"),
    ],
)
def test_the_plan_chooses_the_cheapest_light_that_is_accurate_enough(band, zenith, time, allowed, chosen):
    """Cumulus: as the table of errors against Monte Carlo says."""
    cumulus = {"clouds": {"type": "paper-cumulus", "coverage": 0.45}, "bands": [band], "view": {"zenith": zenith}}
    plan = make_plan(scene(**cumulus, time=time, radiance={"light_accuracy": allowed}))
    assert plan.light.name == chosen
    largest = max(plan.light.expected_rms.values())
    assert largest <= allowed
    for text in (plan_text(plan), plan_brief(plan, predict(plan), "scene.toml")):
        assert re.search(rf"{chosen}.*expected error .*{100.0 * largest:.2g} %", " ".join(text.split()))
    if chosen == "columns":
        assert any("columns are within radiance.light_accuracy" in note for note in plan.notes)


def test_an_accuracy_that_no_light_has_is_refused_with_the_best():
    with pytest.raises(ScenarioError, match=r"light_accuracy.*allowed: at least .* that of 'source'"):
        make_plan(scene(bands=[[3.6, 3.8]], clouds={"type": "paper-cumulus"}, radiance={"light_accuracy": 0.001}))


def test_scenes_without_an_accuracy_stay_columns():
    assert make_plan(scene(radiance={})).light.name == "columns"
    assert scene(radiance={}).radiance.light == "auto"


def test_monte_carlo_as_a_tier_agrees_with_source_within_its_noise():
    """Thermal light in stratocumulus at 50 deg, where source errs by less than .1 %."""
    image = {"rows": 6, "columns": 5, "pixel_size": 100.0}
    cubes = [simulate(scene(light, image=image)) for light in ("reference", "source")]
    noise = json.loads(cubes[0].attrs["hcss_light"])["expected_rms"]
    assert 1e-4 < max(noise.values()) <= 0.01
    ratio = cubes[0].radiance.values / cubes[1].radiance.values
    assert abs(ratio.mean() - 1.0) < 0.005
    assert ratio.std() < 0.005 + max(noise.values())


def test_monte_carlo_of_large_images_is_refused():
    with pytest.raises(ScenarioError, match="allowed: 4096"):
        make_plan(scene("reference", image={"rows": 65, "columns": 64, "pixel_size": 100.0}))


def test_the_tables_of_the_pages_are_those_of_the_measurements():
    script = Path(__file__).parents[1] / "benchmarks" / "tables.py"
    run = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout


def wide(altitude, pixel_size, **changes):
    image = {"rows": 40, "columns": 70, "pixel_size": pixel_size}
    return scene(view={"zenith": 45.0, "azimuth": 20.0}, platform={"altitude": altitude}, image=image, **changes)


def test_views_that_vary_over_the_image_agree_with_monte_carlo_toward_each_pixel():
    """Six squares of cumulus seen from 150 km; columns are 5 % rms off."""
    given = wide(150e3, 400.0, accuracy=0.005, clouds={"type": "paper-cumulus", "coverage": 0.45})
    plan = make_plan(given)
    assert plan.views.varies
    assert any("constant in squares of 32 pixels" in note for note in plan.notes)
    (band,) = compare(given, 6, 150, 0, 2)["bands"]
    assert abs(band["errors"]["cube"]["bias"]) < 0.01
    assert band["errors"]["cube"]["rms"] < min(0.03, 0.4 * band["errors"]["columns"]["rms"])


def test_views_that_vary_too_much_are_refused_by_name():
    with pytest.raises(ScenarioError, match=r"platform.altitude.*displace lines of sight by .* points"):
        make_plan(wide(100e3, 400.0, accuracy=0.005, clouds={"type": "paper-cumulus", "coverage": 0.45}))
