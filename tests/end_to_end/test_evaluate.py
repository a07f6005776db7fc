"""hcss evaluate: laws of comparing images and cubes, bad input, and what the command writes."""

from __future__ import annotations

import json
import os
from html.parser import HTMLParser
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from cheap import CHEAP_OPTIONS
from click.testing import CliRunner

from hcss_twin import EvaluationChoice, HcssError, ImageError, evaluate, open_cube
from hcss_twin.cli import cli
from hcss_twin.clouds.imagery.goes_temperature import PlanckCoefficients
from hcss_twin.evaluation.fractional_brownian_surface import fractional_brownian_surface
from hcss_twin.matching.target import ImageChoice, read_target

FOUR = ("EV", "Den, printed", "Den", "DP, printed", "DP", "FD")


def hcss(*arguments, catch=False):
    return CliRunner().invoke(cli, [str(argument) for argument in arguments], catch_exceptions=catch)


def clouds(seed, hurst=0.6, size=128):
    """Grey levels of a fractal cloud field: half clear."""
    surface = fractional_brownian_surface(size, hurst, seed)
    return np.clip(surface - np.median(surface), 0.0, None)


@pytest.fixture
def save(tmp_path):
    def save(name, values):
        np.save(tmp_path / name, values)
        return tmp_path / name

    return save


def made(path):
    """Three frames in two bands with temperatures and masks."""
    options = {
        "image.rows": 64, "image.columns": 80, "image.pixel_size": 100, "frames.count": 3, "frames.interval": 60,
        "bands": '["mwir","lwir-10.8"]', "clouds.coverage": 0.4, "motion.platform_speed": 0, "output.certificate": 0,
        "output.variables": '["radiance","brightness_temperature","cloud_mask"]',
    }  # fmt: skip
    words = [word for key, value in options.items() for word in ("--set", f"{key}={value}")]
    done = hcss("run", "cumulus", *words, *CHEAP_OPTIONS, "-o", path)
    assert done.exit_code == 0, done.output
    return path


@pytest.fixture(scope="module")
def cube(tmp_path_factory):
    return made(tmp_path_factory.mktemp("cube") / "cube.nc")


@pytest.fixture(scope="module")
def seviri():
    sample = pytest.importorskip("iris_sample_data")
    return Path(sample.path) / "toa_brightness_stereographic.nc"


# --- laws


def test_an_image_beside_itself_differs_in_nothing(seviri):
    found = evaluate(seviri, seviri)
    assert all(each.difference == 0.0 for each in found.metrics)
    assert {each.name for each in found.metrics} >= {
        *FOUR,
        "coverage",
        "tops",
        "outline",
        "spectrum",
        "boxes",
        "aspect",
    }
    assert found.rmse("as-printed") == found.rmse("corrected") == found.spectral_distance_db == 0.0
    assert found.distance("wasserstein") == found.distance("kolmogorov_smirnov") == 0.0
    assert (found.quantity, found.unit) == ("brightness temperature", "K")
    assert any("7.70 % of the pixels are missing" in each for each in found.real.notes)


def test_a_file_beside_a_zarr_store_of_the_same_scene_differs_in_nothing_however_often(cube, tmp_path):
    pytest.importorskip("zarr", reason="the extra 'zarr'")
    store = made(tmp_path / "cube.zarr")
    choice = EvaluationChoice(band="lwir-10.8")
    # A file that had stayed open beside a store ended the process when it was opened the next time.
    for pair in ((cube, store), (store, cube), (cube, cube)):
        found = evaluate(*pair, choice, choice)
        assert all(each.difference == 0.0 for each in found.metrics)
        assert found.distance("wasserstein") == found.spectral_distance_db == 0.0
        with open_cube(cube) as dataset:
            assert dataset.sizes["time"] == 3


def test_a_cube_beside_itself_differs_in_nothing_frame_by_frame(cube):
    choice = EvaluationChoice(band="lwir-10.8")
    found = evaluate(cube, cube, choice, choice)
    assert found.pairing == "3 real frames with 3 simulated ones, one by one"
    assert all(each.difference == 0.0 for each in found.metrics)
    assert [each.rmse for each in found.errors["corrected"]] == [0.0] * 3
    assert all(each.wasserstein == 0.0 for each in found.distributions)


