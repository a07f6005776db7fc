"""PyPI ``satellite-cloud-generator``, clouds of Perlin noise drawn into images, beside ours."""

from __future__ import annotations

import statistics
import time
import warnings
from collections.abc import Callable
from typing import Any

from cloud_scenes import MOTION, digits, make_generator


def perlin(kind: str, pixels: int, rounds: int) -> None:
    """Print milliseconds per image."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import satellite_cloud_generator as library
            import torch
            from satellite_cloud_generator.noise import generate_perlin
    except ImportError as error:
        print(f"missing: {error}; install torch and satellite-cloud-generator (and kornia, imageio)")
        return
    torch.set_num_threads(1)
    image, window = torch.rand(1, 3, pixels, pixels), slice(0, pixels)
    clock = {"frame": 0}
    generator = make_generator(kind, pixels)

    def ours(method: str) -> Callable[[], Any]:
        def run() -> Any:
            clock["frame"] += 1
            return getattr(generator, method)(clock["frame"] * MOTION.frame_interval_s, window, window)

        return run

    rows: tuple[tuple[str, Callable[[], Any]], ...] = (
        (f"ours, {kind}: field V", ours("field")),
        (f"ours, {kind}: thickness", ours("thickness_m")),
        ("theirs: Perlin field alone", lambda: generate_perlin(shape=(pixels, pixels))),
        ("theirs: cloud drawn into an image of 3 channels", lambda: library.add_cloud(image)),
    )
    times: dict[str, list[float]] = {name: [] for name, _ in rows}
    for _, call in rows:
        call()
    for _ in range(rounds):
        for name, call in rows:
            start = time.perf_counter()
            call()
            times[name].append(time.perf_counter() - start)
    told = f"1 thread each, medians of {rounds} interleaved rounds, torch {torch.__version__}"
    print(f"{pixels} x {pixels} pixels, {told}\n")
    print("| way | ms per image | times our field |")
    print("|---|---|---|")
    base = times[rows[0][0]]
    for name, values in times.items():
        ratio = statistics.median(value / own for value, own in zip(values, base, strict=True))
        print(f"| {name} | {digits(statistics.median(values) * 1e3)} | {digits(ratio)} |")
    print("\nTheirs are single pictures: no time, no motion, no thickness in metres.")
