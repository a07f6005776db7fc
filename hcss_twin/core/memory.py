"""Memory that ran out: how much there is, and what needs less."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hcss_twin.core.errors import HcssError, ProviderDefect, ProviderError

_SIGNS = ("cannot allocate memory", "failed to map segment", "memory allocation", "can't start new thread")
"""What libraries say when the system gives them no memory, in lower case."""

LESS = (
    "less is needed with a smaller image.window (or image.rows and image.columns), fewer output.variables, "
    "image.samples_per_pixel = 1, or fewer workers"
)


class OutOfMemory(HcssError, MemoryError):
    """Memory ran out; no provider and no file is at fault."""


@contextmanager
def naming_memory() -> Iterator[None]:
    """Turn every form of memory that ran out in the block into :class:`OutOfMemory`, also inside of a provider.

    Errors that name a file which declares too much are kept.
    """
    try:
        yield
    except Exception as error:
        named = isinstance(error, HcssError) and type(error) not in (ProviderDefect, ProviderError)
        cause = None if named else _cause(error)
        if cause is None:
            raise
        raise OutOfMemory(out_of_memory(cause)) from error


def out_of_memory(cause: BaseException | None = None) -> str:
    """Return a message: what was asked for, what there is, and the keys that need less."""
    asked = " ".join(str(cause).split()) if cause is not None and str(cause) else "an array did not fit"
    there = "; ".join(available())
    return f"memory ran out: {asked}; {there + '; ' if there else ''}{LESS}"


def _cause(error: BaseException) -> BaseException | None:
    """Return the exception in a chain of causes that says that memory ran out."""
    seen: BaseException | None = error
    while seen is not None:
        text = str(seen).lower()
        if isinstance(seen, MemoryError) or (isinstance(seen, OSError) and seen.errno == errno.ENOMEM):
            return seen
        if isinstance(seen, OSError | ImportError | RuntimeError) and any(sign in text for sign in _SIGNS):
            return seen
        seen = seen.__cause__
    return None


def available() -> Iterator[str]:
    """Yield what there is: the limit of this process and its use, and what the machine or container has free."""
    with suppress(OSError, ValueError, ImportError, IndexError):
        import resource

        limit, _ = resource.getrlimit(resource.RLIMIT_AS)
        if limit != resource.RLIM_INFINITY:
            used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
            yield f"this process uses {_megabytes(used)} of the {_megabytes(limit)} that its limit (ulimit -v) allows"
    with suppress(OSError, ValueError):
        limit = int(Path("/sys/fs/cgroup/memory.max").read_text())
        used = int(Path("/sys/fs/cgroup/memory.current").read_text())
        yield f"the container uses {_megabytes(used)} of {_megabytes(limit)}"
    with suppress(OSError, ValueError, IndexError):
        lines = dict(line.split(":", 1) for line in Path("/proc/meminfo").read_text().splitlines())
        free, total = (int(lines[name].split()[0]) * 1024 for name in ("MemAvailable", "MemTotal"))
        yield f"the machine has {_megabytes(free)} of {_megabytes(total)} available"


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.0f} MB"
