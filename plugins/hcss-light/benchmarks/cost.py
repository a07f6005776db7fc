"""Processor time of the tier source: view march, sweeps of scattered light, the sea, and 512 x 512 pixels as frames.

    python plugins/hcss-light/benchmarks/cost.py [--frames 30] [--type stratocumulus]

Aims: 3.5 ns for each slice, pixel and band of the march, 7 ns for each voxel, direction and order, and 60 s on two
cores for 30 frames of 2 bands at 45 deg from cold. Voxels without cloud cost the sweeps little; times are divided by
all voxels, and by cloudy ones.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from hcss_light.orders import DIRECTIONS
from hcss_light.sea import Sea
from hcss_light.slices import march, slices_of
from hcss_light.source import Direction, Particles, Surroundings, scattered_source
from hcss_light.transport import InstantLight

from hcss_twin import Scenario
from hcss_twin.engine.clouds import FrameClouds
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import stream
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
    sea = Sea(slices, view, sun, base_m)
    around = replace(around, glint=0.1, mirrored=np.zeros(slices.count))
    sea.change(sea.paths(density, True), particles, around, thickness.shape)
    times = [time.process_time()]
    for shaded in (False, True):
        found = sea.paths(density, shaded)
        times.append(time.process_time())
        if not shaded:
            sea.change(found, particles, around, thickness.shape)
            times.append(time.process_time())
    copied, mirrored, shadows = 1e9 * np.diff(times) / density.size
    print(f"clouds that the sea mirrors: {mirrored:.2f} ns for each slice, pixel and band")
    print(f"the sun's paths to the sea: {shadows - copied:.2f} ns for each slice and pixel, for all bands")


def timed(spent: list[float]) -> Callable[..., object]:
    """Return what computes the sea below clouds, and adds the time of each call to a list."""
    own = InstantLight.over_sea

    def over_sea(*given: object, **named: object) -> object:
        begun = time.process_time()
        result = own(*given, **named)
        spent.append(time.process_time() - begun)
        return result

    return over_sea


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
    of_sea: list[float] = []
    InstantLight.over_sea = timed(of_sea)
    for _ in stream(plan, tables):
        pass
    end = time.process_time()
    print(
        f"{given.frames} frames: {end - begun:.1f} s, {ready - begun:.1f} s of them for the plan and its tables, "
        f"{sum(of_sea):.1f} s for the sea below clouds"
    )


if __name__ == "__main__":
    main()