def test_turned_clouds_exchange_their_axes_and_keep_their_values(save):
    image = np.repeat(clouds(3, size=192)[:96], 2, axis=0)[:128, :128]
    found = evaluate(save("a.npy", image), save("b.npy", image.T.copy()))
    for name in ("semivariance", "aspect"):
        metric = found.metric(name)
        assert metric.real * metric.sim == pytest.approx(1.0, rel=1e-6)
        assert abs(metric.real - 1.0) > 0.1
    assert found.metric("degree").difference == pytest.approx(0.0, abs=1e-9)
    assert found.metric("long axis").real + found.metric("long axis").sim in (
        pytest.approx(90.0, abs=1e-4),
        pytest.approx(270.0, abs=1e-4),
    )
    assert found.metric("FD").difference == pytest.approx(0.0, abs=1e-9)
    assert found.distance("wasserstein") == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("hurst", [0.3, 0.7])
def test_every_estimator_finds_the_known_dimension_of_a_surface(save, hurst):
    image = save("s.npy", fractional_brownian_surface(256, hurst, 4))
    found = evaluate(image, image)
    # Spreads of single surfaces of this size are in docs/fractal-dimension.md.
    for name, tolerance in (("variogram", 0.05), ("spectrum", 0.2), ("boxes", 0.1), ("tops", 0.1)):
        assert found.metric(name).real == pytest.approx(3.0 - hurst, abs=tolerance)


def test_the_measures_are_those_that_hcss_match_takes(save):
    image = 30.0 + clouds(1) + np.random.default_rng(0).normal(0.0, 0.01, (128, 128))
    path = save("a.npy", image)
    target = read_target(path, ImageChoice(pixel_size_m=1000.0)).image
    found = evaluate(path, path).real.frames[0].measures
    for name, value in vars(target.morphology()).items():
        assert getattr(found.morphology, name) == pytest.approx(value, rel=1e-6), name
    assert found.mean_level == pytest.approx(target.mean_level, rel=1e-6)


def test_pixels_without_cloud_top_are_clear_as_hcss_match_has_them(tmp_path):
    path = tmp_path / "tops.nc"
    heights = clouds(1)
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("y", 128)
        file.createDimension("x", 128)
        variable = file.createVariable("HT", "f8", ("y", "x"), fill_value=-1.0)
        variable.setncatts({"units": "m", "long_name": "Cloud Top Height"})
        variable[:] = np.where(heights > 0.0, 1000.0 * heights, -1.0)
    target = read_target(path, ImageChoice(pixel_size_m=1000.0)).image
    found = evaluate(path, path)
    assert (found.real.method, found.unit) == ("valid", "m")
    for name, value in vars(target.morphology()).items():
        assert getattr(found.real.frames[0].measures.morphology, name) == pytest.approx(value, rel=1e-6), name
    assert found.metric("coverage").real == pytest.approx(np.mean(heights > 0.0))
    assert any("they are clear" in each for each in found.real.notes)
    assert not any("missing" in each for each in found.real.notes if "clear" not in each)


def test_radiance_becomes_the_temperature_that_the_cube_itself_has(cube):
    for band in ("mwir", "lwir-10.8"):
        found = evaluate(
            cube,
            cube,
            EvaluationChoice(band=band, variable="brightness_temperature"),
            EvaluationChoice(band=band, variable="radiance"),
        )
        assert found.unit == "K"
        # The cube's own spectral grid is finer in the absorption bands; a black body hardly feels that.
        assert found.distance("wasserstein") < 0.01
        assert abs(found.metric("deviation").relative) < 1e-3


def test_goes_coefficients_invert_the_planck_function_they_are_made_of():
    # Band 8 of GOES-16.
    found = PlanckCoefficients(50687.1, 2331.58, 1.55228, 0.99667)
    kelvin = np.array([200.0, 240.0, 280.0])
    radiance = 50687.1 / (np.exp(2331.58 / (1.55228 + 0.99667 * kelvin)) - 1.0)
    np.testing.assert_allclose(found.kelvin(radiance), kelvin, rtol=1e-12)
    assert np.isnan(found.kelvin(np.array([0.0, -1.0, np.nan]))).all()


