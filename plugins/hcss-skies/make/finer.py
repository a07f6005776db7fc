"""Detail below the example's pixel against an image of 1 km: ``python make/finer.py GOES-ABI.nc [--figure FILE.png]``.

Reflectance at 0.86 um becomes optical thickness times (1 - g), 2 R / (1 - R), and is averaged to cells of 8 km. The
generator's detail, with strength and exponent that it finds in these cells, divides them by four, and the image of
2 km is compared: root mean square and kurtosis of increments, increments over sides of cells in those inside, the
three Haar coefficients of 2 by 2 pixels (across rows, across columns, diagonal), and AUC of a forest, patches of 64
pixels. The left half of the image is where the law of the detail was chosen; the right one is held out.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import netCDF4
import numpy as np
from hcss_evaluate.realism import compare
from hcss_skies.detail import deviation_of, moments_of
from hcss_skies.detail_of_image import fit_detail
from hcss_skies.fibres import textures
from hcss_skies.refining import MARGIN, refine

CELL, PIXEL, PATCH, SEEDS = 8, 2, 64, 2
CLEAR, BRIGHTEST = 0.0137, 0.75  # reflectance factor of the sea (5th percentile), and of thick cloud under this sun
SEA_ROWS = 800  # land below


def averaged(field: np.ndarray, side: int) -> np.ndarray:
    """Return means over squares."""
    rows, columns = (length // side for length in field.shape)
    mean: np.ndarray = field[: rows * side, : columns * side].reshape(rows, side, columns, side).mean(axis=(1, 3))
    return mean


def finer(cells: np.ndarray, seed: int) -> np.ndarray:
    """Return cells (rows, columns) divided into pixels, without ``MARGIN`` at each side."""
    detail = fit_detail(cells)
    assert detail is not None
    halvings = int(math.log2(CELL // PIXEL))
    law = np.array([deviation_of(detail.exponent, each) for each in range(halvings)])
    out = np.empty(((cells.shape[0] - 2 * MARGIN) * 2**halvings, (cells.shape[1] - 2 * MARGIN) * 2**halvings))
    moments = moments_of([97 * seed + each for each in range(halvings)], [math.nan] * halvings)
    refine(
        out, cells, np.zeros(2, np.int64), detail.strength, law, 1.0001 * float(cells.max()), 0.5, textures(), *moments
    )
    return out


def reflectance(thickness: np.ndarray) -> np.ndarray:
    """Return what has this thickness."""
    share: np.ndarray = thickness / (2.0 + thickness)
    return share


def described(image: np.ndarray) -> str:
    """Return a line of numbers of an image whose cells are complete."""
    step = np.diff(image, axis=1)
    over = np.arange(step.shape[1]) % (CELL // PIXEL) == CELL // PIXEL - 1
    a, b, c, d = image[::2, ::2], image[::2, 1::2], image[1::2, ::2], image[1::2, 1::2]
    haar = [np.std(each) for each in (a + b - c - d, a - b + c - d, a - b - c + d)]
    return (
        f"increments {np.std(step):.4f}, kurtosis {np.mean(step**4) / np.mean(step**2) ** 2:.1f}, over sides "
        f"{np.std(step[:, over]) / np.std(step[:, ~over]):.2f}, Haar {haar[0]:.3f} {haar[1]:.3f} {haar[2]:.3f}"
    )


def main() -> None:
    """Print both halves, and draw a part of the right one."""
    parser = argparse.ArgumentParser()
    parser.add_argument("file", type=Path)
    parser.add_argument("--figure", type=Path)
    given = parser.parse_args()
    with netCDF4.Dataset(given.file) as file:
        measured = np.ma.filled(file["CMI"][:SEA_ROWS].astype(float), np.nan)
    share = np.clip((measured - CLEAR) / BRIGHTEST, 0.0, 0.93)
    thickness = 2.0 * share / (1.0 - share)
    middle = thickness.shape[1] // 2 // CELL * CELL
    for name, half in (("chosen half", thickness[:, :middle]), ("held out", thickness[:, middle:])):
        border = MARGIN * CELL // PIXEL
        cells, truth = averaged(half, CELL), averaged(half, PIXEL)[border:-border, border:-border]
        skies = [finer(cells, seed) for seed in range(SEEDS)]
        error = max(np.abs(averaged(sky, CELL // PIXEL) - cells[MARGIN:-MARGIN, MARGIN:-MARGIN]).max() for sky in skies)
        patches = [
            [300.0 - 60.0 * reflectance(field[y : y + PATCH, x : x + PATCH])
             for y in range(0, field.shape[0] - PATCH + 1, PATCH) for x in range(0, field.shape[1] - PATCH + 1, PATCH)]
            for field in (truth, *skies)
        ]  # fmt: skip
        places = list(range(len(patches[0])))
        found = compare(
            patches[0], [each for sky in patches[1:] for each in sky], places, places * SEEDS,
            classifiers=("forest",), scales=("z-scored",), copies=0, blur_pixels=0.0, noise_k=0.05,
        ).scores[0]  # fmt: skip
        print(f"{name}: AUC {found.auc:.3f} ({found.low:.2f} to {found.high:.2f}), cells kept to {error:.0e}")
        print(f"    measured   {described(reflectance(truth))}")
        print(f"    detail     {described(reflectance(skies[0]))}", flush=True)
        if given.figure is not None:
            _draw(
                given.figure.with_stem(f"{given.figure.stem}-{name.replace(' ', '-')}"),
                cells[MARGIN:-MARGIN, MARGIN:-MARGIN],
                truth,
                skies[0],
            )


def _draw(path: Path, cells: np.ndarray, truth: np.ndarray, sky: np.ndarray) -> None:
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(16.5, 5.9))
    part = np.s_[:160, :160]
    squares = np.kron(cells, np.ones((CELL // PIXEL, CELL // PIXEL)))
    for axis, field, title in zip(
        axes, (squares, sky, truth), ("cells of 8 km", "with detail", "measured"), strict=True
    ):
        axis.imshow(reflectance(field[part]), cmap="gray", vmin=0.0, vmax=0.9, interpolation="nearest")
        axis.set_title(title)
        axis.axis("off")
    figure.tight_layout()
    figure.savefig(path, dpi=70)


if __name__ == "__main__":
    main()
