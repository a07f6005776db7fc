"""What kind of file a path names."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from hcss_twin.clouds.imagery.netcdf_image import quiet
from hcss_twin.comparison.choice import EvaluationChoice
from hcss_twin.comparison.footage import Footage
from hcss_twin.cube.formats import is_zarr
from hcss_twin.cube.header import FORMAT_ATTRIBUTE
from hcss_twin.errors import CatalogError, ImageError


def open_footage(
    title: str,
    source: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    choice: EvaluationChoice,
    stack: ExitStack,
    like: Footage | None,
) -> Footage:
    """Open an image, several images or a cube.

    Parameters
    ----------
    title : str
        REAL or SIM, for messages.
    source : path or sequence of paths
    choice : EvaluationChoice
    stack : ExitStack
        Closes a cube.
    like : Footage, optional
        What it will be compared with.

    Raises
    ------
    CatalogError
        If there is no such file, or it is not a usable image.
    CubeError
        If a cube cannot be read or lacks what is asked for.
    ImageError
        If a choice does not fit the file.
    """
    choice.check()
    paths = [Path(source)] if isinstance(source, str | os.PathLike) else [Path(each) for each in source]
    if not paths:
        raise ImageError(f"{title}: no file given, allowed: one or more")
    cubes = [path for path in paths if is_cube(path)]
    if cubes and len(paths) > 1:
        raise ImageError(f"{title}: {cubes[0]} is a cube; allowed: one cube, or several images")
    if not cubes:
        from hcss_twin.comparison.image_footage import open_images

        for path in paths:
            if path.is_dir():
                raise CatalogError(f"{title}: {path} is a folder; allowed: an image, or a cube")
        return open_images(paths, choice)
    from hcss_twin.comparison.cube_footage import cube_footage
    from hcss_twin.cube.reader import open_cube

    return cube_footage(title, stack.enter_context(open_cube(paths[0])), paths[0], choice, like)


def is_cube(path: Path) -> bool:
    """Whether a file is one of our cubes, finished or not."""
    if is_zarr(path) and path.is_dir():
        return True
    try:
        with path.open("rb") as file:
            if not file.read(4).startswith((b"\x89HDF", b"CDF")):
                return False
    except OSError:
        return False
    import netCDF4

    try:
        with quiet(), netCDF4.Dataset(path) as dataset:
            return FORMAT_ATTRIBUTE in dataset.ncattrs()
    except (OSError, RuntimeError):
        return False
