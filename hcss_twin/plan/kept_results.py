"""Results that are kept between runs under a name that says all they depend on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from hcss_twin.core.cache import Store, package_fingerprint, read_record, top_level, write_record
from hcss_twin.core.catalog import Catalog, SecludedCatalog
from hcss_twin.core.environment import versions
from hcss_twin.core.result_cache import ResultCache
from hcss_twin.providers.registry.discovery import Entry

_T = TypeVar("_T")

FORMAT = 1
"""Raised when what is written changes its meaning."""


@dataclass(frozen=True)
class Kept:
    """A result, and the files that were read for it beside those its name knows.

    Attributes
    ----------
    folder : str
        Where a user's relative paths started from, if such files are among these.
    """

    result: Any
    file_names: tuple[str, ...]
    file_sha256: tuple[str, ...]
    folder: str


class KeptResults(Generic[_T]):
    """Results of one kind for scenarios of one catalog; none where the catalog is secluded.

    Parameters
    ----------
    kind : (str, str)
        Of :mod:`hcss_twin.core.cache`.
    catalog : Catalog
        Records what an earlier run read, and says whether that has changed.
    result : type
        What is kept, a frozen dataclass.
    parts : iterable of type
        The dataclasses that may occur in it.
    """

    def __init__(self, kind: tuple[str, str], catalog: Catalog, result: type[_T], parts: Iterable[type] = ()) -> None:
        self._store = None if isinstance(catalog, SecludedCatalog) else Store(*kind)
        self._catalog, self._result = catalog, result
        all_parts: tuple[type, ...] = (Kept, result, *parts)
        self._classes = {each.__name__: each for each in all_parts}

    def find(self, key: str) -> _T | None:
        """Return a result kept by an earlier run whose files are unchanged; they are recorded as read."""
        path = None if self._store is None else self._store.find(key)
        if self._store is None or path is None:
            return None
        try:
            kept = read_record(path, self._classes)
            if kept.folder not in ("", self._folder()):
                return None  # of a scenario elsewhere, with files of its own
            files = dict(zip(kept.file_names, kept.file_sha256, strict=True))
            if isinstance(kept.result, self._result) and self._catalog.unchanged(files):
                return kept.result
        except Exception:  # whatever is wrong with the file, it is made again
            pass
        self._store.forget(key)
        return None

    def keep(self, key: str, result: _T, before: Mapping[str, str]) -> None:
        """Keep a result.

        Parameters
        ----------
        before : mapping of str to str
            Files that the key knows, with their hashes.
        """
        if self._store is None:
            return
        read = {name: digest for name, digest in self._catalog.used.items() if name not in before}
        folder = self._folder() if any(Path(name).is_absolute() for name in read) else ""
        kept = Kept(result, tuple(read), tuple(read.values()), folder)
        self._store.keep(key, lambda draft: write_record(draft, kept, self._classes))

    def _folder(self) -> str:
        return str(self._catalog.base.resolve())


@dataclass(frozen=True)
class Code:
    """All code that has a share in a scene's numbers.

    Attributes
    ----------
    providers : mapping of str to tuple of str
        By the names that the assembly gives them: name, version and fingerprint.
    engine : str
        Fingerprint.
    libraries : mapping of str to str
        Their versions.
    """

    providers: Mapping[str, tuple[str, str, str]]
    engine: str
    libraries: Mapping[str, str]


def code_of(entries: Mapping[str, Entry], shelf: ResultCache) -> Code:
    """Return the code of an engine with some providers.

    Parameters
    ----------
    entries : mapping of str to Entry
    shelf : ResultCache
        Remembers the code as it was when it was looked at first.
    """

    def fingerprint(package: str) -> str:
        # Most providers come from one package, whose many files are looked at once.
        return shelf.get_or_compute(("fingerprint", package), lambda: package_fingerprint(package))

    providers = {
        name: (entry.qualified_name, entry.version, fingerprint(top_level(entry.spec.target)))
        for name, entry in entries.items()
    }
    return Code(providers, fingerprint(top_level(__name__)), shelf.get_or_compute("versions", versions))


def key_of(parts: Mapping[str, Any], code: Code, without: Collection[str] = ()) -> str:
    """Return a hash of parts and of code.

    Parameters
    ----------
    without : collection of str
        Providers that do not count.
    """
    providers = {name: each for name, each in code.providers.items() if name not in without}
    engine = {"format": FORMAT, "libraries": code.libraries, "engine": code.engine}
    text = json.dumps({**parts, **engine, "code": providers}, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()
