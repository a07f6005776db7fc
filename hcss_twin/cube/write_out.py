"""Data put on the disk while more are written, so that little is left to do at the end."""

from __future__ import annotations

import os
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path

PIECE_BYTES = 32 * 2**20
"""Written between two calls of the system to put a file on the disk."""


class WriteOut:
    """Asks the system, in a thread, to put a growing file on the disk piece by piece.

    Left alone, systems keep gigabytes in memory before they begin to write, and the wait comes at the end. At most two
    pieces wait for the disk: whoever is faster than it waits in :meth:`wrote`.

    Parameters
    ----------
    path : Path
        The file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._waiting = 0
        self._thread: ThreadPoolExecutor | None = None
        self._running: Future[None] | None = None

    def wrote(self, count: int) -> None:
        """Take note of bytes that were written.

        Raises
        ------
        OSError
            If an earlier piece could not be put on the disk.
        """
        self._waiting += count
        if self._waiting < PIECE_BYTES:
            return
        self._settle()
        self._waiting = 0
        if self._thread is None:
            self._thread = ThreadPoolExecutor(1, thread_name_prefix="disk")
        self._running = self._thread.submit(flush, self._path)

    def finish(self) -> None:
        """Put what is left on the disk and return when all is there.

        Raises
        ------
        OSError
            If any of it could not be.
        """
        self._settle()
        flush(self._path)

    def stop(self) -> None:
        """Wait until nothing more is done to the file, whatever comes of it, and let go of the thread."""
        if self._running is not None:
            wait([self._running])
        if self._thread is not None:
            self._thread.shutdown(wait=False)

    def _settle(self) -> None:
        # what the system says of a failed piece it says once
        running, self._running = self._running, None
        if running is not None:
            running.result()


def flush(path: Path) -> None:
    """Ask the system to put a file on the disk.

    Raises
    ------
    OSError
        If it cannot.
    """
    flush_handle(os.open(path, os.O_RDWR))


def flush_handle(handle: int) -> None:
    """Do so for an open file or folder, and close it."""
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
