"""What tells the difference of 10.8 and 12.0 um of blended skies from the measured one: an ablation.

    python make/split_window.py BLOCKS.nc [--half 0|1] [--features 4]

AUC of the forest between patches (64 x 64 pixels, z-scored, .2 K of noise, folds by block) of the measured difference
``ir_108`` - ``ir_120`` and of

* ``physics``: that which the importer's model of clouds (one ratio of optical thicknesses, heights x estimated from the
  difference itself and smoothed) gives for the measured image: nothing is blended;
* ``physics, sharp``: the same with the heights before they are smoothed;
* ``exact``: clouds under gas, whose part in the difference falls by e in 2.5 km of height, with the heights of 0 to 12
  km that come closest to the measured difference at each pixel; the share of pixels where one fits is printed;
* ``blended exact``: the same of blended p and x;
* ``blended physics``: that of blended heights p and x, as in ``example``;
* ``blended difference``: the measured difference itself in the place of x, blended together with p;
* ``blended differ., shuffled``: the difference drawn at random among pixels with the same p (101 quantiles), smoothed
  as much as x is: right in its distribution for each p, wrong in its arrangement.

Patches are those in which 10.8 um has cloud, as in the realism test.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import kinds
import netCDF4
import numpy as np
from hcss_author import sample_cloud_inputs
from hcss_evaluate.realism.classifiers import auc, auc_interval, out_of_fold
from hcss_evaluate.realism.features import all_features
from hcss_evaluate.realism.patches import z_scored
from hcss_skies import split_window
from hcss_skies.example import make_example, read_example, write_example
from hcss_skies.generator import ExampleClouds
from hcss_skies.importing import CLEAR_K, clear_sky_K, sharpened
from hcss_skies.parameters import ExampleParameters
from scipy.ndimage import gaussian_filter

from hcss_twin.core.catalog import Catalog
from hcss_twin.physics.planck import planck
from hcss_twin.providers import Grid

GAS_M, HEIGHTS_M = 2500.0, np.linspace(0.0, 12_000.0, 49)
SIDE, SIZE, BLUR, NOISE_K, LAPSE_K_M, RAISED_K = 256, 64, 0.65, 0.2, 6.5e-3, 10.0
Pair = tuple[np.ndarray, np.ndarray]


def difference_of(
    first_K: np.ndarray, excess_m: np.ndarray | float, clear_K: float, second_clear_K: float, gas: bool = False
) -> np.ndarray:
    """Return the difference that clouds with tops ``excess_m`` above opaque ones have, as the importer assumes.

    With ``gas``, what is above a cloud makes it colder at 12.0 um, as it makes the clear sky.
    """
    one, two = (1e4 / each for each in split_window.WAVELENGTHS_UM)
    sea, second_sea = planck(np.array(one), clear_K), planck(np.array(two), second_clear_K)
    cloud_K = np.maximum(first_K - LAPSE_K_M * np.clip(excess_m, 0.0, None), np.minimum(185.0, first_K))
    cloud = planck(np.array(one), cloud_K)
    through = np.clip((planck(np.array(one), first_K) - cloud) / np.maximum(sea - cloud, 1e-9 * sea), 0.0, 1.0)
    through = through**split_window.DEPTH_RATIO
    dimmed_K = cloud_K
    if gas:
        top_m = np.maximum((clear_K - first_K) / LAPSE_K_M + np.clip(excess_m, 0.0, None), 0.0)
        dimmed_K = cloud_K - (clear_K - second_clear_K) * np.exp(-top_m / GAS_M)
    second = (1.0 - through) * planck(np.array(two), dimmed_K) + through * second_sea
    kelvin = np.linspace(180.0, 330.0, 3001)
    difference: np.ndarray = first_K - np.interp(second, planck(np.array(two), kelvin), kelvin)
    return difference


def exact_heights(
    first_K: np.ndarray, difference_K: np.ndarray, clear_K: float, second_clear_K: float
) -> tuple[np.ndarray, float]:
    """Return the heights above opaque clouds that come closest to the difference, and the share of pixels that fit."""
    tried = np.stack([difference_of(first_K, each, clear_K, second_clear_K, True) for each in HEIGHTS_M])
    closest = np.abs(tried - difference_K).argmin(axis=0)
    inside = (difference_K >= tried.min(axis=0)) & (difference_K <= tried.max(axis=0))
    return HEIGHTS_M[closest], float(inside.mean())


def blended(opaque_m: np.ndarray, other: np.ndarray, seed: int, folder: Path) -> Pair:
    """Return both fields of a blended sky."""
    path = folder / "block.nc"
    clear_m = CLEAR_K / LAPSE_K_M
    write_example(
        path, make_example(opaque_m, other, pixel_size_m=3000.0, clear_m=clear_m, kind="", source="", licence="")
    )
    inputs = sample_cloud_inputs(seed=seed, catalog=Catalog(base=folder))
    inputs = replace(
        inputs,
        grid=Grid(SIDE, SIDE, 3000.0),
        motion=kinds.STILL,
        layer=replace(inputs.layer, thickness_min_m=1e-6, base_m=0.0, top_m=1.0),
    )
    clouds = ExampleClouds(inputs, ExampleParameters(example=str(path), clear_sky="example"))
    whole, example = slice(0, SIDE), read_example(path)
    low = min(clear_m, float(np.quantile(example.opaque_m[example.opaque], 0.01)))
    p = low + clouds.thickness_m(0.0, whole, whole).astype(float) * (float(example.opaque_m[-1]) - low)
    return p, clouds.top_above_opaque_m(0.0, whole, whole).astype(float)


def patches(first_K: np.ndarray, difference: np.ndarray, rng: np.random.Generator) -> list[np.ndarray]:
    """Return patches of the difference, with noise, where 10.8 um has cloud."""
    found = []
    colder = first_K < np.percentile(first_K, 99.0) - 2.5
    for row, column in np.ndindex(SIDE // SIZE, SIDE // SIZE):
        at = np.s_[row * SIZE : (row + 1) * SIZE, column * SIZE : (column + 1) * SIZE]
        if colder[at].mean() >= 0.05 and first_K[at].std() >= 0.5:
            found.append(difference[at] + NOISE_K * rng.standard_normal((SIZE, SIZE)))
    return found


def shuffled(first_K: np.ndarray, difference: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return the difference exchanged at random among pixels of about the same temperature, and smoothed."""
    edges = np.quantile(first_K, np.linspace(0.0, 1.0, 102)[1:-1])
    bins = np.searchsorted(edges, first_K)
    out = difference.copy()
    for each in np.unique(bins):
        out[bins == each] = rng.permutation(difference[bins == each])
    smooth: np.ndarray = gaussian_filter(out, 2.0)
    return smooth


