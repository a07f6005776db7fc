"""Live frames: agreement with frames of many points a pixel, and their cost, as ratios.

    python plugins/hcss-payload/benchmarks/live.py agreement --skies 16 --poses 2
    python plugins/hcss-payload/benchmarks/live.py speed
    python plugins/hcss-payload/benchmarks/live.py cube
    python plugins/hcss-payload/benchmarks/live.py allocations
    python plugins/hcss-payload/benchmarks/live.py paced --rate 100
    python plugins/hcss-payload/benchmarks/live.py hand-over
    python plugins/hcss-payload/benchmarks/live.py ring --rate 200
    python plugins/hcss-payload/benchmarks/live.py follow --rate 100 --seconds 60

Agreement is that of the mean, of the contrast and of that between neighbours, in several skies at random times of a
pass from low orbit (zenith 36 to 50 degrees, by day) with jitter of 3 mrad and 20 mrad about the axis, with the models
of the paper: of all frames together, and of single ones, whose pixels happen to hold more or less cloud than the
average of pixels with the same mean of the field. Many poses in one sky show the same clouds: they say nothing about
the bias.

The speed is processor time for each pixel, and its ratio to that of a copy of the frame in memory; least and median
times of frames are those of all threads together. With two threads other processes of the machine stretch the wall
time. Frames of the stages of cubes, of scenes that fast frames do not show, have the wall time of the longest stages
beside. Allocations are what Python, numpy and compiled loops have at once for a frame that is written into an array
(tracemalloc), and pages that the system had to provide (Linux), after the first frames. A paced run asks a server in
another process for frames of 512 x 512 pixels with sensor and target at a rate, whether the last one is done or not.
The hand-over is what server and client spend to pass a frame of 512 x 512 numbers through shared memory, and its ratio
to the copy alone. The ring gives frames of 512 x 512 numbers that were made before, at a rate, to the client in C of
the examples, which prints the time from their publication until it has read them. A run that follows asks a server of
keyframes of 256 x 256 pixels for frames at a rate, while the scene assimilates an image of 512 x 512: frames that are
skipped, or come later than the next pose, are late.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
import tracemalloc
from pathlib import Path

import numpy as np
from hcss_payload import Camera, Circular, Jitter, Track, pose_at
from hcss_payload.build import payload_of
from hcss_payload.frames import frames
from hcss_payload.live import LiveClient, LiveTwin, PointTarget, live_pass
from hcss_payload.live import ring as ring_module
from hcss_payload.live.folder_watch import FolderWatch
from hcss_payload.live.ring import Ring, RingShape
from hcss_payload.live.server import Server

from hcss_twin import Scenario
from hcss_twin.providers import Catalog

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from payload_scenes import radiometer_of  # the sensor that tests check

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
        for name, more in (("scene", {}), ("scene and sensor", {"sensor": radiometer_of(camera)})):
            planned = scene("stratus", 100.0, 96, bands, **more)
            for threads in (1, 2):
                twin = LiveTwin(planned, camera, threads)
                with twin.prepare(orbit, track, 0.0, 30.0, Jitter((2e-5, 2e-5, 1e-5)), target) as live:
                    for number in range(20):
                        live.frame(0.01 * number)
                    wall, busy, began = [], [], time.process_time()
                    for number in range(count):
                        at, used = time.perf_counter(), time.process_time()
                        live.frame(0.2 + 0.01 * number)
                        wall.append(time.perf_counter() - at)
                        busy.append(time.process_time() - used)
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
                    f"{spent / copy:.0f} copies; processor time {1e3 * min(busy):.1f} ms at least, "
                    f"{1e3 * float(np.median(busy)):.1f} median; wall {1e3 * min(wall):.1f} ms at least, {middle:.1f} "
                    f"p50, {late:.1f} p99; {live.stalls} stalls",
                    flush=True,
                )


def scenes_of_cubes(camera: Camera) -> dict[str, dict[str, object]]:
    """Return keys of scenes that frames of cubes show, beside those of one layer of stratus."""
    layers = [{"type": kind, "coverage": 0.5, "coverage_mode": "field"} for kind in ("stratus", "cirrus")]
    sea = {"wind_speed": 10.0, "temperature": 291.4, "model": "cox-munk", "temperature_texture": 0.0}
    ship = {"x": 0.0, "y": 0.0, "altitude": 0.0, "intensity": 2e6}
    return {
        "one layer, no texture": {"sea": sea},
        "one layer": {},
        "two layers": {"clouds": {"layers": layers}},
        "surfaces": {"surfaces": {"provider": "coast"}},
        "element": {"elements": [{"provider": "point-sources", "parameters": {"tracks": [ship]}}]},
        "shadows": {"slant": {"shadows": "on"}},
        "sensor": {"sensor": radiometer_of(camera)},
    }


def cubes(count: int) -> None:
    """Print the cost of live frames that are computed by the stages of cubes."""
    for size in (256, 512):
        camera, orbit, track = orbit_of(size, size, 100.0)
        for name, more in scenes_of_cubes(camera).items():
            planned = scene("stratus", 100.0, 96, ["lwir"], **{"slant": {"shadows": "off"}, **more})
            with LiveTwin(planned, camera, method="cube").prepare(orbit, track, 0.0, 30.0) as live:
                live.frame(0.0)
                spent, parts = [], []
                for number in range(count):
                    began = time.process_time()
                    live.frame(0.2 + 0.01 * number)
                    spent.append(time.process_time() - began)
                    parts.append(live.seconds)
            least = {part: min(of[part] for of in parts) for part in parts[0]}
            longest = sorted(least.items(), key=lambda item: -item[1])[:4]
            print(
                f"{size} x {size}, {name}: processor time {1e3 * min(spent):.0f} ms at least, "
                f"{1e3 * float(np.median(spent)):.0f} median; wall time at least: "
                + ", ".join(f"{part} {1e3 * seconds:.0f} ms" for part, seconds in longest),
                flush=True,
            )


def measured_pass() -> tuple[LiveTwin, Circular, Track, PointTarget]:
    """Return a camera of 512 x 512 pixels and one band with a sensor, its pass, and a target."""
    camera, orbit, track = orbit_of(512, 512, 100.0)
    frames = {"count": 2, "interval": 90.0}
    twin = LiveTwin(scene("stratus", 100.0, 96, ["lwir"], sensor=radiometer_of(camera), frames=frames), camera)
    return twin, orbit, track, PointTarget(30.0, 150.0, 12e3, (1e3,))


def allocations(count: int) -> None:
    """Print what frames allocate once the first ones are done."""
    twin, orbit, track, target = measured_pass()
    with twin.prepare(orbit, track, 0.0, 30.0, Jitter((2e-5, 2e-5, 1e-5)), target) as live:
        out = np.empty(live.shape, np.float32)
        for number in range(50):
            live.frame(0.01 * number, out=out)
        # New tiles of the sky are made by a thread of their own: what it allocates is not the frames'.
        time.sleep(2.0)
        tracemalloc.start()
        peaks, pages = [], []
        for number in range(count):
            before = tracemalloc.get_traced_memory()[0]
            tracemalloc.reset_peak()
            faults = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
            live.frame(0.5 + 1e-4 * number, out=out)
            pages.append(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - faults)
            peaks.append(tracemalloc.get_traced_memory()[1] - before)
        largest = max(tracemalloc.take_snapshot().traces, key=lambda trace: trace.size).size
        tracemalloc.stop()
    print(
        f"{count} frames of {out.nbytes / 1e6:.1f} MB: {np.median(peaks) / 1e3:.1f} kB at once in the median, "
        f"{max(peaks) / 1e3:.1f} at most; {np.median(pages):.0f} new pages in the median, {max(pages)} at most; the "
        f"largest block that is left has {largest / 1e3:.1f} kB"
    )


def serve(name: str) -> None:
    """Serve the frames of a paced run."""
    twin, orbit, track, target = measured_pass()
    live = twin.prepare(orbit, track, 0.0, 90.0, None, target)
    Server(live, name).serve(lambda: None)


def paced(rate_hz: float, seconds: float) -> None:
    """Print how many of the poses that come at a rate are skipped, and how late frames are."""
    name = f"hcss-paced-{os.getpid()}"
    server = subprocess.Popen([sys.executable, __file__, "serve", "--name", name])
    _, orbit, track, _ = measured_pass()
    jitter = Jitter((2e-5, 2e-5, 1e-5))
    with LiveClient(name, 120.0) as client:
        client.wait(client.send_pose(pose_at(0.0, orbit, track)), 60.0)
        image = np.empty(client.shape, np.uint16)
        before, late, sent, seen = client.counts(), [], {}, 0
        began = time.monotonic()
        while time.monotonic() - began < seconds:
            due = began + len(sent) / rate_hz
            if time.monotonic() >= due:
                pose = pose_at(0.02 + len(sent) / rate_hz, orbit, track, jitter)
                number = client.send_pose(pose)
                sent[number] = time.monotonic_ns()
            frame = client.latest(image) if client.counts()["frames"] > seen else None
            if frame is not None:
                seen = frame.number + 1
                if frame.pose_number in sent:
                    late.append(1e-6 * (frame.published_ns - sent[frame.pose_number]))
            else:
                time.sleep(max(0.0, min(2e-4, began + len(sent) / rate_hz - time.monotonic())))
        counts = client.counts()
        client.stop_server()
    server.wait()
    middle, most, last = np.quantile(late, (0.5, 0.99, 0.999))
    print(
        f"{rate_hz:g} Hz for {seconds:g} s: {len(sent)} poses, {counts['skipped'] - before['skipped']} skipped, "
        f"{counts['stalls'] - before['stalls']} tiles late; from pose to frame {middle:.1f} ms p50, {most:.1f} p99, "
        f"{last:.1f} p99.9; load of the machine {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors"
    )


FOLLOWED = {
    "image": {"rows": 64, "columns": 64, "pixel_size": 200.0},
    "frames": {"count": 2, "interval": 300.0},
    "sea": {"wind_speed": 10.0, "temperature": 291.4, "model": "cox-munk", "waves": "off"},
    "slant": {"shadows": "off"},
    "camera": {"rows": 256, "columns": 256, "focal_length": 1.0, "detector_pitch": 8e-6, "points": 1},
    "orbit": {"provider": "geostationary", "longitude": 140.0},
    "attitude": {"provider": "track"},
}


def followed_scene() -> Scenario:
    """Return a scene of a camera in geostationary orbit."""
    return Scenario.from_dict({**json.loads(scene("stratus", 200.0, 64, ["lwir"]).to_json()), **FOLLOWED})


def serve_followed(name: str, folder: Path) -> None:
    """Serve keyframes of a scene that follows the images of a folder by their mean (``tests/cover_follower.py``)."""
    live = live_pass(
        followed_scene(), threads=1, method="keyframes", margin_px=8.0, follower="cover_follower:cover", keyframe_s=8.0
    )
    print(f"keyframes every {live.keyframe_s:g} s, blended over {live.blend_s:g} s", flush=True)
    Server(live, name, images=FolderWatch(folder)).serve(lambda: None)


def follow(rate_hz: float, seconds: float) -> None:
    """Print how many frames are late while an image is assimilated."""
    name, tests = f"hcss-follow-{os.getpid()}", Path(__file__).parents[1] / "tests"
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, __file__, "serve-followed", "--name", name, "--folder", folder]
        server = subprocess.Popen(command, env=os.environ | {"PYTHONPATH": str(tests)})
        payload = payload_of(followed_scene(), Catalog())
        poses = [payload.pose(number / rate_hz) for number in range(round(rate_hz * seconds))]
        with LiveClient(name, 600.0) as client:
            client.wait(client.send_pose(poses[0]), 60.0)
            image, before, ms = np.empty(client.shape, np.float32), client.counts(), list[float]()
            begun, seen, began = 0, before["frames"], time.monotonic()
            for number, pose in enumerate(poses):
                if number == len(poses) // 10:
                    np.save(Path(folder) / "image.npy", np.full((512, 512), 0.8))
                time.sleep(max(0.0, began + number / rate_hz - time.monotonic()))
                posted, at = client.send_pose(pose), time.monotonic_ns()
                due = began + (number + 1) / rate_hz - 5e-4
                while client.counts()["frames"] == seen and time.monotonic() < due:
                    time.sleep(2e-4)
                frame = client.latest(image) if client.counts()["frames"] > seen else None
                if frame is not None:
                    seen = frame.number + 1
                    begun += frame.state_number == 1
                    if frame.pose_number == posted:
                        ms.append(1e-6 * (frame.published_ns - at))
            counts = client.counts()
            client.stop_server()
        server.wait()
    middle, most = np.quantile(ms, (0.5, 0.99))
    print(
        f"{rate_hz:g} Hz for {seconds:g} s: {len(poses)} poses, {len(poses) - len(ms)} late, "
        f"{counts['skipped'] - before['skipped']} skipped, {counts['stalls'] - before['stalls']} keyframes late, "
        f"{begun} frames of the new state; from pose to frame {middle:.1f} ms p50, {most:.1f} p99, {max(ms):.1f} at "
        f"most; load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors"
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


def ring(rate_hz: float, seconds: float) -> None:
    """Print what the client in C says of frames that were made before."""
    here = Path(__file__).parents[1]
    with tempfile.TemporaryDirectory() as folder:
        program = str(Path(folder) / "client")
        include = f"-I{Path(ring_module.__file__).parents[1] / 'include'}"
        source = str(here / "examples" / "client.c")
        subprocess.run(["cc", "-std=gnu11", "-O2", source, include, "-lrt", "-o", program], check=True)
        shape, count = RingShape(4, 1, 512, 512, np.dtype(np.uint16)), int(rate_hz * seconds)
        made = np.random.default_rng(1).integers(0, 2**14, (8, 1, 512, 512), np.uint16)
        ring = Ring.create(f"hcss-ring-{os.getpid()}", shape, os.getpid())
        ring.header["ready"] = 1
        try:
            with subprocess.Popen([program, f"/{ring.memory.name}", str(count)]) as client:
                time.sleep(0.2)
                began = time.monotonic()
                for number in range(count):
                    time.sleep(max(0.0, began + number / rate_hz - time.monotonic()))
                    np.copyto(ring.begin(number), made[number % len(made)])
                    ring.publish(number, number, np.eye(8)[-1], time.monotonic_ns())
                time.sleep(0.1)
                ring.header["ready"] = 0  # so that a client that lost frames ends, too
                client.wait()
        finally:
            ring.close(delete=True)
    print(f"{count} frames at {rate_hz:g} Hz; load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    whats = ("agreement", "speed", "cube", "allocations", "paced", "serve", "hand-over", "ring", "follow")
    parser.add_argument("what", choices=(*whats, "serve-followed"))
    parser.add_argument("--skies", type=int, default=16)
    parser.add_argument("--poses", type=int, default=2, help="in each sky")
    parser.add_argument("--points", type=int, default=8)
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--rate", type=float, default=100.0, help="poses a second")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--folder", type=Path, help="of a followed run's images")
    parser.add_argument("--name", help="of the memory of a paced run's server")
    options = parser.parse_args()
    if options.what == "agreement":
        agreement(options.skies, options.poses, options.points)
    elif options.what == "speed":
        speed(options.frames)
    elif options.what == "cube":
        cubes(max(3, options.frames // 50))
    elif options.what == "allocations":
        allocations(options.frames)
    elif options.what == "paced":
        paced(options.rate, options.seconds)
    elif options.what == "follow":
        follow(options.rate, options.seconds)
    elif options.what == "serve-followed":
        serve_followed(options.name, options.folder)
    elif options.what == "ring":
        ring(options.rate, options.seconds)
    elif options.what == "serve":
        serve(options.name)
    else:
        hand_over(options.frames)
