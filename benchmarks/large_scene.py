"""One frame of 20 000 x 20 000 pixels by tiles: memory, time, and windows of it computed alone.

::

    python benchmarks/large_scene.py                                      # `stratus`, one band and the cloud mask: 2 GB
    python benchmarks/large_scene.py --set clouds.coverage_mode=frame     # coverage exact in the frame
    python benchmarks/large_scene.py --workers 2 --suffix .zarr
    python benchmarks/large_scene.py --size 3000 --least-bytes 0          # quickly, all the same by tiles

The scene is run in a process of its own, and so is the frame of 800 x 800 pixels that it is compared with. Times are
those of making and writing frames; plan, tables and certificate are apart, the peak of memory has them all. The cube
lies in a temporary folder and is removed.
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
from pathlib import Path

SEED = 20_240_420
SMALL = {"image.rows": 800, "image.columns": 800, "frames.count": 1}
SCENE = {"bands": ["lwir"], "output.variables": ["radiance", "cloud_mask"], "clouds.coverage_mode": "field"}


def child(path: Path, overrides: dict[str, object], workers: int, least_bytes: int) -> None:
    """Run and print what it took: peak memory in MB of this process and of its largest worker, and seconds."""
    from hcss_twin import Scenario, make_plan
    from hcss_twin.engine import parts as tiles_module
    from hcss_twin.engine.parts import parts_of
    from hcss_twin.engine.simulate import run

    tiles_module.LARGEST_FRAME_BYTES = least_bytes
    plan = make_plan(Scenario.load("stratus", overrides))
    found: list[object] = []
    seconds: list[float] = []

    def timed(parts, count):  # type: ignore[no-untyped-def]
        before = time.perf_counter(), _processor_s(_WHO[:1])
        yield from parts
        seconds.extend((time.perf_counter() - before[0], _processor_s(_WHO[:1]) - before[1]))

    run(plan, path, timed, found.append, workers)
    # That of workers, with their plan and tables, is known once they have ended.
    seconds[1] += _processor_s(_WHO[1:])
    peak = [resource.getrusage(who).ru_maxrss / 1024 for who in _WHO]  # Linux gives kB
    told = {"peak_MB": peak[0], "worker_MB": peak[1], "s": seconds[0], "processor_s": seconds[1]}
    pixels = plan.frame_times_s.size * plan.pixels[0] * plan.pixels[1]
    certified = [certificate.passed for certificate in found]  # type: ignore[attr-defined]
    print(json.dumps({**told, "pixels": pixels, "parts": parts_of(plan), "passed": certified}))


_WHO = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)


def _processor_s(who: tuple[int, ...]) -> float:
    return sum(usage.ru_utime + usage.ru_stime for usage in map(resource.getrusage, who))


def windows_differ(path: Path, overrides: dict[str, object], count: int, most: int) -> int:
    """Compute random windows alone and return the number of values that are not those of the cube."""
    import numpy as np

    from hcss_twin import Scenario, open_cube, simulate

    random = np.random.default_rng(SEED)
    different = 0
    with open_cube(path) as cube:
        for _ in range(count):
            window = {}
            for name, dim in (("rows", "y"), ("columns", "x")):
                size = cube.sizes[dim]
                first = int(random.integers(0, size))
                window[name] = [first, min(size, first + int(random.integers(1, most)))]
            place = {"y": slice(*window["rows"]), "x": slice(*window["columns"])}
            alone = simulate(Scenario.load("stratus", {**overrides, "image.window": window, "output.certificate": 0}))
            part = cube.isel(place).load()
            wrong = sum(
                # Missing values are values, too.
                int(np.sum(~np.equal(*_bits(alone[name].to_numpy(), part[name].to_numpy()))))
                for name in (*alone.data_vars, "x", "y")
            )
            print(f"window {window}: {wrong} values differ", flush=True)
            different += wrong
    return different


def _bits(*arrays):  # type: ignore[no-untyped-def]
    return [each.view(f"u{each.dtype.itemsize}") for each in arrays]


def measured(path: Path, overrides: dict[str, object], workers: int, least_bytes: int) -> dict[str, float]:
    """Run in a process of its own."""
    given = json.dumps(overrides)
    command = [sys.executable, __file__, "--child", str(path), given, str(workers), str(least_bytes)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    return dict(json.loads(done.stdout.splitlines()[-1]))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=20_000)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--windows", type=int, default=6)
    parser.add_argument("--most", type=int, default=400, help="Rows and columns of a window, at most.")
    parser.add_argument("--suffix", default=".nc", choices=[".nc", ".zarr"])
    parser.add_argument("--least-bytes", type=int, default=2**28, help="Larger frames are made by tiles.")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--folder", help="Where the cube lies meanwhile; default: the system's.")
    parser.add_argument("--child", nargs=4, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        path, overrides, workers, least_bytes = given.child
        child(Path(path), json.loads(overrides), int(workers), int(least_bytes))
        return 0
    from hcss_twin.scenario.overrides import parse_assignment

    scene = {**SCENE, **dict(map(parse_assignment, given.set))}
    large = {**scene, "image.rows": given.size, "image.columns": given.size, "frames.count": 1}
    with tempfile.TemporaryDirectory(dir=given.folder) as folder:
        # Twice: the first run compiles kernels and tables, which both others find.
        for _ in range(2):
            small = measured(Path(folder) / "small.nc", {**scene, **SMALL}, 1, 2**28)
            os.unlink(Path(folder) / "small.nc")
        print(f"1 frame of 800 x 800: {_told(small)}", flush=True)
        path = Path(folder) / f"large{given.suffix}"
        found = measured(path, large, given.workers, given.least_bytes)
        print(f"1 frame of {given.size} x {given.size}, {given.workers} workers: {_told(found)}", flush=True)
        ratio = found["processor_s"] / found["pixels"] / (small["processor_s"] / small["pixels"])
        print(f"processor time per pixel, times that of 800 x 800: {ratio:.2f}", flush=True)
        different = windows_differ(path, large, given.windows, given.most)
    print(f"{given.windows} windows computed alone: {different} values differ")
    return int(different > 0 or max(found["peak_MB"], found["worker_MB"]) > 1000)


def _told(found: dict[str, float]) -> str:
    nanoseconds = 1e9 * found["processor_s"] / found["pixels"]
    return (
        f"peak {found['peak_MB']:.0f} MB (largest worker {found['worker_MB']:.0f} MB), {found['parts']} parts, "
        f"{found['s']:.1f} s, {found['processor_s']:.1f} s of processors, {nanoseconds:.0f} ns a "
        f"pixel, certificate {'passed' if all(found['passed']) else 'FAILED'}"  # type: ignore[call-overload]
    )


if __name__ == "__main__":
    sys.exit(main())
