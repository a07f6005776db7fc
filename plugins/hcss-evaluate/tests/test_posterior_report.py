"""The page of a posterior: every number is that of its draws."""

import json
from types import SimpleNamespace

import netCDF4
import numpy as np
import pytest
from hcss_evaluate.pages.posterior_figures import mass_levels, prior_density
from hcss_evaluate.pages.posterior_page import read_contents
from hcss_evaluate.posterior.mixing import mixing
from hcss_evaluate.posterior.posterior_file import Diagnostic, VariogramCheck, write_posterior
from pages import read_page

import hcss_twin
from hcss_twin.core.errors import HcssError
from hcss_twin.core.plugins import Origin

RANDOM = np.random.default_rng(5)
CHAINS = {"H": RANDOM.normal(0.4, 0.03, (8, 40)), "Lx": RANDOM.lognormal(2.0, 0.1, (8, 40))}
PRIORS = {"H": "uniform:0.02:0.98", "Lx": "loguniform:1:50"}
DIAGNOSED = {
    name: [f"{size:.5g}" for size in (mixing_of.bulk_effective_sample_size, mixing_of.tail_effective_sample_size)]
    + [f"{mixing_of.rank_normalized_split_r_hat:.4f}"]
    for name, mixing_of in ((name, mixing(draws)) for name, draws in CHAINS.items())
}
LAGS = np.array([1, 2, 4, 8])


def written(path, **changes):
    chains = changes.get("chains", CHAINS)
    told = {name: Diagnostic(f"meaning of {name}", PRIORS.get(name, "uniform:0:1"), 30.5) for name in chains}
    values = {
        "title": "Clouds <of> a test",
        "inputs": [("image.nc", "ab" * 32)],
        "chains": chains,
        "log_probability": np.zeros((8, 40)),
        "diagnostics": told,
        "fixed": {"gamma": 2.0},
        "priors": PRIORS,
        "seed": 7,
    }
    write_posterior(path, **(values | changes))
    return path


def check(images=()):
    observed = np.ones((*images, 4, 2)) * LAGS[:, None]
    quantiles = np.array([0.05, 0.5, 0.95])
    predicted = np.stack([observed * factor for factor in (0.8, 1.0, 1.2)])
    return VariogramCheck(LAGS, observed, 0.1 * observed, quantiles, predicted)


def test_parameters_convergence_and_provenance_are_those_of_the_file(tmp_path):
    trace = (("H", "Lx"), np.zeros((2, 8, 50)))
    doubt = {"image": "image.nc", "parameters": ["Lx", "Ly"], "reason": "few cells"}
    told = {"predictive_p_value": [0.37], "unlikeness": [0.8], "doubts": json.dumps([doubt])}
    last = np.repeat([4, 5, 5, 5], 80).reshape(8, 40)
    found = written(tmp_path / "p.nc", variogram=check(), trace=trace, attributes=told, last_octave=last)
    page = hcss_twin.report(found)
    found = read_page(page)
    rows = found.table("parameter", "meaning", "median")
    for row, (name, draws) in zip(rows, CHAINS.items(), strict=False):
        low, middle, high = np.quantile(draws, (0.05, 0.5, 0.95))
        numbers = [f"{value:.4g}" for value in (middle, low, high, draws.mean(), draws.std())]
        assert row == [name, f"meaning of {name}", *numbers]
    assert rows[2][:3] == ["gamma", "fixed", "2"]
    assert found.table("parameter", "autocorrelation time, steps") == [
        [name, "30.5", *DIAGNOSED[name]] for name in CHAINS
    ]
    assert "of the 320 stored draws" in found.text
    assert found.table("image", "posterior predictive p-value") == [["image.nc", "0.37"]]
    assert found.table("image", "unlikeness") == [["image.nc", "0.80"]]
    assert found.table("image", "doubtful", "reason") == [["image.nc", "Lx, Ly", "few cells"]]
    assert "each draw has its own: 4 in 25%, 5 in 75% of the draws" in found.text
    assert found.table("parameter", "prior") == [[name, text] for name, text in PRIORS.items()]
    assert found.table("file", "SHA-256") == [["image.nc", "ab" * 32]]
    correlation = np.corrcoef(CHAINS["H"].ravel(), CHAINS["Lx"].ravel())[0, 1]
    assert found.table("", "H", "Lx")[0] == ["H", "1.00", f"{correlation:.2f}"]
    for text in ("Clouds <of> a test", "8 chains of 40 draws", "converged", "all steps, burn-in included"):
        assert text in found.text
    pictures = [attributes["alt"] for tag, attributes in found.elements if tag == "img"]
    assert pictures == [
        "corner plot of H, Lx",
        "traces of the chains",
        "prior and posterior of H",
        "prior and posterior of Lx",
        "observed and predicted variogram",
    ]


