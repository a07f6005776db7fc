"""Writing of a cube in the format of another program."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from hcss_twin.cube.reader import open_cube
from hcss_twin.drafts import draft_of
from hcss_twin.errors import CubeError, choose_from
from hcss_twin.export.file_names import SUFFIXES, FileNames, file_names
from hcss_twin.export.selection import Selection, select

Limits = tuple[float, float]


@dataclass(frozen=True)
class Exported:
    """What came of an export.

    Attributes
    ----------
    files : tuple of Path
        All files, those with values first.
    variable : str
    frames, planes, rows, columns : int
        Size of what was written; planes are bands or layers.
    missing : int
        Values that do not exist: NaN, in PNG sample 0.
    """

    files: tuple[Path, ...]
    variable: str
    frames: int
    planes: int
    rows: int
    columns: int
    missing: int


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

    FITS and ENVI have all frames in one file (ENVI with a header beside it), GeoTIFF a file per frame, PNG a file per
    frame and band and one JSON. Files get their names when all of the export is written.

    Parameters
    ----------
    cube : path-like
        A finished cube.
    to : {"fits", "envi", "geotiff", "png"}
    output : path-like, optional
        Name of the file, or a folder; where there are several files, bands and numbers are added to the name.
        Default: ``CUBE_VARIABLE`` beside the cube.
    variable : str, optional
        Default: radiance, or the only image there is.
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
        If the cube cannot be read or lacks what is asked for, a file exists or cannot be written, a package is
        missing, or the format has no place for the values.
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
        with ExitStack() as stack:
            # the last to be entered gets its name first: companions, which say how to read the others, come last
            drafts = {path: stack.enter_context(draft_of(path, CubeError)) for path in reversed(names.all)}
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
        raise CubeError(f"limits: {to} holds the values themselves; allowed: for png")
    if not (math.isfinite(limits[0]) and math.isfinite(limits[1]) and limits[0] < limits[1]):
        raise CubeError(f"limits: {limits[0]:g} to {limits[1]:g}; two finite values that grow are needed")


def _write(
    selection: Selection,
    source: str,
    to: str,
    names: FileNames,
    drafts: Mapping[Path, Path],
    limits: Limits | None,
) -> int:
    """Write the drafts of an export and return how many values are missing."""
    if to == "fits":
        from hcss_twin.export.fits import write_fits

        return write_fits(selection, source, drafts[names.images[0][0]])
    if to == "envi":
        from hcss_twin.export.envi import write_envi

        described, header = names.companions
        return write_envi(selection, source, drafts[names.images[0][0]], drafts[header], drafts[described])
    if to == "geotiff":
        from hcss_twin.export.geotiff import write_geotiff

        return sum(
            write_geotiff(selection, source, frame, drafts[path])
            for frame, (path,) in zip(selection.frames, names.images, strict=True)
        )
    from hcss_twin.export.png import scalings, sidecar, write_png

    scaling = scalings(selection, limits)
    missing = sum(
        write_png(selection, source, frame, scaling, [drafts[path] for path in paths])
        for frame, paths in zip(selection.frames, names.images, strict=True)
    )
    listed = [[path.name for path in paths] for paths in names.images]
    text = sidecar(selection, source, scaling, listed)
    drafts[names.companions[0]].write_text(text, encoding="ascii")
    return missing
