"""hcss match: an image, or a range of the fractal dimension, becomes clouds that a scenario can run."""

from __future__ import annotations

import json
import tomllib

import numpy as np
import pytest
from cheap import CHEAP
from command import hcss
from hcss_evaluate.matching.dimension_range import empty_frame
from hcss_evaluate.matching.search import reference_cells
from hcss_evaluate.matching.structure import simulate_image
from sample_data import sample_file

from hcss_twin import Scenario, simulate
from hcss_twin.core.errors import HcssError
from hcss_twin.models.clouds.fractal.parameters import FractalParameters

SCENE = """time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
image = {rows = 96, columns = 128, pixel_size = 500.0}
frames = {count = 1}
bands = ["lwir-10.8"]
output = {variables = ["radiance", "truth"]}

"""


@pytest.fixture(scope="module")
def level():
    like = empty_frame(96, 128, 500.0)
    parameters = FractalParameters(gamma=2.0, H=0.5, L=reference_cells(np.array([8.0, 6.0]), like), k=(0, 4))
    return simulate_image(parameters, 0.4, like, 3).level[::-1]


@pytest.fixture
def working_folder(level, tmp_path, monkeypatch):
    """A folder with an image of fractal clouds, dark sea below them, in which the commands run."""
    monkeypatch.chdir(tmp_path)
    np.save("clouds.npy", level)
    return tmp_path


