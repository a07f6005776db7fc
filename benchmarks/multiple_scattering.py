"""Error and speed of the solvers of multiple scattering, by streams and azimuth modes.

::

    python benchmarks/multiple_scattering.py            # tables of docs/development/radiance.md, some minutes
    python benchmarks/multiple_scattering.py --quick    # a tenth of the layers

Random layers: optical thickness 0.01 to 100 (evenly in its logarithm), albedo 0.3 to 1, Henyey-Greenstein
with g 0.7 to 0.95, sun at zenith angles 0 to 84 degrees. The reference is PythonicDISORT with 64 streams at its
own directions; two-stream is compared with adding-doubling of 16 streams.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from PythonicDISORT.pydisort import pydisort

from hcss_twin.physics.multiple_scattering.directions import gauss_streams
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.starting_layer import START, halvings
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun
from hcss_twin.physics.multiple_scattering.two_stream import solve_layers_two_stream, solve_sun_two_stream

AZIMUTH = np.linspace(0.0, np.pi, 7)
TERMS = 600
REFERENCE_STREAMS = 64
# Streams per hemisphere and modes.
SETTINGS = ((8, 8), (8, 16), (16, 16), (16, 32), (24, 48))
MIN_MU = {"75": 0.259, "87": 0.05}

Layer = tuple[float, float, float, float]

SPEED_LAYER = (10.0, 0.9, 0.85, 0.6)

FIRST_CALLS = """
import time
from hcss_twin.physics.multiple_scattering.layer import solve_layers
from hcss_twin.physics.multiple_scattering.sunlight import solve_sun
start = time.process_time()
layer = [[1.0]], [0.9], [[1.0], [0.8]]
solve_layers(*layer, [1.0], 8, threads=1)
solve_sun(*layer, [1.0], 0.5, [0.0], 8, 16, threads=1)
print(time.process_time() - start)
"""


def random_layers(count: int) -> list[Layer]:
    rng = np.random.default_rng(500)
    return [
        (10 ** rng.uniform(-2, 2), rng.uniform(0.3, 1.0), rng.uniform(0.7, 0.95), rng.uniform(0.1, 1.0))
        for _ in range(count)
    ]


def disort(layer: Layer, streams: int, sun: bool) -> Any:
    """Run PythonicDISORT; its isotropic source is multiplied by 1 - albedo inside."""
    tau, albedo, g, mu_sun = layer
    moments = g ** np.arange(TERMS)
    common = {"NLeg": streams, "f_arr": moments[streams]}
    arguments = (np.array([tau]), np.array([albedo]), streams, moments[np.newaxis], mu_sun)
    if sun:
        return pydisort(*arguments, 1.0, 0.0, NFourier=streams, NT_cor=True, **common)
    return pydisort(*arguments, 0.0, 0.0, NFourier=1, s_poly_coeffs=np.array([[1.0]]), **common)


def print_errors(layers: list[Layer]) -> None:
    found: dict[tuple[int, int, str, str], list[float]] = {}
    negative: dict[int, float] = {}
    half = REFERENCE_STREAMS // 2
    for layer in layers:
        tau, albedo, g, mu_sun = layer
        thermal = disort(layer, REFERENCE_STREAMS, sun=False)
        emissivity = thermal[3](0.0)[:half]
        radiance = disort(layer, REFERENCE_STREAMS, sun=True)[4](np.array([0.0, tau]), np.pi - AZIMUTH)
        exact_back, exact_through = radiance[:half, 0] / mu_sun, radiance[half:, 1] / mu_sun
        given = np.array([[1.0], [g]])
        seen = thermal[0][:half] >= min(MIN_MU.values())
        mu = thermal[0][:half][seen]
        views, azimuth = np.repeat(mu, AZIMUTH.size), np.tile(AZIMUTH, mu.size)
        for streams, modes in SETTINGS:
            mine = solve_layers([[tau]], [albedo], given, mu, streams, threads=1)
            lowest = min(mine.reflection.min(), mine.transmission.min())
            negative[streams] = min(negative.get(streams, 0.0), lowest)
            back, through = solve_sun(
                [[tau]], [albedo], given, views, mu_sun, azimuth, streams, modes, 1, mode_tolerance=0.0
            )
            off = np.abs(mine.emissivity[0, 0, : mu.size] - emissivity[seen])
            off_back = np.abs(back[0, 0].reshape(mu.size, -1) - exact_back[seen])
            off_through = np.abs(through[0, 0].reshape(mu.size, -1) - exact_through[seen])
            for angle, least in MIN_MU.items():
                few = mu >= least
                largest = exact_back[seen][few].max()
                both = max(largest, exact_through[seen][few].max())
                for name, error in (
                    ("emissivity", off[few].max()),
                    ("brdf", off_back[few].max() / largest),
                    ("btdf", off_through[few].max() / both),
                ):
                    found.setdefault((streams, modes, angle, name), []).append(float(error))
    print(f"\nErrors of {len(layers)} random layers: largest over directions, then over layers\n")
    print("| streams, modes | view zenith to | emissivity: median, 95 %, largest | brdf | btdf |")
    print("|---|---|---|---|---|")
    for streams, modes in SETTINGS:
        for angle in MIN_MU:
            cells = []
            for name in ("emissivity", "brdf", "btdf"):
                errors = np.array(found[streams, modes, angle, name])
                scale, unit = (1.0, "") if name == "emissivity" else (100.0, " %")
                numbers = (np.median(errors), np.quantile(errors, 0.95), errors.max())
                cells.append(", ".join(f"{scale * number:.2g}" for number in numbers) + unit)
            print(f"| {streams}, {modes} | {angle} | " + " | ".join(cells) + " |")
    print()
    for streams, modes in SETTINGS:
        for angle in MIN_MU:
            within = np.mean(np.array(found[streams, modes, angle, "brdf"]) < 0.02)
            print(f"{streams} streams, {modes} modes, to {angle} degrees: brdf within 2 % in {within:.1%} of layers")
    print("Most negative kernel, sr-1: " + ", ".join(f"{n} streams {v:.2g}" for n, v in negative.items()))


def print_two_stream(layers: list[Layer]) -> None:
    mu = np.array([1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.26])
    views, azimuth = np.repeat(mu, AZIMUTH.size), np.tile(AZIMUTH, mu.size)
    found: dict[str, list[float]] = {"emissivity": [], "far share": [], "reflected": [], "transmitted": []}
    found |= {"brdf": [], "btdf": []}
    for tau, albedo, g, mu_sun in layers:
        arguments = ([[tau]], [albedo], np.array([[1.0], [g]]))
        exact, fast = solve_layers(*arguments, mu, 16, threads=1), solve_layers_two_stream(*arguments, mu, 8)
        few = np.s_[0, 0, : mu.size]

        def difference(exact: np.ndarray, fast: np.ndarray) -> float:
            return float(np.abs(exact - fast).max())

        found["emissivity"].append(difference(exact.emissivity[few], fast.emissivity[few]))
        found["far share"].append(difference(exact.far_share[few], fast.far_share[few]))
        rows = []
        for layer in (exact, fast):
            flux = 2.0 * np.pi * layer.mu * layer.weight
            passed = layer.transmission[few] @ flux + layer.direct[few]
            rows.append((layer.reflection[few] @ flux, passed))
        found["reflected"].append(difference(rows[0][0], rows[1][0]))
        found["transmitted"].append(difference(rows[0][1], rows[1][1]))
        back, through = solve_sun(*arguments, views, mu_sun, azimuth, 16, 32, 1, mode_tolerance=0.0)
        fast_back, fast_through = solve_sun_two_stream(*arguments, views, mu_sun, azimuth, 8)
        found["brdf"].append(difference(back, fast_back) / back.max())
        found["btdf"].append(difference(through, fast_through) / max(back.max(), through.max()))
    print(f"\nTwo-stream against adding-doubling, {len(layers)} random layers, view zenith to 75 degrees\n")
    print("| | rms | 95 % | largest |")
    print("|---|---|---|---|")
    for name, values in found.items():
        errors = np.array(values)
        scale, unit = (100.0, " %") if name in ("brdf", "btdf") else (1.0, "")
        numbers = (np.sqrt(np.mean(errors**2)), np.quantile(errors, 0.95), errors.max())
        print(f"| {name} | " + " | ".join(f"{scale * number:.2g}{unit}" for number in numbers) + " |")


def best_s(call: Callable[[], Any], repeats: int) -> float:
    call()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)


def print_speed(quick: bool) -> None:
    """Time per layer at g = 0.85, albedo 0.9, thickness 10, one thread."""
    count, repeats = 200, 3 if quick else 20
    tau, albedo = np.full((1, count), 10.0), np.full(count, 0.9)
    moments = np.stack([np.ones(count), np.full(count, 0.85)])
    views, azimuth = np.repeat([1.0, 0.5], 4), np.tile([0.0, 1.0, 2.0, 3.0], 2)
    print("\nTime per layer of thickness 10, one thread, two extra directions; sun: 2 views, 4 azimuths\n")
    print("| streams | us per doubling | thermal, us | / PythonicDISORT | sun, 2N modes, us | / PythonicDISORT |")
    print("|---|---|---|---|---|---|")
    for streams in (4, 8, 16, 32):
        conservative = np.ones(count)

        def thick(depth: float, streams: int = streams, w: np.ndarray = conservative) -> None:
            solve_layers(np.full((1, count), depth), w, moments, [1.0, 0.5], streams, threads=1)

        # A thousand times thicker is ten doublings more.
        doubling = (best_s(lambda: thick(1024.0), repeats) - best_s(lambda: thick(1.0), repeats)) / 10 / count
        thermal = best_s(lambda n=streams: solve_layers(tau, albedo, moments, [1.0, 0.5], n, 1), repeats) / count
        sun = best_s(
            lambda n=streams: solve_sun(tau, albedo, moments, views, 0.6, azimuth, n, 2 * n, 1, 0.0),
            max(2, repeats // 5),
        )
        sun /= count
        other = best_s(lambda n=streams: disort(SPEED_LAYER, 2 * n, sun=False)[3](0.0), 20)
        other_sun = best_s(lambda n=streams: disort(SPEED_LAYER, 2 * n, sun=True)[4](0.0, azimuth[:4]), 10)
        print(
            f"| {streams} | {doubling * 1e6:.2f} | {thermal * 1e6:.1f} | {thermal / other:.3f} "
            f"| {sun * 1e6:.0f} | {sun / other_sun:.3f} |"
        )
    least = float(gauss_streams(8).mu.min())
    depth = 10.0 * (1.0 - 0.9 * 0.85**16)
    print(f"\n8 streams: {halvings(depth, least, START)} doublings for thickness 10")
    modes = best_s(lambda: solve_sun(tau, albedo, moments, views, 0.6, azimuth, 8, 8, 1, 0.0), repeats) / count
    print(f"Sun, 8 streams, 8 modes: {modes * 1e6:.0f} us per layer")
    fast = best_s(lambda: solve_layers_two_stream(tau, albedo, moments, [1.0, 0.5], 8), repeats) / count
    fast_sun = best_s(lambda: solve_sun_two_stream(tau, albedo, moments, views, 0.6, azimuth, 8), repeats) / count
    print(f"Two-stream, 8 streams: {fast * 1e6:.1f} us, sun {fast_sun * 1e6:.1f} us per layer")


def print_families(quick: bool) -> None:
    """Time per layer of ten halves of thickness 10 against ten layers that are no halves of each other."""
    count, repeats = 50, 2 if quick else 5
    albedo, moments = np.full(count, 0.9), np.stack([np.ones(count), np.full(count, 0.85)])
    views, azimuth = np.repeat([1.0, 0.5], 4), np.tile([0.0, 1.0, 2.0, 3.0], 2)
    halves = np.repeat(10.0 * 0.5 ** np.arange(10)[:, np.newaxis], count, axis=1)
    others = halves * (1.0 + 1e-6 * np.arange(10))[:, np.newaxis]
    print("\nTen halves of thickness 10, us per layer, one thread\n")
    print("| streams | thermal, apart | one chain | sun, 2N modes, apart | one chain |")
    print("|---|---|---|---|---|")
    for streams in (8, 16):
        cells = [
            best_s(lambda n=streams, t=t: solve_layers(t, albedo, moments, [1.0, 0.5], n, 1), repeats)
            for t in (others, halves)
        ]
        cells += [
            best_s(lambda n=streams, t=t: solve_sun(t, albedo, moments, views, 0.6, azimuth, n, 2 * n, 1, 0.0), 2)
            for t in (others, halves)
        ]
        print(f"| {streams} | " + " | ".join(f"{1e6 * cell / halves.size:.1f}" for cell in cells) + " |")


def print_mode_tolerance(layers: list[Layer], quick: bool) -> None:
    """Time saved by leaving out modes, and what that changes."""
    tau, albedo, g, _ = np.array(layers).T
    moments = np.stack([np.ones_like(g), g])
    mu = np.array([1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.26])
    views, azimuth = np.repeat(mu, AZIMUTH.size), np.tile(AZIMUTH, mu.size)
    print(f"\nModes left out, {len(layers)} random layers, view zenith to 75 degrees, sun at 53 degrees\n")
    print("| streams | mode_tolerance | time / all modes | largest change of brdf or btdf, relative |")
    print("|---|---|---|---|")
    for streams in (8, 16, 24):
        arguments = (tau[np.newaxis], albedo, moments, views, 0.6, azimuth, streams, 2 * streams, 1)
        every, whole = solve_sun(*arguments, 0.0), best_s(lambda a=arguments: solve_sun(*a, 0.0), 2)
        for tolerance in (1e-5, 1e-4, 1e-3):
            few = solve_sun(*arguments, tolerance)
            change = max(float(np.max(np.abs(f / e - 1.0))) for f, e in zip(few, every, strict=True))
            spent = best_s(lambda a=arguments, t=tolerance: solve_sun(*a, t), 1 if quick else 2)
            print(f"| {streams} | {tolerance:g} | {spent / whole:.2f} | {change:.2g} |")


def print_first_calls() -> None:
    """Processor time of the first calls where nothing is compiled yet, and where all is."""
    with tempfile.TemporaryDirectory() as empty:
        environment = os.environ | {"NUMBA_CACHE_DIR": empty}
        command = [sys.executable, "-c", FIRST_CALLS]
        cold, warm = (
            float(subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout)
            for _ in range(2)
        )
    print(f"\nFirst solve_layers and solve_sun: {cold:.1f} s with nothing compiled, {warm:.2f} s after")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a tenth of the layers")
    options = parser.parse_args()
    print_first_calls()
    print_speed(options.quick)
    print_families(options.quick)
    layers = random_layers(20 if options.quick else 200)
    print_mode_tolerance(layers, options.quick)
    print_two_stream(layers)
    print_errors(layers)


if __name__ == "__main__":
    main()
