"""Effective samples per second of `hcss fit`: three parameters (H, Lx, Ly) of one simulated image, or of a population.

    python benchmarks/fit_speed.py [PIXELS]
    python benchmarks/fit_speed.py 128 --images 3      # mean, spread and the parameters of each of three images

All is counted, the simulations that teach the scatter included, imports and compilation excluded.
"""

from __future__ import annotations

import argparse
import math
import os
import platform
import tempfile
import time
from pathlib import Path

import numpy as np
from hcss_evaluate.matching.dimension_range import empty_frame
from hcss_evaluate.matching.structure import simulate_image
from hcss_evaluate.matching.target import Target
from hcss_evaluate.posterior.fit import fit_targets
from hcss_evaluate.posterior.fit_run import FitOptions

from hcss_twin.models.clouds.fractal.parameters import FractalParameters

H, CELLS = 0.4, (6.0, 8.0)
"""Of one image; of several the middle, about which H scatters by .06 and cells per frame by a fifth."""


def target(side: int, seed: int, scatters: bool) -> Target:
    random = np.random.default_rng(seed)
    away = random.standard_normal(3) if scatters else np.zeros(3)
    shape = FractalParameters(
        gamma=2.0,
        H=H + 0.06 * float(away[0]),
        L=(
            CELLS[0] * math.exp(0.2 * float(away[1])) * 16_000 / (20 * side),
            CELLS[1] * math.exp(0.2 * float(away[2])) * 16_000 / (20 * side),
        ),
        k=(0, 8),
    )
    return Target(simulate_image(shape, 0.4, empty_frame(side, side, 20.0), seed), "simulated", ())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pixels", type=int, nargs="?", default=256, help="side of the images")
    parser.add_argument("--images", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    options = FitOptions(fixed={"gamma": 2.0, "coverage": "image"})
    print(
        f"{platform.machine()}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}, "
        f"{given.images} x {given.pixels} x {given.pixels} pixels"
    )
    for run in range(given.rounds):
        targets = [target(given.pixels, run + 10 * each, given.images > 1) for each in range(given.images)]
        with tempfile.TemporaryDirectory() as folder:
            wall, used = time.perf_counter(), time.process_time()
            found = fit_targets(targets, Path(folder) / "p.nc", [(each.source, "") for each in targets], options)
            wall, used = time.perf_counter() - wall, time.process_time() - used
        size = min(each["bulk_effective_sample_size"] for each in found.diagnostics.values())
        note = " (the first run loads kernels)" if run == 0 else ""
        print(f"{size:.0f} effective samples, {wall:.1f} s, {used:.1f} s of processor time{note}")


if __name__ == "__main__":
    main()
