"""Images, cubes and choices that cannot be compared."""

from __future__ import annotations

import netCDF4
import numpy as np
import pytest
from evaluation_images import clouds
from hcss_evaluate import EvaluationChoice, evaluate

from hcss_twin import HcssError, ImageError


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
        ("text.nc", "it is not a NetCDF file, or its header is damaged"),
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
    assert any("is excluded: no pixel is cloudy" in note for note in found.sim.notes)
    assert "the mean of 3 real ones" in found.pairing


@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_a_band_in_which_clouds_are_invisible_is_refused_in_plain_words(cube, tmp_path, noise):
    # Where the air above the clouds is opaque, no more is left than the error of the radiance tables.
    path = tmp_path / "opaque.nc"
    path.write_bytes(cube.read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        values = file["radiance"][:, 1]
        file["radiance"][:, 1] = values.mean()
        file["radiance"][:, 1, 0, :9] = (1.0 + noise) * values.mean()
    choice = EvaluationChoice(variable="radiance", band="lwir-10.8")
    for pair, side in (((path, cube), "real"), ((cube, path), "sim")):
        with pytest.raises(ImageError) as error:
            evaluate(*pair, choice, choice)
        message = str(error.value)
        assert "opaque.nc" in message
        assert "no pixel differs from clear sea by more than" in message
        assert f"choose another band (--{side}-band) or variable (--{side}-variable)" in message


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        (EvaluationChoice(band="lwir-10.3"), "no such band; allowed: lwir-10.8, mwir; closest is 'lwir-10.8'"),
        (EvaluationChoice(), "2 bands; choose one, as --sim-band mwir; allowed: lwir-10.8, mwir"),
        (EvaluationChoice(band="mwir", frames=(7,)), "the cube has 0 to 2; closest is 2"),
        (EvaluationChoice(band="mwir", variable="radiancee"), "closest is 'radiance'"),
        (EvaluationChoice(band="mwir", method="coverage"), "coverage: needed with the method"),
        (EvaluationChoice(band="mwir", window_pixels=5), "window_pixels (--window): allowed with the method 'local'"),
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
        (EvaluationChoice(band="mwir"), "band: applies to cubes only"),
        (EvaluationChoice(frames=(1,)), "frames: applies to cubes only"),
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
