"""Every command that reads cubes reads every kind of cube, and its output is right; or it says what the cube lacks."""

import json
import tomllib

import h5py
import numpy as np
import pytest
from cheap import CHEAP
from command import hcss
from distributions import need

import hcss_twin
from hcss_twin import Scenario, simulate
from hcss_twin.core.errors import HcssError
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.physics.planck import planck

SCENE = {
    "time": "2024-04-20T11:00:00+09:00",
    "place": {"latitude": 30.0, "longitude": 150.0},
    "image": {"rows": 32, "columns": 34, "pixel_size": 200.0},
    "frames": {"count": 1},
    "sea": {"temperature": 291.0, "wind_speed": 7.0, "temperature_texture": 0.0},
    "bands": [{"name": "window", "limits": [10.5, 11.0]}],
    "atmosphere": {"profile": "us-standard-1976"},
    "clouds": {"type": "paper-stratus", "coverage": 0.5, "coverage_mode": "field"},
    "accuracy": 1e-2,
    "output": {"variables": ["radiance", "cloud_mask", "cloud_thickness", "cloud_top_altitude"], "certificate": 2},
}
CAMERA = {
    "camera": {"rows": 32, "columns": 34, "focal_length": 0.15, "detector_pitch": 4e-5, "points": 1},
    "orbit": {"altitude": 7e5, "inclination": 98.2, "above": [30.0, 153.0], "above_time": 0.0},
    "attitude": {"provider": "track"},
}
SOURCE = {
    "provider": "point-sources",
    "parameters": {"tracks": [{"x": 100.0, "y": 50.0, "temperature": 600.0, "area": 50.0}]},
}
DERIVED = {"provider": "split-window", "parameters": {"bands": ["window", "12"]}}
TWO_BANDS = [*SCENE["bands"], {"name": "12", "limits": [11.8, 12.0]}]
KINDS = {
    "grid": {},
    "window": {"image.window": {"rows": [0, 32], "columns": [1, 34]}},
    "altitude": {"platform.altitude": 8e5, "view.zenith": 30.0, "image.pixel_size": 300.0},
    "push-broom": {"platform.altitude": 7e5, "platform.mode": "push-broom", "frames.count": 2},
    "camera": CAMERA,
    "camera, push-broom": CAMERA
    | {"attitude": {"provider": "push-broom"}, "camera": CAMERA["camera"] | {"line_time": 0.01}},
    "mask": {"output.variables": ["cloud_mask"]},
    "int16": {"output.packing": "int16"},
    "elements": {"elements": [SOURCE]},
    "measured": {"sensor.parameters": {"noise": "nedt", "nedt": 0.05}},
    "night": {"time": "2024-04-20T23:00:00+09:00"},
    "derived": {
        "bands": TWO_BANDS,
        "output.derived": [DERIVED],
        "output.variables": [*SCENE["output"]["variables"], "split_window_difference"],
    },
    "zarr": {},
}
NEEDS = {"camera": "hcss-payload", "camera, push-broom": "hcss-payload", "derived": "hcss-examples", "zarr": "zarr"}
"""Kinds, and the package without which there are none."""

ON_GROUND = "a grid on the ground"
REFUSED = {
    ("volume", "camera"): ON_GROUND,
    ("volume", "camera, push-broom"): ON_GROUND,
    ("volume", "mask"): "lacks cloud_thickness and cloud_top_altitude",
    ("match", "camera"): "pixel_size: not in .* pixels of a camera differ in size on the ground",
    ("match", "camera, push-broom"): "pixel_size: not in .* pixels of a camera differ in size on the ground",
    ("match", "mask"): "has no cloud_thickness",
    ("sense", "mask"): "has no radiance, which a sensor needs",
    ("sense", "elements"): "lacks element_point_radiance",
    ("sense", "measured"): "already a sensor cube",
    ("sense", "zarr"): r"sensors measure NetCDF cubes",
    ("evaluate", "mask"): "all cloudy pixels are 255, allowed: values that vary",
    ("kelvin", "mask"): "holds no 'brightness_temperature'",
}
"""All refusals that there are, and what their message names."""

SENSOR = """
title = "noise"
bands = ["window", "12"]
[parameters]
noise = "nedt"
nedt = 0.05
[sources]
bands = "test"
noise = "test"
nedt = "test"
"""


