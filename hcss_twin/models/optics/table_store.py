"""Files of bulk-property tables: built-in ones in the catalog, computed ones in the user's cache."""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cache import OPTICS, cache_root, cached_file, in_use
from hcss_twin.core.catalog import Catalog, SecludedCatalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.files import Writing, open_format
from hcss_twin.core.netcdf import NetcdfFile
from hcss_twin.core.trust import make_private, withhold
from hcss_twin.models.optics.bulk import BulkTable

FORMAT, VERSION = "hcss-bulk-optics", 1

_GROUPS = (("properties", "f8"), ("moments", "f4"))
"""Parts of a table and their precision in files; single precision has an error of 6e-8 for a moment."""


def key_of(path: Path) -> str:
    """Return the key of the table in a file.

    Raises
    ------
    CatalogError
        If the file is not in this format.
    """
    with open_format(path, FORMAT, VERSION) as dataset:
        return str(getattr(dataset, "key", ""))


def read_into(table: BulkTable, path: Path) -> None:
    """Fill missing values of ``table`` from a file.

    Raises
    ------
    CatalogError
        If the file is damaged (every block has a checksum), contains another table, or has another format.
    """
    stored = {}
    with open_format(path, FORMAT, VERSION) as dataset:
        if getattr(dataset, "key", None) != table.key:
            raise CatalogError(f"{path}: holds another table than {table.key[:12]}")
        for name, _ in _GROUPS:
            dataset[name].set_auto_mask(False)
            stored[name] = np.asarray(dataset[name][:], dtype=np.float64)
    for name, values in stored.items():
        part = getattr(table, name)
        if values.shape != part.values.shape:
            raise CatalogError(f"{path}: {name} has shape {values.shape}; allowed {part.values.shape}")
        part.adopt(values)


def write(table: BulkTable, path: Path, **attributes: str) -> None:
    """Write a table atomically: the complete file replaces an older one in one step.

    Raises
    ------
    CatalogError
        If the file cannot be written.
    """
    with Writing(path, CatalogError) as draft, NetcdfFile(draft, "w") as dataset:
        dataset.format, dataset.format_version, dataset.key = FORMAT, VERSION, table.key
        dataset.setncatts(attributes)
        for name, kind in _GROUPS:
            _write_part(dataset, name, kind, getattr(table, name))


def _write_part(dataset: Any, name: str, kind: str, part: Any) -> None:
    components, nodes = part.values.shape
    dataset.createDimension(f"{name}_component", components)
    dataset.createDimension(f"{name}_node", nodes)
    # No least_significant_digit: files would be smaller still, but differ from values computed on demand.
    variable = dataset.createVariable(
        name, kind, (f"{name}_component", f"{name}_node"), zlib=True, complevel=6, shuffle=True, fletcher32=True
    )
    variable.long_name = {
        "properties": "ln of extinction and absorption cross section per particle (m2), asymmetry parameter",
        "moments": "Legendre moments of the phase function",
    }[name]
    variable[:] = part.values
    position = dataset.createVariable(f"{name}_wavelength", "f8", (f"{name}_node",), zlib=True, fletcher32=True)
    position.units = "um"
    position[:] = np.exp(part.nodes)


def write_if_possible(table: BulkTable, path: Path) -> bool:
    """Store a table, merged with values that another run has stored meanwhile; return whether it was written.

    If it cannot be written (full or read-only disk), the next run computes it again.
    """
    with suppress(CatalogError, OSError):
        make_private(path.parent)
        with suppress(CatalogError):
            read_into(table, path)
        write(table, path)
        withhold(path)
        return True
    return False


FOLDER, SUFFIX = OPTICS

_MIN_FOR_PROGRESS = 64
"""Number of wavelengths to compute above which a progress bar is shown."""


def cache_folder() -> Path | None:
    """Return the folder of computed tables in the user's cache; None without a home folder."""
    root = cache_root()
    return None if root is None else root / FOLDER


class TableStore:
    """Reads table values from files, computes missing ones, and stores them.

    Parameters
    ----------
    catalog : Catalog
        Contains the built-in tables; with a secluded catalog, computed tables are not stored.
    """

    def __init__(self, catalog: Catalog) -> None:
        self._catalog = catalog
        self._shipped: dict[str, str] | None = None
        self._looked_up: set[str] = set()

    def complete(self, table: BulkTable, position: Array) -> None:
        """Fill ``table`` with the values needed at ``position`` (V,), ln wavelength."""
        if table.key not in self._looked_up:
            self._looked_up.add(table.key)
            self._look_up(table)
        if table.complete(position, _progress) and (path := self._cached(table)):
            write_if_possible(table, path)

    def _look_up(self, table: BulkTable) -> None:
        name = self._names().get(table.key)
        if name is not None:
            read_into(table, self._catalog.find(name, FOLDER, SUFFIX))
            return
        # A damaged file is recomputed and replaced; only time is lost.
        with suppress(CatalogError, OSError):
            if (path := self._cached(table)) and cached_file(path.parent, path.name):
                read_into(table, path)

    def _names(self) -> dict[str, str]:
        """Return the names of built-in tables by key."""
        if self._shipped is None:
            self._shipped = {}
            for name in self._catalog.names(FOLDER, SUFFIX):
                path = self._catalog.root / FOLDER / f"{name}{SUFFIX}"
                with suppress(CatalogError):  # the folder also contains files in other formats
                    self._shipped[self._catalog.shelf.parsed(path, key_of)] = name
        return self._shipped

    def _cached(self, table: BulkTable) -> Path | None:
        folder = None if isinstance(self._catalog, SecludedCatalog) else in_use(cache_folder())
        return None if folder is None else folder / f"{table.key}{SUFFIX}"


_LONG_S = 10.0
"""Predicted duration above which a computation is announced; large particles take minutes."""


def _progress(pieces: Iterable[NDArray[np.intp]], total: int) -> Iterator[NDArray[np.intp]]:
    """Show a progress bar for many wavelengths on a terminal; otherwise announce a computation that takes long."""
    if total < _MIN_FOR_PROGRESS or not sys.stderr.isatty():
        start, done = time.monotonic(), 0
        for piece in pieces:
            yield piece
            left = (time.monotonic() - start) / piece.size * (total - piece.size)
            if not done and left > _LONG_S:
                message = "cloud optics: %d wavelengths take about %.0f s more; they are kept for later runs"
                logging.getLogger(__name__).warning(message, total - piece.size, left)
            done += piece.size
        return
    import click

    with click.progressbar(length=total, label="cloud optics", file=sys.stderr) as bar:
        for piece in pieces:
            yield piece
            bar.update(piece.size)
