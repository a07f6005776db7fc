"""Writing of cubes, and whole runs, against writing the same bytes raw to a preallocated file.

::

    python benchmarks/writing.py                            # layouts, 8 frames of `stratus`
    python benchmarks/writing.py --runs --frames 8          # whole runs from a plan whose tables are kept
    python benchmarks/writing.py --runs --frames 512 --rounds 3
    python benchmarks/writing.py --band lwir                # also packed into 16 bits

All put the file on the disk (fsync) before the clock stops. Contenders take turns in every round and ratios are taken
within a round. Sizes and errors do not depend on the machine.
"""

from __future__ import annotations

import argparse
import os
import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from hcss_twin import Scenario, make_plan
from hcss_twin.cube.writer import CubeWriter, bits_for, round_bits
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.simulate import cube_header, run
from hcss_twin.engine.stream import stream
from hcss_twin.plan.plan import Plan

Frames = Sequence[dict[str, NDArray[Any]]]


def clocked(task: Callable[[], object]) -> tuple[float, float]:
    """Seconds that pass, and seconds of all processors, also of other threads."""
    start, cpu = time.perf_counter(), time.process_time()
    task()
    return time.perf_counter() - start, time.process_time() - cpu


def raw(path: Path, pieces: Sequence[NDArray[np.uint8]], times: int = 1) -> Callable[[], None]:
    """Write pieces one after the other into a file that has its size already, so many times."""
    path.unlink(missing_ok=True)
    handle = os.open(path, os.O_CREAT | os.O_RDWR)
    os.posix_fallocate(handle, 0, times * sum(piece.size for piece in pieces))

    def task() -> None:
        at = 0
        for _ in range(times):
            for piece in pieces:
                at += os.pwrite(handle, piece, at)
        os.fsync(handle)
        os.close(handle)

    return task


def bytes_of(frame: dict[str, NDArray[Any]]) -> NDArray[np.uint8]:
    return np.concatenate([array.view(np.uint8).ravel() for array in frame.values()])


def rounded(frames: Frames, error: float) -> Frames:
    """Copies with radiance rounded as ``output.quantization`` does."""
    copies = []
    for frame in frames:
        copy = {name: array.copy() for name, array in frame.items()}
        for array in copy.values():
            if array.dtype == np.float32:
                round_bits(array, bits_for(error))
        copies.append(copy)
    return copies


def largest_error(frames: Frames, others: Frames) -> float:
    return max(
        float(np.max(np.abs(other["radiance"].astype(np.float64) / frame["radiance"] - 1.0)))
        for frame, other in zip(frames, others, strict=True)
    )


def write_cube(path: Path, plan: Plan, frames: Frames, level: int | None) -> None:
    with CubeWriter(path, cube_header(plan, None), compression=level) as writer:
        for index, frame in enumerate(frames):
            writer.write_frame(index, frame)


def write_zstd(path: Path, frames: Frames, level: int) -> None:
    """The same numbers by another codec of the netCDF library, which not every reader has."""
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("time", len(frames))
        for name, array in frames[0].items():
            dims = [file.createDimension(f"{name}_{axis}", size).name for axis, size in enumerate(array.shape)]
            file.createVariable(
                name, array.dtype, ("time", *dims), compression="zstd", complevel=level, shuffle=True,
                chunksizes=(1,) * (len(dims) - 1) + array.shape[-2:], fill_value=False,
            )  # fmt: skip
        for index, frame in enumerate(frames):
            for name, array in frame.items():
                file[name][index] = array
    with path.open("rb+") as written:
        os.fsync(written)


def write_with_xarray(path: Path, plan: Plan, frames: Frames) -> None:
    """All frames at once, on the disk when it returns."""
    variables = {spec.name: (spec.dims, np.stack([frame[spec.name] for frame in frames])) for spec in plan.variables}
    xr.Dataset(variables).to_netcdf(path, engine="netcdf4")
    with path.open("rb+") as written:
        os.fsync(written)


