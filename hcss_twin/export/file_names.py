"""Names of the files of an export."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from hcss_twin.errors import CubeError
from hcss_twin.export.selection import Selection

SUFFIXES = {
    "fits": (".fits", ".fit", ".fts"),
    "envi": (".img", ".dat", ".raw", ".bin"),
    "geotiff": (".tif", ".tiff"),
    "png": (".png",),
}
"""Endings of file names by format; the first is the default."""


@dataclass(frozen=True)
class FileNames:
    """Where the images of an export go.

    Attributes
    ----------
    images : tuple of tuple of Path
        Files by frame and, in it, by plane; one file for all frames or all planes stands only once.
    companions : tuple of Path
        Files beside them, without which they cannot be read.
    """

    images: tuple[tuple[Path, ...], ...]
    companions: tuple[Path, ...]

    @property
    def all(self) -> tuple[Path, ...]:
        """Every file, those with values first."""
        return (*(path for frame in self.images for path in frame), *self.companions)


def file_names(selection: Selection, to: str, cube: Path, output: Path | None) -> FileNames:
    """Return the files that an export writes.

    FITS and ENVI hold everything in one file, GeoTIFF a frame, PNG one image of it.

    Parameters
    ----------
    to : str
        Format, a key of ``SUFFIXES``.
    cube : Path
        Gives the default name, and its folder is the default folder.
    output : Path or None
        A name or a folder.

    Raises
    ------
    CubeError
        If the name ends in what belongs to another format, or its folder does not exist.
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
    # names that differ only in what a file may not hold, or not at all, as those of layers may
    folded = [name.casefold() for name in names]
    return [
        name if folded.count(name.casefold()) == 1 else f"{name}-{index}" for index, name in enumerate(names)
    ]