def test_fragment_ends_a_scenario_that_runs_with_the_coverage_of_the_image(working_folder):
    done = hcss(
        "match", "clouds.npy", "--pixel-size", "500 m", "--budget", 4, "--preview", "both.png",
        "--method", "coverage", "--coverage", 0.4,
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    assert "96 rows x 128 columns of 500 m: the whole image." in done.output
    assert "RMSE (eq 24)" in done.output
    assert (working_folder / "both.png").read_bytes().startswith(b"\x89PNG")
    text = (working_folder / "clouds-clouds.toml").read_text(encoding="utf-8")
    assert all(len(line) <= 110 for line in text.splitlines())
    (working_folder / "scene.toml").write_text(SCENE + text, encoding="utf-8")
    with simulate(Scenario.load("scene.toml", CHEAP), "cube.nc") as cube:
        cloudy = cube["cloud_thickness"].isel(time=0).values > 0.0
    fragment = tomllib.loads(text)["clouds"]
    assert np.count_nonzero(cloudy) == round(fragment["coverage"] * cloudy.size)
    assert FractalParameters(**fragment["parameters"]).k is not None
    # The cube is matched by its own mask; a threshold of its thickness leaves thin cloud out.
    answer, other = (
        json.loads(hcss("match", "cube.nc", *options, "--budget", 0, "-o", name, "--json").output)
        for name, *options in (("a.toml",), ("b.toml", "--variable", "cloud_thickness", "--method", "otsu"))
    )
    assert answer["coverage"] == np.mean(cloudy) > other["coverage"] + 0.05
    assert "where its cloud_mask is 1, with grey levels from its cloud_thickness" in answer["notes"][1]
    with pytest.raises(HcssError, match="cloud_is: has no meaning for a cube"):
        hcss("match", "cube.nc", "--cloud-is", "dark", "-o", "c.toml")


def test_same_seed_writes_the_same_fragment_and_the_answer_is_json(working_folder):
    options = ("--pixel-size", 500, "--budget", 2, "--json")
    answers = [json.loads(hcss("match", "clouds.npy", "-o", name, *options).output) for name in ("a.toml", "b.toml")]
    assert (working_folder / "a.toml").read_bytes() == (working_folder / "b.toml").read_bytes()
    other = json.loads(hcss("match", "clouds.npy", "-o", "c.toml", "--seed", 50, *options).output)
    assert answers[0]["rmse"] == answers[1]["rmse"] != other["rmse"]
    names = [quantity["name"] for quantity in answers[0]["quantities"]]
    assert {"EV", "Den", "DP", "FD", "coverage", "anisotropy"} <= set(names)
    assert answers[0]["mean_rmse"] == pytest.approx(np.mean(answers[0]["rmse"]))
    assert (
        answers[0]["parameters"]["H"]
        == tomllib.loads((working_folder / "a.toml").read_text())["clouds"]["parameters"]["H"]
    )


def test_entry_of_the_database_is_matched_with_its_own_mask(working_folder):
    assert hcss("import", "clouds.npy", "--pixel-size", "500 m", "--name", "mine").exit_code == 0
    options = ("--budget", 0, "--json")
    answer = json.loads(hcss("match", "clouds/mine.nc", *options).output)
    assert any("the entry's mask" in note for note in answer["notes"])
    listed = json.loads(hcss("clouds", "list", "--json").output)
    assert answer["coverage"] == pytest.approx(listed[0]["coverage"])
    with pytest.raises(HcssError, match="method: has no meaning for an entry"):
        hcss("match", "clouds/mine.nc", "--method", "otsu", "--force")


def test_values_in_cloud_only_are_cloud_wherever_there_are_some(working_folder):
    level = np.load("clouds.npy")
    np.save("heights.npy", np.where(level > 0.0, level, np.nan))
    answer = json.loads(
        hcss("match", "heights.npy", "--pixel-size", 500, "--method", "valid", "--budget", 0, "--json").output
    )
    assert answer["coverage"] == pytest.approx(np.mean(level > 0.0))
    with pytest.raises(HcssError, match="missing"):
        hcss("match", "heights.npy", "--pixel-size", 500, "-o", "other.toml")


def test_range_of_the_dimension_needs_no_image(working_folder):
    done = hcss(
        "match", "--fd", 2.6, 2.7, "--type", "stratus", "--coverage", 0.4, "--rows", 96, "--columns", 96,
        "-o", "range.toml", "--preview", "range.png", "--json",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    answer = json.loads(done.stdout)
    assert 2.6 <= np.mean(answer["dimensions"]) <= 2.7
    assert (working_folder / "range.png").exists()
    fragment = tomllib.loads((working_folder / "range.toml").read_text(encoding="utf-8"))["clouds"]
    assert (fragment["type"], fragment["coverage"]) == ("stratus", 0.4)


def test_range_of_the_dimension_changes_the_match_of_an_image(working_folder):
    done = hcss("match", "clouds.npy", "--pixel-size", 500, "--budget", 6, "--fd", 2.6, 2.75, "--json")
    answer = json.loads(done.stdout)
    assert 2.6 <= np.mean(answer["dimensions"]) <= 2.75
    assert answer["source"] == "clouds.npy"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "nothing to match"),
        (("--fd", 2.4, 2.5), "--fd without IMAGE needs --coverage"),
        (("--fd", 2.4, 2.5, "--coverage", 0.3, "--row-origin", 0), "row_origin: applies only with IMAGE"),
        (("clouds.npy", "-o", "x", "--preview", "x"), "allowed: different files"),
        (("clouds.npy", "-o", "no/x.toml"), "there is no folder"),
        (("clouds.npy", "-o", "clouds.npy"), "exists; give another name, or --force"),
    ],
)
def test_wrong_options_are_refused_before_the_search(working_folder, arguments, message):
    done = hcss("match", *arguments, catch=True)
    assert done.exit_code != 0
    assert message in " ".join(done.output.split())
    assert sorted(path.name for path in working_folder.iterdir()) == ["clouds.npy"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("clouds.npy",), "pixel_size: not in clouds.npy"),
        (("clouds.npy", "--pixel-size", 500, "--rows", 8), "allowed: 32 or more"),
        (("clouds.npy", "--pixel-size", 500, "--rows", 800), "closest is 96"),
        (("clouds.npy", "--pixel-size", 500, "--coverage", 0.2), "needed with the method 'coverage'"),
        (("clouds.npy", "--pixel-size", 500, "--window", 9), "allowed with the method 'local'"),
        (("clouds.npy", "--pixel-size", 500, "--type", "cumulos"), "cumulus"),
        (("text.npy", "--pixel-size", 500), "text.npy"),
    ],
)
def test_bad_input_is_named_and_nothing_is_written(working_folder, arguments, message):
    (working_folder / "text.npy").write_text("no image")
    with pytest.raises(HcssError, match=message):
        hcss("match", *arguments)
    assert not list(working_folder.glob("*.toml"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "--missing: 1 of the 12288 pixels of the part are missing; allowed: --missing clear, or a part"),
        (("--rows", 800), "--rows: 800 is more than the image has (96 rows, 128 columns); closest is 96"),
        (("--rows", 64, "--row-origin", 90), "--row-origin: 90 puts 64 rows beyond the image's 96"),
        (("--columns", 64, "--column-origin", 90), "--column-origin: 90 puts 64 columns beyond the image's 128"),
    ],
)
@pytest.mark.parametrize("command", ["match", "fit"])
def test_what_is_wrong_with_an_image_names_the_file_and_options_of_the_command(
    working_folder, command, options, message
):
    values = np.load("clouds.npy").astype(float)
    values[40, 40] = np.nan
    np.save("holes.npy", values)
    with pytest.raises(HcssError) as error:
        hcss(command, "holes.npy", "--pixel-size", 500, *options)
    assert str(error.value).startswith("holes.npy: 1 problem\n")
    assert message in str(error.value)


# The goal is 5 %; cloud-top heights have two modes, which one exponent does not give (docs/how-to/match-and-fit.md).
# A part of the usual simulations reaches it.
@pytest.mark.long
@pytest.mark.parametrize(
    ("pattern", "options", "budget", "limit"),
    [
        pytest.param("OR_ABI-L2-CMIPM2-M3C01*.nc", (), 45, 0.05, marks=pytest.mark.campaign),
        pytest.param("OR_ABI-L2-CMIPM2-M3C03*.nc", (), 45, 0.05, marks=pytest.mark.campaign),
        pytest.param("OR_ABI-L1b-RadC-M3C08*.nc", (), 45, 0.05, marks=pytest.mark.campaign),
        ("Miriam*.jpg", ("--pixel-size", "2 km"), 45, 0.05),
        pytest.param("*Cloud_Top_Height.nc", (), 180, 0.07, marks=pytest.mark.campaign),
        ("*Cloud_Top_Height.nc", ("--method", "otsu", "--missing", "clear"), 90, 0.05),
    ],
)
def test_real_images_are_matched_to_five_per_cent(working_folder, pattern, options, budget, limit):
    image = sample_file(f"images/{pattern}")
    answer = json.loads(hcss("match", image, "-o", "real.toml", "--json", "--budget", budget, *options).output)
    assert answer["mean_rmse"] < limit
