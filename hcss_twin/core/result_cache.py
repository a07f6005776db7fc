"""What scenes that follow each other in one process need not read or find out again."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Any, TypeVar

_T = TypeVar("_T")

MAX = 512
"""Things that are remembered; the least recently used are forgotten first."""


class ResultCache:
    """Remembers by names that say all that a thing depends on; whoever wants scenes to share hands one on.

    What lies on it is the same for all of them and must not be changed.
    """

    def __init__(self) -> None:
        self._things: OrderedDict[Hashable, Any] = OrderedDict()

    def get_or_compute(self, name: Hashable, make: Callable[[], _T]) -> _T:
        """Return the thing of a name, made when it is asked for first."""
        if name in self._things:
            self._things.move_to_end(name)
        else:
            self._things[name] = make()
            if len(self._things) > MAX:
                self._things.popitem(last=False)
        thing: _T = self._things[name]
        return thing

    def sha256(self, path: Path) -> str:
        """Return the hash of a file, which is read again where its size, its time or the file itself is another."""
        return self.get_or_compute(("sha256", *_state(path)), lambda: hashlib.sha256(path.read_bytes()).hexdigest())

    def parsed(self, path: Path, read: Callable[[Path], _T]) -> _T:
        """Return what a reader, a function of a module, makes of a file."""
        return self.get_or_compute((read.__module__, read.__qualname__, *_state(path)), lambda: read(path))


def _state(path: Path) -> tuple[str, int, int, int]:
    about = path.stat()
    return str(path.resolve()), about.st_size, about.st_mtime_ns, about.st_ino
