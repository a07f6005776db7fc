"""Recorded cases: parts, formats, and what reads cubes. Every function is one case, as in ``scenes.py``."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from small_cubes import CHEAP, IR, SMALL, Results, cloud_image, cube, fragment, hcss, inside

import hcss_twin

# --- parts, formats, and what reads cubes -----------------------------------------------


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


def zarr_quantized(folder: Path) -> Results:
    """A Zarr store holds the values of the NetCDF file."""
    values = {**CHEAP, **IR, "output.quantization": 1e-4, "output.compression": 4}
    file = cube(folder, "stratus", **values)
    store = cube(folder, "stratus", "cube.zarr", **values)
    with hcss_twin.open_cube(file) as one, hcss_twin.open_cube(store) as other:
        for name in one.variables:
            np.testing.assert_array_equal(one[name].values, other[name].values, err_msg=str(name))
        return {"file": file, "store": other.load()}


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
clouds = {type = "stratus", generator = "fractal"}
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


def run_with_a_sensor(folder: Path) -> Results:
    """`hcss run` of a file: clean and measured cube."""
    hcss("run", fragment(folder, "pair.toml", PAIR), "-o", folder / "pair.nc", "--json")
    return {"clean": folder / "pair.nc", "measured": folder / "pair.sensor.nc"}


def exports(folder: Path) -> Results:
    """Samples of files that other programs read; headers say who wrote them and are left out."""
    from hcss_export import export_cube

    values = {**CHEAP, "bands": ["lwir-10.8"], "output.variables": ["radiance"], "output.certificate": 0}
    made = cube(folder, "stratus", **values)
    export_cube(made, "envi", folder / "a.img")
    export_cube(made, "geotiff", folder / "b.tif")
    from PIL import Image

    export_cube(made, "png", folder / "c.png")
    pictures = {}
    for path in sorted(folder.glob("c*.png")):
        with Image.open(path) as picture:
            pictures[path.stem] = np.asarray(picture)
    import tifffile

    tiffs = {path.stem: tifffile.imread(path) for path in sorted(folder.glob("b*.tif"))}
    return {"envi": np.fromfile(folder / "a.img", dtype="<f4"), **pictures, **tiffs}


def volume(folder: Path) -> Results:
    """`hcss volume`: filled shares of voxels."""
    made = cube(folder, "cumulus", **CHEAP, bands=["lwir-10.8"])
    options = ("-o", folder / "v.png", "--occupancy", folder / "v.nc", "--step-m", 200, "--json")
    return {"answer": json.loads(hcss("volume", made, *options)), "voxels": folder / "v.nc"}


# --- many scenes ------------------------------------------------------------------------


def sweep_of_three_points(folder: Path) -> Results:
    from hcss_sweep import open_sweep, sweep

    values = {**SMALL, **CHEAP, "bands": ["lwir-10.8"], "frames.count": 1}
    done = sweep(
        "stratus", folder / "sweep", over={"view.zenith": [0, 30, 60]}, overrides=values, dataset=folder / "all.nc"
    )
    assert not done.failed
    return {"dataset": open_sweep(folder / "all.nc"), "last": done.cube(2)}


def propagation(folder: Path) -> Results:
    """`hcss propagate` with two uncertain inputs."""
    from hcss_uncertainty import open_propagation

    values = {**SMALL, **CHEAP, **IR, "frames.count": 1, "output.variables": ["radiance"]}
    words = [word for key, value in values.items() for word in ("--set", f"{key}={json.dumps(value)}")]
    uncertain = ["--uncertain", "sea.temperature=normal:291:0.5", "--uncertain", "clouds.coverage=uniform:0.2:0.8"]
    out = folder / "a.nc"
    answer = json.loads(hcss("propagate", "stratus", "--draws", 8, *uncertain, *words, "-o", out, "--json"))
    del answer["pixels"]  # in the file
    return {"file": open_propagation(out), "answer": answer}


# --- answers in JSON --------------------------------------------------------------------


def evaluate(folder: Path) -> Results:
    from hcss_evaluate import EvaluationChoice
    from hcss_evaluate import evaluate as judge

    values = {"frames.count": 3, "frames.interval": 60.0, "image.rows": 64, "image.columns": 80}
    values |= {"image.pixel_size": 100.0, "motion.platform_speed": 0.0, "output.certificate": 0}
    made = cube(folder, "cumulus", **{**CHEAP, "bands": ["lwir-10.8"], **values})
    np.save(folder / "image.npy", cloud_image(64, 80))
    with inside(folder):
        pair = judge("image.npy", made.name, EvaluationChoice(pixel_size_m=100.0)).as_dict()
        self = judge(made.name, made.name).as_dict()
    return {"image-and-cube": json.loads(json.dumps(pair)), "cube-and-itself": json.loads(json.dumps(self))}


IMAGE = ("--pixel-size", "20 m", "--method", "coverage", "--coverage", 0.4)
FIXED = ("--fix", "gamma=2", "--samples", 100, "--json")


def fit_dimension(folder: Path) -> Results:
    size = ("--rows", 64, "--columns", 64)
    from hcss_evaluate import read_posterior

    out = folder / "d.nc"
    answer = hcss("fit", "--fd", 2.4, "--fd-error", 0.05, *size, *FIXED, "--fix", "coverage=0.4", "-o", out)
    posterior = read_posterior(out)
    return {"answer": json.loads(answer), **posterior.samples}


def fit_image(folder: Path) -> Results:
    from hcss_evaluate import read_posterior

    np.save(folder / "a.npy", cloud_image(64, 64))
    with inside(folder):
        words = ("--fix", "coverage=image", "--fix", "Lx=40", "-o", "p.nc")
        answer = hcss("fit", "a.npy", *IMAGE, *FIXED, *words)
        posterior = read_posterior(Path("p.nc"))
    return {"answer": json.loads(answer), **posterior.samples}


def match(folder: Path) -> Results:
    np.save(folder / "a.npy", cloud_image(64, 64))
    with inside(folder):
        return {"answer": json.loads(hcss("match", "a.npy", *IMAGE, "--budget", 2, "--json", "-o", "m.toml"))}


def plan(folder: Path) -> Results:
    """`hcss plan` of scenarios in full size."""
    words = [word for key, value in CHEAP.items() for word in ("--set", f"{key}={value}")]
    plans = {
        "baseline": json.loads(hcss("plan", "baseline", "--json")),
        "cirrus-over-cumulus": json.loads(hcss("plan", "cirrus-over-cumulus", "--json", *words)),
    }
    for of_scene in plans.values():
        del of_scene["predicted"]  # the time on this machine
    return plans
