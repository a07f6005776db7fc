"""Choose the parameters of a mechanism by the features of measured blocks of its kind.

    python make/tune.py BLOCKS.nc KIND [STEPS]

An evolution strategy of one parent changes the parameters at random; a change stays if skies blended from three
examples of the mechanism come closer to the left halves of the blocks in the features of the realism test: the mean
over features of (2 AUC - 1)^2, and that of the eight that tell most. The forest that scores kinds is not asked, and
right halves are held out (``kinds.py --side right``).
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import kinds
import library
import numpy as np
from hcss_evaluate.realism.classifiers import auc
from hcss_evaluate.realism.features import all_features
from hcss_evaluate.realism.patches import cut_patches, z_scored
from hcss_skies.example import write_example

from hcss_twin import HcssError


def features(kelvin: list[np.ndarray], blur: float) -> np.ndarray:
    """Return the features (P, F) of the patches of images."""
    found = cut_patches(
        "side", kelvin, range(len(kelvin)), size=64, blur_pixels=blur, noise_k=0.2, rng=np.random.default_rng(1)
    )
    return all_features(z_scored(found.noisy))[1]


def distance(measured: np.ndarray, kind: str, shape: dict[str, float], folder: Path) -> float:
    """Return how far skies of a mechanism are from measured patches."""
    skies = []
    try:
        for number in range(1, library.VARIANTS + 1):
            path = folder / f"{kind}-{number}.nc"
            write_example(path, library.made(kind, number, shape))
            skies.append(kinds.blended(path, number)[0])
        simulated = features(skies, 0.65)
    except HcssError:  # no cloud, or heights that no example may have
        return 9.0
    label = np.repeat([False, True], [len(measured), len(simulated)])
    both = np.concatenate((measured, simulated))
    told = np.sort([(2.0 * auc(column, label) - 1.0) ** 2 for column in both.T])
    few = 0.5 * max(0.0, 1.0 - len(simulated) / (0.6 * 16 * library.VARIANTS))
    return float(told.mean() + told[-8:].mean() + few)


def main() -> None:
    """Search and print the best parameters."""
    source, kind = Path(sys.argv[1]), sys.argv[2]
    steps = int(sys.argv[3]) if len(sys.argv) > 3 else 150
    kelvin = kinds.measured(source, 1, "left")
    measured = features([kelvin[block] for block in kinds.blocks_of(source)[kind]], 0.0)
    rng, limits = np.random.default_rng(7), library.LIMITS[kind]
    names = list(limits)
    low, high = (np.array([limits[name][n] for name in names]) for n in range(2))
    best = np.clip((np.array([library.SHAPES[kind][name] for name in names]) - low) / (high - low), 0.0, 1.0)
    size = 0.25
    with tempfile.TemporaryDirectory() as folder:
        score = distance(measured, kind, library.SHAPES[kind], Path(folder))
        print(f"{kind} start {score:.4f}", flush=True)
        for step in range(steps):
            moved = rng.random(len(names)) < max(0.3, 2.0 / len(names))
            trial = best + size * rng.standard_normal(len(names)) * moved
            trial = np.abs(trial) % 2.0
            trial = np.where(trial > 1.0, 2.0 - trial, trial)
            shape = {name: float(f"{value:.3g}") for name, value in zip(names, low + trial * (high - low), strict=True)}
            own = distance(measured, kind, shape, Path(folder))
            size = float(np.clip(size * (1.35 if own < score else 0.93), 0.04, 0.3))
            if own < score:
                best, score = trial, own
                print(f"{kind} {step} {score:.4f} {shape}", flush=True)


if __name__ == "__main__":
    main()
