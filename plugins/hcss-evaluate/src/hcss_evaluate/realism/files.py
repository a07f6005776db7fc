"""Brightness temperatures of files for the realism test, scene by scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from hcss_evaluate.comparison.footage import EvaluationChoice, is_kelvin
from hcss_evaluate.comparison.image_footage import is_cube, open_footage
from hcss_evaluate.realism.patches import SIZE
from hcss_evaluate.realism.score import Realism, compare
from hcss_twin import CatalogError, ImageError
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array, NetcdfFile

SCENE_SIZE = 4 * SIZE
"""Side of the scenes, pixels, into which larger images are cut."""

_SAME_SIZE = 0.05


@dataclass
class _Side:
    """Images of one side with their scenes and times (s), and the pixel sizes (m) of its files, None if unknown."""

    kelvin: list[Array] = field(default_factory=list)
    scene: list[int] = field(default_factory=list)
    time_s: list[float] | None = field(default_factory=list)
    sizes_m: list[float | None] = field(default_factory=list)


def compare_files(
    real: Sequence[Path],
    simulated: Sequence[Path],
    real_choice: EvaluationChoice,
    simulated_choice: EvaluationChoice,
    *,
    paired: bool,
    blur_pixels: float,
    seed: int,
) -> Realism:
    """Run the realism test on files or folders of files.

    Each file is a scene: an image, a cube with its frames, or a NetCDF variable with several images, each of which is a
    scene unless the dimension is ``time``. Images of 512 pixels or more a side are cut into scenes of 256 or more.

    Parameters
    ----------
    real, simulated : sequence of Path
    real_choice, simulated_choice : EvaluationChoice
        Variable, band, frames and pixel size of each side.
    paired : bool
        Whether the n-th simulated scene was made from the n-th real one.
    blur_pixels, seed
        See :func:`hcss_evaluate.realism.compare`.

    Raises
    ------
    CatalogError, CubeError
        If a file cannot be read.
    ImageError
        If values are not brightness temperatures, pixel sizes differ by more than 5 %, or paired sides have different
        numbers of scenes; and whatever ``compare`` raises.
    """
    first, second = _read("REAL", real, real_choice), _read("SIM", simulated, simulated_choice)
    stated = [*first.sizes_m, *second.sizes_m]
    sizes = [size for size in stated if size is not None]
    if sizes and max(sizes) > min(sizes) * (1.0 + _SAME_SIZE):
        raise ImageError(
            f"pixel sizes: from {min(sizes):.6g} to {max(sizes):.6g} m, allowed: the same on both sides within 5 %; "
            "--real-pixel-size and --sim-pixel-size override those of the files"
        )
    counts = [side.scene[-1] + 1 for side in (first, second)]
    if paired and counts[0] != counts[1]:
        raise ImageError(f"--paired: {counts[0]} real and {counts[1]} simulated scenes, allowed: as many of both")
    found = compare(
        first.kelvin,
        second.kelvin,
        first.scene,
        second.scene if paired else [counts[0] + number for number in second.scene],
        real_time_s=first.time_s,
        simulated_time_s=second.time_s,
        blur_pixels=blur_pixels,
        seed=seed,
    )
    if len(sizes) == len(stated):
        return found
    note = f"{len(stated) - len(sizes)} of {len(stated)} files state no pixel size: it must be the same on both sides."
    return replace(found, notes=(note,))


def _read(title: str, paths: Sequence[Path], choice: EvaluationChoice) -> _Side:
    side, count = _Side(), 0
    for path in (file for given in paths for file in _files(title, given)):
        for frames, times in _scenes(title, path, choice, side.sizes_m):
            for part in zip(*map(_parts, frames), strict=True):
                side.kelvin += part
                side.scene += [count] * len(part)
                side.time_s = None if times is None or side.time_s is None else [*side.time_s, *times]
                count += 1
    return side


def _parts(frame: Array) -> list[Array]:
    """Return an image in parts of 256 x 256 pixels or a little more; a smaller one whole."""
    rows, columns = (max(1, length // SCENE_SIZE) for length in frame.shape)
    return [part for band in np.array_split(frame, rows) for part in np.array_split(band, columns, axis=1)]


def _files(title: str, path: Path) -> list[Path]:
    """Return the file, or the files of a folder in the order of their names."""
    if not path.is_dir() or is_cube(path):
        return [path]
    files = sorted(
        file for file in path.iterdir() if not file.name.startswith(".") and (file.is_file() or is_cube(file))
    )
    if not files:
        raise CatalogError(f"{title}: no file in the folder {path}; allowed: images or cubes")
    return files


def _scenes(
    title: str, path: Path, choice: EvaluationChoice, sizes_m: list[float | None]
) -> Iterator[tuple[list[Array], Sequence[float] | None]]:
    """Yield frames (K) and their times for each scene of a file; add the pixel size to a list."""
    stack = None if is_cube(path) else _stack(path, choice.variable)
    if stack is not None:
        sizes_m.append(choice.pixel_size_m)
        values, times = stack
        yield from ((list(frames), times) for frames in values)
        return
    with ExitStack() as opened:
        footage = open_footage(title, path, choice, opened, None)
        if footage.kelvin is None and footage.units:
            raise ImageError(
                f"{path}: unit {footage.units}, allowed: brightness temperature in K, or a cube's radiance"
            )
        sizes_m.append(footage.pixel_size_m)
        frames = [footage.values(number) for number in range(footage.count)]
        yield [frame if footage.kelvin is None else footage.kelvin(frame) for frame in frames], footage.seconds


def _stack(path: Path, variable: str | None) -> tuple[Array, Sequence[float] | None] | None:
    """Return a NetCDF variable of several images as (scenes, times, rows, columns) with its times; None for others."""
    if variable is None:
        return None
    if not Reading(path, CatalogError).is_netcdf:
        return None
    with Reading(path, CatalogError) as reading, NetcdfFile.open_with_xarray(path) as dataset:
        if variable not in dataset or dataset[variable].squeeze().ndim < 3:
            return None
        item = dataset[variable]
        reading.require_size(item.shape)
        if not is_kelvin(str(item.attrs.get("units", ""))):
            raise ImageError(f"{path}: {variable} has the unit '{item.attrs.get('units', '')}', allowed: K")
        timed = "time" in item.dims[:-2]
        item = item if timed else item.expand_dims("time")
        others = [name for name in item.dims[:-2] if name != "time"]
        ordered = item.transpose(*others, "time", *item.dims[-2:])
        values = ordered.values.astype(np.float64).reshape(-1, *ordered.shape[-3:])
        if not timed or "time" not in item.coords:
            return values, None if timed else [0.0]
        times = item["time"].values
        seconds = (times - times[0]) / np.timedelta64(1, "s") if times.dtype.kind == "M" else times - times[0]
        return values, [float(second) for second in seconds]
