"""Laws of clouds of cubes and simulations, frames of a file together, beside what is published.

    python make/laws.py FILE.nc ... [--above 0.3] [--from-s 7200] [--average 2]

Statistics of ``hcss evaluate --realism``, here of the optical thickness, a column for each file. Then the correlation
of frames about 150 s apart, moved onto each other, of the whole field and by wavelength.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path

import numpy as np
import xarray as xr
from hcss_evaluate.realism.coherence import WAVELENGTHS, coherence
from hcss_evaluate.realism.laws import PUBLISHED, cloud_laws

NAMES = ("optical_thickness", "cloud_optical_thickness")
APART_S = 150.0


def thickness(path: Path, from_s: float, average: int) -> tuple[list[np.ndarray], np.ndarray]:
    """Return optical thickness (rows, columns) of each frame, and times in s; of the first band of cubes."""
    with xr.open_dataset(path, decode_times=False) as file:
        name = next((name for name in NAMES if name in file), None)
        if name is None:
            raise SystemExit(f"{path}: none of {', '.join(NAMES)}; write a cube with output.variables that has it")
        item = file[name]
        item = item.isel({dim: 0 for dim in item.dims[:-2] if dim not in ("time", "frame")})
        times = np.asarray(file["time"].values, dtype=np.float64) if "time" in file else np.arange(item.shape[0])
        frames = np.nan_to_num(item.values.astype(np.float64))
    kept = times - times[0] >= from_s
    rows, columns = (length // average for length in frames.shape[1:])
    frames = frames[kept, : rows * average, : columns * average]
    return list(frames.reshape(-1, rows, average, columns, average).mean(axis=(2, 4))), times[kept]


def main() -> None:
    """Measure files and print a table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--above", type=float, default=0.3, help="Optical thickness of cloud.")
    parser.add_argument("--from-s", type=float, default=0.0, help="Frames from this time on.")
    parser.add_argument("--average", type=int, default=1, help="Pixels a side to average.")
    given = parser.parse_args()
    read = [thickness(path, given.from_s, given.average) for path in given.files]
    found = [cloud_laws([frame > given.above for frame in frames], frames) for frames, _ in read]
    print(f"{'':32}" + "".join(f"{path.stem[:13]:>14}" for path in given.files) + "   published")
    for name in found[0]:
        row = "".join("             -" if laws[name] is None else f"{laws[name]:14.3f}" for laws in found)
        print(f"{name:32}{row}   " + (f"{known.low:g} to {known.high:g}" if (known := PUBLISHED.get(name)) else ""))
    for path, (frames, times) in zip(given.files, read, strict=True):
        step = round(APART_S / np.median(np.diff(times))) if len(times) > 1 else 0
        if step:
            pairs = [
                ([one, two], [0.0, APART_S]) for one, two in zip(frames[:-step:step], frames[step::step], strict=True)
            ]
            values = coherence(pairs)[APART_S]
            bands = ", ".join(
                f"{low:g}-{high:g} px {value:.2f}"
                for (low, high), value in zip(pairwise(WAVELENGTHS), values[1:], strict=True)
            )
            print(f"{path.stem}: correlation after {times[step] - times[0]:g} s {values[0]:.2f}, waves of {bands}")


if __name__ == "__main__":
    main()