def test_a_real_sequence_has_times_and_a_simulated_one_its_own_correlation(cube, tmp_path):
    paths = []
    for number, shift in enumerate((0, 3, 6)):
        path = tmp_path / f"{number}.nc"
        with netCDF4.Dataset(path, "w") as file:
            file.time_coverage_start = f"2024-04-20T12:0{number}:00Z"
            file.createDimension("y", 64)
            file.createDimension("x", 80)
            variable = file.createVariable("T", "f8", ("y", "x"))
            variable.units = "K"
            variable[:] = 290.0 - np.roll(clouds(5), shift, axis=1)[:64, :80]
        paths.append(path)
    found = evaluate(paths, cube, None, EvaluationChoice(band="lwir-10.8"))
    assert found.real.kind == "images"
    np.testing.assert_allclose(found.real.temporal.lag_s, [0.0, 60.0, 120.0])
    assert 1.0 > found.real.temporal.correlation[1] > found.real.temporal.correlation[2]
    assert found.sim.temporal is not None
    assert found.pairing.startswith("3 real frames with 3")
    alone = evaluate(paths[0], cube, None, EvaluationChoice(band="lwir-10.8"))
    assert "change over time is not known" in alone.pairing
    assert alone.real.temporal is None
    assert len(alone.errors["as-printed"]) == 3
    uneven = evaluate(paths[:2], cube, None, EvaluationChoice(band="lwir-10.8"))
    assert "the mean of 2 real ones" in uneven.pairing


def test_the_band_of_the_real_image_is_chosen(cube, tmp_path):
    path = tmp_path / "goes.nc"
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("y", 64)
        file.createDimension("x", 80)
        variable = file.createVariable("CMI", "f8", ("y", "x"))
        variable.units = "K"
        variable[:] = 290.0 - clouds(5)[:64, :80]
        for name, value in (("band_id", 13), ("band_wavelength", 10.35)):
            scalar = file.createVariable(name, "f8")
            scalar[...] = value
            scalar.units = "um" if name == "band_wavelength" else "1"
    found = evaluate(path, cube, EvaluationChoice(variable="CMI"))
    assert found.sim.band.startswith("lwir-10.8")
    assert any("it holds 10.35 um" in each for each in found.sim.notes)
    other = evaluate(path, cube, EvaluationChoice(variable="CMI"), EvaluationChoice(band="mwir"))
    assert any("The bands differ" in each for each in other.notes)


def test_shapes_and_pixel_sizes_that_differ_are_told_and_nothing_is_resampled(save):
    small, large = save("small.npy", clouds(1, size=96)), save("large.npy", clouds(2, size=128))
    sizes = EvaluationChoice(pixel_size_m=1000.0), EvaluationChoice(pixel_size_m=2000.0)
    found = evaluate(small, large, *sizes)
    assert found.real.part == found.sim.part == (96, 96)
    np.testing.assert_array_equal(found.sim.pictured.values > 0, found.sim.pictured.level > 0)
    assert any("central 96 rows x 96 columns" in each for each in found.notes)
    assert any("Pixels differ, 1000 m and 2000 m" in each for each in found.notes)
    assert not found.metric("FD").comparable
    assert found.metric("coverage").comparable
    whole = evaluate(small, large, sizes[0], sizes[0], whole=True)
    assert whole.sim.part == (128, 128)
    assert whole.metric("FD").comparable
    assert not whole.metric("DP").comparable
    assert any("is not known" in each for each in evaluate(small, small).notes)


@pytest.mark.parametrize(("size", "is_marked"), [("1 km", False), ("2 km", True)])
def test_the_rmse_is_marked_on_screen_and_page_where_its_terms_are(save, tmp_path, size, is_marked):
    page = tmp_path / "report.html"
    sizes = ("--real-pixel-size", "1 km", "--sim-pixel-size", size)
    done = hcss("evaluate", save("a.npy", clouds(1)), save("b.npy", clouds(2)), *sizes, "-o", page)
    assert done.exit_code == 0, done.output
    for name in ("EV", "as-printed", "corrected"):
        assert (f"\n  {name} ~ " in done.output) is is_marked
    words = page.read_text(encoding="utf-8").partition("Pictures</h2>")[0]
    for name in ("EV", "Den", "DP", "FD", "RMSE"):
        assert words.count(f">{name} ~<") == (2 if is_marked else 0)
    assert ("~ depends on the size" in words) is is_marked


