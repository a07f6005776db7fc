"""`hcss propagate`: against scenes computed one by one, and what goes wrong with it."""

import json

import numpy as np
import pytest
from agreement_of_scenes import QUANTILES, Scenes, by_bootstrap, by_permutation
from cheap import CHEAP, CHEAP_OPTIONS, NARROW
from click.testing import CliRunner
from hcss_uncertainty import propagate
from hcss_uncertainty.dataset import open_propagation, with_summary
from hcss_uncertainty.draws import UncertainScenario
from hcss_uncertainty.joint_sample import PosteriorDraws
from posterior_example import example_posterior
from scipy import ndimage

import hcss_twin
from hcss_twin.cli.main import cli
from hcss_twin.core.errors import HcssError
from hcss_twin.engine.certificate.certificate import PARTS, Certificate

SMALL = CHEAP | {
    "image.rows": 40,
    "image.columns": 48,
    "frames.count": 2,
    "bands": ["mwir-3.7", "lwir-10.8"],
    "output.certificate": 0,
    "time": "2024-04-20T14:30:00Z",
}
FRAME = {"clouds.coverage_mode": "frame"}
CLASSES = ("all", Certificate.CLEAR, *PARTS)


@pytest.fixture(scope="module")
def posterior(tmp_path_factory):
    return example_posterior(tmp_path_factory.mktemp("posterior") / "posterior.nc")


@pytest.fixture(scope="module")
def found(posterior, tmp_path_factory):
    path = tmp_path_factory.mktemp("found") / "a.nc"
    return propagate("stratus", path, draws=8, posterior=posterior, overrides=SMALL | FRAME)


def scene(values, variables=("radiance", "brightness_temperature", "cloud_mask", "cloud_thickness")):
    overrides = SMALL | FRAME | {"output.variables": list(variables), "output.certificate": 0} | values
    return hcss_twin.simulate(hcss_twin.Scenario.load("stratus", overrides))


def values_of(dataset, mixture, draw):
    """The scenario of a draw, from what the file says."""
    h, length_x, length_y, coverage, *rest = dataset["input_value"].values[draw]
    values = {
        "clouds.parameters.H": h,
        "clouds.parameters.gamma": 3.0,
        "clouds.parameters.L": [length_x, length_y],
        "clouds.coverage": coverage,
        "seed": int(dataset["scene_seed"].values[mixture, draw]),
    }
    return values | dict(zip(dataset["input"].values[4:].tolist(), rest, strict=True))


def masks(cube):
    """Pixels of each class, found again from the truth of a cube of one layer, (class, time, y, x)."""
    thickness, cloudy = cube["cloud_thickness"].values, cube["cloud_mask"].values > 0
    cross = ndimage.generate_binary_structure(2, 1)
    inner = np.stack([ndimage.binary_erosion(mask, cross, border_value=1) for mask in cloudy])
    thick = thickness >= np.sqrt(10.0 * (1000.0 - 33.0))  # of the type stratus
    edge = cloudy & ~inner
    return [np.ones_like(cloudy), ~cloudy, cloudy & inner & ~thick, edge, cloudy & inner & thick]


def sums(cube):
    """Mean, spread and count of each class, (band, class), with numpy alone."""
    found = {}
    for name in ("radiance", "brightness_temperature"):
        values = np.moveaxis(cube[name].values.astype(np.float64), 1, 0)
        by_class = [values[:, mask] for mask in masks(cube)]
        found[name] = np.stack([pixels.mean(axis=1) for pixels in by_class], axis=1)
        found[f"{name}_spread"] = np.stack([pixels.std(axis=1) for pixels in by_class], axis=1)
    return found


def test_each_draw_is_the_scene_that_a_run_of_its_own_makes(found):
    data = found.dataset
    for mixture, draw in ((0, 0), (1, 0), (0, 5)):
        cube = scene(values_of(data, mixture, draw))
        for name, expected in sums(cube).items():
            np.testing.assert_allclose(data[name].values[mixture, draw], expected, rtol=3e-6, atol=3e-5, err_msg=name)
        pixels = [int(mask.sum()) for mask in masks(cube)]
        assert data["class_pixels"].values[mixture, draw].tolist() == pixels


