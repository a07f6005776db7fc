"""Score shipped examples against measured blocks of their kind, and kinds against each other.

    python make/kinds.py BLOCKS.nc [--kinds a,b] [--folder LIBRARY] [--side right] [--seed 2]
        [--pairs] [--features 3]

Skies blended from each example (its clear sky's texture included, temperature linear in height) against the blocks
that ``block-kinds.txt`` gives this kind: AUC of the forest, z-scored, folds by block. ``--side right`` takes the
halves of blocks by which no parameter was chosen, ``--seed`` other skies. ``--pairs`` tells the examples of kinds from
each other.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import netCDF4
import numpy as np
from hcss_author import sample_cloud_inputs
from hcss_evaluate.realism import compare
from hcss_skies import library
from hcss_skies.example import read_example
from hcss_skies.generator import ExampleClouds
from hcss_skies.pace import MEASURED_S
from hcss_skies.parameters import ExampleParameters

from hcss_twin.core.catalog import Catalog
from hcss_twin.providers import Grid, Motion

SIDE, SEEDS, CLEAR_K, LAPSE_K_M = 256, 2, 293.0, 6.5e-3
STILL = Motion(0.0, (0.0, 0.0), math.inf, 1.0)
Images = list[np.ndarray]


def blocks_of(path: Path) -> dict[str, list[int]]:
    """Return the places of the blocks in the file by kind."""
    found: dict[str, list[int]] = {}
    for line in Path(__file__).with_name("block-kinds.txt").read_text(encoding="utf-8").splitlines():
        number, *kinds = line.split("#")[0].split() or [""]
        for kind in kinds:
            found.setdefault(kind, []).append(int(number))
    with netCDF4.Dataset(path) as file:
        numbers = [int(number) for number in file["block"][:]]
    return {kind: [numbers.index(block) for block in members] for kind, members in found.items()}


def measured(path: Path, time: int, side: str = "both") -> np.ndarray:
    """Return brightness temperature (blocks, y, x) at 10.8 um; of the left or right halves of blocks, or of both."""
    with netCDF4.Dataset(path) as file:
        kelvin: np.ndarray = np.ma.filled(file["ir_108"][:, time].astype(float), np.nan)
    half = kelvin.shape[2] // 2
    return {"left": kelvin[:, :, :half], "right": kelvin[:, :, half:], "both": kelvin}[side]


def blended(path: Path, seed: int, times_s: Sequence[float] = (0.0,)) -> Images:
    """Return frames of a sky of an example in kelvin, with the texture of its clear sky; one time: nothing moves."""
    example = read_example(path)
    inputs = sample_cloud_inputs(seed=seed, catalog=Catalog(base=path.parent))
    inputs = replace(
        inputs,
        grid=Grid(SIDE, SIDE, example.pixel_size_m),
        motion=STILL if len(times_s) == 1 else replace(STILL, evolution_time_s=MEASURED_S),
        layer=replace(inputs.layer, thickness_min_m=1e-6, base_m=0.0, top_m=1.0),
    )
    clouds = ExampleClouds(inputs, ExampleParameters(example=str(path.resolve()), clear_sky="example"))
    shares = [clouds.thickness_m(time, slice(0, SIDE), slice(0, SIDE)).astype(float) for time in times_s]
    low = min(example.clear_m, float(np.quantile(example.opaque_m[example.opaque], 0.01)))
    return [CLEAR_K - LAPSE_K_M * (low + share * (float(example.opaque_m[-1]) - low)) for share in shares]


def told(
    real: Images, simulated: Images, of_real: list[int], of_simulated: list[int], blur: float = 0.65
) -> tuple[float, float, float, list[str]]:
    """Return the AUC with its interval, and the features that tell most."""
    found = compare(
        real, simulated, of_real, of_simulated, classifiers=("forest",), scales=("z-scored",), copies=0,
        blur_pixels=blur, resamples=200,
    )  # fmt: skip
    score = found.scores[0]
    features = [
        f"{feature.name} {feature.real:.2f} / {feature.simulated:.2f} ({feature.auc:.2f})" for feature in found.features
    ]
    return score.auc, score.low, score.high, features


def show(kind: str, result: tuple[float, float, float, list[str]], features: int) -> None:
    """Print a line, and those of features (median measured / simulated, AUC of the feature alone)."""
    print(f"{kind:15} {result[0]:.3f} ({result[1]:.2f} to {result[2]:.2f})", flush=True)
    for feature in result[3][:features]:
        print(f"    {feature}", flush=True)


def main() -> None:
    """Parse arguments and print scores."""
    parser = argparse.ArgumentParser()
    parser.add_argument("file", type=Path)
    parser.add_argument("--kinds")
    parser.add_argument("--folder", type=Path, default=Path(library.__file__).parent, help="Of the examples.")
    parser.add_argument("--time", type=int, default=1)
    parser.add_argument("--features", type=int, default=3)
    parser.add_argument("--seed", type=int, default=0, help="Of the first sky of each example.")
    parser.add_argument("--side", default="both", choices=("left", "right", "both"))
    parser.add_argument("--pairs", action="store_true")
    given = parser.parse_args()
    members = blocks_of(given.file)
    kinds = sorted(members) if given.kinds is None else given.kinds.split(",")
    paths = {kind: sorted(given.folder.glob(f"{kind}-[0-9]*.nc")) for kind in kinds}
    if given.pairs:
        fields = {kind: [_as_it_is(path) for path in paths[kind]] for kind in kinds}
        for first, second in combinations(kinds, 2):
            a, b = fields[first], fields[second]
            numbers = list(range(len(a))), list(range(100, 100 + len(b)))
            show(f"{first}, {second}", told(a, b, *numbers, blur=0.0), given.features)
        return
    kelvin = measured(given.file, given.time, given.side)
    for kind in kinds:
        blocks = members[kind]
        skies = [blended(path, seed)[0] for path in paths[kind] for seed in range(given.seed, given.seed + SEEDS)]
        numbers = [100 + n for n in range(len(paths[kind])) for _ in range(SEEDS)]
        show(kind, told([kelvin[b] for b in blocks], skies, blocks, numbers), given.features)


def _as_it_is(path: Path) -> np.ndarray:
    example = read_example(path)
    field: np.ndarray = CLEAR_K - LAPSE_K_M * example.opaque_m[example.opaque]
    return field


if __name__ == "__main__":
    main()
