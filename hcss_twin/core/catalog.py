"""Named data that a scenario can refer to, and a record of every file that was read.

The data are in ``catalogs/``: inside the package in an installed wheel, next to the package folder in a
source checkout. A :class:`Catalog` belongs to one run and records the hash of each file it opens, for the
provenance of a cube.
"""

from __future__ import annotations

import copy
import io
import math
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CatalogError, choose_from
from hcss_twin.core.reading import Reading, require_no_stream
from hcss_twin.core.result_cache import ResultCache

_T = TypeVar("_T")


def catalog_root() -> Path:
    """Return the folder of the shipped catalog files.

    Raises
    ------
    CatalogError
        If the folder is not installed.
    """
    package = Path(__file__).parents[1]
    for candidate in (package / "catalogs", package.parent / "catalogs"):
        if (candidate / "bands.toml").is_file():
            return candidate
    raise CatalogError(f"the catalog files are missing next to {package}; reinstall hcss-twin")


class Catalog:
    """Reader of catalog files and user files that records each file it reads.

    Parameters
    ----------
    root : Path, optional
        Folder of the named files; the shipped ``catalogs/`` by default.
    base : Path, optional
        Folder against which a user's relative paths are resolved (the folder of the scenario file).

    Attributes
    ----------
    shelf : ResultCache
        Parsed files; the catalogs of several scenes in one process can share it. Not part of the provider
        API.
    """

    def __init__(self, root: Path | None = None, base: Path | None = None) -> None:
        self.shelf = ResultCache()
        self.root = root or catalog_root()
        try:
            self.base = base or Path.cwd()
        except FileNotFoundError as error:
            raise CatalogError("the current folder no longer exists; change to another one") from error
        self._used: dict[str, str] = {}

    @property
    def used(self) -> Mapping[str, str]:
        """SHA-256 of each file opened so far, by catalog name or path."""
        return dict(sorted(self._used.items()))

    def branch(self) -> Catalog:
        """Return a catalog that has read the same files, and whose further ones this one does not record."""
        other = copy.copy(self)
        other._used = dict(self._used)
        return other

    def names(self, folder: str, suffix: str) -> list[str]:
        """List the names in a catalog folder, without suffix."""
        return sorted(path.name.removesuffix(suffix) for path in (self.root / folder).glob(f"*{suffix}"))

    def find(self, name: str, folder: str, suffix: str, *, beside: bool = False) -> Path:
        """Resolve a catalog name, or the path of a user's file that ends in ``suffix``.

        Parameters
        ----------
        name : str
            Catalog name or path.
        folder, suffix : str
            Catalog folder and suffix of the named files.
        beside : bool
            Whether to also search a folder of the same name next to the scenario; a shipped file takes precedence.

        Raises
        ------
        CatalogError
            If neither exists; the message lists the known names and the closest one.
        """
        roots = [self.root, self.base] if beside else [self.root]
        for root in roots:
            named = root / folder / f"{name}{suffix}"
            if "/" not in name:
                if root is not self.root:
                    named = self._own(named.relative_to(root))
                if _is_file(named):
                    return self._record(named)
                require_no_stream(named, CatalogError)
        resolved = self._own(name)
        if resolved.suffix and _is_file(resolved):
            return self._record(resolved)
        require_no_stream(resolved, CatalogError)
        known = set(self.names(folder, suffix))
        where = f"in catalogs/{folder}"
        if beside:
            known |= {path.name.removesuffix(suffix) for path in (self.base / folder).glob(f"[!.]*{suffix}")}
            where += f", in {self.base / folder}"
        raise CatalogError(f"'{name}' is neither {where} nor a file; {choose_from(name, known)}")

    def file(self, path: str | Path) -> Path:
        """Resolve a path given by the user and record the file.

        Raises
        ------
        CatalogError
            If there is no such file.
        """
        resolved = self._own(path)
        if not _is_file(resolved):
            require_no_stream(resolved, CatalogError)
            raise CatalogError(f"no file '{path}' (looked at {resolved})")
        return self._record(resolved)

    def shipped(self, path: Path) -> Path:
        """Record a file that a plugin ships, which a scenario from someone else's cube may use, too."""
        return self._record(path, shipped=True)

    def unchanged(self, used: Mapping[str, str]) -> bool:
        """Whether files that were read before, by their names in :attr:`used`, are unchanged.

        If all are, they are recorded as read; otherwise none is.
        """
        now = Catalog(self.root, self.base)
        now.shelf = self.shelf
        for name, digest in used.items():
            path = self.root / name if not Path(name).is_absolute() else Path(name)
            if not _is_file(path):
                return False
            now._record(path)
            if now._used.get(name) != digest:
                return False
        self._used.update(now._used)
        return True

    def parsed(self, path: Path, read: Callable[[Path], _T]) -> _T:
        """Return what a module-level function makes of a file that was found here, kept while the file is unchanged.

        Objects of one scene share it, so that it must not be modified.
        """
        return self.shelf.parsed(path, read)

    def toml(self, path: Path) -> dict[str, Any]:
        """Parse a TOML file that :meth:`find` or :meth:`file` returned."""
        return copy.deepcopy(self.shelf.parsed(path, read_toml))

    def columns(self, path: Path) -> dict[str, NDArray[np.float64]]:
        """Read a CSV of numbers with ``#`` comments and one row of column names.

        Returns
        -------
        dict
            Column name to array of shape (rows,).

        Raises
        ------
        CatalogError
            If a row is not numeric or has another number of fields than the header.
        """
        return {name: column.copy() for name, column in self.shelf.parsed(path, read_columns).items()}

    def _own(self, path: str | Path) -> Path:
        """Resolve a user's path against the scenario's folder, or among the files that its cube stores."""
        try:
            given = Path(path).expanduser()
        except RuntimeError as error:  # ~ of an unknown user
            raise CatalogError(f"'{path}': {error}") from error
        resolved, stored = self.base / given, self.shelf.stored
        if stored is None or (_is_file(resolved) and self.shelf.may_read(resolved)):
            return resolved
        return stored.find(given) or stored.find(resolved) or resolved

    def _record(self, path: Path, shipped: bool = False) -> Path:
        inside = path.is_relative_to(self.root) and ".." not in path.relative_to(self.root).parts
        if not inside and not shipped and not self.shelf.may_read(path):
            raise CatalogError(f"{path}: not read, because it is not under the cube's folder; name it with --data")
        key = path.relative_to(self.root).as_posix() if inside else str(path.resolve())
        if self.shelf.stored is not None:
            key = self.shelf.stored.name_of(path) or key
        if not inside and (path.is_relative_to(self.base) or not _is_in_package(path)):
            self.shelf.user_files[key] = path
        if key not in self._used:
            self._used[key] = self.shelf.sha256(path)
        return path