def test_a_dimension_that_no_surface_can_have_is_marked_on_its_side_on_screen_and_page(save, tmp_path):
    page = tmp_path / "report.html"
    # Anticorrelated neighbours: rougher than any surface.
    noise = np.random.default_rng(1).random((128, 128))
    rough = noise - 0.3 * (np.roll(noise, 1, axis=0) + np.roll(noise, 1, axis=1))
    done = hcss("evaluate", save("a.npy", clouds(1)), save("b.npy", rough), "-o", page)
    assert done.exit_code == 0, done.output
    found = evaluate(tmp_path / "a.npy", tmp_path / "b.npy")
    surfaces = [found.metric(name) for name in ("tops", "variogram", "spectrum", "boxes", "boxes, raw")]
    beyond = [each for each in surfaces if each.sim < 2.0 or each.sim > 3.0]
    assert beyond
    assert done.output.count("out of range, 2 to 3: simulated") == len(beyond)
    words = page.read_text(encoding="utf-8")
    assert words.count("(out of range)") == len(beyond)
    assert all(2.0 <= each.real <= 3.0 for each in surfaces)


def test_the_grey_levels_of_files_without_a_common_unit_are_said_to_be_that(save, cube):
    found = evaluate(save("a.npy", clouds(1)), cube, None, EvaluationChoice(band="mwir"))
    assert found.quantity == "grey level of cloud"
    assert found.unit == ""
    assert any(each.startswith("No common quantity") for each in found.notes)


def test_the_truth_mask_is_that_of_the_cube(cube):
    with open_cube(cube) as dataset:
        share = float(dataset["cloud_mask"].isel(time=1).mean())
    choice = EvaluationChoice(band="lwir-10.8", method="truth", frames=(1,))
    found = evaluate(cube, cube, choice, choice)
    assert found.metric("coverage").sim == pytest.approx(share) == found.metric("coverage, truth").real


# --- bad input


def bad(tmp_path):
    flat, rng = np.full((64, 64), 5.0), np.random.default_rng(0)
    np.save(tmp_path / "constant.npy", flat)
    np.save(tmp_path / "nan.npy", np.full((64, 64), np.nan))
    np.save(tmp_path / "tiny.npy", rng.random((5, 5)))
    np.save(tmp_path / "cubic.npy", rng.random((4, 64, 64)))
    few = flat.copy()
    few[3, 3] = 9.0
    np.save(tmp_path / "one-cloud.npy", few)
    (tmp_path / "text.nc").write_text("no image", encoding="utf-8")
    gaps = clouds(1)
    gaps[rng.random(gaps.shape) < 0.2] = np.nan
    np.save(tmp_path / "gaps.npy", gaps)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("constant.npy", "all pixels have the value 5"),
        ("nan.npy", "all 4096 pixels are missing"),
        ("tiny.npy", "5 rows x 5 columns, allowed: 32 or more"),
        ("cubic.npy", "allowed: real numbers, (rows, columns)"),
        ("one-cloud.npy", "all cloudy pixels are"),
        ("text.nc", "it is no NetCDF file, or its beginning is damaged"),
        ("gaps.npy", "largest part without missing pixels"),
        ("nowhere.npy", "no image"),
    ],
)
def test_images_that_cannot_be_judged_are_refused_on_either_side(tmp_path, save, name, message):
    good = save("good.npy", clouds(2))
    bad(tmp_path)
    for pair in ((tmp_path / name, good), (good, tmp_path / name)):
        with pytest.raises(HcssError) as error:
            evaluate(*pair)
        assert message in str(error.value)