def test_of_several_images_each_has_its_interval_and_its_variogram(tmp_path):
    chains = {"mean_H": CHAINS["H"], "spread_H": 0.1 * CHAINS["H"], "H": RANDOM.uniform(0.3, 0.5, (8, 40, 3))}
    path = written(tmp_path / "p.nc", chains=chains, variogram=check((3,)))
    contents = read_contents(path)
    assert contents.variogram.observed.shape == (3, 4, 2)
    assert contents.variogram.predicted.shape == (3, 3, 4, 2)
    found = read_page(hcss_twin.report(path))
    pictures = [attributes["alt"] for tag, attributes in found.elements if tag == "img"]
    assert "corner plot of mean_H, spread_H" in pictures
    assert "H of each image" in pictures
    assert pictures.count("observed and predicted variogram") == 3
    assert "without burn-in" in found.text


def test_labels_traces_and_variogram_come_back_as_they_were_written(tmp_path):
    trace = RANDOM.random((2, 8, 5))
    contents = read_contents(written(tmp_path / "p.nc", trace=(("H", "coverage"), trace), variogram=check()))
    assert list(contents.traces) == ["H", "coverage"]
    np.testing.assert_allclose(contents.traces["coverage"], trace[1], rtol=1e-6)
    assert contents.variogram.axes == ("x", "y")
    np.testing.assert_array_equal(contents.variogram.observed[0, :, 1], LAGS)


def test_chains_that_have_not_converged_have_no_page(tmp_path):
    path = written(tmp_path / "p.nc")
    with netCDF4.Dataset(path, "a") as file:
        file.converged = "false"
    with pytest.raises(HcssError, match="not converged"):
        hcss_twin.report(path)
    assert not (tmp_path / "p.html").exists()


def test_without_a_page_the_package_is_named(tmp_path, monkeypatch):
    def broken():
        raise ImportError("no figures")

    path, mark = written(tmp_path / "p.nc"), "hcss_posterior_version"
    for found, message in (
        ([], "hcss-evaluate"),
        (
            [(Origin(mark, "hcss-evaluate", "9"), SimpleNamespace(name=mark, load=broken))],
            "hcss-evaluate 9.*no figures",
        ),
    ):
        monkeypatch.setattr("hcss_twin.reports.report.installed", lambda group, found=found: found)
        with pytest.raises(HcssError, match=message):
            hcss_twin.report(path)


@pytest.mark.parametrize(
    "text", ["uniform:0.2:0.7", "loguniform:0.1:9", "normal:1:0.3", "lognormal:1.5:0.4", "lognormal:0.2:1"]
)
def test_the_density_of_a_prior_has_the_integral_one(text):
    values = np.linspace(-5.0, 60.0, 400_001)
    density = prior_density("X", text, values)
    assert np.sum(density) * (values[1] - values[0]) == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("text", ["", "flat", "uniform:0:x", "beta:1:2"])
def test_a_prior_written_in_another_way_has_no_curve(text):
    assert prior_density("H", text, np.array([0.5])) is None


def test_a_prior_ends_where_its_parameter_does():
    values = np.linspace(-1.0, 2.0, 300_001)
    for name in ("coverage", "mean_coverage"):
        density = prior_density(name, "normal:0.5:0.6", values)
        assert np.all(density[(values < 0.0) | (values > 1.0)] == 0.0)
        assert np.sum(density) * (values[1] - values[0]) == pytest.approx(1.0, abs=1e-4)
    spread = prior_density("spread_H", "normal:0.2:0.3", values)
    assert np.all(spread[values < 0.0] == 0.0)
    assert spread[-1] > 0.0


def test_lines_of_a_corner_plot_hold_the_shares_they_say():
    y, x = np.mgrid[-4:4:161j, -4:4:161j]
    density = np.exp(-0.5 * (x**2 + y**2))
    # of a normal distribution in two dimensions a share p lies where the density exceeds 1 - p of its maximum
    np.testing.assert_allclose(mass_levels(density, (0.9, 0.5)), [0.1, 0.5], atol=0.01)