def test_pixels_of_all_draws_together_are_those_of_all_cubes(found):
    data = found.dataset
    cubes = [scene(values_of(data, 0, draw)) for draw in range(8)]
    for number, name in enumerate(CLASSES):
        pixels = np.concatenate(
            [np.moveaxis(cube["radiance"].values, 1, 0)[:, masks(cube)[number]] for cube in cubes], axis=1
        ).astype(np.float64)
        at = data.sel({"class": name})
        np.testing.assert_allclose(at["radiance_pixel_mean"], pixels.mean(axis=1), rtol=1e-5)
        np.testing.assert_allclose(at["radiance_pixel_standard_deviation"], pixels.std(axis=1), rtol=1e-3, atol=1e-6)
        expected = np.quantile(pixels, QUANTILES, axis=1)
        scale = 0.02 * np.ptp(pixels, axis=1) + 1e-6
        distance = np.abs(at["radiance_pixel_quantile"].sel(quantile=list(QUANTILES)).values - expected)
        np.testing.assert_array_less(distance, np.broadcast_to(scale, distance.shape))


def test_tables_are_compiled_once_for_draws_of_clouds_and_for_each_temperature_of_the_sea(found, tmp_path, monkeypatch):
    assert (found.tables.scenes, found.tables.sets) == (16, 1)
    monkeypatch.setenv("HCSS_CACHE_DIR", str(tmp_path / "cache"))
    scenes = SMALL | {"image.rows": 8, "image.columns": 8, "frames.count": 1, "bands": [[10.3, 11.3]]}
    made = propagate("stratus", draws=3, uncertain={"sea.temperature": "normal:291:0.5"}, overrides=scenes)
    assert vars(made.tables) == {"scenes": 6, "sets": 3, "compiled": 3}
    again = propagate("stratus", draws=3, uncertain={"clouds.coverage": "uniform:0.2:0.8"}, overrides=scenes)
    assert vars(again.tables) == {"scenes": 6, "sets": 1, "compiled": 1}


def test_coverage_that_frames_have_exactly_is_all_from_the_posterior(found):
    coverage = found.dataset.sel(metric_name="coverage")
    drawn = found.dataset["input_value"].sel(input="coverage").values
    np.testing.assert_allclose(coverage["metric"].values, np.stack([drawn, drawn]), atol=0.51 / (40 * 48))
    assert float(coverage["metric_first_order"].sel(source="all but the seed")) == pytest.approx(1.0, abs=1e-6)


def test_what_the_file_says_is_computed_again_from_its_draws(found):
    with open_propagation(found.path) as data:
        whole = data.load()
    kept = [name for name in whole.data_vars if whole[name].dims[:1] in (("mixture",), ("draw",), ("sample",))]
    again = with_summary(whole[kept].drop_vars(["quantile", "source"], errors="ignore"))
    for name in whole.data_vars:
        np.testing.assert_array_equal(again[name], whole[name], err_msg=name)
        np.testing.assert_array_equal(found.dataset[name], whole[name], err_msg=name)


def test_the_same_seed_gives_the_same_bytes_and_another_does_not(posterior, tmp_path):
    few = SMALL | {"image.rows": 32, "image.columns": 32, "frames.count": 1, "bands": NARROW[1:]}
    for name, seed in (("a", 5), ("b", 5), ("c", 6)):
        propagate("stratus", tmp_path / f"{name}.nc", draws=2, posterior=posterior, overrides=few | {"seed": seed})
    first, second, other = ((tmp_path / f"{name}.nc").read_bytes() for name in "abc")
    assert first == second
    assert first != other


def test_an_interrupted_propagation_leaves_nothing(posterior, tmp_path):
    def stopped(draws, count):
        for draw in draws:
            yield draw
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        propagate(
            "stratus", tmp_path / "a.nc", draws=3, posterior=posterior, overrides=SMALL, cubes_of=[0], progress=stopped
        )
    assert list(tmp_path.iterdir()) == []


def test_one_of_two_layers_has_a_posterior(posterior):
    scenes = SMALL | {"image.rows": 32, "image.columns": 32, "frames.count": 1, "bands": NARROW[1:]}
    made = propagate("cirrus-over-cumulus", draws=2, posterior=posterior, overrides=scenes, layer=1).dataset
    assert made["class"].values[2] == "thin (low only)"
    assert made.attrs["posterior_layer"] == "clouds.layers.1"


