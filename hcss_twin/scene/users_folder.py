"""Where a user's relative paths start from, for results that are kept between runs."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from hcss_twin.catalog import Catalog


def users_folder(catalog: Catalog, used: Iterable[str]) -> str:
    """Return the folder that relative paths start from, if files of a user are among those used; else nothing.

    Parameters
    ----------
    used : iterable of str
        Names as in :attr:`hcss_twin.catalog.Catalog.used`.
    """
    return str(catalog.base.resolve()) if any(Path(name).is_absolute() for name in used) else ""


def of_the_same_folder(catalog: Catalog, folder: str) -> bool:
    """Whether kept results, with what :func:`users_folder` returned for them, can be those of a scenario."""
    return folder in ("", str(catalog.base.resolve()))
