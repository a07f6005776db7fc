"""What is drawn: distributions as they are written, and draws that do not depend on each other."""

import numpy as np
import pytest
from hcss_evaluate.errors import PosteriorError
from hcss_evaluate.posterior.posterior_file import read_posterior
from hcss_uncertainty.draws import uncertain_keys
from hcss_uncertainty.joint_sample import PosteriorDraws, joint_sample
from posterior_example import example_posterior
from scipy import stats

from hcss_twin.core.errors import ScenarioError


@pytest.mark.parametrize(
    ("short", "table"),
    [
        ("normal:291:0.5", {"distribution": "normal", "mean": 291.0, "standard_deviation": 0.5}),
        ("normal:5:3:0:9", {"distribution": "normal", "mean": 5.0, "standard_deviation": 3.0, "from": 0.0, "to": 9.0}),
        ("uniform:1:2", {"distribution": "uniform", "from": 1.0, "to": 2.0}),
        ("log-uniform:1 km:2 km", {"distribution": "log-uniform", "from": "1 km", "to": "2 km"}),
    ],
)
def test_the_short_form_and_the_table_are_the_same(short, table):
    (one,), (two,) = (uncertain_keys({"sea.temperature": given}) for given in (short, table))
    assert one == two
    (nested,) = uncertain_keys({"sea": {"temperature": table}})
    assert nested == one


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"sea.temperature": "gauss:1:2"}, "'gauss'; allowed: log-uniform, normal, uniform; closest is 'normal'"),
        ({"sea.temperature": "normal:1"}, "has 1 number; allowed"),
        ({"sea.temperature": "normal:291:-1"}, "standard_deviation = -1; allowed: > 0"),
        ({"sea.temperature": "normal:a:b"}, "'a', 'b': allowed: numbers"),
        ({"sea.temperature": "uniform:1:inf"}, "inf: allowed: finite numbers"),
        ({"sea.temperature": "uniform:2:1"}, "allowed: from < to"),
        ({"sea.temperature": [1, 2]}, "[1, 2] is not a distribution"),
        ({"sea.temperature": 291}, "291 is not a distribution"),
        ({"sea": {"temperature": {"distribution": "normal", "mean": 1}}}, "lacks standard_deviation"),
        ({"sea.temperature": {"distribution": "uniform", "from": 1, "to": 2, "seed": 1}}, "seed: all inputs share"),
        ({"see.temperature": "normal:1:2"}, "not a scenario key; allowed: keys"),
        ({"seaa.temperature": "normal:1:2"}, "closest is 'sea'"),
        ({"bands": "normal:1:2"}, "must be the same in all draws"),
        ({"seed": "uniform:1:2"}, "must be the same in all draws"),
        ({"sea.temperature": "normal:1:2", "sea": {"distribution": "uniform", "from": 1, "to": 2}}, "overlaps"),
    ],
)
def test_a_distribution_that_cannot_be_names_its_key(given, told):
    with pytest.raises(ScenarioError) as caught:
        uncertain_keys(given)
    assert told in str(caught.value)
    assert f"uncertain.{next(reversed(given))}".split(".")[1] in str(caught.value)


def drawn(tmp_path, keys, count=2000, seed=3, **options):
    posterior = PosteriorDraws.read(example_posterior(tmp_path / "posterior.nc"))
    made = uncertain_keys(dict.fromkeys(keys, "normal:0:1"))
    return joint_sample(posterior, "clouds", made, count, seed, pick_freeze=options.get("pick_freeze", False))


def columns(sample):
    values = [np.array(value) for value in sample.values.values()]
    return np.column_stack([np.concatenate(sample.rows), *values, sample.seeds.ravel() / 2.0**63])


def test_inputs_seeds_and_the_two_samples_are_independent(tmp_path):
    sample = drawn(tmp_path, ["sea.temperature", "sea.wind_speed"])
    every = columns(sample)
    both = np.column_stack([every[:2000], every[2000:]])
    correlation = np.corrcoef(both.T) - np.eye(both.shape[1])
    assert np.abs(correlation).max() < 4.5 / np.sqrt(2000.0)
    drawn_normal = stats.kstest(sample.values["sea.temperature"], "norm")
    assert drawn_normal.pvalue > 0.001


def test_draws_follow_the_posterior_row_by_row(tmp_path):
    sample = drawn(tmp_path, [], count=500)
    known = {tuple(row) for row in sample.posterior.samples}
    assert {tuple(row) for row in sample.rows[0]} <= known
    np.testing.assert_allclose(sample.rows[0].mean(axis=0), sample.posterior.samples.mean(axis=0), rtol=0.05)


def test_the_first_draws_do_not_depend_on_what_else_is_uncertain(tmp_path):
    one = drawn(tmp_path, ["sea.temperature"], count=20)
    more = drawn(tmp_path, ["sea.temperature", "sea.wind_speed"], count=20, pick_freeze=True)
    assert one.overrides(one.mixtures[0], 7).items() <= more.overrides(more.mixtures[0], 7).items()


def test_mixtures_exchange_what_they_say(tmp_path):
    sample = drawn(tmp_path, ["sea.temperature"], count=4, pick_freeze=True)
    first, seed, others, posterior, key = (sample.overrides(mixture, 2) for mixture in sample.mixtures)
    differ = [{name for name in first if first[name] != values[name]} for values in (seed, others, posterior, key)]
    clouds = {"clouds.parameters.H", "clouds.parameters.L", "clouds.coverage"}
    assert differ == [{"seed"}, {"seed", "sea.temperature"} | clouds, clouds, {"sea.temperature"}]


def test_a_posterior_of_several_images_gives_all_parameters_of_one_image(tmp_path):
    path = example_posterior(tmp_path / "posterior.nc", free=("H", "coverage"), shape=(4, 10, 3))
    found = PosteriorDraws.read(path)
    assert (found.names, found.images, found.samples.shape) == (("H", "coverage"), 3, (120, 2))
    samples = read_posterior(path).samples
    pairs = set(zip(samples["H"].ravel(), samples["coverage"].ravel(), strict=True))
    assert {tuple(row) for row in found.samples} == pairs


def test_octaves_of_the_posterior_are_those_of_the_scene(tmp_path):
    path = example_posterior(tmp_path / "posterior.nc", attributes={"octaves": [0, 8]})
    found = PosteriorDraws.read(path)
    assert found.overrides("clouds", found.samples[0])["clouds.parameters.k"] == [0, 8]
    assert "clouds.parameters.k" in found.keys("clouds")
    last = np.arange(200).reshape(4, 50) % 7 + 3
    found = PosteriorDraws.read(example_posterior(tmp_path / "unknown.nc", last_octave=last))
    hurst = read_posterior(tmp_path / "unknown.nc").samples["H"]
    for row in found.rows(20, np.random.SeedSequence(0)):
        keys = found.overrides("clouds", row)
        # Each draw has the last octave that it was fitted with.
        assert keys["clouds.parameters.k"] == [0, last.ravel()[hurst == keys["clouds.parameters.H"]].item()]
    assert "clouds.parameters.k" in found.keys("clouds")
    path = example_posterior(tmp_path / "odd.nc", attributes={"octaves": "all"})
    with pytest.raises(PosteriorError, match="octaves all, allowed: two whole numbers"):
        PosteriorDraws.read(path)
