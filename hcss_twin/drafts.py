"""Files that appear under their name only when they are complete."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path

from hcss_twin.errors import HcssError


@contextlib.contextmanager
def draft_of(path: Path, error: type[HcssError]) -> Iterator[Path]:
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
