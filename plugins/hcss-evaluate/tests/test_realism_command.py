"""``hcss evaluate --realism`` on files and folders."""

import json

import netCDF4
import numpy as np
import pytest
from evaluation_images import hcss
from hcss_evaluate.comparison.footage import EvaluationChoice
from hcss_evaluate.realism.files import compare_files
from random_fields import power_law

from hcss_twin import CatalogError, ImageError

AT_3_KM = EvaluationChoice(pixel_size_m=3000.0)


@pytest.fixture
def folders(tmp_path):
    rng = np.random.default_rng(1)
    for name, slope in (("real", -2.8), ("sim", -3.4)):
        (tmp_path / name).mkdir()
        for number in range(3):
            np.save(tmp_path / name / f"{number}.npy", power_law(rng, slope, 192))
    return tmp_path / "real", tmp_path / "sim"


def stacked(path, values, units="K"):
    with netCDF4.Dataset(path, "w") as file:
        for name, size in zip(("block", "time", "y", "x"), values.shape, strict=True):
            file.createDimension(name, size)
        times = file.createVariable("time", "f8", ("time",))
        times.units = "seconds since 2020-09-06"
        times[:] = 900.0 * np.arange(values.shape[1])
        variable = file.createVariable("bt", "f8", ("block", "time", "y", "x"))
        variable.units = units
        variable[:] = values
    return path


def realism_of(real, sim, paired=False, choice=AT_3_KM):
    return compare_files([real], [sim], choice, AT_3_KM, paired=paired, blur_pixels=0.0, seed=0)


def test_the_command_answers_as_a_table_and_as_json(folders, tmp_path):
    pytest.importorskip("sklearn")
    page = tmp_path / "page.html"
    done = hcss("evaluate", "--realism", *folders, "--json", tmp_path / "answer.json", "-o", page)
    assert done.exit_code == 0, done.output
    answer = json.loads((tmp_path / "answer.json").read_text(encoding="utf-8"))
    assert f"{answer['scores'][0]['auc']:.3f}" in done.output
    assert answer["features"][0]["name"] in done.output
    for text in (f"{answer['scores'][0]['auc']:.3f}", answer["features"][0]["name"], "power spectra of both sides"):
        assert text in page.read_text(encoding="utf-8")
    law = next(law for law in answer["laws"] if law["name"] == "dimension of the field")
    for text in (f"{law['real']:.3f}", "1.59 to 1.75"):
        assert text in done.output
        assert text in page.read_text(encoding="utf-8")
    assert law["published"]["low"] == 1.59
    assert answer["scenes"] == [3, 3]
    assert answer["common_scenes"] == 0
    assert "note: 6 of 6 files state no pixel size" in done.output
    assert "Copies: 27 simulated patches searched in all real images" in done.output


def test_a_stack_of_images_has_a_scene_for_each_place_and_pairs_with_files(monkeypatch, folders, tmp_path):
    monkeypatch.setattr("hcss_evaluate.realism.files.compare", lambda *given, **options: (given, options))
    values = 285.0 + np.random.default_rng(2).random((3, 2, 192, 192))
    given, options = realism_of(
        stacked(tmp_path / "stack.nc", values), folders[1], True, EvaluationChoice(variable="bt", pixel_size_m=3000.0)
    )
    np.testing.assert_array_equal(given[0], values.reshape(6, 192, 192))
    assert given[2:] == ([0, 0, 1, 1, 2, 2], [0, 1, 2])
    assert options["real_time_s"] == [0.0, 900.0] * 3
    np.testing.assert_array_equal(given[1][1][::-1], np.load(folders[1] / "1.npy"))


def test_the_radiance_of_a_cube_becomes_its_brightness_temperature_with_times(monkeypatch, cube):
    monkeypatch.setattr("hcss_evaluate.realism.files.compare", lambda *given, **options: (given, options))
    choices = [EvaluationChoice(band="lwir-10.8", variable=name) for name in ("radiance", "brightness_temperature")]
    given, options = compare_files([cube], [cube], *choices, paired=True, blur_pixels=0.0, seed=0)
    np.testing.assert_allclose(given[0], given[1], atol=0.02)
    assert given[2:] == ([0, 0, 0], [0, 0, 0])
    assert options["real_time_s"] == [0.0, 60.0, 120.0]


def test_a_large_image_is_cut_into_scenes_that_no_other_side_has(monkeypatch, tmp_path):
    monkeypatch.setattr("hcss_evaluate.realism.files.compare", lambda *given, **options: given)
    image = np.random.default_rng(3).random((520, 300))
    np.save(tmp_path / "image.npy", image)
    real, simulated, *scenes = realism_of(tmp_path / "image.npy", tmp_path / "image.npy")
    np.testing.assert_array_equal(np.concatenate(real)[::-1], image)  # rows go northward
    assert len(simulated) == 2
    assert scenes == [[0, 1], [2, 3]]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--realism", "--method", "otsu"), "--method: allowed without --realism only"),
        (("--seed", "3"), "--seed: allowed with --realism only"),
        (("--paired",), "--paired: allowed with --realism only"),
    ],
)
def test_options_of_the_other_test_are_refused(folders, options, message):
    done = hcss("evaluate", *folders, *options)
    assert done.exit_code == 2
    assert message in done.output


def test_files_that_cannot_be_compared_are_named(folders, tmp_path):
    real, sim = folders
    (tmp_path / "empty").mkdir()
    with pytest.raises(CatalogError, match=r"SIM: no file in the folder .*empty"):
        realism_of(real, tmp_path / "empty")
    with pytest.raises(ImageError, match="--paired: 3 real and 1 simulated scenes"):
        realism_of(real, sim / "0.npy", True)
    with pytest.raises(ImageError, match="from 2000 to 3000 m, allowed: the same on both sides"):
        compare_files(
            [real],
            [sim],
            EvaluationChoice(pixel_size_m=2000.0),
            EvaluationChoice(pixel_size_m=3000.0),
            paired=False,
            blur_pixels=0.65,
            seed=0,
        )
    wrong = stacked(tmp_path / "wrong.nc", np.ones((2, 1, 64, 64)), "W m-2")
    with pytest.raises(ImageError, match="bt has the unit 'W m-2', allowed: K"):
        realism_of(wrong, sim, choice=EvaluationChoice(variable="bt", pixel_size_m=3000.0))
    np.save(tmp_path / "counts.npy", np.random.default_rng(0).random((64, 64)))
    with pytest.raises(ImageError, match=r"real image 0: values from .* allowed: .* 100 to 400 K$"):
        realism_of(tmp_path / "counts.npy", sim)
    np.save(tmp_path / "counts.npy", np.random.default_rng(0).uniform(2200.0, 3000.0, (64, 64)))
    with pytest.raises(ImageError, match=r"closest is the unit dK: 22.* to 29"):
        realism_of(tmp_path / "counts.npy", sim)
