"""The certificate of whole runs."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from cheap import CHEAP
from click.testing import CliRunner

from hcss_twin import Scenario, make_plan, open_cube, simulate
from hcss_twin.cli.main import cli
from hcss_twin.core.errors import CertificateWarning, CubeError, ScenarioError
from hcss_twin.engine.certificate import reference_columns
from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.engine.certificate.certify import certify
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.stream import stream
from hcss_twin.engine.tables.tensor_train import TensorTrain
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.plan.numerics import reference_level

SMALL = CHEAP | {"bands": ["mwir-3.7", "lwir-10.8"], "image.rows": 40, "image.columns": 50, "frames.count": 3}
NAMES = {"hcss_certificate", "hcss_accuracy_achieved", "hcss_certificate_pixels", "hcss_certificate_strata"}


def cube(name="stratus", **changes):
    return simulate(Scenario.load(name, SMALL | {key.replace("__", "."): each for key, each in changes.items()}))


def found_strata(cube):
    return {each["name"]: each for each in json.loads(cube.attrs["hcss_certificate_strata"])}


def arguments(**changes):
    overrides = SMALL | {key.replace("__", "."): each for key, each in changes.items()}
    return [part for key, value in overrides.items() for part in ("--set", f"{key}={json.dumps(value)}")]


@pytest.fixture
def tampered(monkeypatch):
    """Tables whose radiance of clouds above 400 m is wrong by three times the accuracy, in the second band.

    The error begins smoothly at 120 m: tables are polynomials.
    """

    def wrong(plan):
        tables = compile_tables(plan)
        share = np.clip(np.log(tables.axes[0].exact_m / 120.0) / np.log(400.0 / 120.0), 0.0, 1.0)
        wrong = 3.0 * plan.accuracy.relative * np.concatenate(((0.0,), share**2 * (3.0 - 2.0 * share)))
        changed = []
        for table in tables.tables:
            core = table.columns.cores[0].copy()
            core[1 :: len(plan.bands)] *= (1.0 + wrong)[:, None]
            changed.append(replace(table, columns=TensorTrain((core,))))
        return replace(tables, tables=tuple(changed))

    monkeypatch.setattr("hcss_twin.engine.compile.tables_of", wrong)


def test_a_correct_cube_passes_and_says_what_was_requested_estimated_and_achieved():
    made = cube()
    assert made.attrs["hcss_certificate"].startswith("computed as specified: 24 random pixels")
    achieved = json.loads(made.attrs["hcss_accuracy_achieved"])
    assert set(achieved) == {"mwir-3.7", "lwir-10.8"}
    assert 0 < max(achieved.values()) <= made.attrs["hcss_table_error_estimated"] < 1e-3
    assert made.attrs["hcss_accuracy_requested"] == 1e-3
    assert made.attrs["hcss_certificate_pixels"] == 24
    assert "11.7 %" in made.attrs["hcss_certificate"]
    assert set(found_strata(made)) == {"clear", "thin", "edge", "thick"}
    assert all(each["checked"] >= 1 for each in found_strata(made).values())
    # "computed as specified" stands for the engine; omitted physics and the errors of the models stand beside it
    left, beyond = (json.loads(made.attrs[f"hcss_{name}"]) for name in ("left_out", "beyond_accuracy"))
    assert any("image.samples_per_pixel = 2 or more" in text for text in left)
    assert any("radiance.model = 'physical'" in text for text in left)
    assert any('sea.model = "rough-sea"' in text for text in beyond)
    assert len(beyond) == 1
    assert "NOT WITHIN the requested accuracy because of one omitted effect" in made.attrs["hcss_certificate"]
    for cells in json.loads(made.attrs["hcss_error_budget"]).values():
        assert {band: cell["contributions"][0]["relative"] for band, cell in cells.items()} == achieved
        assert all(
            cell["at_least" if cell["unknown"] else "total"] > 10.0 * achieved[band] for band, cell in cells.items()
        )


@pytest.mark.parametrize("sea_varies", [False, True], ids=["one sea", "texture of the sea"])
def test_the_achieved_error_is_that_of_the_cube_against_the_reference(sea_varies):
    """All pixels are checked, so that it is the largest over the cube itself; the reference has the sea of each."""
    variables = ["radiance", "cloud_thickness", *(["sea_temperature"] if sea_varies else [])]
    changes = {"frames.count": 1, "output.certificate": 63, "output.variables": variables}
    sea = {"sea.temperature_texture": 0.3 if sea_varies else 0.0}
    scenario = Scenario.load("stratus", SMALL | {"image.rows": 7, "image.columns": 9} | changes | sea)
    made, plan = simulate(scenario), make_plan(scenario)
    thickness = np.minimum(made.cloud_thickness.values.ravel().astype(float), plan.layers[0].thickness_max_m)
    # at one level finer, all at once: the certificate adds small differences at fewer wavenumbers
    reference, sun = plan.assembly.at_level(reference_level(plan.assembly)), plan.sun_at(0.0)
    grid = plan.assembly.refined_grid(plan.grid_refinement.refinement + 1)

    def of_sea(warmer_K, thickness_m):
        scene = reference.perturbed(warmer_K, 1.0)
        return SpectralGrid.reference_radiance(scene.model, scene.setting(sun), grid, thickness_m)

    if sea_varies:
        warmer_K = made.sea_temperature.values.ravel().astype(float) - plan.assembly.sea_temperature_K
        exact = np.concatenate([of_sea(*pixel) for pixel in zip(warmer_K, thickness[:, None], strict=True)])
        assert np.abs(exact / of_sea(0.0, thickness) - 1.0).max() > 1e-4
    else:
        exact = of_sea(0.0, thickness)
    error = np.abs(made.radiance.values[0].reshape(2, -1).T / exact - 1.0).max(axis=0)
    achieved = json.loads(made.attrs["hcss_accuracy_achieved"])
    np.testing.assert_allclose(list(achieved.values()), error, rtol=0.15)
    assert made.attrs["hcss_certificate_pixels"] == 63
    assert "at most 0 % of all pixels" in made.attrs["hcss_certificate"]


def test_a_band_whose_finer_grid_has_no_other_wavenumbers_is_certified():
    narrow = {"bands": [{"name": "narrow", "limits": [8.3911, 8.3940]}], "accuracy": 1e-2, "frames.count": 1}
    scenario = Scenario.load("stratus", SMALL | narrow | {"time": "2024-04-20T00:30:00+10:00", "output.certificate": 2})
    plan = make_plan(scenario)
    finer = plan.assembly.refined_grid(plan.grid_refinement.refinement + 1)
    np.testing.assert_array_equal(finer.wavenumber_cm1, plan.spectral_grid.wavenumber_cm1)
    assert simulate(scenario).attrs["hcss_certificate"].startswith("computed as specified")


def test_a_wrong_table_fails_names_the_stratum_and_keeps_the_cube(tampered, tmp_path):
    path = tmp_path / "wrong.nc"
    done = CliRunner().invoke(cli, ["run", "stratus", "-o", str(path), *arguments()])
    assert done.exit_code == 1
    assert re.search(
        r"error: .*wrong.nc: certificate NOT as specified: .* thick \(\d+ of \d+, error up to 0\.00\d+", done.stderr
    )
    assert "in lwir-10.8" in done.stderr
    with open_cube(path) as made:
        text = made.attrs["hcss_certificate"]
        assert text.startswith("NOT as specified: ")
        assert "confidence" not in text
        strata = found_strata(made)
        assert strata["thick"]["exceeding"] >= 1
        assert strata["clear"]["exceeding"] == strata["thin"]["exceeding"] == 0
        assert json.loads(made.attrs["hcss_accuracy_achieved"])["lwir-10.8"] == pytest.approx(3e-3, rel=0.05)
        assert json.loads(made.attrs["hcss_accuracy_achieved"])["mwir-3.7"] < 1e-3


def test_the_python_interface_warns_of_a_failed_certificate_and_returns_the_cube(tampered):
    with pytest.warns(CertificateWarning, match=r"NOT as specified: .*thick"):
        made = cube()
    assert made.attrs["hcss_certificate"].startswith("NOT as specified: ")


def test_the_command_prints_the_certificate_and_answers_in_json(tmp_path):
    told = CliRunner().invoke(cli, ["run", "stratus", "-o", str(tmp_path / "a.nc"), *arguments()])
    assert told.exit_code == 0, told.output
    assert "computed as specified: 24 random pixels" in told.stdout
    assert "0.1 % asked for" in told.stdout
    assert "checked pixels" not in told.stdout
    assert len(told.stdout.splitlines()) <= 8
    whole = CliRunner().invoke(cli, ["run", "stratus", "-o", str(tmp_path / "v.nc"), "--verbose", *arguments()])
    with open_cube(tmp_path / "v.nc") as made:
        lines = made.attrs["hcss_certificate"].split("; ")
    assert len(lines) > 4
    assert all(line in whole.stdout for line in lines)
    answer = CliRunner().invoke(cli, ["run", "stratus", "-o", str(tmp_path / "b.nc"), "--json", *arguments()])
    certificate = json.loads(answer.stdout)["certificate"]
    assert certificate["passed"] is True
    assert certificate["pixels"] == 24
    none = CliRunner().invoke(
        cli, ["run", "stratus", "-o", str(tmp_path / "c.nc"), "--json", *arguments(output__certificate=0)]
    )
    assert json.loads(none.stdout)["certificate"] is None


@pytest.mark.parametrize(("coverage", "expected"), [(0.0, {"clear"}), (1.0, {"thin", "thick"})])
def test_skies_without_cloud_and_full_of_it_pass(coverage, expected):
    made = cube(clouds__coverage=coverage)
    assert set(found_strata(made)) <= expected
    assert made.attrs["hcss_certificate_pixels"] == 24
    assert made.attrs["hcss_certificate"].startswith("computed as specified")


def test_a_scene_without_layers_passes():
    scenario = json.loads(Scenario.load("stratus", SMALL).to_json())
    scenario["clouds"] = {"layers": []}
    made = simulate(Scenario.from_dict(scenario))
    assert set(found_strata(made)) == {"clear"}
    assert made.attrs["hcss_certificate"].startswith("computed as specified")


def test_an_image_of_one_pixel_is_checked_whole():
    made = cube(image__rows=1, image__columns=1)
    assert made.attrs["hcss_certificate_pixels"] == 1
    assert made.attrs["hcss_certificate"].startswith("computed as specified: 1 random pixels")


@pytest.mark.parametrize("variables", [["cloud_mask"], ["truth"]])
def test_a_run_without_radiance_has_no_certificate(variables):
    assert not NAMES & set(cube(output__variables=variables).attrs)


def test_a_cube_of_brightness_temperature_has_one():
    made = cube(output__variables=["brightness_temperature"])
    assert made.attrs["hcss_certificate"].startswith("computed as specified")


def test_0_pixels_are_no_certificate():
    assert not NAMES & set(cube(output__certificate=0).attrs)


@pytest.mark.parametrize("value", [-1, 3001])
def test_other_numbers_of_pixels_are_refused(value):
    with pytest.raises(ScenarioError, match=r"output\.certificate.*3000"):
        cube(output__certificate=value)


def test_pixels_of_several_points_are_the_mean_over_them():
    made = cube(image__samples_per_pixel=2, image__pixel_size=200.0)
    assert made.attrs["hcss_certificate"].startswith("computed as specified: 24 random pixels")
    assert found_strata(made)["edge"]["checked"] >= 1
    assert max(json.loads(made.attrs["hcss_accuracy_achieved"]).values()) < 1e-3


def test_two_layers_have_strata_of_their_own():
    made = cube("cirrus-over-cumulus", output__certificate=60)
    strata = found_strata(made)
    assert made.attrs["hcss_certificate"].startswith("computed as specified: 60 random pixels")
    for choice in ("low only", "high only", "both"):
        assert any(f"({choice})" in name for name in strata)
    assert all(each["checked"] >= 1 for each in strata.values())
    assert len(re.search(r"frames ([0-9, ]+):", made.attrs["hcss_certificate"])[1].split(",")) == 2


def test_single_precision_is_no_error_at_the_finest_accuracy():
    assert (
        cube(accuracy=1e-6, image__rows=12, image__columns=12)
        .attrs["hcss_certificate"]
        .startswith("computed as specified")
    )


def test_clear_pixels_in_the_shadow_of_clouds_are_a_stratum_of_their_own():
    made = cube(
        "cumulus",
        slant__shadows="on",
        clouds__coverage_mode="field",
        image__pixel_size=100.0,
        output__variables=["radiance", "shadow_mask", "cloud_mask"],
        frames__count=1,
    )
    strata, shaded = found_strata(made), int(made.shadow_mask.sum())
    assert shaded > 0
    assert strata["clear in shadow"]["pixels"] == shaded
    assert strata["clear"]["pixels"] + shaded == int((made.cloud_mask == 0).sum())
    assert strata["clear in shadow"]["checked"] >= 3
    assert all(not each["left_out"] for each in strata.values())
    assert "not checked" not in made.attrs["hcss_certificate"]
    assert made.attrs["hcss_certificate"].startswith("computed as specified")


def test_attributes_that_a_cube_has_are_not_given_again(tmp_path):
    from example_cube import example_frame, example_header

    from hcss_twin.cube.writer import CubeWriter

    header = example_header()
    writer = CubeWriter(tmp_path / "cube.nc", header)
    with pytest.raises(CubeError, match="not open"):
        writer.set_attributes({"late": 1})
    with writer:
        for index in range(header.frames):
            writer.write_frame(index, example_frame(header, index))
        writer.set_attributes({"late": "said"})
        for taken in ("late", "title", "hcss_cube_format"):
            with pytest.raises(CubeError, match=f"attribute {taken}: the cube has it already"):
                writer.set_attributes({taken: "again"})
        with pytest.raises(CubeError, match="attribute other: bool"):
            writer.set_attributes({"other": True})
    with open_cube(tmp_path / "cube.nc") as made:
        assert made.attrs["late"] == "said"


def test_terms_that_are_in_the_cube_are_checked_too():
    made = cube(output__variables=["radiance", "terms"])
    terms = json.loads(made.attrs["hcss_certificate_terms"])
    assert set(terms) == {name.removeprefix("radiance_") for name in made.data_vars if name.startswith("radiance_")}
    assert 0.0 < max(terms.values()) < 1e-3
    assert made.attrs["hcss_certificate"].startswith("computed as specified")


def test_a_wrong_term_is_found_though_the_total_is_right(monkeypatch):
    """What one term has too much another has too little."""

    def wrong(plan):
        tables = compile_tables(plan)
        table = tables.tables[0]
        clear = table.clear.copy()
        clear[3] += 3.0 * plan.accuracy.relative * clear[0]
        clear[5] -= 3.0 * plan.accuracy.relative * clear[0]
        return replace(tables, tables=(replace(table, clear=clear), *tables.tables[1:]))

    monkeypatch.setattr("hcss_twin.engine.compile.tables_of", wrong)
    with pytest.warns(CertificateWarning, match="clear"):
        made = cube(output__variables=["radiance", "terms"], frames__count=1)
    assert max(json.loads(made.attrs["hcss_certificate_terms"]).values()) == pytest.approx(3e-3, rel=0.05)
    assert max(json.loads(made.attrs["hcss_accuracy_achieved"]).values()) < 1e-3


def test_what_providers_say_of_their_own_errors_is_quoted_and_not_added():
    plan = make_plan(Scenario.load("stratus", {"image.rows": 16, "image.columns": 16, "bands": ["lwir-10.8"]}))
    own = plan.assembly.own_errors
    assert [each.split(":")[0] for each in own] == ["band model", "sea"]
    told = certify(plan, tables := compile_tables(plan), [])
    assert told.own_errors == own
    assert told.estimated == tables.estimated_error
    assert all(any(each in line for line in told.lines) for each in own)


def test_a_band_that_nothing_lights_is_told():
    dark = cube(bands=["lwir-10.8", [0.72, 0.75]], time="2024-04-20T23:30:00+10:00")
    assert "band '0.72-0.75um' is darker than" in dark.attrs["hcss_certificate"]
    assert "band 'lwir-10.8' is darker" not in dark.attrs["hcss_certificate"]


def test_a_scene_that_is_run_again_is_certified_from_the_same_columns():
    first = cube(seed=4711)
    with pytest.MonkeyPatch.context() as patch:  # of its own: with that of the test, kept columns would not be read
        patch.setattr(reference_columns, "ColumnStates", None)
        again = cube(seed=4711)
        with pytest.raises(AttributeError):
            cube(seed=4712)
    assert again.attrs["hcss_certificate"] == first.attrs["hcss_certificate"]


def test_a_pixel_that_is_no_number_exceeds():
    plan = make_plan(Scenario.load("stratus", SMALL))
    tables, sample = compile_tables(plan), PixelSample(plan)
    for _ in stream(plan, tables, sample):
        pass
    assert certify(plan, tables, sample.frames).passed
    sample.frames[0].radiance[3] = np.nan
    found = certify(plan, tables, sample.frames)
    assert found.exceeding == 1
    assert json.loads(json.dumps(found.as_dict(), allow_nan=False))["achieved"]["mwir-3.7"] is None


def test_kelvin_of_black_pixels_are_refused_before_anything_is_computed():
    every = ["cloud_emission", "cloud_reflected_sun", "sea_emission", "sea_reflected_sun", "path_emission"]
    every += ["reflected_air_emission", "path_scattered_sun"]
    black = {"radiance.model": "physical-two-stream", "radiance.parameters.leave_out": every}
    with pytest.raises(ScenarioError, match=r"'0.5 K': brightness temperature in band 'mwir-3.7' is below 60 K"):
        make_plan(Scenario.load("stratus", SMALL | black | {"accuracy": "0.5 K"}))