@pytest.mark.long
def test_pick_freeze_gives_every_input_both_shares(posterior):
    few = SMALL | {"image.rows": 32, "image.columns": 32, "frames.count": 1, "bands": [[10.3, 11.3]]}
    made = propagate(
        "stratus",
        draws=4,
        posterior=posterior,
        uncertain={"sea.temperature": "normal:291:2"},
        overrides=few,
        shares="pick-freeze",
    )
    data = made.dataset
    assert made.tables.scenes == 4 * 5
    shares = data["brightness_temperature_total"].sel({"class": "clear", "band": data["band"][0]})
    # Clouds do not change what is clear: shares that are exact whatever is drawn.
    assert float(shares.sel(source="posterior")) == 0.0
    assert float(shares.sel(source="seed")) == 0.0
    named = dict(zip(data["source"].values, data["total_estimator"].values, strict=True))
    assert {name for name, how in named.items() if how == "pick-freeze"} == {"seed", "posterior", "sea.temperature"}


DRAWS = 12
"""Of the frames that lack a class."""


@pytest.fixture(scope="module")
def patchy(posterior):
    """Frames so small that some lack a class, by both ways of sharing out the variance."""
    few = SMALL | {"image.rows": 12, "image.columns": 12, "frames.count": 1, "bands": NARROW[1:]}
    few |= {"clouds.coverage_mode": "field", "seed": 7}
    return [
        propagate("stratus", draws=DRAWS, posterior=posterior, overrides=few, shares=shares).dataset
        for shares in ("regression", "pick-freeze")
    ]


def test_each_scene_that_has_a_class_counts_once(patchy):
    data = patchy[0]
    values = data["radiance"].values
    known = np.isfinite(values)
    single = known[0] != known[1]
    assert np.all(single.any(axis=0)[:, 1:])  # of each class but all, some draws have it with one seed only
    np.testing.assert_array_equal(data["radiance_scenes"], known.sum(axis=(0, 1)))
    np.testing.assert_array_equal(data["radiance_draws"], known.all(axis=0).sum(axis=0))
    np.testing.assert_allclose(data["radiance_mean"], np.nanmean(values, axis=(0, 1)), rtol=1e-12)
    expected = np.nanquantile(values, QUANTILES, axis=(0, 1))
    np.testing.assert_allclose(data["radiance_quantile"].sel(quantile=list(QUANTILES)), expected, rtol=1e-12)
    # Pairs of scenes of different draws, one by one.
    draw = np.tile(np.arange(DRAWS), 2)
    for band, kind in ((0, 1), (0, 4)):
        pixels, of = values[..., band, kind].ravel(), draw[known[..., band, kind].ravel()]
        pixels = pixels[np.isfinite(pixels)]
        apart = 0.5 * (pixels[:, None] - pixels) ** 2
        expected = np.sqrt(apart[of[:, None] != of].mean())
        assert float(data["radiance_standard_deviation"][band, kind]) == pytest.approx(expected, rel=1e-9)


def test_moments_are_the_same_whether_or_not_more_scenes_are_computed_for_shares(patchy):
    one, more = patchy
    assert more.sizes["mixture"] == 4
    assert np.any((more["radiance_draws"] < one["radiance_draws"])[:, 2:])  # of a class that varies
    for name in ("radiance", "brightness_temperature", "radiance_spread", "class_fraction", "metric"):
        for statistic in ("mean", "standard_deviation", "quantile", "scenes"):
            np.testing.assert_array_equal(more[f"{name}_{statistic}"], one[f"{name}_{statistic}"])


