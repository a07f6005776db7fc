"""Processor time of the tier source: view march, sweeps of scattered light, and 512 x 512 pixels through the engine.

    python plugins/hcss-light/benchmarks/cost.py [--frames 30] [--type stratocumulus]

Aims: 3.5 ns for each slice, pixel and band of the march, 7 ns for each voxel, direction and order, and 60 s on two
cores for 30 frames of 2 bands at 45 deg from cold. Voxels without cloud cost the sweeps little; times are divided by
all voxels, and by cloudy ones.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from hcss_light.orders import DIRECTIONS
from hcss_light.slices import march, slices_of
from hcss_light.source import Direction, Particles, Surroundings, scattered_source

from hcss_twin import Scenario
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import FrameClouds, stream
from hcss_twin.plan.make_plan import make_plan


def scene(kind: str, frames: int) -> Scenario:
    """Return the scenario of the aim."""
    return Scenario.from_dict(
        {
            "time": "2024-04-20T14:30:00+10:00",
            "place": {"latitude": 20.0, "longitude": 150.0},
            "view": {"zenith": 45.0},
            "image": {"rows": 512, "columns": 512, "pixel_size": 100.0},
            "frames": {"count": frames},
            "accuracy": 0.01,
            "bands": ["lwir-10.8", "mwir-3.7"],
            "clouds": {"type": kind, "coverage": 0.45},
            "radiance": {"light": "source"},
            "output": {"variables": ["radiance"], "certificate": 0},
        }
    )


def kernels(thickness: np.ndarray, base_m: float, top_m: float) -> None:
    """Print the cost of march and sweeps for one group of wavenumbers."""
    particles, view, sun = Particles(0.055, 0.95, np.array([1.0, 0.81])), Direction(45.0, 0.0), Direction(37.0, 263.0)
    slices = slices_of(base_m, top_m, "base", 100.0, 45.0, particles.scaled[0] * (top_m - base_m))
    density = slices.density(thickness)
    around = Surroundings(np.ones(slices.count), 0.2, 1.0, np.ones(slices.count), np.full(slices.count, 1e-5))
    radiance = np.empty(thickness.shape, dtype=np.float32)
    shifts = slices.shifts(45.0, 0.0, base_m)
    source = scattered_source(slices, density, particles, around, view, sun, 1)
    arguments = density, source, np.zeros(slices.count), particles.scaled[0], slices.height_m, 0.7, shifts, 1.0
    march(*arguments, radiance)
    begun = time.process_time()
    march(*arguments, radiance)
    print(f"view march: {1e9 * (time.process_time() - begun) / density.size:.2f} ns for each slice, pixel and band")
    spent = []
    for orders in (4, 20):
        begun = time.process_time()
        scattered_source(slices, density, particles, around, view, sun, orders)
        spent.append(time.process_time() - begun)
    each = 1e9 * (spent[1] - spent[0]) / 16 / DIRECTIONS
    cloudy = np.count_nonzero(density)
    print(f"sweeps: {each / density.size:.2f} ns for each voxel, direction and order; {each / cloudy:.2f} ns if cloudy")


def main() -> None:
    """Print all figures."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--frames", type=int, default=30)
    options.add_argument("--type", default="stratocumulus")
    given = options.parse_args()
    plan = make_plan(scene(given.type, 1))
    (layer,) = plan.layers
    (thickness,) = FrameClouds(plan, 0.0).thickness_m((slice(0, 256), slice(0, 256)))
    kernels(thickness, layer.base_m, layer.top_m)
    begun = time.process_time()
    plan = make_plan(scene(given.type, given.frames))
    tables = tables_of(plan)
    ready = time.process_time()
    for _ in stream(plan, tables):
        pass
    end = time.process_time()
    print(f"{given.frames} frames: {end - begun:.1f} s, {ready - begun:.1f} s of them for the plan and its tables")


if __name__ == "__main__":
    main()
