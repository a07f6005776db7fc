"""The cases whose results are recorded: one function each, which writes into a folder and returns what it found.

A case uses only the public names of ``hcss_twin`` and the command ``hcss``: it stays as it is when modules move.
It returns, by name, datasets (paths of cubes or open datasets), arrays, and answers in JSON.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import hcss_twin
from hcss_twin import Scenario, simulate

Results = dict[str, Any]
Case = Callable[[Path], Results]

CASES: dict[str, Case] = {}

QUICK = ("clear-sky", "night", "window", "layers-averaged-pixels", "plan")
"""Cases that take a second or less each with the kernels compiled: every run of the tests compares them."""

RANDOM_WALKS = ("fit-dimension", "fit-image", "match")
"""Cases in which rounding decides between branches, and each branch leads elsewhere: they have no tolerance."""

CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie"}
"""The models of the HCSS paper, which compile quickly."""

SMALL = {
    "image.rows": 32,
    "image.columns": 48,
    "frames.count": 2,
    "accuracy": 1e-2,
    "output.certificate": 8,
    "output.variables": ["all"],
}
IR = {"bands": ["mwir-3.7", "lwir-10.8"]}

SCENE = {
    "time": "2024-04-20T12:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "atmosphere": {"profile": "us-standard-1976", "parameters": {"aerosol": "none"}},
    "sea": {"temperature": 291.4, "wind_speed": 8.0},
    "seed": 3,
}
LAYERS = [
    {"type": "stratus", "coverage": 0.4, "coverage_mode": "field"},
    {"type": "cirrus", "coverage": 0.5, "coverage_mode": "field", "edge_taper": 0.2},
]


def hcss(*words: object) -> str:
    """Run the command, and return what it prints for programs."""
    from click.testing import CliRunner

    command = importlib.import_module("hcss_twin.cli").cli
    done = CliRunner().invoke(command, [str(word) for word in words], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return str(done.stdout)


def case(function: Case) -> Case:
    """Add a function to the table."""
    CASES[function.__name__.replace("_", "-")] = function
    return function


def cube(folder: Path, source: str | dict[str, Any], name: str = "cube.nc", **overrides: Any) -> Path:
    """Write the cube of a shipped scenario, or of keys, made small."""
    values = {**SMALL, **overrides}
    load = Scenario.load if isinstance(source, str) else Scenario.from_dict
    simulate(load(source, values), folder / name).close()
    return folder / name


@contextlib.contextmanager
def inside(folder: Path) -> Iterator[None]:
    """Run in a folder, so that no path of the machine is in a scenario."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def fragment(folder: Path, name: str, text: str) -> Path:
    """Write a scenario file."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def cloud_image(rows: int = 96, columns: int = 112) -> np.ndarray:
    """Blurred noise between 0 and 1, by exact binary steps of addition: the same on any machine."""
    values = np.random.default_rng(7).integers(0, 2**20, (rows, columns)).astype(np.float64)
    for _ in range(6):
        for axis in (0, 1):
            values = values + np.roll(values, 1, axis)
    return (values - values.min()) / np.ptp(values)


# --- shipped scenarios ------------------------------------------------------------------


@case
def shipped_baseline(folder: Path) -> Results:
    return {"cube": cube(folder, "baseline")}


@case
def shipped_cirrus(folder: Path) -> Results:
    return {"cube": cube(folder, "cirrus", **IR)}


@case
def shipped_cirrus_over_cumulus(folder: Path) -> Results:
    return {"cube": cube(folder, "cirrus-over-cumulus", **{"bands": ["lwir-10.8"], "output.certificate": 4})}


@case
def shipped_cumulus(folder: Path) -> Results:
    return {"cube": cube(folder, "cumulus", bands=["mwir"])}


@case
def shipped_degraded_cirrus(folder: Path) -> Results:
    values = {"frames.count": 1, "sensor.variables": ["all"]}
    return {"cube": cube(folder, "degraded-cirrus", **values), "measured": folder / "cube.sensor.nc"}


@case
def shipped_simulated(folder: Path) -> Results:
    return {"cube": cube(folder, "simulated", bands=["lwir"])}


@case
def shipped_stratus(folder: Path) -> Results:
    return {"cube": cube(folder, "stratus", **IR)}


# --- models -----------------------------------------------------------------------------


@case
def as_printed(folder: Path) -> Results:
    return {"cube": cube(folder, "stratus", **CHEAP, bands=["swir-2.7-3.0", "mwir", "lwir"])}


@case
def as_printed_with_rough_sea_and_bulk_optics(folder: Path) -> Results:
    values = {**IR, **CHEAP, "sea.model": "rough-sea", "optics.provider": "bulk", "view.zenith": 50.0}
    return {"cube": cube(folder, "stratus", **values)}


@case
def physical_two_stream(folder: Path) -> Results:
    return {"cube": cube(folder, "stratus", **IR, **{"radiance.model": "physical-two-stream"})}


@case
def accuracy_in_kelvin(folder: Path) -> Results:
    values = {**CHEAP, "bands": ["lwir-10.8"], "accuracy": "0.2 K"}
    return {"cube": cube(folder, "cumulus", **values)}


@case
def climatology(folder: Path) -> Results:
    """Air and sea of place and month, which the scenario does not give."""
    scene = {"time": "2024-01-15T12:00:00Z", "place": {"latitude": -10.0, "longitude": -20.0}}
    clouds = {"clouds": {"type": "cumulus", "coverage": 0.3}}
    return {"cube": cube(folder, scene | clouds, **{**CHEAP, "bands": ["lwir-10.8"]})}


@case
def table_atmosphere(folder: Path) -> Results:
    """A tabulated atmosphere, with its profile, below the physical model of a sea seen at a slant."""
    values = {**IR, "atmosphere": {"provider": "table"}, "view.zenith": 60.0, "clouds.coverage": 0.2}
    return {"cube": cube(folder, "stratus", **values)}


# --- clouds -----------------------------------------------------------------------------


@case
def layers_averaged_pixels(folder: Path) -> Results:
    values = {**CHEAP, "bands": ["lwir-10.8"], "clouds": {"layers": LAYERS}, "image.samples_per_pixel": 2}
    return {"cube": cube(folder, SCENE, **values)}


@case
def surrogate_clouds(folder: Path) -> Results:
    np.save(folder / "image.npy", cloud_image())
    clouds = {"type": "stratus", "coverage": 0.3, "generator": "surrogate"}
    clouds["parameters"] = {"image": "image.npy", "method": "coverage"}
    values = {"image.pixel_size": 200.0, "frames.interval": 60.0, "motion.evolution_time": 600.0}
    with inside(folder):
        return {"cube": cube(folder, SCENE | {"clouds": clouds}, **values, **CHEAP, bands=["lwir-10.8"])}


@case
def imagery_clouds(folder: Path) -> Results:
    """A satellite image (SEVIRI, 10.8 um) as a static scene."""
    sample = importlib.import_module("iris_sample_data")
    image = Path(sample.path) / "toa_brightness_stereographic.nc"
    clouds = {"type": "cumulus", "top": 10_000.0, "generator": "imagery"}
    clouds["parameters"] = {"image": str(image), "missing": "clear"}
    values = {"image.rows": 64, "image.columns": 96, "image.pixel_size": 35_492.0, "frames.count": 1}
    return {"cube": cube(folder, SCENE | {"clouds": clouds}, **{**values, **CHEAP, **IR})}


@case
def imagery_single_clouds(folder: Path) -> Results:
    """An image made into an entry of the cloud database, whose clouds are scattered over a push-broom scene."""
    np.save(folder / "sea.npy", cloud_image())
    with inside(folder):
        imported = json.loads(hcss("import", "sea.npy", "--pixel-size", "500", "--json"))
        clouds = {"type": "cumulus", "coverage": 0.4, "coverage_mode": "field", "generator": "imagery"}
        clouds["parameters"] = {"entry": "sea", "placement": "single-clouds"}
        values = {"image.pixel_size": 500.0, "motion": {"platform_speed": 2000.0, "wind_speed": 0.0}}
        scene = SCENE | {"clouds": clouds, "frames": {"interval": 1.0}}
        made = cube(folder, scene, **{**values, **CHEAP, "bands": ["lwir-10.8"]})
    return {"entry": folder / "clouds" / "sea.nc", "import": imported, "cube": made}


# --- geometry, light and time -----------------------------------------------------------


@case
def shadows(folder: Path) -> Results:
    clouds = {"type": "cumulus", "base": 1000.0, "top": 1900.0, "coverage": 0.4, "coverage_mode": "field"}
    values = {**IR, "slant.shadows": True, "image.pixel_size": 100.0, "output.certificate": 4}
    return {"cube": cube(folder, SCENE | {"clouds": clouds}, **values)}


@case
def shadows_and_parallax(folder: Path) -> Results:
    values = {**CHEAP, **IR, "clouds": {"layers": LAYERS}, "image.pixel_size": 200.0, "view.zenith": 30.0}
    return {"cube": cube(folder, SCENE, **values, **{"slant.shadows": True, "slant.parallax": True})}


@case
def resolved_waves(folder: Path) -> Results:
    sea = {"sea.model": "rough-sea", "sea.waves": "resolved"}
    values = {**CHEAP, **IR, "image.pixel_size": 2.0, "view.zenith": 40.0, "accuracy": 3e-3}
    clouds = {"type": "cumulus", "coverage": 0.4}
    return {"cube": cube(folder, SCENE | {"clouds": clouds}, **{**values, **sea})}


WIDE = {
    **CHEAP,
    "bands": ["lwir-10.8"],
    "image.pixel_size": 3000.0,
    "platform.altitude": "800 km",
    "platform.mode": "push-broom",
}


@case
def wide_field(folder: Path) -> Results:
    """Several views; the second cube is a window of the first."""
    values = WIDE | {"output.variables": ["all", "geometry"]}
    window = {"image.window": {"rows": [17, 30], "columns": [3, 36]}, "output.certificate": 0}
    return {
        "cube": cube(folder, "stratus", **values),
        "window": cube(folder, "stratus", "window.nc", **values, **window),
    }


@case
def wide_field_physical(folder: Path) -> Results:
    values = {**WIDE, "radiance.model": "physical", "sea.model": "rough-sea", "optics.provider": "bulk"}
    values |= {"clouds.type": "cirrus", "output.certificate": 4}
    return {"cube": cube(folder, "cirrus", **values)}


@case
def moving_sun(folder: Path) -> Results:
    """From the afternoon into the night."""
    values = {**CHEAP, **IR, "frames.count": 6, "frames.interval": 1200.0, "image.rows": 24, "image.columns": 24}
    scene = SCENE | {"clouds": {"type": "stratus", "coverage": 0.5}, "time": "2024-04-20T16:45:00+10:00"}
    return {"cube": cube(folder, scene, **values)}


@case
def moving_sun_physical(folder: Path) -> Results:
    values = {"bands": ["mwir-3.7"], "frames.count": 4, "frames.interval": 600.0, "image.rows": 24}
    return {"cube": cube(folder, "cirrus", **values)}


@case
def night(folder: Path) -> Results:
    values = {**CHEAP, **IR, "time": "2024-04-20T00:30:00+10:00"}
    return {"cube": cube(folder, "stratus", **values)}


@case
def clear_sky(folder: Path) -> Results:
    return {"cube": cube(folder, SCENE, **CHEAP, **IR)}


@case
def clear_sky_physical(folder: Path) -> Results:
    """Without a file: the dataset in memory."""
    scenario = Scenario.from_dict(SCENE, {**SMALL, "bands": ["swir-2.7-3.0", "lwir"]})
    return {"dataset": simulate(scenario)}


# --- parts, formats, and what reads cubes -----------------------------------------------


@case
def window(folder: Path) -> Results:
    """A window holds the bits of the same part of the whole image."""
    values = {**CHEAP, "bands": ["mwir-3.7"], "output.certificate": 0, "clouds.coverage_mode": "frame"}
    whole = cube(folder, "stratus", "whole.nc", **values)
    place = {"image.window": {"rows": [5, 29], "columns": [7, 40]}}
    part = cube(folder, "stratus", "part.nc", **values, **place)
    with hcss_twin.open_cube(whole) as one, hcss_twin.open_cube(part) as other:
        for name in other.data_vars:
            if {"y", "x"} <= set(other[name].dims):
                same = one[name].isel(y=slice(5, 29), x=slice(7, 40))
                np.testing.assert_array_equal(other[name].values, same.values, err_msg=str(name))
    return {"whole": whole, "part": part}


@case
def zarr_quantized(folder: Path) -> Results:
    """A Zarr store holds the values of the NetCDF file."""
    values = {**CHEAP, **IR, "output.quantization": 1e-4, "output.compression": 4}
    file = cube(folder, "stratus", **values)
    store = cube(folder, "stratus", "cube.zarr", **values)
    with hcss_twin.open_cube(file) as one, hcss_twin.open_cube(store) as other:
        for name in one.variables:
            np.testing.assert_array_equal(one[name].values, other[name].values, err_msg=str(name))
        return {"file": file, "store": other.load()}


@case
def sense_of_a_cube(folder: Path) -> Results:
    """`hcss sense` of a finished cube by two named sensors, and from Python."""
    clean = cube(folder, "stratus", **CHEAP, bands=["mwir", "lwir-10.8"])
    every = ("--set", 'variables=["all"]')
    hcss("sense", clean, "--sensor", "generic-mwir", *every, "-o", folder / "mwir.nc")
    section = {"parameters": {"noise": "nedt", "nedt": 0.05, "psf": "gaussian", "psf_sigma": 1.2}}
    return {"generic-mwir": folder / "mwir.nc", "own": hcss_twin.sense(clean, section)}


PAIR = """
time = 2024-04-20T12:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
seed = 5
bands = ["mwir", {name = "spike", limits = [4.17, 4.2]}]
image = {rows = 32, columns = 40}
frames = {count = 3, first = 2, interval = 0.5}
motion.platform_speed = 1000
clouds.type = "stratus"
output = {variables = ["radiance", "radiance_sea_emission", "truth"], certificate = 4}
accuracy = 1e-2
radiance.model = "as-printed"
sea.model = "cox-munk"
optics.provider = "mie"

