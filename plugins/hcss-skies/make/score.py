"""Score examples imported from a file of satellite images through the engine: AUC, copies and coherence.

``python make/score.py BLOCKS.nc [--half 1] [--clear-sky uniform] [--frames 0,1,4] [--seed 3]`` imports each image of
``ir_108`` (dimensions scene, time, y, x), simulates its sky with a seed of its own, by night, as brightness temperature
at 10.3 to 11.3 um, and prints the realism test against these images. ``--half`` takes every second scene: choose
settings with one half and report the other. Needs hcss-evaluate with scikit-learn.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import netCDF4
import numpy as np
from hcss_evaluate.realism import compare
from hcss_evaluate.realism.text import realism_text
from hcss_skies.example import write_example
from hcss_skies.importing import import_example

import hcss_twin

SCENARIO = """
title = "Sky like an image"
seed = {seed}
bands = ["lwir-10.8"]
time = 2020-09-06T00:15:00Z
[place]
latitude = 15.0
longitude = -30.0
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
[atmosphere]
profile = "tropical"
[clouds]
type = "deep-convection"
thickness_min = 0.01
generator = "example"
parameters = {{example = "block", clear_sky = "{clear}"}}
[sea]
wind_speed = 7.0
temperature = 300.0
[output]
variables = ["radiance", "brightness_temperature", "cloud_mask"]
"""


def main() -> None:
    """Parse arguments, simulate and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("file", type=Path)
    parser.add_argument("--half", type=int, choices=(0, 1))
    parser.add_argument("--clear-sky", default="example", choices=("uniform", "example"))
    parser.add_argument("--frames", default="0", help="Frames to test, 30 min apart: 0,1,4 for 0, 30 and 120 min.")
    parser.add_argument("--time", type=int, default=1, help="Index of the time of the images.")
    parser.add_argument("--seed", type=int, default=0, help="Other skies of the same images.")
    given = parser.parse_args()
    frames = [int(each) for each in given.frames.split(",")]
    with netCDF4.Dataset(given.file) as file:
        measured = np.ma.filled(file["ir_108"][:, given.time].astype(float), np.nan)
    scenes = range(0 if given.half is None else given.half, len(measured), 1 if given.half is None else 2)
    kelvin: list[np.ndarray] = []
    numbers: list[int] = []
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "skies").mkdir()
        for scene in scenes:
            done = import_example(
                given.file, variable="ir_108", at={"block": scene, "time": given.time}, pixel_size_m=3000.0
            )
            write_example(Path(folder) / "skies" / "block.nc", done.example)
            path = Path(folder) / "scene.toml"
            seed = scene + 100 * given.seed
            path.write_text(SCENARIO.format(seed=seed, count=max(frames) + 1, clear=given.clear_sky), encoding="utf-8")
            cube = hcss_twin.simulate(hcss_twin.Scenario.load(path))
            values = np.asarray(cube["brightness_temperature"].isel(band=0))
            kelvin += [values[each].astype(float) for each in frames]
            numbers += [scene] * len(frames)
    print(realism_text(compare(measured[list(scenes)], kelvin, list(scenes), numbers, copies=300)))


if __name__ == "__main__":
    main()
