"""Folders of entries: the names, listing and look-up of entries of the cloud database."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.providers import CatalogError, choose_from

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9._-]*")


@dataclass(frozen=True)
class ListedEntry:
    """One file in a folder of entries.

    ``name`` is the file name without its suffix, ``shape`` is (rows, columns). If the file is not an entry, ``facts``
    is None, ``shape`` is (0, 0), and ``trouble`` is the reason.
    """

    name: str
    path: Path
    facts: CloudEntry.Facts | None
    shape: tuple[int, int]
    trouble: str = ""


def valid_entry_name(text: str) -> str:
    """Return ``text`` if it is a valid entry name for files and scenarios.

    Raises
    ------
    CatalogError
        If it contains other characters.
    """
    if not _NAME.fullmatch(text):
        closest = re.sub(r"[^A-Za-z0-9._-]+", "-", text).lstrip(".-") or "clouds"
        raise CatalogError(
            f"name: '{text}' given, allowed: letters, digits, '_', '.' and '-', not starting with '.' or '-'; "
            f"closest is '{closest}'"
        )
    return text


def list_entries(folder: Path) -> list[ListedEntry]:
    """List the entries of a folder by name, with the reason for invalid files; empty for a missing folder."""
    entries = []
    for path in sorted(folder.glob(f"*{CloudEntry.SUFFIX}")):
        if path.name.startswith("."):
            continue
        name = path.name.removesuffix(CloudEntry.SUFFIX)
        try:
            entries.append(ListedEntry(name, path, *CloudEntry.read_facts(path)))
        except CatalogError as error:
            entries.append(ListedEntry(name, path, None, (0, 0), str(error)))
    return entries


def entry_path(folder: Path, name: str) -> Path:
    """Return the file of an existing entry.

    Raises
    ------
    CatalogError
        If it does not exist; the message lists the names in the folder.
    """
    path = folder / f"{name}{CloudEntry.SUFFIX}"
    if not path.is_file():
        known = [path.name.removesuffix(CloudEntry.SUFFIX) for path in folder.glob(f"*{CloudEntry.SUFFIX}")]
        raise CatalogError(f"no entry '{name}' in {folder}; {choose_from(name, known)}")
    return path