@pytest.fixture
def working_folder(tmp_path):
    """An empty folder in which commands run; no code is replaced, so that analyses of scenes are kept."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        yield tmp_path


def command(*words):
    return CliRunner().invoke(cli, ["propagate", *words])


TINY = [
    *CHEAP_OPTIONS,
    *(
        word
        for key, value in {
            "image.rows": 32,
            "image.columns": 32,
            "frames.count": 1,
            "bands": '["lwir"]',
            "output.certificate": 4,
        }.items()
        for word in ("--set", f"{key}={value}")
    ),
]


@pytest.mark.long
def test_the_command_writes_a_file_cubes_and_a_table(posterior, working_folder):
    words = ["stratus", *TINY, "--draws", "3", "--posterior", str(posterior), "--cube-of", "0,2"]
    result = command(*words)
    assert result.exit_code == 0, result.output
    assert "1 set for 3 draws" in result.output
    assert "shares of the variance" in result.output
    names = {path.name for path in working_folder.iterdir()}
    assert names == {"stratus.propagation.nc", "stratus.draw-0000.nc", "stratus.draw-0002.nc"}
    with open_propagation("stratus.propagation.nc") as data, hcss_twin.open_cube("stratus.draw-0002.nc") as cube:
        mean = float(data["radiance"].sel({"class": "all"})[0, 2, 0])
        assert float(cube["radiance"].astype(np.float64).mean()) == pytest.approx(mean, rel=1e-6)
    again = command(*words)
    assert again.exit_code == 1
    assert "exists" in again.output
    forced = command(*words, "--force", "--json")
    told = json.loads(forced.output)
    assert told["tables"]["sets"] == 1
    assert told["draws"] == 3
    assert told["outputs"]["radiance"]["mean"]["lwir"]["all"] > 0.0
    assert told["cubes"] == ["stratus.draw-0000.nc", "stratus.draw-0002.nc"]


IMAGERY = ["--set", "clouds.generator=imagery", "--set", 'clouds.parameters={image="a.png"}']

SECTION = """
time = 2024-04-20T14:30:00Z
place = {latitude = 35.0, longitude = 150.0}
clouds.coverage = 0.0

