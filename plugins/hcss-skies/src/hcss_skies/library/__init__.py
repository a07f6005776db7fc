"""Shipped examples, films and volumes, and where else they are searched."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from hcss_twin.providers import Catalog, CatalogError, choose_from

SUFFIX = ".nc"

FOLDER = "skies"
"""Folder beside a scenario whose examples, films and volumes have names."""


def shipped() -> dict[str, Path]:
    """Return the files of the shipped examples by name."""
    return _within(Path(__file__).parent)


@cache
def shipped_films() -> dict[str, Path]:
    """Return the files of the shipped films by name."""
    return _within(Path(__file__).parent / "films")


def shipped_volumes() -> dict[str, Path]:
    """Return the files of the shipped volumes by name."""
    return _within(Path(__file__).parent / "volumes")


def find_example(name: str, catalog: Catalog) -> Path:
    """Return the file of an example: shipped, in the folder ``skies`` beside the scenario, or a path.

    Raises
    ------
    CatalogError
        If there is none.
    """
    return _find("example", name, shipped(), catalog)


def find_film(name: str, catalog: Catalog) -> Path:
    """Return the file of a film: shipped, in the folder ``skies`` beside the scenario, or a path.

    Raises
    ------
    CatalogError
        If there is none.
    """
    return _find("film", name, shipped_films(), catalog)


def find_volume(name: str, catalog: Catalog) -> Path:
    """Return the file of a volume: shipped, in the folder ``skies`` beside the scenario, or a path.

    Raises
    ------
    CatalogError
        If there is none.
    """
    return _find("volume", name, shipped_volumes(), catalog)


def _within(folder: Path) -> dict[str, Path]:
    return {path.stem: path for path in sorted(folder.glob(f"*{SUFFIX}"))}


def _find(what: str, name: str, known: dict[str, Path], catalog: Catalog) -> Path:
    if name in known:
        return catalog.shipped(known[name])
    try:
        return catalog.find(name, FOLDER, SUFFIX, beside=True)
    except CatalogError as error:
        beside = [path.stem for path in (catalog.base / FOLDER).glob(f"[!.]*{SUFFIX}")]
        raise CatalogError(
            f"no {what} '{name}': neither shipped, nor in {catalog.base / FOLDER}, nor a file; "
            f"{choose_from(name, {*known, *beside})}"
        ) from error
