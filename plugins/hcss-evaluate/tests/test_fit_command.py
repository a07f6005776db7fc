"""hcss fit: from images, or a dimension, to a posterior that has converged, or to none."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command import hcss
from hcss_evaluate import PosteriorError, fit_dimension, read_posterior
from hcss_evaluate.matching.dimension_range import empty_frame
from hcss_evaluate.matching.structure import simulate_image
from hcss_evaluate.posterior import chains, fit
from hcss_evaluate.posterior.batch_variogram import BatchVariogram, DimensionLikelihood
from hcss_evaluate.posterior.mixing import mixing
from hcss_evaluate.posterior.octaves import UNKNOWN, Octaves

from hcss_twin.models.clouds.fractal.parameters import FractalParameters

TRUTH = FractalParameters(gamma=2.0, H=0.4, L=(75.0, 100.0), k=(0, 8))
QUICK = ["--fix", "gamma=2", "--fix", "coverage=image", "--samples", "200"]


@pytest.fixture(autouse=True)
def few_simulations(monkeypatch):
    monkeypatch.setattr(fit, "SIMULATIONS", (40, 40, 80))


@pytest.fixture(scope="module")
def levels():
    """Two images of one kind of clouds: bright over a dark sea."""
    return [simulate_image(TRUTH, 0.4, empty_frame(64, 64, 20.0), seed).level for seed in (1, 2)]


@pytest.fixture
def working_folder(levels, tmp_path, monkeypatch):
    """A folder with the two images."""
    monkeypatch.chdir(tmp_path)
    for seed, level in enumerate(levels, 1):
        np.save(f"clouds{seed}.npy", level)
    return tmp_path


@pytest.mark.long
def test_an_image_gives_a_posterior_and_an_answer(working_folder):
    choice = ["--pixel-size", "20 m", "--method", "coverage", "--coverage", 0.4]
    done = hcss("fit", "clouds1.npy", *choice, *QUICK, "--json", "-o", "p.nc")
    answer = json.loads(done.stdout)
    found = read_posterior(Path("p.nc"))
    assert set(found.samples) == {"H", "Lx", "Ly"} == set(answer["parameters"])
    assert found.fixed == {"gamma": 2.0, "coverage": pytest.approx(0.4, abs=1e-3)}
    for name, value in (("H", 0.4), ("Lx", 75.0), ("Ly", 100.0)):
        told = answer["parameters"][name]
        assert abs(np.log(told["mean"] / value)) < 4 * told["standard_deviation"] / told["mean"]
        assert told == told | asdict(mixing(found.chains[name]))
        assert told["bulk_effective_sample_size"] >= 200
        assert told["tail_effective_sample_size"] >= 200
        assert told["rank_normalized_split_r_hat"] <= 1.01
    # Nothing is said of octaves: each draw has its own last one.
    assert found.last_octave.shape == found.chains["H"].shape
    for last, part in answer["last_octave"].items():
        assert int(last) in UNKNOWN
        assert part == pytest.approx(np.mean(found.last_octave == int(last)))
    assert sum(answer["last_octave"].values()) == pytest.approx(1.0)
    assert answer["doubts"] == found.doubts
    assert answer["predictive_p_values"] == [found.attributes["predictive_p_value"]]
    with xr.open_dataset("p.nc") as file:
        assert json.loads(file.attrs["inputs"])[0]["name"] == "clouds1.npy"
        assert file.trace.sizes["step"] <= 500
        predicted = file.variogram_predicted
        assert np.all(predicted.sel(quantile=0.05) < predicted.sel(quantile=0.95))
        # Made by the model, the image is like its predictions.
        assert file.attrs["predictive_p_value"] > 0.01
    assert not list(working_folder.glob("*.state"))


def test_the_same_seed_gives_the_same_bytes_and_a_killed_fit_goes_on(working_folder, monkeypatch):
    given = {"fixed": {"gamma": 2.0, "coverage": 0.4}, "samples": 200.0}
    fit_dimension(2.4, 0.05, "whole.nc", **given)

    monkeypatch.setattr("hcss_evaluate.posterior.fit_run.SECONDS_APART", 0.0)
    extend, calls = chains.extend, []

    def dies(*arguments):
        calls.append(arguments)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return extend(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(chains, "extend", dies)
        with pytest.raises(KeyboardInterrupt):
            fit_dimension(2.4, 0.05, "halved.nc", **given)
    assert not Path("halved.nc").exists()
    assert Path("halved.nc.state").exists()
    with pytest.raises(PosteriorError, match="state of another fit"):
        fit_dimension(2.5, 0.05, "halved.nc", **given)
    fit_dimension(2.4, 0.05, "halved.nc", **given)
    assert Path("halved.nc").read_bytes() == Path("whole.nc").read_bytes()
    assert not Path("halved.nc.state").exists()


def test_chains_that_have_not_converged_are_refused_and_gone_on_with(working_folder):
    dimension = ["--fd", 2.4, "--fd-error", 0.05, "--fix", "gamma=2", "--fix", "coverage=0.4", "-o", "p.nc"]
    done = hcss("fit", *dimension, "--max-steps", 500, catch=True)
    assert done.exit_code == 1
    message = str(done.exception)
    assert "not converged after 500 steps; no posterior is written" in message
    assert "allow more steps" in message
    assert "autocorrelation times of" in message
    assert not Path("p.nc").exists()
    assert Path("p.nc.state").exists()
    assert hcss("fit", *dimension, "--samples", 200).exit_code == 0
    assert read_posterior(Path("p.nc")).attributes["converged"] == "true"


def test_a_dimension_is_met_by_its_posterior(working_folder):
    given = {"fixed": {"gamma": 2.0, "Lx": 75.0, "Ly": 75.0, "coverage": 0.4}, "samples": 400.0}
    found = fit_dimension(2.3, 0.03, "p.nc", **given)
    assert set(found.samples) == {"H"}
    # One parameter: the posterior is an integral.
    hurst = np.linspace(0.021, 0.979, 500)
    values = np.column_stack([hurst, *(np.full(500, value) for value in (2.0, 75.0, 75.0, 0.4))])
    likelihood = DimensionLikelihood(2.3, 0.03, 800, 800, 20.0, BatchVariogram.of(Octaves(0, UNKNOWN)))
    weight = np.exp(likelihood(values))
    mean = np.average(hurst, weights=weight)
    deviation = np.sqrt(np.average((hurst - mean) ** 2, weights=weight))
    drawn = found.samples["H"]
    error = deviation / np.sqrt(found.diagnostics["H"]["bulk_effective_sample_size"])
    assert abs(drawn.mean() - mean) < 4 * error
    assert drawn.std() == pytest.approx(deviation, rel=0.15)
    # A larger dimension is a smaller Hurst exponent.
    rougher = fit_dimension(2.6, 0.03, "q.nc", **{**given, "samples": 200.0})
    assert rougher.samples["H"].mean() < found.samples["H"].mean() - 0.2


@pytest.mark.long
def test_several_images_have_a_mean_and_a_spread(working_folder):
    choice = ["--pixel-size", "20 m", "--method", "coverage", "--coverage", 0.4, "--fix", "Lx=75", "--fix", "Ly=100"]
    done = hcss("fit", "clouds1.npy", "clouds2.npy", *choice, *QUICK, "-o", "p.nc")
    assert done.exit_code == 0
    found = read_posterior(Path("p.nc"))
    assert set(found.samples) == {"mean_H", "spread_H", "H"}
    assert found.samples["H"].shape == (found.samples["mean_H"].size, 2)
    # Two images say little of a population, but the mean lies where they do.
    assert abs(found.samples["mean_H"].mean() - 0.4) < 2 * found.samples["mean_H"].std()
    with xr.open_dataset("p.nc") as file:
        assert file.H.dims == ("chain", "draw", "image")
        assert file.variogram_observed.dims == ("image", "lag", "axis")


@pytest.mark.long
def test_an_image_of_a_satellite_is_fitted(tmp_path):
    """SEVIRI 10.8 um. Real clouds are no fractal field, and the fit says so unless it is allowed for."""
    sample = pytest.importorskip("iris_sample_data")
    path = Path(sample.path) / "toa_brightness_stereographic.nc"
    part = ["--rows", 64, "--columns", 64, "--row-origin", 48, "--column-origin", 96, "--missing", "clear"]
    done = hcss("fit", path, *part, *QUICK, "--misfit", 0.1, "-o", tmp_path / "p.nc")
    assert done.exit_code == 0, done.output
    found = read_posterior(tmp_path / "p.nc")
    assert 0.0 < found.samples["H"].mean() < 1.0
    assert "H " in done.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "give IMAGES, or --fd"),
        (["clouds1.npy", "--fd", 2.3, "--fd-error", 0.1], "not both"),
        (["--fd", 2.3], "--fd and --fd-error must be given together"),
        (["--fd", 2.3, "--fd-error", 0.1, "--missing", "clear"], "missing: applies only with IMAGES"),
        (["--fd", 3.3, "--fd-error", 0.1], "allowed: 2 to 3; closest is 3"),
        (["--fd", 2.3, "--fd-error", 0], "greater than 0"),
        (["--fd", 2.3, "--fd-error", 0.1, "--rows", 5], "32 or more along each axis"),
        (["--fd", 2.3, "--fd-error", 0.1, "--fix", "coverage=image"], "allowed: a number, or 'image' of images"),
        (["--fd", 2.3, "--fd-error", 0.1, "--fix", "H"], "allowed: NAME=VALUE"),
        (["--fd", 2.3, "--fd-error", 0.1, "--fix", "H=a"], "'a' given, allowed: a number"),
        (["--fd", 2.3, "--fd-error", 0.1, "--fix", "H=.1", "--fix", "H=.2"], "H is given twice"),
        (["--fd", 2.3, "--fd-error", 0.1, "--octaves", 5, 2], "first <= last"),
        (["--fd", 2.3, "--fd-error", 0.1, "-o", "none/p.nc"], "there is no folder"),
        (["clouds1.npy"], "not in clouds1.npy"),
        (["cloudy.npy", "--pixel-size", "20 m"], "all pixels have the value 7"),
        (["holes.npy", "--pixel-size", "20 m"], "missing"),
        (["tiny.npy", "--pixel-size", "20 m"], "allowed: 32 or more along each axis"),
        (["text.nc"], "text.nc"),
        (["clouds1.npy", "--pixel-size", "20 m", "--smallest-lag", 60], "smallest lag: 60 pixels, allowed: 1 to 8"),
        (["clouds1.npy", "--pixel-size", "20 m", "--prior", "spread_H=uniform:0:1"], "one image has no spread"),
    ],
)
def test_what_cannot_be_fitted_is_said_and_nothing_is_written(working_folder, arguments, message):
    np.save("cloudy.npy", np.full((64, 64), 7.0))
    level = np.load("clouds1.npy")
    level[0, 0] = np.nan
    np.save("holes.npy", level)
    np.save("tiny.npy", level[1:6, :5])
    Path("text.nc").write_text("no image")
    before = set(working_folder.iterdir())
    output = [] if "-o" in arguments else ["-o", "p.nc"]
    done = hcss("fit", *arguments, *output, catch=True)
    assert done.exit_code != 0
    assert message in f"{done.output}{done.exception}"
    assert set(working_folder.iterdir()) == before


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--fix", "gama=2"], "parameter: 'gama' given, allowed: H, Lx, Ly, coverage, gamma; closest is 'gamma'"),
        (["--fix", "H=2"], "H: fixed at 2, allowed: between 0 and 1"),
        (["--fix", "H=image"], "H: fixed at 'image', allowed: a number"),
        (["--prior", "H=unform:0:1"], "prior of H: 'unform' given"),
        (["--prior", "spread_H=uniform:0:1"], "one image has no spread"),
        (["--octaves", "5", "2"], "octaves: (5, 2) given"),
    ],
)
def test_options_are_checked_before_the_image_is_read(working_folder, options, message):
    Path("no-image.npy").write_bytes(b"\x93NUMPY, but broken")
    done = hcss("fit", "no-image.npy", "--pixel-size", "20 m", *options, catch=True)
    assert message in str(done.exception or done.output)
    image = hcss("fit", "no-image.npy", "--pixel-size", "20 m", "--fix", "coverage=image", catch=True)
    assert "not an array that can be read" in str(image.exception)


def test_an_existing_posterior_is_kept(working_folder):
    Path("p.nc").write_text("mine")
    done = hcss("fit", "--fd", 2.3, "--fd-error", 0.1, "-o", "p.nc", catch=True)
    assert "exists" in done.output
    assert Path("p.nc").read_text() == "mine"
