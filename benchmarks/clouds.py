"""Speed and memory of the cloud field beside other ways to make one, in one run.

::

    python benchmarks/clouds.py                         # stratus, 8 frames of 800 x 800
    python benchmarks/clouds.py --type cumulus --frames 512
    python benchmarks/clouds.py --memory                # peak memory for 8 and for 5000 frames

The PyPI packages ``pyfastnoiselite`` and ``gstools`` are used where they are installed; what is missing is named below
the table. Repeats are interleaved: each round runs every contender once, and ratios are taken within a round, because
the speed of a shared machine drifts.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import argparse
import importlib.metadata
import platform
import statistics
import time

from cloud_scenes import TYPES, digits


def machine() -> str:
    """Return what the numbers depend on."""
    versions = []
    for package in ("numpy", "scipy", "numba", "pyfastnoiselite", "gstools"):
        try:
            versions.append(f"{package} {importlib.metadata.version(package)}")
        except importlib.metadata.PackageNotFoundError:
            continue
    return f"{platform.machine()}, {os.cpu_count()} CPUs, Python {platform.python_version()}, " + ", ".join(versions)


def speed(kind: str, pixels: int, frames: int, rounds: int) -> None:
    """Print nanoseconds per pixel and frame, and their ratio to ours on one thread."""
    from cloud_contenders import contenders

    found, missing = contenders(kind, pixels, frames)
    for contender in found:
        contender.run()  # compiles and fills caches
    seconds_per_pixel: dict[str, list[float]] = {contender.name: [] for contender in found}
    for _ in range(rounds):
        for contender in found:
            start = time.perf_counter()
            count = contender.run()
            seconds_per_pixel[contender.name].append((time.perf_counter() - start) / count)
    ours = seconds_per_pixel[found[0].name]
    print(f"{kind}, {pixels} x {pixels} pixels, {frames} frames; medians of {rounds} interleaved rounds; {machine()}\n")
    print("| way | ns per pixel and frame | range | times ours | remark |")
    print("|---|---|---|---|---|")
    for contender in found:
        values = seconds_per_pixel[contender.name]
        ratio = statistics.median(value / own for value, own in zip(values, ours, strict=True))
        print(
            f"| {contender.name} | {digits(statistics.median(values) * 1e9)} | {digits(min(values) * 1e9)}-"
            f"{digits(max(values) * 1e9)} | {digits(ratio)} | {contender.remark} |"
        )
    for line in missing:
        print(f"\nmissing: {line}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--type", default="stratus", choices=TYPES)
    parser.add_argument("--pixels", type=int, default=800, help="rows and columns of a frame")
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--memory", action="store_true")
    given = parser.parse_args()
    if given.memory:
        from cloud_memory import memory

        memory(given.type)
    else:
        speed(given.type, given.pixels, given.frames, given.rounds)


if __name__ == "__main__":
    main()