class SecludedCatalog(Catalog):
    """Catalog of a run that uses no cached results of other runs and stores none."""


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # not a possible file name, so there is no such file
        return False


def _is_in_package(path: Path) -> bool:
    """Whether a plugin ships a file; known also of files that a kept result was computed from."""
    return any((folder / "__init__.py").is_file() for folder in path.parents)


def read_toml(path: Path) -> dict[str, Any]:
    """Parse a TOML file; raises :class:`CatalogError`."""
    with Reading(path, CatalogError, "not valid TOML"):
        return tomllib.loads(path.read_text(encoding="utf-8"))


def read_columns(path: Path) -> dict[str, NDArray[np.float64]]:
    """Read a CSV of numbers with ``#`` comments and one row of column names.

    Raises
    ------
    CatalogError
        If a row is not numeric, not finite, or has another number of fields than the header.
    """
    with Reading(path, CatalogError, "not a text file"):
        text = path.read_text(encoding="utf-8-sig")  # spreadsheets write a byte-order mark
    header: list[str] | None = None
    rows: list[list[float]] = []
    for number, line in enumerate(io.StringIO(text), start=1):
        stripped = line.strip()
        if not stripped or stripped.startswith("#"):
            continue
        fields = [field.strip() for field in stripped.split(",")]
        if header is None:
            header = fields
            continue
        try:
            values = [float(field) for field in fields]
        except ValueError as error:
            raise CatalogError(f"{path}, line {number}: {error}") from error
        if len(values) != len(header):
            raise CatalogError(f"{path}, line {number}: {len(values)} fields, the header has {len(header)}")
        if not all(map(math.isfinite, values)):
            raise CatalogError(f"{path}, line {number}: a value is not finite")
        rows.append(values)
    if header is None or not rows:
        raise CatalogError(f"{path}: no rows of numbers")
    table = np.array(rows, dtype=np.float64)
    return {name: table[:, index].copy() for index, name in enumerate(header)}


def used_paths(catalog: Catalog) -> list[Path]:
    """Return the path of each file that a catalog has opened."""
    return [catalog.root / name for name in catalog.used]
