"""How many streams does sunlight need with light scattered twice in closed form, and with light scattered once alone?

    python benchmarks/second_order.py              # half a minute

Layers of the catalog's droplets and crystals at five wavenumbers of 2.7 to 4.8 um, of optical thickness 0.3 to 40,
toward random views and suns, one of them near the glory. Errors are those of the sum over the wavenumbers, relative to
64 streams with 128 moments for droplets, which resolve all of them, and to 64 with 96 for crystals. Time is that of a
processor, of all layers and views, relative to 24 streams with light scattered once; in a scene, with ten times as many
thicknesses, the closed form adds less.
"""

from __future__ import annotations

import time

import numpy as np

from hcss_twin import Scenario, make_plan
from hcss_twin.core.arrays import Array
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun
from hcss_twin.providers import SingleScattering

WAVENUMBERS = np.array([2100.0, 2400.0, 2700.0, 3400.0, 3500.0])
THICKNESS = np.array([0.3, 1.0, 3.0, 10.0, 40.0])
GEOMETRIES, SEED = 8, 1
STREAMS = (8, 12, 16, 24, 32)
MOST = {"stratus": (64, 128), "cirrus": (64, 96)}


def geometries() -> list[tuple[float, float, float]]:
    """Cosines of view and sun, and relative azimuth; the last one is 7 degrees from the glory."""
    random = np.random.default_rng(SEED)
    zenith = np.cos(np.radians(random.uniform(5.0, 75.0, (GEOMETRIES, 2))))
    azimuth = random.uniform(0.0, np.pi, GEOMETRIES)
    drawn = [(float(view), float(sun), float(turned)) for (view, sun), turned in zip(zenith, azimuth, strict=True)]
    return [*drawn, (float(np.cos(np.radians(30.0))), float(np.cos(np.radians(37.0))), 0.03)]


def reflected(particles: SingleScattering, streams: int, moments: int, exact_orders: int) -> Array:
    """Sum over the wavenumbers of the brdf, (geometries, thicknesses)."""
    depth = THICKNESS[:, None] * np.ones(WAVENUMBERS.size)
    layers = depth, particles.albedo, particles.moments
    return np.stack(
        [
            solve_sun(
                *layers, [view], sun, [turned], streams, moments, kept_moments=moments, exact_orders=exact_orders
            )[0].sum(axis=(1, 2))
            for view, sun, turned in geometries()
        ]
    )


def main() -> None:
    """Print a table."""
    print("particles   streams  once: median  largest  time   twice: median  largest  time")
    for scene, (streams, moments) in MOST.items():
        plan = make_plan(Scenario.load(scene))
        particles = plan.assembly.optics.single_scattering(plan.layers[0].microphysics, WAVENUMBERS)
        exact = reflected(particles, streams, moments, 2)
        rows: dict[tuple[int, int], tuple[float, float, float]] = {}
        for count in STREAMS:
            for orders, kept in ((1, count), (2, 3 * count // 2)):
                begin = time.process_time()
                error = np.abs(reflected(particles, count, kept, orders) / exact - 1.0)
                rows[count, orders] = float(np.median(error)), float(np.max(error)), time.process_time() - begin
        whole = rows[24, 1][2]
        for count in STREAMS:
            cells = [f"{a:13.1e} {b:8.1e} {c / whole:5.2f}" for a, b, c in (rows[count, 1], rows[count, 2])]
            print(f"{scene:<11} {count:7d} {cells[0]}  {cells[1]}")


if __name__ == "__main__":
    main()
