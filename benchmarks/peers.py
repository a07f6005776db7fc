"""One cloud layer by our solver, PythonicDISORT and sasktran2: the same work in one run, with differences of results.

    pip install sasktran2
    python benchmarks/peers.py            # a minute
    python benchmarks/peers.py --write    # and rewrite the table of the page

Random layers over black ground: optical thickness .1 to 50, albedo .5 to .999, Henyey-Greenstein with g .7 to .9, sun
at 20 to 70 degrees, eight views to 65 degrees; by night isothermal, toward the same views. All three use the same
streams, scale the forward peak (delta-M) and take light scattered once from the whole phase function. Radiance is
compared with PythonicDISORT's of 64 streams; it interpolates between its streams. Seconds are of one thread and one
layer, the least of three runs; PythonicDISORT solves one layer a call, the others all at once.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from functools import partial
from itertools import product
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy

import numpy as np
import sasktran2
from numpy.typing import NDArray
from PythonicDISORT import subroutines
from PythonicDISORT.pydisort import pydisort

from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun

Array = NDArray[np.float64]

LAYERS, TERMS, FINEST = 40, 600, 64
STREAMS = (16, 32)
VIEWS = np.cos(np.radians([10.0, 20.0, 35.0, 50.0, 65.0, 35.0, 50.0, 65.0]))
AZIMUTHS = np.radians([0.0, 30.0, 60.0, 100.0, 140.0, 160.0, 20.0, 80.0])
SUN = 0.6
TOLERANCE = 1e-4
"""Of what azimuth modes add, in our solver."""


def random_layers() -> tuple[Array, Array, Array]:
    """Return thickness, albedo and asymmetry (N,)."""
    rng = np.random.default_rng(47)
    thickness = 10 ** rng.uniform(-1.0, np.log10(50.0), LAYERS)
    return thickness, 1.0 - 10 ** rng.uniform(-3.0, np.log10(0.5), LAYERS), rng.uniform(0.7, 0.9, LAYERS)


def ours(streams: int, sun: bool) -> Array:
    """Return BRDF, or emissivity, (N, views)."""
    thickness, albedo, g = random_layers()
    given = thickness[None], albedo, np.stack([np.ones(LAYERS), g])
    half = streams // 2
    if sun:
        back, _ = solve_sun(*given, VIEWS, SUN, AZIMUTHS, half, streams, 1, mode_tolerance=TOLERANCE)
        return np.asarray(back[0])
    mu, place = np.unique(VIEWS, return_inverse=True)
    return np.asarray(solve_layers(*given, mu, half, threads=1).emissivity[0][:, : mu.size][:, place])


def disort(streams: int, sun: bool) -> Array:
    """Return the same by PythonicDISORT."""
    found = []
    for thickness, albedo, g in zip(*random_layers(), strict=True):
        moments = g ** np.arange(TERMS)
        layer = np.array([thickness]), np.array([albedo]), streams, moments[None], SUN
        common = {"NLeg": streams, "f_arr": moments[streams]}
        if sun:
            intensity = pydisort(*layer, 1.0, 0.0, NFourier=streams, NT_cor=True, **common)[4]
            at = subroutines.interpolate(intensity)(VIEWS, 0.0, np.pi - AZIMUTHS)
            found.append(np.diagonal(at) / SUN)
        else:  # its isotropic source is multiplied by 1 - albedo inside
            mean = pydisort(*layer, 0.0, 0.0, NFourier=1, s_poly_coeffs=np.array([[1.0]]), **common)[3]
            found.append(subroutines.interpolate(mean)(VIEWS, 0.0))
    return np.array(found)


def sasktran(streams: int, sun: bool, cells: int = 1) -> Array:
    """Return the same by sasktran2, which integrates sunlight along the view from cell to cell."""
    thickness, albedo, g = random_layers()
    config = sasktran2.Config()
    config.num_streams, config.num_threads, config.delta_m_scaling = streams, 1, True
    config.multiple_scatter_source = sasktran2.MultipleScatterSource.DiscreteOrdinates
    config.num_singlescatter_moments = TERMS
    if sun:
        config.single_scatter_source = sasktran2.SingleScatterSource.Exact
    else:
        config.single_scatter_source = sasktran2.SingleScatterSource.DiscreteOrdinates
        config.emission_source = sasktran2.EmissionSource.DiscreteOrdinates
    flat = sasktran2.GeometryType.PlaneParallel
    linear = sasktran2.InterpolationMethod.LinearInterpolation
    depth = np.concatenate([np.geomspace(1.0, 1.0 / cells**2, cells), [0.0]])
    height_m = 1000.0 * (1.0 - depth)  # finer toward the top
    geometry = sasktran2.Geometry1D(SUN, 0.0, 6.37e6, height_m, linear, flat)
    seen = sasktran2.ViewingGeometry()
    for mu, azimuth in zip(VIEWS, AZIMUTHS, strict=True):
        seen.add_ray(sasktran2.GroundViewingSolar(SUN, np.pi - azimuth, mu, 2000.0))
    wavelengths_nm = 1e4 + np.arange(LAYERS)
    air = sasktran2.Atmosphere(geometry, config, wavelengths_nm=wavelengths_nm, calculate_derivatives=False)
    order = np.arange(TERMS)[:, None, None]
    both = np.ones((height_m.size, 1))
    moments = (2.0 * order + 1.0) * (g[None] * both)[None] ** order
    air["cloud"] = sasktran2.constituent.Manual(both * thickness / 1000.0, both * albedo, moments)
    kelvin = 280.0
    if not sun:
        air.temperature_k = np.full(height_m.size, kelvin)
        air.pressure_pa = np.full(height_m.size, 1e5)
        air.storage.solar_irradiance[:] = 0.0
        air["thermal"] = sasktran2.constituent.ThermalEmission()
    radiance = sasktran2.Engine(config, geometry, seen).calculate_radiance(air)["radiance"].values[..., 0]
    if sun:
        return np.asarray(radiance) / SUN
    planck = sasktran2.constituent.emission.planck_blackbody_radiance(np.array([kelvin]), wavelengths_nm)
    return np.asarray(radiance) / np.ravel(planck)[:, None]


SOLVERS: dict[str, tuple[Callable[[int, bool], Array], str]] = {
    "ours": (ours, "sun and thermal"),
    "PythonicDISORT": (disort, "sun and thermal"),
    "sasktran2": (sasktran, "thermal"),
    "sasktran2, 10 cells": (partial(sasktran, cells=10), "sun"),
    "sasktran2, 40 cells": (partial(sasktran, cells=40), "sun"),
}
"""With the light that each is for."""


def measured(solve: Callable[[], Array]) -> tuple[float, Array]:
    """Return the least seconds a layer of three runs after a first, and the result."""
    result, times = solve(), []
    for _ in range(3):
        start = time.process_time()
        solve()
        times.append(time.process_time() - start)
    return min(times) / LAYERS, result


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="rewrite the table of the page")
    given = parser.parse_args()
    rows = [
        "| light | streams | solver | ms a layer | error: median | 90 % | largest |",
        "|---|---|---|---|---|---|---|",
    ]
    for light in ("sun", "thermal"):
        exact = disort(FINEST, light == "sun")
        for streams, (name, (solver, lights)) in product(STREAMS, SOLVERS.items()):
            if light not in lights:
                continue
            seconds, found = measured(partial(solver, streams, light == "sun"))
            errors = np.abs(found / exact - 1.0)
            sizes = " | ".join(f"{size:.1e}" for size in (*np.quantile(errors, (0.5, 0.9)), np.max(errors)))
            rows.append(f"| {light} | {streams} | {name} | {1e3 * seconds:.2f} | {sizes} |")
    print("\n".join(rows))
    if given.write:
        from page import put

        put("peers of the solver", "\n".join(rows), Path(__file__).parents[1] / "docs" / "development" / "radiance.md")


if __name__ == "__main__":
    main()
