"""Laws of comparing images and cubes."""

from __future__ import annotations

import os
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from evaluation_images import FOUR, clouds, hcss, made, surface
from hcss_evaluate import EvaluationChoice, evaluate
from hcss_evaluate.matching.target import ImageChoice, read_target

from hcss_twin import open_cube
from hcss_twin.models.clouds.imagery.image import PlanckCoefficients


def test_an_image_beside_itself_differs_in_nothing(seviri):
    found = evaluate(seviri, seviri)
    assert all(metric.difference == 0.0 for metric in found.metrics)
    assert {metric.name for metric in found.metrics} >= {
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
    assert any("7.70 % of the pixels are missing" in note for note in found.real.notes)


def test_a_file_beside_a_zarr_store_of_the_same_scene_differs_in_nothing_however_often(cube, tmp_path):
    pytest.importorskip("zarr", reason="the extra 'zarr'")
    store = made(tmp_path / "cube.zarr")
    choice = EvaluationChoice(band="lwir-10.8")
    # A file that had stayed open beside a store ended the process when it was opened the next time.
    for pair in ((cube, store), (store, cube), (cube, cube)):
        found = evaluate(*pair, choice, choice)
        assert all(metric.difference == 0.0 for metric in found.metrics)
        assert found.distance("wasserstein") == found.spectral_distance_db == 0.0
        with open_cube(cube) as dataset:
            assert dataset.sizes["time"] == 3


def test_a_cube_beside_itself_differs_in_nothing_frame_by_frame(cube):
    choice = EvaluationChoice(band="lwir-10.8")
    found = evaluate(cube, cube, choice, choice)
    assert found.pairing == "3 real frames with 3 simulated ones, one by one"
    assert all(metric.difference == 0.0 for metric in found.metrics)
    assert [frame.rmse for frame in found.errors["corrected"]] == [0.0] * 3
    assert all(distribution.wasserstein == 0.0 for distribution in found.distributions)


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
    image = save("s.npy", surface(4, hurst, 256))
    found = evaluate(image, image)
    # The surface is exact at large distances only; hcss_twin tests its estimators on exact ones.
    for name in ("variogram", "spectrum", "boxes", "tops"):
        assert found.metric(name).real == pytest.approx(3.0 - hurst, abs=0.25)


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
    assert any("they are clear" in note for note in found.real.notes)
    assert not any("missing" in note for note in found.real.notes if "clear" not in note)


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
    assert any("it holds 10.35 um" in note for note in found.sim.notes)
    other = evaluate(path, cube, EvaluationChoice(variable="CMI"), EvaluationChoice(band="mwir"))
    assert any("The bands differ" in note for note in other.notes)


def test_shapes_and_pixel_sizes_that_differ_are_told_and_nothing_is_resampled(save):
    small, large = save("small.npy", clouds(1, size=96)), save("large.npy", clouds(2, size=128))
    sizes = EvaluationChoice(pixel_size_m=1000.0), EvaluationChoice(pixel_size_m=2000.0)
    found = evaluate(small, large, *sizes)
    assert found.real.part == found.sim.part == (96, 96)
    np.testing.assert_array_equal(found.sim.pictured.values > 0, found.sim.pictured.level > 0)
    assert any("central 96 rows x 96 columns" in note for note in found.notes)
    assert any("Pixels differ, 1000 m and 2000 m" in note for note in found.notes)
    assert not found.metric("FD").comparable
    assert found.metric("coverage").comparable
    whole = evaluate(small, large, sizes[0], sizes[0], whole=True)
    assert whole.sim.part == (128, 128)
    assert whole.metric("FD").comparable
    assert not whole.metric("DP").comparable
    assert any("is not known" in note for note in evaluate(small, small).notes)


@pytest.mark.long
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
    beyond = [metric for metric in surfaces if metric.sim < 2.0 or metric.sim > 3.0]
    assert beyond
    assert done.output.count("(out of range 2 to 3)") == len(beyond)
    words = page.read_text(encoding="utf-8")
    assert words.count("(out of range 2 to 3)") == len(beyond)
    assert all(2.0 <= metric.real <= 3.0 for metric in surfaces)


def test_the_grey_levels_of_files_without_a_common_unit_are_said_to_be_that(save, cube):
    found = evaluate(save("a.npy", clouds(1)), cube, None, EvaluationChoice(band="mwir"))
    assert found.quantity == "grey level of cloud"
    assert found.unit == ""
    assert any(note.startswith("No common quantity") for note in found.notes)


def test_the_truth_mask_is_that_of_the_cube(cube):
    with open_cube(cube) as dataset:
        share = float(dataset["cloud_mask"].isel(time=1).mean())
    choice = EvaluationChoice(band="lwir-10.8", method="truth", frames=(1,))
    found = evaluate(cube, cube, choice, choice)
    assert found.metric("coverage").sim == pytest.approx(share) == found.metric("coverage, truth").real


@pytest.mark.long
def test_a_goes_radiance_becomes_temperature_and_finds_its_band(cube):
    folder = os.environ.get("HCSS_SAMPLE_DATA")
    goes = next(Path(folder).glob("images/OR_ABI-L1b-RadC-M3C08*.nc"), None) if folder else None
    if goes is None:
        pytest.skip("HCSS_SAMPLE_DATA names no folder with images/OR_ABI-L1b-RadC-M3C08*.nc")
    found = evaluate(goes, cube, EvaluationChoice(variable="Rad"), EvaluationChoice(band="lwir-10.8"))
    assert found.unit == "K"
    # Water vapour of the upper troposphere at 6.2 um.
    assert 225.0 < found.metric("mean").real < 255.0
    assert found.real.part == (64, 80)
    assert any("The bands differ" in note for note in found.notes)