def scenario(kind):
    changes = KINDS[kind]
    return Scenario.from_dict(SCENE, {**CHEAP, "optics.provider": "bulk", **changes})


@pytest.fixture(scope="module")
def cubes(tmp_path_factory):
    """A function that returns the cube of a kind, made once."""
    folder, made = tmp_path_factory.mktemp("cubes"), {}

    def cube(kind):
        if kind in NEEDS:
            need(NEEDS[kind])
        if kind not in made:
            path = folder / f"{kind.replace(', ', '-')}{'.zarr' if kind == 'zarr' else '.nc'}"
            simulate(scenario(kind), path).close()
            made[kind] = path.with_suffix(".sensor.nc") if kind == "measured" else path
        return made[kind]

    return cube


def command(name, kind, *arguments):
    """Run a command; return None if it refuses as the list says, else its result, which has succeeded."""
    reason = REFUSED.get((name, kind))
    if reason is None:
        result = hcss(*arguments)
        assert result.exit_code == 0, result.output
        return result
    with pytest.raises(HcssError, match=reason):
        hcss(*arguments)
    return None


def images(path):
    """First frame of the cube as it is seen, south first, in memory."""
    with hcss_twin.open_cube(path) as cube:
        return FrameSelection.as_seen(cube).isel(time=0).load()


ALL = pytest.mark.parametrize("kind", KINDS)


@ALL
def test_verify_finds_the_same_bits(cubes, kind):
    assert json.loads(command("verify", kind, "verify", cubes(kind), "--json").output)["verdict"] == "identical"


@ALL
def test_preview_draws_what_the_cube_has(cubes, kind, tmp_path):
    image = pytest.importorskip("PIL.Image")
    command("preview", kind, "preview", cubes(kind), "-o", tmp_path)
    pictures = sorted(tmp_path.glob("*.png"))
    assert len(pictures) == (2 if kind == "derived" else 1)
    with image.open(pictures[0]) as picture:
        assert np.asarray(picture.convert("L")).std() > 10.0


@pytest.mark.parametrize("kind", ["grid", "camera", "measured", "zarr", "mask"])
def test_preview_in_kelvin(cubes, kind, tmp_path):
    command("kelvin", kind, "preview", cubes(kind), "--kelvin", "-o", tmp_path)
    assert bool(list(tmp_path.glob("*.png"))) == (("kelvin", kind) not in REFUSED)


