"""Effective samples per second of `hcss fit`: three parameters (H, Lx, Ly) of one simulated image.

    python benchmarks/fit_speed.py [PIXELS]

All is counted, the simulations that teach the scatter included, imports and compilation excluded.
"""

from __future__ import annotations

import os
import platform
import sys
import tempfile
import time
from pathlib import Path

from hcss_twin.clouds.fractal.parameters import FractalParameters
from hcss_twin.matching.cloud_image import simulate_image
from hcss_twin.matching.cloud_type import empty_frame
from hcss_twin.matching.target import Target
from hcss_twin.uncertainty.fit import fit_targets
from hcss_twin.uncertainty.fit_options import FitOptions


def main() -> None:
    side = int(sys.argv[1]) if len(sys.argv) > 1 else 256
    shape = FractalParameters(
        gamma=2.0, H=0.4, L=(6 * 16_000 / (20 * side), 8 * 16_000 / (20 * side)), k=(0, 8)
    )
    options = FitOptions(fixed={"gamma": 2.0, "coverage": "image"})
    print(
        f"{platform.machine()}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}, {side} x {side} pixels"
    )
    for run in range(3):
        image = simulate_image(shape, 0.4, empty_frame(side, side, 20.0), run)
        with tempfile.TemporaryDirectory() as folder:
            wall, used = time.perf_counter(), time.process_time()
            found = fit_targets(
                [Target(image, "simulated", ())], Path(folder) / "p.nc", [("simulated", "")], options
            )
            wall, used = time.perf_counter() - wall, time.process_time() - used
        size = min(each["effective_sample_size"] for each in found.diagnostics.values())
        note = " (the first run loads kernels)" if run == 0 else ""
        print(f"{size:.0f} effective samples, {wall:.1f} s, {used:.1f} s of processor time{note}")


if __name__ == "__main__":
    main()