[uncertain]
sea.temperature = "normal:291:0.5"
atmosphere.water_vapour_scale = {distribution = "uniform", from = 0.9, to = 1.1}
"""


def test_a_section_says_what_is_uncertain_and_is_refused_where_it_would_be_ignored(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(SECTION)
    result = command(str(path), *TINY, "--draws", "2", "-o", str(tmp_path / "a.nc"))
    assert result.exit_code == 0, result.output
    with open_propagation(tmp_path / "a.nc") as data:
        assert data["input"].values.tolist() == ["sea.temperature", "atmosphere.water_vapour_scale"]
    with pytest.raises(HcssError, match=r"uncertain: the file has uncertain keys.*hcss-uncertainty"):
        hcss_twin.Scenario.load(path)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--draws", "1", "--uncertain", "sea.temperature=normal:291:1"], "draws: 1 given, allowed"),
        (["--draws", "3"], "nothing is uncertain"),
        (["--draws", "3", "--uncertain", "sea.temprature=normal:291:1"], "closest is 'temperature'"),
        (["--draws", "3", "--uncertain", "sea.wind_speed=normal:-5:1"], "sea.wind_speed: -"),
        (["--draws", "3", "--uncertain", "clouds.top=uniform:1:9"], "is not above the base"),
        (["--draws", "3", "--uncertain", "clouds.parameters.H=uniform:1.5:2"], "clouds.parameters.H"),
        (
            ["--draws", "3", "--uncertain", "sea.wind_speed=normal:5:1", "--set", "sea.wind_speed=3"],
            "is set to one value",
        ),
        (["--draws", "3", "--posterior", "POSTERIOR", "--uncertain", "clouds.coverage=uniform:0:1"], "overlaps"),
        (["--draws", "3", "--posterior", "POSTERIOR", *IMAGERY], "'imagery'; a posterior describes clouds"),
        (["--draws", "3", "--posterior", "POSTERIOR", "--layer", "1"], "layer 1 given; allowed: 0 to 0"),
        (["--draws", "3", "--posterior", "POSTERIOR", "--cube-of", "3"], "allowed: draws 0 to 2"),
        (["--draws", "3", "--posterior", "POSTERIOR", "--cube-of", "a"], "allowed: numbers of draws"),
        (["--draws", "3", "--posterior", "POSTERIOR", "-o", "a.zarr"], "closest is a.nc"),
        (["--draws", "3", "--posterior", "POSTERIOR", "-o", "none/a.nc"], "there is no folder"),
        (["--draws", "3", "--posterior", "none.nc"], "does not exist"),
        (["--draws", "3", "--posterior", "UNFINISHED"], "not converged"),
        (["--draws", "3", "--posterior", "TEXT"], "not a NetCDF file"),
        (["--draws", "3", "--posterior", "CUBE"], "not a posterior of hcss fit"),
        (["--draws", "3", "--posterior", "HALF"], "only one of Lx and Ly"),
    ],
)
def test_what_cannot_be_propagated_is_told_and_leaves_nothing(words, told, posterior, working_folder):
    made = {
        "POSTERIOR": lambda path: posterior,
        "UNFINISHED": unfinished,
        "TEXT": lambda path: path.write_text("no") and path,
        "CUBE": lambda path: example_cube(path),
        "HALF": lambda path: example_posterior(path, free=("H", "Lx"), fixed={}),
    }
    folder = working_folder / "inputs"
    folder.mkdir()
    words = [str(made[word](folder / "file.nc")) if word in made else word for word in words]
    result = command("stratus", *TINY, *words)
    text = result.output + str(result.exception)
    assert result.exit_code != 0
    assert told in text
    assert [path.name for path in working_folder.iterdir()] == ["inputs"]


def unfinished(path):
    import netCDF4

    example_posterior(path)
    with netCDF4.Dataset(path, "a") as file:
        file.converged = "false"
    return path


def example_cube(path):
    scenario = hcss_twin.Scenario.load("stratus", SMALL | {"image.rows": 4, "image.columns": 4})
    hcss_twin.simulate(scenario, path).close()
    return path


def test_the_draw_that_is_not_valid_is_named_with_its_value(tmp_path):
    with pytest.raises(HcssError) as caught:
        propagate("stratus", draws=30, uncertain={"sea.wind_speed": "normal:1:1"}, overrides=SMALL)
    assert "(draw " in str(caught.value)
    assert "sea.wind_speed = -" in str(caught.value)
    assert "also wrong: draws " in str(caught.value)
    assert str(caught.value).count("\n") == 1


@pytest.mark.parametrize(
    ("key", "closest"), [("sea.temprature", "temperature"), ("clouds.parameters.gama", "gamma"), ("see.waves", "seed")]
)
def test_a_wrong_key_is_refused_before_draws_are_checked(tmp_path, monkeypatch, key, closest):
    checked = []
    check = UncertainScenario.scenario
    monkeypatch.setattr(
        UncertainScenario, "scenario", lambda *arguments: checked.append(arguments) or check(*arguments)
    )
    with pytest.raises(HcssError, match=rf"{key}: .*closest is '{closest}'$"):
        propagate("stratus", draws=1000, uncertain={key: "normal:291:1"}, overrides=SMALL)
    assert len(checked) <= 3


@pytest.mark.campaign
def test_the_spread_is_that_of_independent_scenes_within_sampling_error(posterior):
    """12 scenes made one by one by ``simulate``, with draws of their own."""
    count, key = 12, "sea.temperature"
    scenes = SMALL | {"frames.count": 1, "bands": NARROW[1:]}
    made = propagate(
        "stratus", draws=count, posterior=posterior, uncertain={key: "uniform:289:293"}, overrides=scenes
    ).dataset
    rng = np.random.default_rng(99)
    chains = PosteriorDraws.read(posterior).samples
    brute = []
    for row in chains[rng.integers(chains.shape[0], size=count)]:
        values = {
            "clouds.parameters.H": float(row[0]),
            "clouds.parameters.gamma": 3.0,
            "clouds.parameters.L": [float(row[1]), float(row[2])],
            "clouds.coverage": float(row[3]),
            "seed": int(rng.integers(2**62)),
            "frames.count": 1,
            "bands": NARROW[1:],
            key: float(rng.uniform(289.0, 293.0)),
        }
        brute.append(sums(scene(values))["brightness_temperature"])
    name = "brightness_temperature"
    stated, error = (
        np.stack(
            [
                made[f"{name}_mean{end}"],
                made[f"{name}_standard_deviation{end}"],
                *made[f"{name}_quantile{end}"].sel(quantile=list(QUANTILES)),
            ]
        ).reshape(5, -1)
        for end in ("", "_error")
    )
    propagated = made[name].values[:2].reshape(2, count, -1)
    compared = Scenes(propagated, np.reshape(brute, (count, -1)), stated, error)
    assert by_bootstrap(compared)[0] > 0.01
    assert min(by_permutation(compared)) > 0.01
    spread = made["brightness_temperature_standard_deviation"].values
    error = made["brightness_temperature_standard_deviation_error"].values
    assert np.all(error < 0.35 * spread)
