"""Live frames: agreement with frames of many points a pixel, and their cost, as ratios.

    python plugins/hcss-payload/benchmarks/live.py agreement --skies 16 --poses 2
    python plugins/hcss-payload/benchmarks/live.py speed
    python plugins/hcss-payload/benchmarks/live.py hand-over

Agreement is that of the mean, of the contrast and of that between neighbours, in several skies at random times of a
pass from low orbit (zenith 36 to 50 degrees, by day) with jitter of 3 mrad and 20 mrad about the axis, with the models
of the paper: of all frames together, and of single ones, whose pixels happen to hold more or less cloud than the
average of pixels with the same mean of the field. Many poses in one sky show the same clouds: they say nothing about
the bias. The
speed is processor time for each pixel, and its ratio to that of a copy of the frame in memory. The hand-over is what
server and client spend to pass a frame of 512 x 512 numbers through shared memory, and its ratio to the copy alone.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

import numpy as np
from hcss_payload import Camera, Circular, Jitter, Track
from hcss_payload.frames import frames
from hcss_payload.live import LiveClient, LiveTwin, PointTarget
from hcss_payload.live.ring import Ring, RingShape

from hcss_twin import Scenario

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from payload_scenes import RADIOMETER  # the sensor that tests check

CASES = [(kind, size) for size in (100.0, 30.0, 300.0) for kind in ("stratus", "cumulus", "cirrus", "stratocumulus")]


def scene(kind: str, pixel_m: float, pixels: int, bands: list[str], **more: object) -> Scenario:
    """Return a scene of broken clouds of the models of the paper."""
    return Scenario.from_dict(
        {
            "seed": 1,
            "time": "2024-04-20T02:30:00Z",
            "bands": bands,
            "place": {"latitude": 30.0, "longitude": 150.0},
            "image": {"rows": pixels, "columns": pixels, "pixel_size": pixel_m},
            "frames": {"count": 2, "interval": 30.0},
            "motion": {"wind_speed": 10.0, "wind_from": 250.0},
            "clouds": {"type": kind, "coverage": 0.5, "coverage_mode": "field"},
            "sea": {"wind_speed": 10.0, "temperature": 291.4, "model": "cox-munk"},
            "radiance": {"model": "as-printed"},
            "optics": {"provider": "mie"},
            "output": {"certificate": 0},
            **more,
        }
    )


def orbit_of(rows: int, columns: int, pixel_m: float) -> tuple[Camera, Circular, Track]:
    """Return a camera in low orbit that stares at the place of the scene."""
    orbit = Circular(altitude_m=700e3, inclination_deg=98.2, node_longitude_deg=156.0, argument_deg=26.5)
    return Camera(rows, columns, 1.0, pixel_m / 700e3), orbit, Track(orbit, 30.0, 150.0)


def neighbours(image: np.ndarray) -> float:
    """Return the contrast between neighbours."""
    return float(np.sqrt(np.mean(np.diff(image, axis=0) ** 2) + np.mean(np.diff(image, axis=1) ** 2)))


def agreement(skies: int, poses: int, points: int) -> None:
    """Print how live frames agree with frames of many points."""
    rng, bands = np.random.default_rng(1), ["lwir", "mwir"]
    print(
        f"{'clouds, pixel at nadir, band':36}bias     neighbours  contrast  of single frames: rms and worst, neighbours"
    )
    for kind, pixel_m in CASES:
        camera, orbit, track = orbit_of(64, 64, pixel_m)
        jitter, found = Jitter((3e-3, 3e-3, 2e-2), seed=5), []
        for seed in range(skies):
            times = np.sort(rng.uniform(0.0, 30.0, poses)).tolist()
            fine = scene(kind, pixel_m / points, 800, bands, seed=seed)
            with LiveTwin(scene(kind, 100.0, 96, bands, seed=seed), camera).prepare(
                orbit, track, 0.0, 30.0, jitter
            ) as live:
                for exact in frames(fine, camera, orbit, track, times, jitter, points=points):
                    own = live.frame(exact.pose.time_s).radiance
                    found.append([[f(image.astype(float)) for f in (np.mean, np.std, neighbours) for image in pair]
                                  for pair in zip(own, exact.radiance, strict=True)])  # fmt: skip
        for band, each in zip(bands, np.moveaxis(found, 1, 0), strict=True):
            mean, true_mean, contrast, true_contrast, beside, true_beside = each.T
            away = mean / true_mean - 1.0 - (mean.sum() / true_mean.sum() - 1.0)
            print(
                f"{kind + f', {pixel_m:g} m, {band}':36}{mean.sum() / true_mean.sum() - 1.0:+8.1e}"
                f"{np.linalg.norm(beside) / np.linalg.norm(true_beside):10.3f}"
                f"{np.linalg.norm(contrast) / np.linalg.norm(true_contrast):10.3f}"
                f"{away.std():12.1e}{np.abs(away).max():9.1e}{(beside / true_beside).min():10.3f} to "
                f"{(beside / true_beside).max():.3f}",
                flush=True,
            )


def speed(count: int) -> None:
    """Print the cost of live frames."""
    for bands, rows, columns in ((["lwir"], 512, 512), (["lwir", "mwir"], 512, 640)):
        camera, orbit, track = orbit_of(rows, columns, 100.0)
        target = PointTarget(30.0, 150.0, 12e3, (1e3,) * len(bands))
        for name, more in (("scene", {}), ("scene and sensor", {"sensor": RADIOMETER})):
            planned = scene("stratus", 100.0, 96, bands, **more)
            for threads in (1, 2):
                twin = LiveTwin(planned, camera, threads)
                with twin.prepare(orbit, track, 0.0, 30.0, Jitter((2e-5, 2e-5, 1e-5)), target) as live:
                    for number in range(20):
                        live.frame(0.01 * number)
                    wall, began = [], time.process_time()
                    for number in range(count):
                        at = time.perf_counter()
                        live.frame(0.2 + 0.01 * number)
                        wall.append(time.perf_counter() - at)
                    spent = (time.process_time() - began) / count
                    frame = live.frame(0.2).radiance
                    began = time.process_time()
                    for _ in range(200):
                        frame.copy()
                    copy = (time.process_time() - began) / 200
                per = 1e9 * spent / (rows * columns)
                middle, late = (1e3 * float(np.quantile(wall, share)) for share in (0.5, 0.99))
                print(
                    f"{rows} x {columns} x {len(bands)}, {name}, {threads} thread(s): {per:.1f} ns a pixel, "
                    f"{spent / copy:.0f} copies; {middle:.1f} ms p50, {late:.1f} ms p99; {live.stalls} stalls",
                    flush=True,
                )


def hand_over(count: int) -> None:
    """Print what a client spends on a frame."""
    shape = RingShape(4, 1, 512, 512, np.dtype(np.uint16))
    ring = Ring.create(f"hcss-hand-over-{os.getpid()}", shape, os.getpid())
    client = LiveClient(ring.memory.name)
    try:
        out = np.empty((1, 512, 512), np.uint16)
        taken, copied = [], []
        for number in range(count):
            ring.begin(number)[:] = number
            began = time.perf_counter()
            ring.publish(number, number + 1, np.eye(8)[-1], 0)
            client.latest(out)
            taken.append(time.perf_counter() - began)
            began = time.perf_counter()
            np.copyto(out, ring.frames[number % 4])
            copied.append(time.perf_counter() - began)
    finally:
        client.close()
        ring.close(delete=True)
    least, middle = (1e6 * float(np.quantile(taken, share)) for share in (0.05, 0.5))
    ratio = float(np.quantile(taken, 0.5) / np.quantile(copied, 0.5))
    print(f"publication and copy {least:.0f} us (5 %), {middle:.0f} us (median), {ratio:.1f} times the copy")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("agreement", "speed", "hand-over"))
    parser.add_argument("--skies", type=int, default=16)
    parser.add_argument("--poses", type=int, default=2, help="in each sky")
    parser.add_argument("--points", type=int, default=8)
    parser.add_argument("--frames", type=int, default=300)
    options = parser.parse_args()
    if options.what == "agreement":
        agreement(options.skies, options.poses, options.points)
    elif options.what == "speed":
        speed(options.frames)
    else:
        hand_over(options.frames)