def main() -> None:
    """Print the AUC of each way to make the difference."""
    parser = argparse.ArgumentParser()
    parser.add_argument("file", type=Path)
    parser.add_argument("--half", type=int, choices=(0, 1))
    parser.add_argument("--features", type=int, default=4)
    given = parser.parse_args()
    with netCDF4.Dataset(given.file) as file:
        channels = [np.ma.filled(file[name][:, 1].astype(float), np.nan) for name in ("ir_108", "ir_120")]
    scenes = range(len(channels[0])) if given.half is None else range(given.half, len(channels[0]), 2)
    rng = np.random.default_rng(1)
    sides: dict[str, tuple[list[np.ndarray], list[int]]] = {}

    def add(name: str, scene: int, first_K: np.ndarray, difference: np.ndarray, blur: float = BLUR) -> None:
        seen = [gaussian_filter(each, blur) if blur else each for each in (first_K, difference)]
        kept = patches(*seen, rng)
        sides.setdefault(name, ([], []))[0].extend(kept)
        sides[name][1].extend([scene] * len(kept))

    smooth = split_window._SMOOTH_PIXELS
    with tempfile.TemporaryDirectory() as folder:
        for scene in scenes:
            first, second = (channel[scene] for channel in channels)
            add("measured", scene, first, first - second, 0.0)
            warm = clear_sky_K(first)
            second_warm = float(np.median(second[first > warm - 1.0]))
            sharp, sharp_second = sharpened(first), sharpened(second)
            excess = split_window.height_above_opaque_m(first, second, warm, LAPSE_K_M)
            add("physics", scene, sharp, difference_of(sharp, excess, warm, second_warm))
            split_window._SMOOTH_PIXELS = 0.01
            unsmoothed = split_window.height_above_opaque_m(first, second, warm, LAPSE_K_M)
            split_window._SMOOTH_PIXELS = smooth
            add("physics, sharp", scene, sharp, difference_of(sharp, unsmoothed, warm, second_warm))
            opaque = (warm - sharp) / LAPSE_K_M
            heights, inside = exact_heights(sharp, sharp - sharp_second, warm, second_warm)
            print(f"block {scene}: a height fits exactly in {inside:.2f} of pixels", flush=True)
            add("exact", scene, sharp, difference_of(sharp, heights, warm, second_warm, True))
            p, x = blended(opaque, heights, scene, Path(folder))
            kelvin = warm - LAPSE_K_M * p
            add("blended exact", scene, kelvin, difference_of(kelvin, x, warm, second_warm, True))
            p, x = blended(opaque, excess, scene, Path(folder))
            kelvin = warm - LAPSE_K_M * p
            add("blended physics", scene, kelvin, difference_of(kelvin, x, warm, second_warm))
            of_all = sharp - sharp_second
            p, d = blended(opaque, RAISED_K + of_all, scene, Path(folder))
            add("blended difference", scene, warm - LAPSE_K_M * p, d - RAISED_K)
            mixed = shuffled(sharp, of_all, rng)
            p, d = blended(opaque, RAISED_K + mixed, scene, Path(folder))
            add("blended differ., shuffled", scene, warm - LAPSE_K_M * p, d - RAISED_K)
    real, of_real = sides.pop("measured")
    for name, (simulated, of_simulated) in sides.items():
        label = np.repeat([False, True], [len(real), len(simulated)])
        scene_of = np.array([*of_real, *of_simulated])
        names, values = all_features(z_scored(np.stack([*real, *simulated])))
        chance = out_of_fold(values, label, scene_of, "forest", 0)
        low, high = auc_interval(chance, label, scene_of, resamples=200, seed=0)
        print(f"{name:26} {auc(chance, label):.3f} ({low:.2f} to {high:.2f})", flush=True)
        told = sorted(zip(names, values.T, strict=True), key=lambda each: -abs(auc(each[1], label) - 0.5))
        for feature, column in told[: given.features]:
            medians = [float(np.median(column[label == side])) for side in (False, True)]
            print(f"    {feature} {medians[0]:.2f} / {medians[1]:.2f} ({auc(column, label):.2f})", flush=True)


if __name__ == "__main__":
    main()
