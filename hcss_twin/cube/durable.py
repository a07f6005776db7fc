"""Files and folders that are on the disk when they are said to be."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path


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
