"""Score clouds made from a file of satellite images through the engine: AUC, copies, distribution of temperature.

``python make/score.py BLOCKS.nc [--half 1] [--clear-sky uniform] [--frames 0,1,4] [--seed 3]`` imports each image of
``ir_108`` (dimensions scene, time, y, x), simulates its sky with a seed of its own, by night, as brightness temperature
at 10.3 to 11.3 um, and prints the realism test against these images. ``--half`` takes every second scene: choose
settings with one half and report the other. ``--generator imagery`` or ``surrogate`` (structure "bands", or with
``--structure spectrum`` the default one) makes clouds of the images' own temperature, without a second blur, and
``measured`` compares disjoint halves of the images. ``--own`` gives each scene the air of its place and a sea so warm
that clear sky has the 99th percentile of the image, and prints how far percentiles and cover of the sky are from those
of the image. Needs hcss-evaluate with scikit-learn.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import netCDF4
import numpy as np
import xarray as xr
from hcss_evaluate.realism import compare
from hcss_evaluate.realism.text import realism_text
from hcss_skies.example import write_example
from hcss_skies.importing import import_example
from scipy.ndimage import gaussian_filter

import hcss_twin

SCENARIO = """
title = "Sky like an image"
seed = {seed}
bands = ["lwir-10.8"]
time = 2020-09-06T00:15:00Z
[place]
latitude = {place[0]}
longitude = {place[1]}
[view]
zenith = 20.0
azimuth = 0.0
[image]
rows = 256
columns = 256
pixel_size = 3000.0
[frames]
count = {count}
interval = 1800.0
[motion]
platform_speed = 0.0
wind_speed = 0.0
evolution_time = 1800.0
{air}
[clouds]
type = "deep-convection"
thickness_min = 0.01
generator = "{generator}"
parameters = {parameters}
[sea]
wind_speed = 7.0
temperature = {sea}
[output]
variables = ["radiance", "brightness_temperature", "cloud_mask"]
"""

SEAS_K = 280.0, 300.0
COLDER_K = 2.5
"""Pixels so much colder than the 99th percentile of the image are cloud, as in the realism test."""
SPLITS, REAL = 10, {"blur_pixels": 0.0, "scales": ("z-scored",), "copies": 0, "resamples": 2}


def main() -> None:
    """Parse arguments, simulate and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("file", type=Path)
    parser.add_argument("--half", type=int, choices=(0, 1))
    parser.add_argument("--scenes", help="Places in the file: 0,4,8 in place of a half or all.")
    parser.add_argument("--generator", default="example", choices=("example", "imagery", "surrogate", "measured"))
    parser.add_argument("--structure", default="bands", choices=("bands", "spectrum"), help="Of surrogates.")
    parser.add_argument("--clear-sky", default="example", choices=("uniform", "example"))
    parser.add_argument("--own", action="store_true", help="Air of the place, clear sky as warm as in the image.")
    parser.add_argument("--lapse", type=float, default=6.5, help="K/km, with which images are imported.")
    parser.add_argument("--frames", default="0", help="Frames to test, 30 min apart: 0,1,4 for 0, 30 and 120 min.")
    parser.add_argument("--time", type=int, default=1, help="Index of the time of the images.")
    parser.add_argument("--seed", type=int, default=0, help="Other skies of the same images.")
    given = parser.parse_args()
    frames = [int(number) for number in given.frames.split(",")]
    with netCDF4.Dataset(given.file) as file:
        measured = np.ma.filled(file["ir_108"][:, given.time].astype(float), np.nan)
        places = [[float(file[name][n].mean()) for name in ("latitude", "longitude")] for n in range(len(measured))]
    scenes = list(range(given.half or 0, len(measured), 1 if given.half is None else 2))
    scenes = [int(number) for number in given.scenes.split(",")] if given.scenes else scenes
    if given.generator == "measured":
        real_against_real(measured, scenes)
        return
    kelvin: list[np.ndarray] = []
    blur = 0.65 if given.generator == "example" else 0.0
    parameters = (
        f'{{example = "block", clear_sky = "{given.clear_sky}"}}'
        if given.generator == "example"
        else '{image = "image.nc", method = "temperature", reinterpret_pixel_size = true'
        + (f', structure = "{given.structure}"}}' if given.generator == "surrogate" else "}")
    )
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "skies").mkdir()
        path = Path(folder) / "scene.toml"

        def scene_of(scene: int, sea_K: float) -> hcss_twin.Scenario:
            """Return the scenario of a scene, whose image is already in the folder."""
            seed, count = scene + 100 * given.seed, max(frames) + 1
            position, air = (places[scene], "") if given.own else ([15.0, -30.0], '[atmosphere]\nprofile = "tropical"')
            of_scene = {"seed": seed, "count": count, "sea": sea_K, "place": position, "air": air}
            text = SCENARIO.format(generator=given.generator, parameters=parameters, **of_scene)
            path.write_text(text, encoding="utf-8")
            return hcss_twin.Scenario.load(path)

        for scene in scenes:
            image = xr.DataArray(measured[scene], dims=("y", "x"), attrs={"units": "K"})
            image.to_netcdf(Path(folder) / "image.nc")
            at = {"block": scene, "time": given.time}
            done = import_example(given.file, variable="ir_108", at=at, pixel_size_m=3000.0, lapse_K_km=given.lapse)
            write_example(Path(folder) / "skies" / "block.nc", done.example)
            warm_K, sea_K = float(np.percentile(measured[scene], 99.0)), 300.0
            if given.own:
                clear_K = [
                    hcss_twin.make_plan(scene_of(scene, kelvin)).assembly.built["clouds"].inputs.inversion.clear_K
                    for kelvin in SEAS_K
                ]
                sea_K = SEAS_K[0] + (warm_K - clear_K[0]) * (SEAS_K[1] - SEAS_K[0]) / (clear_K[1] - clear_K[0])
            cube = hcss_twin.simulate(scene_of(scene, sea_K))
            values = np.asarray(cube["brightness_temperature"].isel(band=0))
            kelvin += [values[frame].astype(float) for frame in frames]
            if given.own:
                show_distribution(scene, measured[scene], kelvin[-len(frames) :], warm_K - COLDER_K, blur)
    numbers = np.repeat(scenes, len(frames))
    if len(scenes) > 6:
        print(realism_text(compare(measured[scenes], kelvin, scenes, numbers, copies=300, blur_pixels=blur)))