def test_no_cloud_is_refused_and_nothing_but_cloud_has_no_outline(cube, tmp_path):
    paths = {}
    for name, mask in (("clear", 0), ("cloudy", 1)):
        paths[name] = tmp_path / f"{name}.nc"
        paths[name].write_bytes(cube.read_bytes())
        with netCDF4.Dataset(paths[name], "a") as file:
            file["cloud_mask"][:] = mask
    choice = EvaluationChoice(band="lwir-10.8", method="truth")
    with pytest.raises(ImageError, match=r"SIM clear.nc, frame .*: no pixel is cloudy by the method 'truth'"):
        evaluate(cube, paths["clear"], choice, choice)
    found = evaluate(cube, paths["cloudy"], choice, choice)
    assert found.metric("coverage").sim == 1.0
    assert np.isnan(found.metric("outline").sim)


def test_frames_without_cloud_are_left_out_and_told(cube, tmp_path):
    path = tmp_path / "some.nc"
    path.write_bytes(cube.read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        file["cloud_mask"][1] = 0
    choice = EvaluationChoice(band="lwir-10.8", method="truth")
    found = evaluate(cube, path, choice, choice)
    assert len(found.sim.frames) == 2
    assert len(found.sim.left_out) == 1
    assert found.sim.temporal is None
    assert any("left out: no pixel is cloudy" in each for each in found.sim.notes)
    assert "the mean of 3 real ones" in found.pairing


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        (
            EvaluationChoice(band="lwir-10.3"),
            "no such band; allowed: lwir-10.8, mwir; closest is 'lwir-10.8'",
        ),
        (EvaluationChoice(), "2 bands; choose one, as --sim-band mwir; allowed: lwir-10.8, mwir"),
        (EvaluationChoice(band="mwir", frames=(7,)), "the cube has 0 to 2; closest is 2"),
        (EvaluationChoice(band="mwir", variable="radiancee"), "closest is 'radiance'"),
        (EvaluationChoice(band="mwir", method="coverage"), "coverage: goes with the method"),
        (EvaluationChoice(band="mwir", window_pixels=5), "window_pixels: goes with the method 'local'"),
        (EvaluationChoice(band="mwir", method="coverage", coverage=0.0), "greater than 0"),
        (EvaluationChoice(variable="cloud_mask", band="mwir"), "the same for all bands"),
    ],
)
def test_choices_that_do_not_fit_a_cube_are_refused(cube, save, choice, message):
    with pytest.raises(HcssError) as error:
        evaluate(save("good.npy", clouds(2)), cube, None, choice)
    assert message in str(error.value)


def test_a_band_that_is_missing_is_asked_for_by_the_option_of_its_side(cube, save):
    with pytest.raises(HcssError, match="2 bands; choose one, as --real-band mwir"):
        evaluate(cube, save("good.npy", clouds(2)))


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        (EvaluationChoice(band="mwir"), "band: has a meaning for cubes only"),
        (EvaluationChoice(frames=(1,)), "frames: has a meaning for cubes only"),
        (EvaluationChoice(method="truth"), "is an image and has no mask"),
        (EvaluationChoice(variable="x"), "a single array has no variable"),
    ],
)
def test_choices_that_do_not_fit_an_image_are_refused(save, choice, message):
    good = save("good.npy", clouds(2))
    with pytest.raises(HcssError, match=message):
        evaluate(good, good, choice)


def test_sequences_of_unlike_images_are_refused(save, cube, tmp_path):
    one, other = save("a.npy", clouds(1)), save("b.npy", clouds(1, size=96))
    with pytest.raises(ImageError, match=r"b.npy: shape \(96, 96\), while a.npy has \(128, 128\)"):
        evaluate([one, other], one)
    with pytest.raises(ImageError, match="is a cube; allowed: one cube, or several images"):
        evaluate([one, cube], one)
    with pytest.raises(ImageError, match="REAL: no file given"):
        evaluate([], one)
    with pytest.raises(HcssError, match="is a folder"):
        evaluate(tmp_path, one)


# --- the command


class Addresses(HTMLParser):
    """What a page asks for, and its words."""

    def __init__(self):
        super().__init__()
        self.addresses, self.alternatives, self.text = [], [], ""

    def handle_starttag(self, tag, attrs):
        self.addresses += [value for name, value in attrs if name in ("src", "href")]
        self.alternatives += [value for name, value in attrs if name == "alt"]

    def handle_data(self, data):
        self.text += data


