"""Export of a cube to the format of another program."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from hcss_export.file_names import SUFFIXES, FileNames, file_names, unknown_format
from hcss_export.projection import Projection, projection_of
from hcss_twin import open_cube
from hcss_twin.core.arguments import checked
from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.cube.frame_selection import FrameSelection
from hcss_twin.providers import CubeError

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
        raise CubeError(unknown_format(to))
    if limits is not None:
        _check_limits(to, limits)
    cube = Path(cube)
    with Reading(cube, CubeError), open_cube(cube) as dataset:
        selection = FrameSelection.of(dataset, variable, bands, frames)
        projection = projection_of(dataset, selection.data)
        names = file_names(selection, to, cube, None if output is None else Path(output))
        existing = [path for path in names.all if path.exists()]
        if existing and not replace:
            more = f" (and {len(existing) - 1} more)" if len(existing) > 1 else ""
            raise CubeError(f"{existing[0]} exists{more}; give another name with -o, or --force")
        for path in names.all:
            Writing(path, CubeError, read=[cube]).check()
        with ExitStack() as stack:
            # the file entered last is renamed first: image files first, companions last
            drafts = {path: stack.enter_context(Writing(path, CubeError)) for path in reversed(names.all)}
            missing = _write(selection, projection, cube.name, to, names, drafts, limits)
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
    selection: FrameSelection,
    projection: Projection | None,
    source: str,
    to: str,
    names: FileNames,
    drafts: Mapping[Path, Path],
    limits: Limits | None,
) -> int:
    """Write the files of an export under temporary names and return the number of missing values."""
    if to == "fits":
        from hcss_export.fits import write_fits

        return write_fits(selection, projection, source, drafts[names.images[0][0]])
    if to == "envi":
        from hcss_export.envi import write_envi

        described, header = names.companions
        return write_envi(selection, projection, source, drafts[names.images[0][0]], drafts[header], drafts[described])
    if to == "geotiff":
        from hcss_export.geotiff import write_geotiff

        return sum(
            write_geotiff(selection, projection, source, frame, drafts[path])
            for frame, (path,) in zip(selection.frames, names.images, strict=True)
        )
    from hcss_export.png import scalings, sidecar, write_png

    scaling = scalings(selection, limits)
    missing = sum(
        write_png(selection, projection, source, frame, scaling, [drafts[path] for path in paths])
        for frame, paths in zip(selection.frames, names.images, strict=True)
    )
    listed = [[path.name for path in paths] for paths in names.images]
    text = sidecar(selection, projection, source, scaling, listed)
    drafts[names.companions[0]].write_text(text, encoding="ascii")
    return missing
