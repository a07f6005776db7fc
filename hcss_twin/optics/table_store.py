"""Where tables of bulk properties come from: the catalog, the user's cache, or computation."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cache.folder import cache_root
from hcss_twin.cache.kinds import OPTICS
from hcss_twin.catalog import Catalog, SecludedCatalog
from hcss_twin.errors import CatalogError
from hcss_twin.optics import table_file
from hcss_twin.optics.bulk_table import BulkTable

Array = NDArray[np.float64]

FOLDER, SUFFIX = OPTICS

_WORTH_A_BAR = 64
"""Wavelengths to compute from which progress is shown: less is done at once."""


def cache_folder() -> Path | None:
    """Folder of computed tables in the user's cache; None without a home."""
    root = cache_root()
    return None if root is None else root / FOLDER


class TableStore:
    """Finds the values of tables, computes those that nobody has, and keeps them.

    Parameters
    ----------
    catalog : Catalog
        Holds the tables that ship; with a secluded one no others are kept.
    """

    def __init__(self, catalog: Catalog) -> None:
        self._catalog = catalog
        self._shipped: dict[str, str] | None = None
        self._looked_up: set[str] = set()

    def complete(self, table: BulkTable, position: Array) -> None:
        """Give ``table`` the values that ``position`` (V,), ln wavelength, needs."""
        if table.key not in self._looked_up:
            self._looked_up.add(table.key)
            self._look_up(table)
        if table.complete(position, _progress) and (path := self._cached(table)):
            table_file.write_if_possible(table, path)

    def _look_up(self, table: BulkTable) -> None:
        name = self._names().get(table.key)
        if name is not None:
            table_file.read_into(table, self._catalog.find(name, FOLDER, SUFFIX))
            return
        # A damaged file is computed again and replaced: nothing is lost but time.
        with suppress(CatalogError, OSError):
            if (path := self._cached(table)) and path.is_file():
                table_file.read_into(table, path)

    def _names(self) -> dict[str, str]:
        """Names of the shipped tables by their keys."""
        if self._shipped is None:
            self._shipped = {}
            for name in self._catalog.names(FOLDER, SUFFIX):
                path = self._catalog.root / FOLDER / f"{name}{SUFFIX}"
                with suppress(CatalogError):  # other formats lie there too
                    self._shipped[self._catalog.shelf.parsed(path, table_file.key_of)] = name
        return self._shipped

    def _cached(self, table: BulkTable) -> Path | None:
        folder = None if isinstance(self._catalog, SecludedCatalog) else cache_folder()
        return None if folder is None else folder / f"{table.key}{SUFFIX}"


def _progress(pieces: Iterable[NDArray[np.intp]], total: int) -> Iterator[NDArray[np.intp]]:
    """Show a bar on a terminal while many wavelengths are computed."""
    if total < _WORTH_A_BAR or not sys.stderr.isatty():
        yield from pieces
        return
    import click

    with click.progressbar(length=total, label="cloud optics", file=sys.stderr) as bar:
        for piece in pieces:
            yield piece
            bar.update(piece.size)
