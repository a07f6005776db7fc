"""Bias, spread and speed of the estimators of the fractal dimension, and the measures of simulated clouds.

::

    python benchmarks/fractal_dimension.py            # about 15 minutes
    python benchmarks/fractal_dimension.py --quick    # a tenth of the surfaces, sides to 256
    python benchmarks/fractal_dimension.py --speed    # the last table only
    python benchmarks/fractal_dimension.py --write    # also replaces fractal_dimension.json of the package

Each estimator sees the same exact fractional Brownian surfaces. The calibration of the box counting is taken from
the first half of the seeds; its error, like all tables, from the other half.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import json
import math
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from hcss_evaluate.measures import fractal_dimension
from hcss_evaluate.measures.box_counting import body_dimension, boundary_dimension, box_counting_dimension
from hcss_evaluate.measures.fractal_dimension import EstimatorCalibration, spectral_dimension, variogram_dimension
from hcss_evaluate.measures.histogram_metrics import histogram_metrics, to_grey_levels
from hcss_evaluate.measures.morphology import morphology

from hcss_twin.core.catalog import Catalog, catalog_root
from hcss_twin.models.clouds.coverage import cloud_fraction_value, cloudy_pixels
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import CloudInputs, CloudLayer, Grid, Microphysics, Motion

# The exact surfaces lie beside the tests, which draw them too.
sys.path.append(str(Path(__file__).parents[1] / "tests"))
from fractional_brownian_surface import circulant_embedding, draw_surface

HURST = [round(0.1 * i, 1) for i in range(1, 10)]

# Side of the surfaces and how many of each; every second one makes the calibration. The largest box of the box
# counting doubles at each power of two, and its raw value jumps: both sides of the jump are measured.
SURFACES = {32: 200, 63: 100, 64: 100, 127: 80, 128: 80, 255: 80, 256: 80, 511: 60, 512: 60, 800: 60} | {
    1023: 20,
    1024: 20,
    1600: 10,
}

RAW, CALIBRATED = "box counting, raw", "box counting, calibrated"
ESTIMATORS = ("variogram", "variogram, 8 bit", RAW, CALIBRATED, "spectrum", "boundary")

# Of Tables VIII and IX: coverage (not printed for VIII), EV, Den / 10, DP, FD.
PRINTED = {
    "Table VIII, simulated": (math.nan, 1.830, 0.8476, 2044.0, 2.528),
    "Table VIII, on-orbit": (math.nan, 1.727, 0.8258, 2049.0, 2.545),
    "Table IX, Image3": (0.202, 1.843, 0.8141, 2031.98, 2.559),
    "Table IX, real": (0.292, 2.267, 0.8267, 1901.65, 2.617),
    "Table IX, Image1": (0.292, 2.267, 0.7632, 1903.27, 2.637),
    "Table IX, Image2": (0.333, 2.547, 0.7343, 1813.73, 2.651),
}


def estimates(surface: np.ndarray) -> dict[str, float]:
    """All estimates of one surface, as D; the calibrated one is made later."""
    eight_bit = to_grey_levels(surface, float(surface.min()), float(surface.max()))
    return {
        "variogram": variogram_dimension(surface).dimension,
        "variogram, 8 bit": variogram_dimension(eight_bit).dimension,
        RAW: box_counting_dimension(surface, calibrated=False).dimension,
        "spectrum": spectral_dimension(surface).dimension,
        "boundary": 1.0 + boundary_dimension(surface > np.median(surface)).dimension,
    }


def measure(sizes: dict[int, int]) -> tuple[EstimatorCalibration, dict[str, np.ndarray]]:
    """Means and spreads, and the mean over the calibrating half."""
    shape = len(sizes), len(HURST)
    mean = {name: np.empty(shape) for name in ESTIMATORS}
    spread = {name: np.empty(shape) for name in ESTIMATORS}
    dimension = 3.0 - np.array(HURST)[::-1]
    log_size = np.log(np.array(list(sizes), dtype=np.float64))
    first = {RAW: np.empty(shape)}
    second: dict[tuple[int, int], list[dict[str, float]]] = {}
    for i, (size, count) in enumerate(sizes.items()):
        for j, hurst in enumerate(reversed(HURST)):
            embedding = circulant_embedding(size, hurst)
            found = [estimates(draw_surface(embedding, seed)) for seed in range(count)]
            first[RAW][i, j] = np.mean([one[RAW] for one in found[::2]])
            second[i, j] = found[1::2]
        print(f"side {size}: {count} surfaces of each H", flush=True)
    calibration = EstimatorCalibration(log_size, dimension, first, {})
    for (i, j), found in second.items():
        size = list(sizes)[i]
        for one in found:
            one[CALIBRATED] = calibration.calibrated(RAW, one[RAW], size)
        for name in ESTIMATORS:
            values = [one[name] for one in found]
            mean[name][i, j], spread[name][i, j] = np.mean(values), np.std(values, ddof=1)
    return EstimatorCalibration(log_size, dimension, mean, spread), first


def print_errors(result: EstimatorCalibration, sizes: list[int], shown: tuple[int, ...]) -> None:
    """Markdown tables: bias +- spread of D by estimator and H."""
    for size in (size for size in sizes if size in shown):
        i = sizes.index(size)
        print(f"\n{size} x {size} pixels: bias ± spread of D\n")
        print("| H | " + " | ".join(ESTIMATORS) + " |")
        print("|---" * (len(ESTIMATORS) + 1) + "|")
        for hurst in HURST:
            j = HURST[::-1].index(hurst)
            cells = [
                f"{result.mean[name][i, j] - result.dimension[j]:+.3f} ± {result.spread[name][i, j]:.3f}"
                for name in ESTIMATORS
            ]
            print(f"| {hurst} | " + " | ".join(cells) + " |")


def write(result: EstimatorCalibration, first: dict[str, np.ndarray], sizes: list[int], counts: list[int]) -> None:
    """Replace the package's table; rows by side, columns by ascending H."""
    methods = {}
    for name in ("variogram", RAW, CALIBRATED, "spectrum", "boundary"):
        mean = first[RAW] if name == RAW else result.mean[name]
        methods[name] = {
            "mean": np.round(mean[:, ::-1], 5).tolist(),
            "spread": np.round(result.spread[name][:, ::-1], 5).tolist(),
        }
    content = {
        "title": "Mean and standard deviation of estimated fractal dimensions of exact fractional Brownian surfaces",
        "source": "python benchmarks/fractal_dimension.py --write",
        "rights": "Facts; no rights claimed.",
        "about": "Rows: side of the surface; columns: Hurst exponent. All are dimensions of the surface, 3 - H if "
        "exact; 1 was added to that of the boundary. The mean of 'box counting, raw' is over the even seeds, the "
        "calibration; all else is over the odd seeds.",
        "sizes": sizes,
        "surfaces": counts,
        "hurst": HURST,
        "methods": methods,
    }
    path = Path(fractal_dimension.__file__).with_name("fractal_dimension.json")
    # One row of numbers per line.
    text = re.sub(r"\[([^][]+)\]", lambda row: f"[{' '.join(row[1].split())}]", json.dumps(content, indent=1))
    path.write_text(text + "\n", encoding="utf-8")


