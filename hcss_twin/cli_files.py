"""Files that commands write: what would go wrong is found out before the work, and they appear when they are whole."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import click


def require_writable(paths: Iterable[Path | None], force: bool, remedy: str = "give another name") -> None:
    """Refuse to begin where a result could not be written.

    Parameters
    ----------
    paths : iterable of Path or None
        None: not asked for.
    force : bool
        Existing files may be replaced.
    remedy : str
        What to do about an existing one, beside ``--force``.

    Raises
    ------
    click.ClickException
        If a file exists, or its folder does not.
    """
    for path in paths:
        if path is None:
            continue
        if path.exists() and not force:
            raise click.ClickException(f"{path} exists; {remedy}, or --force")
        folder = path.absolute().parent
        if not folder.is_dir():
            raise click.ClickException(f"cannot write {path}: there is no folder {folder}")


def write_text(path: Path, text: str) -> None:
    """Write a line or more; raises HcssError if it cannot be written."""
    from hcss_twin.drafts import draft_of
    from hcss_twin.errors import HcssError

    with draft_of(path, HcssError) as draft:
        draft.write_text(text + "\n", encoding="utf-8")


def require_two_files(given: Mapping[str, Path | None]) -> None:
    """Refuse one file under two options.

    Parameters
    ----------
    given : mapping of str to Path or None
        By the name of the option; None: not asked for.

    Raises
    ------
    click.UsageError
        Naming both options.
    """
    seen: dict[Path, str] = {}
    for option, path in given.items():
        if path is None:
            continue
        if path.absolute() in seen:
            raise click.UsageError(
                f"{seen[path.absolute()]} and {option} are both {path}; allowed: two files"
            )
        seen[path.absolute()] = option