@ALL
def test_report_shows_the_frames_and_the_verdict(cubes, kind, tmp_path):
    command("report", kind, "report", cubes(kind), "-o", tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert page.count("data:image/png") >= 2
    assert ("computed as specified" in page) == (kind not in ("mask", "measured"))


@ALL
@pytest.mark.parametrize("form", ["envi", "fits"])
def test_exported_numbers_are_those_of_the_cube(cubes, kind, form, tmp_path):
    pytest.importorskip("hcss_export")
    if form == "fits":
        pytest.importorskip("astropy")
    name = "cloud_mask" if kind == "mask" else "radiance"
    out = tmp_path / {"envi": "e.img", "fits": "e.fits"}[form]
    command("export", kind, "export", cubes(kind), "--to", form, "--variable", name, "-o", out)
    expected = images(cubes(kind))[name].to_numpy()
    if form == "fits":
        from astropy.io import fits

        with fits.open(out) as file:
            found = file[0].data
        found = found[0] if kind == "push-broom" else found  # of two frames
    else:
        found = np.fromfile(out, expected.dtype)[: expected.size].reshape(expected.shape)[..., ::-1, :]
    np.testing.assert_array_equal(np.squeeze(found), np.squeeze(expected))


@ALL
def test_sense_adds_noise_of_the_size_that_the_sensor_states(cubes, kind, tmp_path):
    (tmp_path / "sensor.toml").write_text(SENSOR, encoding="utf-8")
    out = tmp_path / "s.nc"
    if command("sense", kind, "sense", cubes(kind), "--sensor", tmp_path / "sensor.toml", "-o", out) is None:
        return
    kelvin = [hcss_twin.brightness_temperature(path)[0, 0] for path in (out, cubes(kind))]
    # The difference is stated at 300 K; colder scenes have more of it, by the derivative of Planck's law.
    slope = [
        float(np.diff(planck(1e4 / 10.75, at + np.array([-0.5, 0.5])))[0]) for at in (300.0, np.nanmean(kelvin[1]))
    ]
    assert np.nanstd(kelvin[0] - kelvin[1]) == pytest.approx(0.05 * slope[0] / slope[1], rel=0.05)


@ALL
def test_volume_holds_the_clouds_of_the_mask(cubes, kind, tmp_path):
    out = tmp_path / "v.nc"
    if command("volume", kind, "volume", cubes(kind), "-o", tmp_path / "v.png", "--occupancy", out) is None:
        return
    with h5py.File(out) as file:
        (occupied,) = (data for data in file.values() if data.ndim == 3)
        columns = np.any(occupied[:] > 0.0, axis=0)
    np.testing.assert_array_equal(columns, images(cubes(kind))["cloud_mask"] == 1)


@ALL
def test_match_measures_the_coverage_of_the_cube(cubes, kind, tmp_path):
    pytest.importorskip("hcss_evaluate")
    out = tmp_path / "m.toml"
    if command("match", kind, "match", cubes(kind), "-o", out, "--budget", "0") is None:
        return
    found = tomllib.loads(out.read_text(encoding="utf-8"))["clouds"]["coverage"]
    assert found == pytest.approx(float(images(cubes(kind))["cloud_mask"].mean()), abs=1e-6)


@ALL
def test_evaluate_finds_no_difference_of_a_cube_from_itself(cubes, kind):
    pytest.importorskip("hcss_evaluate")
    cube, band = cubes(kind), () if kind == "mask" else ("--real-band", "window")
    result = command("evaluate", kind, "evaluate", cube, cube, *band, "--json", "-")
    if result is not None:
        assert json.loads(result.output)["eq24"]["corrected"]["RMSE"] == 0.0


def test_evaluate_finds_the_difference_of_another_cube(cubes):
    pytest.importorskip("hcss_evaluate")
    result = hcss("evaluate", cubes("grid"), cubes("window"), "--real-band", "window", "--json", "-")
    assert json.loads(result.output)["eq24"]["corrected"]["RMSE"] > 0.0


@pytest.mark.parametrize("kind", ["window", "camera", "mask", "int16", "derived"])
def test_the_dataset_of_a_sweep_has_the_cubes_of_its_points(cubes, kind, tmp_path):
    sweeps = pytest.importorskip("hcss_sweep")
    cubes(kind)  # skips what is not installed
    (tmp_path / "scene.json").write_text(scenario(kind).to_json(), encoding="utf-8")
    over = "--over", "seed=[1, 2]", "--dataset", tmp_path / "all.nc"
    command("sweep", kind, "sweep", tmp_path / "scene.json", "-o", tmp_path / "points", *over)
    with sweeps.open_sweep(tmp_path / "all.nc") as data:
        for number in (0, 1):
            with hcss_twin.open_cube(tmp_path / "points" / f"point-{number:04}.nc") as cube:
                for name in cube.data_vars:
                    np.testing.assert_array_equal(
                        data[name].isel(seed=number, missing_dims="ignore"), cube[name], str(name)
                    )
    for source in ("points", "all.nc"):
        command("report", kind, "report", tmp_path / source, "-o", tmp_path / f"{source}.html")
        assert "data:image/png" in (tmp_path / f"{source}.html").read_text(encoding="utf-8")


def test_maps_of_draws_are_on_the_axes_of_a_camera(cubes, tmp_path):
    pytest.importorskip("hcss_uncertainty")
    cube = cubes("camera")
    (tmp_path / "scene.json").write_text(scenario("camera").to_json(), encoding="utf-8")
    varied = "--uncertain", "sea.wind_speed=normal:7:0.5", "--draws", "2", "--maps"
    hcss("propagate", tmp_path / "scene.json", *varied, "-o", tmp_path / "p.nc")
    with h5py.File(tmp_path / "p.nc") as maps, h5py.File(cube) as file:
        for axis in ("row", "column"):
            np.testing.assert_array_equal(maps[axis], file[axis])
        means = [values for name, values in maps.items() if name.endswith("_mean") and values.ndim == 4]
        assert means
        assert all(values.shape == (1, 1, *file["radiance"].shape[2:]) for values in means)
    hcss("report", tmp_path / "p.nc", "-o", tmp_path / "p.html")
    assert "data:image/png" in (tmp_path / "p.html").read_text(encoding="utf-8")
