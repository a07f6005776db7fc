"""Formats, and the names of the files of an export."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hcss_twin.providers import CubeError, choose_from

if TYPE_CHECKING:
    from hcss_twin.cube.frame_selection import FrameSelection

SUFFIXES = {
    "fits": (".fits", ".fit", ".fts"),
    "envi": (".img", ".dat", ".raw", ".bin"),
    "geotiff": (".tif", ".tiff"),
    "png": (".png",),
}
"""File suffixes by format; the first is the default."""


def unknown_format(to: str) -> str:
    """Return what is wrong with the name of a format: which are allowed, and the closest, also by suffix."""
    of_suffix = [known for known, suffixes in SUFFIXES.items() if f".{to.lower().lstrip('.')}" in suffixes]
    hint = f"; closest is '{of_suffix[0]}'" if of_suffix else ""
    allowed = choose_from("" if of_suffix else to, SUFFIXES)
    return f"format '{to}': {allowed}{hint}"


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


def file_names(selection: FrameSelection, to: str, cube: Path, output: Path | None) -> FileNames:
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


def _frame_parts(selection: FrameSelection) -> list[str]:
    numbers = [frame.number or 0 for frame in selection.frames]
    digits = max(3, len(str(max(numbers))))
    return [f"{number:0{digits}d}" for number in numbers] if len(numbers) > 1 else [""]


def _plane_parts(selection: FrameSelection) -> list[str]:
    if len(selection.planes) == 1:
        return [""]
    names = [re.sub(r"[^A-Za-z0-9.]+", "-", plane.name) for plane in selection.planes]
    # layer names may be equal, or differ only in characters not allowed in file names
    folded = [name.casefold() for name in names]
    return [name if folded.count(name.casefold()) == 1 else f"{name}-{index}" for index, name in enumerate(names)]