def show_distribution(scene: int, image: np.ndarray, skies: list[np.ndarray], cold_K: float, blur: float) -> None:
    """Print percentiles and cover of an image, less those of the blurred skies of one scene, all together."""
    both = [image, np.stack([gaussian_filter(sky, blur) if blur else sky for sky in skies])]
    percentiles = [np.percentile(values, np.arange(1, 100)) for values in both]
    off = percentiles[1] - percentiles[0]
    cover = [float(np.mean(values < cold_K)) for values in both]
    print(
        f"scene {scene:2}: coldest percentile {percentiles[0][0]:.1f} K {off[0]:+.1f} K, cover {cover[0]:.2f} "
        f"{cover[1] - cover[0]:+.3f}, percentiles off by {np.abs(off).mean():.1f} K in the mean, at most "
        f"{np.abs(off).max():.1f} K, clear sky by {off[-1]:+.1f} K",
        flush=True,
    )


def real_against_real(measured: np.ndarray, scenes: list[int]) -> None:
    """Print AUC between halves of every image (left or right, by chance), and between half of the images and others."""
    width = measured.shape[2] // 2
    for name in ("halves of every image", "half of the images"):
        found = []
        for split in range(SPLITS):
            order = np.random.default_rng(split).permutation(scenes)
            first, second = np.array_split(order, 2)
            if name == "half of the images":
                result = compare(measured[first], measured[second], first, second, **REAL, seed=split)
            else:
                left, right = measured[order, :, :width], measured[order, :, width:]
                turned = np.isin(order, first)[:, None, None]
                sides = np.where(turned, right, left), np.where(turned, left, right)
                result = compare(*sides, order, order, **REAL, seed=split)
            found.append([score.auc for score in result.scores])
        for classifier, scores in zip(("forest", "boosting"), np.array(found).T, strict=True):
            print(f"{name}, {classifier}: {scores.mean():.3f}, {scores.min():.3f} to {scores.max():.3f}", flush=True)


if __name__ == "__main__":
    main()