def cloud(seed: int, coverage: float) -> tuple[np.ndarray, np.ndarray]:
    """Cloud fraction value and mask of the ``simulated`` type, 800 x 800 pixels of 20 m."""
    catalog = Catalog(root=catalog_root())
    shape = catalog.toml(catalog.find("paper-simulated", "cloud_types", ".toml"))["fractal"]
    particles = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))  # of no effect here
    layer = CloudLayer("simulated", 333.0, 6000.0, "base", 10.0, coverage, None, particles)
    motion = Motion(0.0, (0.0, 0.0), math.inf, 1.0)
    made = FractalClouds(CloudInputs(layer, Grid(800, 800, 20.0), motion, seed, catalog, shape), FractalParameters())
    field = made.field(0.0, slice(0, 800), slice(0, 800))
    return cloud_fraction_value(field), cloudy_pixels(field, coverage)


def print_clouds(seeds: int) -> None:
    """Markdown table: the paper's measures of simulated clouds next to the printed ones."""
    print("\nMasked 8-bit images: printed, and the simulated type (mean ± spread over seeds)\n")
    columns = ("coverage", "EV", "Den", "DP", "FD: body", "FD: box counting, raw", "FD: variogram", "1 + boundary")
    print("| image | " + " | ".join(columns) + " |")
    print("|---" * (len(columns) + 1) + "|")
    for name, (coverage, entropy, density, peak, dimension) in PRINTED.items():
        known = "" if math.isnan(coverage) else f"{coverage:.3f}"
        print(f"| {name} | {known} | {entropy:.3f} | {density:.4f} | {peak:.0f} | {dimension:.3f} | | | |")
    for coverage in (0.202, 0.206, 0.292, 0.333):
        rows = []
        for seed in range(seeds):
            values, mask = cloud(seed, coverage)
            grey = to_grey_levels(values, float(values[mask].min()), float(values[mask].max()), mask=mask)
            found = morphology(values, mask)
            rows.append(
                (
                    found.entropy,
                    found.density,
                    found.diagonal_peak,
                    found.fractal_dimension,
                    box_counting_dimension(grey, calibrated=False).dimension,
                    variogram_dimension(grey).dimension,
                    1.0 + found.boundary_dimension,
                )
            )
        mean, spread = np.mean(rows, axis=0), np.std(rows, axis=0, ddof=1)
        digits = (3, 4, 0, 3, 3, 3, 3)
        cells = [f"{m:.{d}f} ± {s:.{d}f}" for m, s, d in zip(mean, spread, digits, strict=True)]
        print(f"| simulated type | {coverage:.3f} | " + " | ".join(cells) + " |")


