"""Files that appear complete, are on the disk when they are said to be, and never replace an input."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hcss_twin.core.errors import CatalogError, HcssError


@contextlib.contextmanager
def atomic_write(path: Path, error: type[HcssError]) -> Iterator[Path]:
    """Give a hidden name to write to; leaving the block without an exception renames it to ``path``.

    The draft lies in the same folder, so that the renaming is one step and an older file is either whole
    or replaced. Leaving the block through any exception, Ctrl-C among them, removes the draft.

    Parameters
    ----------
    path : Path
        Final name; its folder must exist.
    error : type
        What is raised where the system refuses, or a library reports a refusal as OSError or RuntimeError.

    Raises
    ------
    HcssError
        Of the type ``error``, with the path and the cause.
    """
    if path.is_dir():
        raise error(f"cannot write {path}: it is a folder")
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")
    try:
        yield draft
        with draft.open("rb+") as file:
            os.fsync(file.fileno())
        os.replace(draft, path)
    except (OSError, RuntimeError) as cause:
        raise error(f"cannot write {path}: {getattr(cause, 'strerror', None) or cause}") from cause
    finally:
        with contextlib.suppress(FileNotFoundError, NotADirectoryError):
            draft.unlink()


def require_not_read(output: Path, read: Iterable[Path], error: type[HcssError]) -> None:
    """Refuse to write onto a file that is read, or onto a folder that holds one.

    Raises
    ------
    HcssError
        Of the type ``error``, with the path.
    """
    for path in read:
        same = output.is_file() and path.is_file() and os.path.samefile(output, path)
        if same or (output.is_dir() and path.resolve().is_relative_to(output.resolve())):
            raise error(f"cannot write {output}: it is an input of this command ({path}); give another name")


def flush(path: Path) -> None:
    """Ask the system to put a file, or a folder's entries, on the disk."""
    if path.is_dir():
        # some systems cannot open folders; the rename is then as durable as they make it
        with contextlib.suppress(OSError):
            _flush_handle(os.open(path, os.O_RDONLY))
        return
    _flush_handle(os.open(path, os.O_RDWR))


def _flush_handle(handle: int) -> None:
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def open_format(path: Path, name: str, version: int) -> Iterator[Any]:
    """Open a NetCDF file whose attributes ``format`` and ``format_version`` are the expected ones.

    Raises
    ------
    CatalogError
        If it is not NetCDF or of another format.
    """
    import netCDF4

    try:
        dataset = netCDF4.Dataset(path)
    except OSError as error:
        raise CatalogError(f"{path}: not a readable NetCDF file: {error}") from error
    with dataset:
        actual = (getattr(dataset, "format", None), int(getattr(dataset, "format_version", 0)))
        if actual != (name, version):
            raise CatalogError(f"{path}: format {actual[0]!r} version {actual[1]}; allowed: {name!r} version {version}")
        yield dataset
