"""`hcss propagate` through a sensor, pixel by pixel and on several workers: against sensor cubes made one by one."""

import numpy as np
import pytest
from cheap import CHEAP
from hcss_uncertainty import propagate
from hcss_uncertainty.dataset import open_propagation
from pages import read_page

import hcss_twin
from hcss_twin.core.errors import HcssError
from hcss_twin.engine.sense import measured_path

NOISE = 0.05
SCENE = CHEAP | {
    "image.rows": 20,
    "image.columns": 24,
    "frames.count": 2,
    "clouds.coverage_mode": "frame",
    "bands": ["lwir-10.8"],
    "time": "2024-04-20T14:30:00Z",
    "clouds.parameters.H": 0.4,
    "sensor.parameters.noise": "ner",
    "sensor.parameters.ner": NOISE,
    "sensor.parameters.psf": "gaussian",
    "sensor.parameters.psf_sigma": 0.7,
    "sensor.parameters.gain_deviation": 0.01,
    "sensor.parameters.bits": 12,
    "sensor.parameters.saturation_radiance": 9.0,
}
UNCERTAIN = {"sea.temperature": "normal:291:0.5"}
DRAWS = 3


def propagated(path, **options):
    return propagate("stratus", path, draws=DRAWS, uncertain=UNCERTAIN, overrides=SCENE, maps=True, **options)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return propagated(tmp_path_factory.mktemp("found") / "one.nc")


@pytest.fixture(scope="module")
def cubes(found, tmp_path_factory):
    """Clean and sensor cube of each scene, in the order (draw, seed)."""
    folder, made = tmp_path_factory.mktemp("cubes"), []
    wanted = {"output.variables": ["radiance", "brightness_temperature", "cloud_mask"], "output.certificate": 0}
    for draw in range(DRAWS):
        for mixture in range(2):
            path = folder / f"{draw}-{mixture}.nc"
            values = {
                "seed": int(found.dataset["scene_seed"].values[mixture, draw]),
                "sea.temperature": float(found.dataset["input_value"].values[draw, 0]),
                "sensor.variables": ["all"],
            }
            scenario = hcss_twin.Scenario.load("stratus", SCENE | wanted | values)
            with hcss_twin.simulate(scenario, path) as clean:
                made.append((clean.load(), hcss_twin.open_cube(measured_path(path)).load()))
    return made


def test_what_the_sensor_measures_in_a_draw_is_its_sensor_cube(found, cubes):
    data = found.dataset
    for number, (clean, sensed) in enumerate(cubes):
        draw, mixture = divmod(number, 2)
        cloudy = clean["cloud_mask"].values > 0
        at = data.isel(draw=draw, mixture=mixture, band=0)
        for name, variable in (("measured_radiance", "radiance"), ("digital_number", "digital_number")):
            values = sensed[variable].values[:, 0].astype(np.float64)
            assert float(at[name].sel({"class": "all"})) == pytest.approx(values.mean(), rel=1e-6)
            assert float(at[f"{name}_spread"].sel({"class": "all"})) == pytest.approx(values.std(), rel=1e-5)
            assert float(at[name].sel({"class": "clear"})) == pytest.approx(values[~cloudy].mean(), rel=1e-6)
        saturated = sensed["saturated"].values[:, 0] > 0
        assert float(at["saturated_fraction"].sel({"class": "clear"})) == pytest.approx(saturated[~cloudy].mean())


def test_maps_are_the_moments_of_the_stack_of_all_cubes(found, cubes):
    data = found.dataset
    for name, variable, of in (
        ("radiance", "radiance", 0),
        ("brightness_temperature", "brightness_temperature", 0),
        ("measured_radiance", "radiance", 1),
        ("digital_number", "digital_number", 1),
        ("cloud_mask", "cloud_mask", 0),
    ):
        stack = np.stack([np.asarray(cube[of][variable].values, dtype=np.float64) for cube in cubes])
        stack = np.moveaxis(stack > 0 if name == "cloud_mask" else stack, 2, 1) if stack.ndim == 5 else stack > 0
        stack = stack.astype(np.float64)
        np.testing.assert_allclose(data[f"{name}_map_mean"], stack.mean(axis=0), rtol=1e-6, atol=1e-7)
        # every pair of scenes of different draws, one by one
        pairs = [
            (stack[i] - stack[j]) ** 2 for i in range(len(stack)) for j in range(i + 1, len(stack)) if i // 2 != j // 2
        ]
        scale = 1e-5 * np.abs(stack).max()
        expected = np.sqrt(0.5 * np.mean(pairs, axis=0))
        np.testing.assert_allclose(data[f"{name}_map_standard_deviation"], expected, rtol=1e-5, atol=scale)
        by_pair = stack.reshape(DRAWS, 2, *stack.shape[1:])
        expected = np.sqrt(0.5 * np.mean((by_pair[:, 0] - by_pair[:, 1]) ** 2, axis=0))
        np.testing.assert_allclose(data[f"{name}_map_seed_standard_deviation"], expected, rtol=1e-5, atol=scale)
    for axis in "yx":
        np.testing.assert_allclose(data[axis], cubes[0][0][axis])


def test_several_workers_write_the_same_bytes(found, tmp_path):
    two = propagated(tmp_path / "two.nc", workers=2)
    assert two.path.read_bytes() == found.path.read_bytes()
    assert (two.tables.scenes, two.tables.sets) == (found.tables.scenes, found.tables.sets) == (2 * DRAWS, DRAWS)


@pytest.mark.long
def test_interrupted_workers_leave_no_file(tmp_path):
    def stopped(draws, count):
        for draw in draws:
            yield draw
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        propagated(tmp_path / "a.nc", workers=2, progress=stopped)
    assert list(tmp_path.iterdir()) == []


def test_the_page_shows_sensor_maps_and_budget(found):
    page = read_page(hcss_twin.report(found.path))
    pictures = [attributes["alt"] for tag, attributes in page.elements if tag == "img"]
    assert {"maps of radiance, lwir-10.8", "maps of digital number, lwir-10.8", "maps of cloud mask"} <= set(pictures)
    rows = {(row[0], row[1]): row for row in page.table("class", "measured")}
    ratio = float(found.dataset["signal_to_noise_mean"].sel({"class": "clear"})[0])
    assert float(rows["clear", "signal-to-noise ratio"][3].split()[0]) == pytest.approx(ratio, rel=0.05)
    (clear,) = (row for row in page.table("error of the mean of", "uncertain inputs") if row[0] == "clear")
    assert any("K (" in cell for cell in clear[3:-1]), clear  # models that state something
    assert "K (" in clear[-1], clear
    with open_propagation(found.path) as data:
        assert data["radiance_map_mean"].dims == ("band", "time", "y", "x")


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"workers": 0}, "workers: 0 given, allowed: a whole number from 1"),
        ({"uncertain": {"image.pixel_size": "uniform:15:25"}}, "maps: the image varies between draws"),
    ],
)
def test_what_cannot_be_mapped_is_refused(tmp_path, options, told):
    given = {"draws": 2, "uncertain": UNCERTAIN, "maps": True, "overrides": SCENE} | options
    with pytest.raises(HcssError, match=told):
        propagate("stratus", tmp_path / "a.nc", **given)
    assert list(tmp_path.iterdir()) == []
