"""Shipped examples, and where else examples are searched."""

from __future__ import annotations

from pathlib import Path

from hcss_twin.providers import Catalog, CatalogError, choose_from

SUFFIX = ".nc"

FOLDER = "skies"
"""Folder beside a scenario whose examples have names."""


def shipped() -> dict[str, Path]:
    """Return the files of the shipped examples by name."""
    return {path.stem: path for path in sorted(Path(__file__).parent.glob(f"*{SUFFIX}"))}


def find_example(name: str, catalog: Catalog) -> Path:
    """Return the file of an example: shipped, in the folder ``skies`` beside the scenario, or a path.

    Raises
    ------
    CatalogError
        If there is none.
    """
    shipped_examples = shipped()
    if name in shipped_examples:
        return catalog.file(shipped_examples[name])
    try:
        return catalog.find(name, FOLDER, SUFFIX, beside=True)
    except CatalogError as error:
        beside = [path.stem for path in (catalog.base / FOLDER).glob(f"[!.]*{SUFFIX}")]
        raise CatalogError(
            f"no example '{name}': neither shipped, nor in {catalog.base / FOLDER}, nor a file; "
            f"{choose_from(name, {*shipped_examples, *beside})}"
        ) from error