def layouts(plan: Plan, folder: Path, rounds: int, packing: Plan | None) -> None:
    """Print time, size and error of each way to write, also of a plan with packing."""
    frames = list(stream(plan, tables_of(plan)))
    pieces = [bytes_of(frame) for frame in frames]
    rounding = {error: rounded(frames, error) for error in (1e-5, 1e-4, 5e-4)}
    path = folder / "cube.nc"
    ways: dict[str, tuple[Frames, Callable[[], None]]] = {}
    for level in (None, 1, 4, 9):
        name = "uncompressed" if level is None else f"compression = {level}"
        ways[name] = frames, lambda level=level: write_cube(path, plan, frames, level)
    for error, copies in rounding.items():
        name = f"compression = 1, quantization = {error:g}"
        ways[name] = copies, lambda copies=copies: write_cube(path, plan, copies, 1)
    if packing is not None:
        packed = list(stream(packing, tables_of(packing)))
        for name, level in (("packing = int16", None), ("compression = 1, packing = int16", 1)):
            ways[name] = packed, lambda level=level: write_cube(path, packing, packed, level)
    ways["xarray to_netcdf, from memory"] = frames, lambda: write_with_xarray(path, plan, frames)
    ways["zstd level 3 (not offered)"] = frames, lambda: write_zstd(path, frames, 3)
    ways["zstd level 3, rounded to 1e-4 (not offered)"] = (rounding[1e-4], lambda: write_zstd(path, rounding[1e-4], 3))
    total = sum(piece.size for piece in pieces)
    sizes: dict[str, int] = {}
    seconds: dict[str, list[tuple[float, float]]] = {name: [] for name in ("raw", *ways)}
    for _ in range(rounds):
        seconds["raw"].append(clocked(raw(folder / "raw", pieces)))
        for name, (_, task) in ways.items():
            path.unlink(missing_ok=True)
            seconds[name].append(clocked(task))
            sizes[name] = path.stat().st_size
    print(f"{len(frames)} frames, {total / 1e6:.1f} MB; {rounds} rounds\n")
    print("| way | times raw | processor, ms a frame | size | largest relative error |\n|---|---|---|---|---|")
    for name in seconds:
        ratio = statistics.median(a / b for (a, _), (b, _) in zip(seconds[name], seconds["raw"], strict=True))
        cpu = min(each for _, each in seconds[name]) / len(frames) * 1e3
        size = f"{sizes[name] / total:.2f}" if name in sizes else "1"
        error = largest_error(frames, ways[name][0]) if name in ways else 0.0
        print(f"| {name} | {ratio:.1f} | {cpu:.1f} | {size} | {error:.1e} |")


def runs(plan: Plan, folder: Path, rounds: int) -> None:
    """Print whole runs as multiples of raw writing."""
    count = plan.frame_times_s.size
    piece = np.random.default_rng(0).integers(0, 256, plan.uncompressed_bytes // count, dtype=np.uint8)
    path = folder / "cube.nc"
    run(plan, path)  # compiles tables and kernels
    found = []
    for _ in range(rounds):
        bare = clocked(raw(folder / "raw", [piece], count))
        (folder / "raw").unlink()
        path.unlink()
        found.append((bare, clocked(lambda: run(plan, path))))
        print(f"raw {bare[0]:.3f} s, run {found[-1][1][0]:.3f} s", flush=True)
    ratios = [whole / bare for (bare, _), (whole, _) in found]
    best = min(whole for _, (whole, _) in found) / min(bare for (bare, _), _ in found)
    cpu = min(each for _, (_, each) in found)
    print(
        f"\n{count} frames, {plan.uncompressed_bytes / 1e6:.0f} MB: a run takes {statistics.median(ratios):.1f} times "
        f"raw writing ({min(ratios):.1f} to {max(ratios):.1f}; best of each {best:.1f}) and {cpu / count * 1e3:.1f} ms "
        "of processor a frame, certificate not included"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", default="stratus")
    parser.add_argument("--band", action="append", help="band, instead of the scenario's; adds output.packing")
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--runs", action="store_true", help="whole runs instead of layouts")
    parser.add_argument("--folder", help="where to write; default: the system's temporary folder")
    given = parser.parse_args()
    changes = {"frames.count": given.frames, "output.certificate": 0} | ({"bands": given.band} if given.band else {})
    plan = make_plan(Scenario.load(given.scenario, changes))
    packing = make_plan(Scenario.load(given.scenario, changes | {"output.packing": "int16"})) if given.band else None
    with tempfile.TemporaryDirectory(dir=given.folder) as folder:
        if given.runs:
            for each in (plan, packing):
                if each is not None:
                    runs(each, Path(folder), given.rounds)
        else:
            layouts(plan, Path(folder), given.rounds, packing)


if __name__ == "__main__":
    main()
