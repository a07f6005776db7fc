"""Opening of our own versioned NetCDF formats."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hcss_twin.errors import CatalogError


@contextmanager
def open_format(path: Path, name: str, version: int) -> Iterator[Any]:
    """Open a NetCDF file whose attributes ``format`` and ``format_version`` are the expected ones.

    Raises
    ------
    CatalogError
        If it is not NetCDF or of another format.
    """
    import netCDF4

    try:
        dataset = netCDF4.Dataset(path)
    except OSError as error:
        raise CatalogError(f"{path}: not a readable NetCDF file: {error}") from error
    with dataset:
        found = (getattr(dataset, "format", None), int(getattr(dataset, "format_version", 0)))
        if found != (name, version):
            raise CatalogError(
                f"{path}: format {found[0]!r} version {found[1]}; allowed: {name!r} version {version}"
            )
        yield dataset
