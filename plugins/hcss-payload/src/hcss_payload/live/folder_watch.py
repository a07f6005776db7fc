"""Images that come into a folder: each new file is taken once it is whole."""

from __future__ import annotations

from pathlib import Path

SETTLED_S = 2.0
"""Time for which size and time of a file have not changed when it counts as whole."""

UNFINISHED = (".part", ".tmp", ".partial", ".crdownload")
"""Ends of the names of files that some programs write before they rename them."""


class FolderWatch:
    """The files of a folder.

    Parameters
    ----------
    folder : Path
        Files that are there already are not new, unless they change.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._taken = self._files()
        self._since = dict[str, tuple[tuple[int, int], float]]()

    def new(self, now_s: float) -> list[Path]:
        """Return the files that have become whole since the last call, the oldest first.

        Parameters
        ----------
        now_s : float
            Time of the call, on any clock that does not go back.
        """
        whole = list[tuple[int, str]]()
        for name, state in self._files().items():
            if self._taken.get(name) == state:
                continue
            known, since_s = self._since.get(name, (None, now_s))
            if known != state:
                self._since[name] = state, now_s
            elif now_s - since_s >= SETTLED_S:
                self._taken[name] = state
                del self._since[name]
                whole.append((state[1], name))
        return [self._folder / name for _, name in sorted(whole)]

    def _files(self) -> dict[str, tuple[int, int]]:
        """Return size and time of change of all files but hidden and unfinished ones."""
        found = dict[str, tuple[int, int]]()
        for path in self._folder.iterdir():
            if path.name.startswith(".") or path.name.lower().endswith(UNFINISHED):
                continue
            try:
                status = path.stat()
            except OSError:  # renamed or removed meanwhile
                continue
            if path.is_file() and status.st_size:
                found[path.name] = status.st_size, status.st_mtime_ns
        return found