def best_s(call: Callable[[], Any], repeats: int) -> float:
    """Least processor time of some runs after a first one, in seconds."""
    call()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return min(times)


def print_speed() -> None:
    """Markdown table: time per pixel, alone and as ratios, 800 x 800 pixels."""
    surface = draw_surface(circulant_embedding(800, 0.5), 1)
    single = surface.astype(np.float32)
    mask = surface > np.median(surface)
    low, high = float(surface[mask].min()), float(surface[mask].max())
    grey = to_grey_levels(surface, low, high, mask=mask)
    left, right = grey[:, :-1].ravel(), grey[:, 1:].ravel()
    into = np.empty_like(single)
    calls: dict[str, Callable[[], Any]] = {
        "copy of float32": lambda: np.copyto(into, single),
        "np.histogram2d, 256 x 256 bins": lambda: np.histogram2d(left, right, 256),
        "histogram_metrics": lambda: histogram_metrics(grey),
        "to_grey_levels, masked": lambda: to_grey_levels(surface, low, high, mask=mask),
        "variogram_dimension, float32": lambda: variogram_dimension(single),
        "variogram_dimension, float64": lambda: variogram_dimension(surface),
        "variogram_dimension, masked": lambda: variogram_dimension(surface, mask=mask),
        "box_counting_dimension, float32": lambda: box_counting_dimension(single),
        "body_dimension": lambda: body_dimension(grey),
        "boundary_dimension": lambda: boundary_dimension(mask),
        "spectral_dimension": lambda: spectral_dimension(surface),
        "morphology": lambda: morphology(surface, mask),
    }
    seconds = {name: best_s(call, 20) for name, call in calls.items()}
    copy, histogram = seconds["copy of float32"], seconds["np.histogram2d, 256 x 256 bins"]
    print("\nTime per pixel, 800 x 800, one thread, least processor time of 20 runs\n")
    print("| | ns per pixel | x copy | / np.histogram2d |")
    print("|---|---|---|---|")
    for name, time_s in seconds.items():
        print(f"| {name} | {time_s / single.size * 1e9:.2f} | {time_s / copy:.1f} | {time_s / histogram:.4f} |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a tenth of the surfaces, sides to 256")
    parser.add_argument("--speed", action="store_true", help="only the table of speeds")
    parser.add_argument("--write", action="store_true", help="replace fractal_dimension.json of the package")
    options = parser.parse_args()
    if options.quick and options.write:
        parser.error("--write needs all surfaces: leave out --quick")
    if options.speed:
        print_speed()
        return
    sizes = SURFACES
    if options.quick:
        sizes = {size: count // 10 for size, count in SURFACES.items() if size <= 256}
    result, first = measure(sizes)
    print_errors(result, list(sizes), (32, 64, 256, 800))
    if options.write:
        write(result, first, list(sizes), list(sizes.values()))
    print_clouds(3 if options.quick else 30)
    print_speed()


if __name__ == "__main__":
    main()
