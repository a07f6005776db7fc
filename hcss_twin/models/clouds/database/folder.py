"""A folder of database entries: names, and what each says about itself."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from hcss_twin.core.errors import CatalogError, choose_from
from hcss_twin.models.clouds.database.entry import EntryFacts, read_facts

FOLDER = "clouds"
"""Where entries lie: in the catalog, beside a scenario, and where `hcss import` puts them."""

SUFFIX = ".nc"

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9._-]*")


@dataclass(frozen=True)
class Listed:
    """One file of a folder: what it says about itself, or why it cannot be used.

    Attributes
    ----------
    name : str
        File name without its suffix.
    path : Path
        The file.
    facts : EntryFacts or None
        None where the file is not an entry.
    shape : (int, int)
        Rows and columns; (0, 0) without facts.
    trouble : str
        Why there are no facts, else empty.
    """

    name: str
    path: Path
    facts: EntryFacts | None
    shape: tuple[int, int]
    trouble: str = ""


def entry_name(text: str) -> str:
    """Check the name of an entry.

    Raises
    ------
    CatalogError
        If it holds what a file name or a scenario should not.
    """
    if not _NAME.fullmatch(text):
        closest = re.sub(r"[^A-Za-z0-9._-]+", "-", text).lstrip(".-") or "clouds"
        raise CatalogError(
            f"name: '{text}' given, allowed: letters, digits, '_', '.' and '-', not starting with '.' or '-'; "
            f"closest is '{closest}'"
        )
    return text


def list_entries(folder: Path) -> list[Listed]:
    """List the entries of a folder by name; files that are none tell why. Empty for a missing folder."""
    listed = []
    for path in sorted(folder.glob(f"*{SUFFIX}")):
        if path.name.startswith("."):
            continue
        name = path.name.removesuffix(SUFFIX)
        try:
            facts, shape = read_facts(path)
        except CatalogError as error:
            listed.append(Listed(name, path, None, (0, 0), str(error)))
        else:
            listed.append(Listed(name, path, facts, shape))
    return listed


def entry_path(folder: Path, name: str) -> Path:
    """Return the file of an entry that exists.

    Raises
    ------
    CatalogError
        If there is none; the message gives the names there are.
    """
    path = folder / f"{name}{SUFFIX}"
    if not path.is_file():
        known = [each.name.removesuffix(SUFFIX) for each in folder.glob(f"*{SUFFIX}")]
        raise CatalogError(f"no entry '{name}' in {folder}; {choose_from(name, known)}")
    return path
