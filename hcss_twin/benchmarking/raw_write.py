"""Writing bytes with nothing around them: what any cube costs at least on a disk."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


def write_raw(path: Path, plane: NDArray[Any], times: int) -> None:
    """Write an array so many times, one after the other, into a file whose room is claimed before.

    As a cube does, it grows under another name, is put on the disk (fsync of the file), replaces an older one in one
    step, and the folder is put on the disk.

    Raises
    ------
    OSError
        If the disk refuses; the file is not left behind.
    """
    draft = path.with_name(f".{path.name}.partial")
    handle = os.open(draft, os.O_CREAT | os.O_TRUNC | os.O_WRONLY, 0o666)
    try:
        try:
            _claim(handle, plane.nbytes * times)
            data = np.ascontiguousarray(plane).data.cast("B")
            for _ in range(times):
                _write_all(handle, data)
            os.fsync(handle)
        finally:
            os.close(handle)
        os.replace(draft, path)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise
    _flush_folder(path.parent)


def _claim(handle: int, size: int) -> None:
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(handle, 0, size)
    else:
        os.ftruncate(handle, size)


def _write_all(handle: int, data: memoryview) -> None:
    # One call writes at most 2 GiB.
    written = 0
    while written < data.nbytes:
        written += os.write(handle, data[written:])


def _flush_folder(folder: Path) -> None:
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:
        return  # some systems cannot open folders
    try:
        os.fsync(handle)
    except OSError:
        pass
    finally:
        os.close(handle)
