"""Simulation-based calibration of `hcss fit`: are its posteriors what they say?

Parameters are drawn from the prior, an image is made from each by the fractal generator, and the posterior
given the image is sampled with the same prior. If all is right the rank of the true value among the draws is
uniform, and a 90 % interval holds it nine times of ten (S. Talts et al., arXiv:1804.06788).

    python tests/campaign/calibration/calibration.py --images 200 --workers 2 -o results.json

A run that was interrupted goes on where it was: rows that the output has are not computed again.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import multiprocessing
import os
import platform
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from hcss_evaluate.posterior.fit import fit_targets
from hcss_evaluate.posterior.fit_run import FitOptions
from scipy.stats import chi2, kstest

from hcss_twin.analysis.matching.structure import CloudImage, grey_inputs
from hcss_twin.analysis.matching.target import Target
from hcss_twin.analysis.uncertainty.priors import KINDS, Prior
from hcss_twin.core.errors import HcssError, PosteriorError
from hcss_twin.core.files import atomic_write
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters

PIXEL_M, OCTAVES = 20.0, (0, 8)
DRAWS, BINS = 99, 20


def priors(size: int) -> dict[str, str]:
    """Return the usual priors of `hcss fit`; coverage leaves frames without cloud, or without gaps, out."""
    cells = f"loguniform:{16000 / (size * PIXEL_M):g}:{16000 / (4 * PIXEL_M):g}"
    usual = {"H": "uniform:0.02:0.98", "gamma": "loguniform:1.5:4", "Lx": cells, "Ly": cells}
    return usual | {"coverage": "uniform:0.1:0.9"}


def draw_image(index: int, size: int, seed: int) -> tuple[dict[str, float], CloudImage]:
    """Draw parameters, and an image of the unbounded sky that has them, with any brightness exponent.

    What data are refused depends on the image alone, so that it does not bias ranks of those accepted.
    """
    rng = np.random.default_rng([seed, index])
    while True:
        truth = {
            name: float(Prior.parse(name, text, KINDS[name].low, KINDS[name].high).quantile(rng.uniform()))
            for name, text in priors(size).items()
        }
        shape = FractalParameters(
            gamma=truth["gamma"],
            H=truth["H"],
            L=(truth["Lx"], truth["Ly"]),
            k=OCTAVES,
            brightness_exponent=float(rng.uniform(0.5, 2.0)),
        )
        inputs = grey_inputs(truth["coverage"], size, size, PIXEL_M, int(rng.integers(0, 2**31)))
        layer = dataclasses.replace(inputs.layer, coverage_mode="field")
        clouds = FractalClouds(dataclasses.replace(inputs, layer=layer), shape, threads=1)
        level = clouds.thickness_m(0.0, slice(0, size), slice(0, size))
        cloudy = np.count_nonzero(level)
        if 100 <= cloudy <= level.size - 100:
            return truth, CloudImage(level, PIXEL_M)


def calibrate_one(
    index: int, size: int, seed: int, most_steps: int = 50_000, samples: float = 1000.0
) -> dict[str, Any]:
    """Return ranks of the true values among posterior draws, or why there is no posterior."""
    truth, image = draw_image(index, size, seed)
    options = FitOptions(priors=priors(size), octaves=OCTAVES, seed=index, samples=samples, most_steps=most_steps)
    began = time.perf_counter()
    row: dict[str, Any] = {"index": index, "truth": truth, "image_coverage": image.coverage}
    with tempfile.TemporaryDirectory() as folder:
        try:
            found = fit_targets(
                [Target(image, "synthetic", ())], Path(folder) / "posterior.nc", [("synthetic", "")], options
            )
        except (HcssError, PosteriorError) as error:
            return row | {"refused": str(error)}
    row["seconds"] = round(time.perf_counter() - began, 2)
    row["p_value"] = float(np.atleast_1d(found.attributes["predictive_p_value"])[0])
    ranks, inside, width = {}, {}, {}
    for name, drawn in found.samples.items():
        some = drawn[np.linspace(0, drawn.size - 1, DRAWS).astype(int)]
        ranks[name] = int(np.sum(some < truth[name]))
        low, high = np.quantile(drawn, [0.05, 0.95])
        inside[name] = bool(low <= truth[name] <= high)
        width[name] = float(high - low)
    return row | {"ranks": ranks, "inside_90": inside, "width_90": width}


def summarise(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return, for each parameter, p of uniform ranks (chi squared, and Kolmogorov) and coverage of 90 % intervals."""
    good = [row for row in rows if "ranks" in row]
    summary: dict[str, Any] = {"images": len(good), "refused": len(rows) - len(good)}
    for name in KINDS:
        ranks = np.array([row["ranks"][name] for row in good])
        counts = np.bincount(ranks * BINS // (DRAWS + 1), minlength=BINS)
        expected = ranks.size / BINS
        statistic = float(np.sum((counts - expected) ** 2 / expected))
        summary[name] = {
            "chi_squared_p": float(chi2.sf(statistic, BINS - 1)),
            "kolmogorov_p": float(kstest((ranks + 0.5) / (DRAWS + 1), "uniform").pvalue),
            "inside_90": float(np.mean([row["inside_90"][name] for row in good])),
            "mean_rank": float(np.mean(ranks) / DRAWS),
            "histogram": counts.tolist(),
        }
    return summary


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--images", type=int, default=200)
    parser.add_argument("--size", type=int, default=128, help="Pixels along each axis.")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("-o", "--output", type=Path, required=True)
    given = parser.parse_args()
    asked = {"size": given.size, "seed": given.seed, "priors": priors(given.size), "octaves": list(OCTAVES)}
    rows: list[dict[str, Any]] = []
    if given.output.exists():
        before = json.loads(given.output.read_text(encoding="utf-8"))
        if before["asked"] != asked:
            raise SystemExit(f"{given.output}: of another run; give another name")
        rows = before["rows"]
    known = {row["index"] for row in rows}
    left = [index for index in range(given.images) if index not in known]
    work = partial(calibrate_one, size=given.size, seed=given.seed)
    began = time.perf_counter()
    with multiprocessing.get_context("spawn").Pool(given.workers) as pool:
        for row in pool.imap_unordered(work, left):
            rows = sorted([*rows, row], key=lambda each: each["index"])
            command = f"python tests/campaign/calibration/calibration.py --images {given.images} --size {given.size}"
            content = {
                "command": f"{command} --seed {given.seed} --workers {given.workers}",
                "asked": asked,
                "processors": f"{platform.machine()}, {os.cpu_count()} of them",
                "summary": summarise(rows) if any("ranks" in each for each in rows) else {},
                "rows": rows,
            }
            with atomic_write(given.output, PosteriorError) as draft:
                draft.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
            print(f"{len(rows)} of {given.images}, {time.perf_counter() - began:.0f} s", flush=True)
    for name, found in summarise(rows).items():
        print(name, {k: v for k, v in found.items() if k != "histogram"} if isinstance(found, dict) else found)


if __name__ == "__main__":
    main()
