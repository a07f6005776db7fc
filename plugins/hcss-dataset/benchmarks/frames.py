"""Cost of a data set: processor time, size and memory, from an empty cache.

    python benchmarks/frames.py --size 256 --count 1 --frames 400

makes frames of the example with a new cache, then as many as asked for, and prints what one of these costs,
what the start cost, and what 10 000 frames would. Times are those of one core: they depend little on what else runs.
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
import tomllib
from pathlib import Path
from typing import Any

EXAMPLE = Path(__file__).parents[1] / "examples" / "small-targets.toml"
WHOLE = 10_000
DRAWS_AT_START = 24
"""Enough that each state of the example has had draws with and without targets."""


def options() -> argparse.Namespace:
    """Return the options."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=256, help="Rows and columns.")
    parser.add_argument("--count", type=int, default=1, help="Frames in a sequence.")
    parser.add_argument("--frames", type=int, default=400, help="Frames after the start.")
    parser.add_argument("--workers", type=int, default=1, help="Processes after the start.")
    parser.add_argument("--format", default=None, help="Format of the images, by default that of the example.")
    parser.add_argument("--step", type=float, default=None, help="image.step_temperature, K.")
    parser.add_argument("--distribution", type=Path, default=EXAMPLE, help="File of the data set.")
    parser.add_argument("--warm", action="store_true", help="Use the cache of the user.")
    return parser.parse_args()


def measure(given: argparse.Namespace, folder: Path) -> None:
    """Make both parts and print what they cost."""
    from hcss_dataset.make import make_dataset

    raw = tomllib.loads(given.distribution.read_text(encoding="utf-8"))
    raw["base"].setdefault("image", {}).update(rows=given.size, columns=given.size)
    raw["base"].setdefault("frames", {})["count"] = given.count
    image: dict[str, Any] = raw.setdefault("image", {})
    image |= {} if given.format is None else {"format": given.format}
    image |= {} if given.step is None else {"step_temperature": given.step}
    at_start = DRAWS_AT_START * given.count
    began = time.process_time()
    make_dataset(raw, folder / "start", at_start)
    start_s, memory = time.process_time() - began, _memory_MB()
    began = time.process_time()
    made = make_dataset(raw, folder / "set", given.frames, workers=given.workers)
    spent = time.process_time() - began if given.workers == 1 else made.processor_s
    files = sum(path.stat().st_size for path in (folder / "set" / "shards").iterdir())
    frame_s = spent / given.frames
    start_s -= at_start * frame_s
    print(f"{given.size} x {given.size}, sequences of {given.count}, {given.frames} frames, {given.workers} workers")
    print(f"  a frame: {1e3 * frame_s:.1f} ms of processor time, {files / given.frames / 1e3:.0f} kB")
    print(f"  wall time: {made.seconds:.1f} s, {given.frames / made.seconds:.1f} frames/s; refused: {made.refused}")
    print(f"  start: {start_s:.1f} s of processor time; memory: {memory:.0f} MB, later {_memory_MB():.0f} MB")
    print(f"  {WHOLE} frames: {start_s + WHOLE * frame_s:.0f} s of processor time")


def _memory_MB() -> float:
    """Return the largest memory of this process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        asked = options()
        if not asked.warm:
            os.environ["HCSS_CACHE_DIR"] = str(Path(scratch) / "cache")
        measure(asked, Path(scratch))
