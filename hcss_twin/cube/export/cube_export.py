"""Export of a cube to the format of another program: file names and writing."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from hcss_twin.core.arguments import checked
from hcss_twin.core.errors import CubeError, choose_from
from hcss_twin.core.files import atomic_write, require_not_read
from hcss_twin.core.reading import reads
from hcss_twin.cube.export.selection import Selection, select
from hcss_twin.cube.reader import open_cube

SUFFIXES = {
    "fits": (".fits", ".fit", ".fts"),
    "envi": (".img", ".dat", ".raw", ".bin"),
    "geotiff": (".tif", ".tiff"),
    "png": (".png",),
}
"""File suffixes by format; the first is the default."""


@dataclass(frozen=True)
class FileNames:
    """Files of an export.

    Attributes
    ----------
    images : tuple of tuple of Path
        Files by frame and plane; a file with all frames or planes is listed once.
    companions : tuple of Path
        Accompanying files that readers need.
    """

    images: tuple[tuple[Path, ...], ...]
    companions: tuple[Path, ...]

    @property
    def all(self) -> tuple[Path, ...]:
        """All files, image files first."""
        return (*(path for frame in self.images for path in frame), *self.companions)


def file_names(selection: Selection, to: str, cube: Path, output: Path | None) -> FileNames:
    """Return the files that an export writes.

    FITS and ENVI store everything in one file, GeoTIFF one frame per file, PNG one image per file.

    Parameters
    ----------
    to : str
        Format, a key of ``SUFFIXES``.
    cube : Path
        Determines the default name and folder.
    output : Path or None
        File name or folder.

    Raises
    ------
    CubeError
        If the suffix belongs to another format, or the folder does not exist.
    """
    name = f"{cube.name.removesuffix(cube.suffix)}_{selection.variable}"
    if output is None or output.is_dir():
        folder, stem, suffix = output or cube.parent, name, SUFFIXES[to][0]
    elif output.suffix.lower() in SUFFIXES[to]:
        folder, stem, suffix = output.parent, output.name.removesuffix(output.suffix), output.suffix
    else:
        raise CubeError(
            f"{output}: names of {to} end in {' or '.join(SUFFIXES[to])}; give such a name, or a folder that exists"
        )
    if not folder.is_dir():
        raise CubeError(f"cannot write {folder / stem}{suffix}: there is no folder {folder}")

    def numbered(*parts: str) -> Path:
        return folder / ("_".join([stem, *(part for part in parts if part)]) + suffix)

    described = folder / f"{stem}{suffix}.json"
    frames, planes = _frame_parts(selection), _plane_parts(selection)
    if to == "envi":
        return FileNames(((numbered(),),), (described, folder / f"{stem}.hdr"))
    if to == "geotiff":
        return FileNames(tuple((numbered(frame),) for frame in frames), ())
    if to == "png":
        images = tuple(tuple(numbered(plane, frame) for plane in planes) for frame in frames)
        return FileNames(images, (described,))
    return FileNames(((numbered(),),), ())


def _frame_parts(selection: Selection) -> list[str]:
    numbers = [frame.number or 0 for frame in selection.frames]
    digits = max(3, len(str(max(numbers))))
    return [f"{number:0{digits}d}" for number in numbers] if len(numbers) > 1 else [""]


def _plane_parts(selection: Selection) -> list[str]:
    if len(selection.planes) == 1:
        return [""]
    names = [re.sub(r"[^A-Za-z0-9.]+", "-", plane.name) for plane in selection.planes]
    # layer names may be equal, or differ only in characters not allowed in file names
    folded = [name.casefold() for name in names]
    return [name if folded.count(name.casefold()) == 1 else f"{name}-{index}" for index, name in enumerate(names)]


Limits = tuple[float, float]


@dataclass(frozen=True)
class Exported:
    """Result of an export.

    Attributes
    ----------
    files : tuple of Path
        All files, image files first.
    variable : str
    frames, planes, rows, columns : int
        Size of the export; planes are bands or layers.
    missing : int
        Number of missing values: NaN, or sample 0 in PNG.
    """

    files: tuple[Path, ...]
    variable: str
    frames: int
    planes: int
    rows: int
    columns: int
    missing: int


@checked
@reads(CubeError)
def export_cube(
    cube: str | os.PathLike[str],
    to: str,
    output: str | os.PathLike[str] | None = None,
    *,
    variable: str | None = None,
    bands: Sequence[str] = (),
    frames: Sequence[int] = (),
    limits: Limits | None = None,
    replace: bool = False,
) -> Exported:
    """Write one variable of a cube as FITS, ENVI, GeoTIFF or 16-bit PNG.

    FITS and ENVI use one file for all frames (ENVI with a separate header), GeoTIFF one file per frame, PNG one file
    per frame and band and one JSON. Files get their final names when the whole export is written.

    Parameters
    ----------
    cube : path-like
        A finished cube.
    to : {"fits", "envi", "geotiff", "png"}
    output : path-like, optional
        File name or folder; for several files, bands and numbers are added to the name. Default: ``CUBE_VARIABLE`` in
        the folder of the cube.
    variable : str, optional
        Default: radiance, or the only image variable.
    bands : sequence of str
        Default: all.
    frames : sequence of int
        Numbers from 0; default: all.
    limits : (float, float), optional
        For PNG: values of the samples 1 and 65535. Default: smallest and largest value of each band.
    replace : bool
        Replace existing files.

    Returns
    -------
    Exported

    Raises
    ------
    CubeError
        If the cube cannot be read or lacks what is requested, a file exists or cannot be written, a package is
        missing, or the format cannot store the values.
    """
    if to not in SUFFIXES:
        raise CubeError(f"format '{to}': {choose_from(to, SUFFIXES)}")
    if limits is not None:
        _check_limits(to, limits)
    cube = Path(cube)
    with open_cube(cube) as dataset:
        selection = select(dataset, variable, bands, frames)
        names = file_names(selection, to, cube, None if output is None else Path(output))
        existing = [path for path in names.all if path.exists()]
        if existing and not replace:
            more = f" (and {len(existing) - 1} more)" if len(existing) > 1 else ""
            raise CubeError(f"{existing[0]} exists{more}; give another name with -o, or --force")
        for path in names.all:
            require_not_read(path, [cube], CubeError)
        with ExitStack() as stack:
            # the file entered last is renamed first: image files first, companions last
            drafts = {path: stack.enter_context(atomic_write(path, CubeError)) for path in reversed(names.all)}
            missing = _write(selection, cube.name, to, names, drafts, limits)
        return Exported(
            names.all,
            selection.variable,
            len(selection.frames),
            len(selection.planes),
            selection.rows,
            selection.columns,
            missing,
        )


def _check_limits(to: str, limits: Limits) -> None:
    if to != "png":
        raise CubeError(f"limits: {to} stores unscaled values; allowed: with png only")
    if not (math.isfinite(limits[0]) and math.isfinite(limits[1]) and limits[0] < limits[1]):
        raise CubeError(f"limits: {limits[0]:g} to {limits[1]:g}; two finite, increasing values are needed")


def _write(
    selection: Selection, source: str, to: str, names: FileNames, drafts: Mapping[Path, Path], limits: Limits | None
) -> int:
    """Write the files of an export under temporary names and return the number of missing values."""
    if to == "fits":
        from hcss_twin.cube.export.fits import write_fits

        return write_fits(selection, source, drafts[names.images[0][0]])
    if to == "envi":
        from hcss_twin.cube.export.envi import write_envi

        described, header = names.companions
        return write_envi(selection, source, drafts[names.images[0][0]], drafts[header], drafts[described])
    if to == "geotiff":
        from hcss_twin.cube.export.geotiff import write_geotiff

        return sum(
            write_geotiff(selection, source, frame, drafts[path])
            for frame, (path,) in zip(selection.frames, names.images, strict=True)
        )
    from hcss_twin.cube.export.png import scalings, sidecar, write_png

    scaling = scalings(selection, limits)
    missing = sum(
        write_png(selection, source, frame, scaling, [drafts[path] for path in paths])
        for frame, paths in zip(selection.frames, names.images, strict=True)
    )
    listed = [[path.name for path in paths] for paths in names.images]
    text = sidecar(selection, source, scaling, listed)
    drafts[names.companions[0]].write_text(text, encoding="ascii")
    return missing