def test_the_command_writes_a_table_a_page_and_json_that_agree(cube, seviri, tmp_path):
    page, numbers = tmp_path / "report.html", tmp_path / "numbers.json"
    arguments = ("evaluate", seviri, cube, "--sim-band", "lwir-10.8", "--sim-frames", "0-1")
    done = hcss(*arguments, "-o", page, "--json", numbers)
    assert done.exit_code == 0, done.output
    told = json.loads(numbers.read_text(encoding="utf-8"))
    rmse = f"{100 * told['eq24']['as-printed']['RMSE']:.2f} %"
    assert f"as-printed ~   {rmse}, relative to the simulated values" in done.output
    assert {each["name"] for each in told["metrics"]} >= {*FOUR, "coverage", "degree", "long axis", "mean"}
    assert set(told["definitions"]) == {"EV", "Den", "DP", "FD", "RMSE"}
    assert told["unit"] == "K"
    assert len(told["sim"]["frames"]) == 2
    assert sum(told["real"]["histogram"]) == pytest.approx(1.0)
    assert len(told["histogram_edges"]) == len(told["sim"]["histogram"]) + 1
    found = Addresses()
    found.feed(page.read_text(encoding="utf-8"))
    assert all(address.startswith(("data:", "#")) for address in found.addresses)
    assert rmse in found.text
    for word in ("two-dimensional histogram", "power spectra", "direction", "correlation", "grey levels"):
        assert any(word in each for each in found.alternatives), word
    again = hcss(*arguments, "-o", page)
    assert again.exit_code == 1
    assert "exists; give another name, or --force" in again.output


def test_json_to_the_screen_is_all_that_is_written_there(save):
    path = save("a.npy", clouds(1))
    done = hcss("evaluate", path, path, "--json", "-")
    assert json.loads(done.output)["eq24"]["corrected"]["RMSE"] == 0.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--coverage", "0.5"], "--coverage goes with method coverage, and only with it"),
        (["--window", "9"], "--window goes with method local, and only with it"),
        (["--sim-frames", "3-1"], "'3-1' given, allowed: numbers and ranges"),
        (["-o", "x.html", "--json", "x.html"], "are both x.html"),
        (["-o", "nowhere/x.html"], "there is no folder"),
    ],
)
def test_command_lines_that_contradict_themselves_are_refused(save, options, message):
    path = save("a.npy", clouds(1))
    done = hcss("evaluate", path, path, *options)
    assert done.exit_code != 0
    assert message in done.output


def test_what_one_side_needs_is_not_asked_of_the_other(save, cube):
    path = save("a.npy", clouds(1))
    done = hcss(
        "evaluate", path, cube, "--real-method", "coverage", "--coverage", "0.25", "--sim-method", "truth",
        "--sim-band", "mwir", "--json", "-",
    )  # fmt: skip
    told = json.loads(done.output)
    assert (told["real"]["method"], told["sim"]["method"]) == ("coverage", "truth")
    assert told["real"]["frames"][0]["coverage"] > 0.0


def test_a_failed_evaluation_leaves_no_file(save, tmp_path):
    np.save(tmp_path / "constant.npy", np.ones((64, 64)))
    done = hcss(
        "evaluate", save("a.npy", clouds(1)), tmp_path / "constant.npy", "-o", tmp_path / "r.html",
        "--json", tmp_path / "r.json", catch=True,
    )  # fmt: skip
    assert isinstance(done.exception, HcssError)
    assert not list(tmp_path.glob("*.html"))
    assert not list(tmp_path.glob("*.json"))


@pytest.mark.long
def test_a_goes_radiance_becomes_temperature_and_finds_its_band(cube):
    folder = os.environ.get("HCSS_SAMPLE_DATA")
    files = sorted(Path(folder).glob("OR_ABI-L1b-RadC-M3C08*.nc")) if folder else []
    if not files:
        pytest.skip("HCSS_SAMPLE_DATA names no folder with a GOES L1b file")
    found = evaluate(files[0], cube, EvaluationChoice(variable="Rad"), EvaluationChoice(band="lwir-10.8"))
    assert found.unit == "K"
    # Water vapour of the upper troposphere at 6.2 um.
    assert 225.0 < found.metric("mean").real < 255.0
    assert found.real.part == (64, 80)
    assert any("The bands differ" in each for each in found.notes)