[sensor]
variables = ["all"]
parameters = {psf = "airy", aperture_diameter = 0.2, pixel_angle = 4e-5, integration_time = 2e-3, noise = "photon", \
well_depth = 1e7, bits = 14}
"""


@case
def run_with_a_sensor(folder: Path) -> Results:
    """`hcss run` of a file: clean and measured cube."""
    hcss("run", fragment(folder, "pair.toml", PAIR), "-o", folder / "pair.nc", "--json")
    return {"clean": folder / "pair.nc", "measured": folder / "pair.sensor.nc"}


@case
def exports(folder: Path) -> Results:
    """Samples of files that other programs read; headers say who wrote them and are left out."""
    values = {**CHEAP, "bands": ["lwir-10.8"], "output.variables": ["radiance"], "output.certificate": 0}
    made = cube(folder, "stratus", **values)
    hcss_twin.export_cube(made, "envi", folder / "a.img")
    hcss_twin.export_cube(made, "geotiff", folder / "b.tif")
    from PIL import Image

    hcss_twin.export_cube(made, "png", folder / "c.png")
    pictures = {}
    for path in sorted(folder.glob("c*.png")):
        with Image.open(path) as picture:
            pictures[path.stem] = np.asarray(picture)
    import tifffile

    tiffs = {path.stem: tifffile.imread(path) for path in sorted(folder.glob("b*.tif"))}
    return {"envi": np.fromfile(folder / "a.img", dtype="<f4"), **pictures, **tiffs}


@case
def volume(folder: Path) -> Results:
    """`hcss volume`: filled shares of voxels."""
    made = cube(folder, "cumulus", **CHEAP, bands=["lwir-10.8"])
    options = ("-o", folder / "v.png", "--occupancy", folder / "v.nc", "--step-m", 200, "--json")
    return {"answer": json.loads(hcss("volume", made, *options)), "voxels": folder / "v.nc"}


# --- many scenes ------------------------------------------------------------------------


@case
def sweep_of_three_points(folder: Path) -> Results:
    values = {**SMALL, **CHEAP, "bands": ["lwir-10.8"], "frames.count": 1}
    done = hcss_twin.sweep(
        "stratus", folder / "sweep", over={"view.zenith": [0, 30, 60]}, overrides=values, dataset=folder / "all.nc"
    )
    assert not done.failed
    return {"dataset": hcss_twin.open_sweep(folder / "all.nc"), "last": done.cube(2)}


@case
def propagation(folder: Path) -> Results:
    """`hcss run --draws` with two uncertain inputs."""
    values = {**SMALL, **CHEAP, **IR, "frames.count": 1, "output.variables": ["radiance"]}
    words = [word for key, value in values.items() for word in ("--set", f"{key}={json.dumps(value)}")]
    uncertain = ["--uncertain", "sea.temperature=normal:291:0.5", "--uncertain", "clouds.coverage=uniform:0.2:0.8"]
    out = folder / "a.nc"
    answer = json.loads(hcss("run", "stratus", "--draws", 8, *uncertain, *words, "-o", out, "--json"))
    del answer["pixels"]  # in the file
    return {"file": hcss_twin.open_propagation(out), "answer": answer}


# --- answers in JSON --------------------------------------------------------------------


@case
def evaluate(folder: Path) -> Results:
    values = {"frames.count": 3, "frames.interval": 60.0, "image.rows": 64, "image.columns": 80}
    values |= {"image.pixel_size": 100.0, "motion.platform_speed": 0.0, "output.certificate": 0}
    made = cube(folder, "cumulus", **{**CHEAP, "bands": ["lwir-10.8"], **values})
    np.save(folder / "image.npy", cloud_image(64, 80))
    with inside(folder):
        words = ("--real-pixel-size", "100 m")
        pair = json.loads(hcss("evaluate", "image.npy", made.name, *words, "--json", "-"))
        self = json.loads(hcss("evaluate", made.name, made.name, "--json", "-"))
    return {"image-and-cube": pair, "cube-and-itself": self}


IMAGE = ("--pixel-size", "20 m", "--method", "coverage", "--coverage", 0.4)
FIXED = ("--fix", "gamma=2", "--samples", 100, "--json")


@case
def fit_dimension(folder: Path) -> Results:
    size = ("--rows", 64, "--columns", 64)
    out = folder / "d.nc"
    answer = hcss("fit", "--fd", 2.4, "--fd-error", 0.05, *size, *FIXED, "--fix", "coverage=0.4", "-o", out)
    posterior = hcss_twin.read_posterior(out)
    return {"answer": json.loads(answer), **posterior.samples}


@case
def fit_image(folder: Path) -> Results:
    np.save(folder / "a.npy", cloud_image(64, 64))
    with inside(folder):
        words = ("--fix", "coverage=image", "--fix", "Lx=40", "-o", "p.nc")
        answer = hcss("fit", "a.npy", *IMAGE, *FIXED, *words)
        posterior = hcss_twin.read_posterior(Path("p.nc"))
    return {"answer": json.loads(answer), **posterior.samples}


@case
def match(folder: Path) -> Results:
    np.save(folder / "a.npy", cloud_image(64, 64))
    with inside(folder):
        return {"answer": json.loads(hcss("match", "a.npy", *IMAGE, "--budget", 2, "--json", "-o", "m.toml"))}


@case
def plan(folder: Path) -> Results:
    """`hcss plan` of scenarios in full size."""
    words = [word for key, value in CHEAP.items() for word in ("--set", f"{key}={value}")]
    return {
        "baseline": json.loads(hcss("plan", "baseline", "--json")),
        "cirrus-over-cumulus": json.loads(hcss("plan", "cirrus-over-cumulus", "--json", *words)),
    }
