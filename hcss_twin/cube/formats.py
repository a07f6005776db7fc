"""Which format a cube has: NetCDF, or a Zarr store where its name ends in ``.zarr``."""

from __future__ import annotations

import os
from pathlib import Path

from hcss_twin.cube.streamed_writer import StreamedWriter
from hcss_twin.cube.writer import CubeWriter

ZARR_SUFFIX = ".zarr"


def is_zarr(path: str | os.PathLike[str]) -> bool:
    """Whether a path names a Zarr store."""
    return Path(path).suffix.lower() == ZARR_SUFFIX


def cube_writer(path: str | os.PathLike[str]) -> type[StreamedWriter]:
    """Return the class that writes cubes of this name.

    Raises
    ------
    CubeError
        If the package ``zarr`` is needed and not installed.
    """
    if not is_zarr(path):
        return CubeWriter
    # imported here because it needs a package that is optional
    from hcss_twin.cube.zarr_writer import ZarrWriter, require_zarr

    require_zarr(path)
    return ZarrWriter


def cube_bytes(path: Path) -> int:
    """Size of a cube on the disk: of a file, or of all files of a store."""
    if path.is_file():
        return path.stat().st_size
    return sum(each.stat().st_size for each in path.rglob("*") if each.is_file())
