"""Processor time of blended skies, ns per pixel and frame on one thread: ``python make/cost.py [EXAMPLE.nc]``.

Frames of 512 x 512 pixels with evolution, outside a scene, the compilation of kernels and the preparation of the
example left out. "Thickness" is what a scene asks for; the second field comes together with the first at the pixel of
the example and above. The smallest of five runs, because other programs slow caches down; the last line has a normal
number of NumPy's, to compare machines (8.7 ns on one without other programs).
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from hcss_author import sample_cloud_inputs
from hcss_skies import library
from hcss_skies.generator import ExampleClouds
from hcss_skies.pace import MEASURED_S
from hcss_skies.parameters import ExampleParameters

from hcss_twin.core.catalog import Catalog
from hcss_twin.providers import Grid, Motion

SIDE, RUNS, FRAMES = 512, 5, 2


def main() -> None:
    """Print a line for each pixel size."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else library.shipped()["closed-cells-1"]
    whole = slice(0, SIDE)
    for pixel_m in (20_000.0, 3000.0, 2900.0, 1000.0, 300.0, 30.0, 5.0):
        inputs = replace(
            sample_cloud_inputs(catalog=Catalog(base=path.parent)),
            grid=Grid(SIDE, SIDE, pixel_m),
            motion=Motion(0.0, (0.0, 0.0), MEASURED_S, 1.0),
        )
        clouds = ExampleClouds(inputs, ExampleParameters(example=str(path.resolve())))
        found = []
        for which in (0, 1):
            clouds._window(0.0, whole, whole, which)
            spent = []
            for run in range(RUNS):
                begun = time.process_time()
                for frame in range(FRAMES):
                    clouds._window(60.0 * (run * FRAMES + frame), whole, whole, which)
                spent.append((time.process_time() - begun) / (FRAMES * SIDE * SIDE))
            found.append(1e9 * min(spent))
        print(f"{pixel_m:7.0f} m: thickness {found[0]:5.1f} ns, second field {found[1]:5.1f} ns", flush=True)
    rng, spent = np.random.default_rng(1), []
    for _ in range(RUNS):
        begun = time.process_time()
        rng.standard_normal(SIDE * SIDE)
        spent.append(time.process_time() - begun)
    print(f"a normal number: {1e9 * min(spent) / SIDE**2:.1f} ns")


if __name__ == "__main__":
    main()
