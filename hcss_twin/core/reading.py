"""Reading of input files: any exception of a library becomes one error that names the file.

Libraries trust what a file declares. A damaged file can therefore cause almost any exception, even long after it was
opened, and a small file can declare more values than fit into memory.
"""

from __future__ import annotations

import mmap
import os
import stat
import struct
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, Self, TypeVar

from hcss_twin.core.errors import HcssError
from hcss_twin.core.netcdf import NETCDF, NetcdfFile, netcdf_lock

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Reading"]

_P = ParamSpec("_P")
_T = TypeVar("_T")
_Error = type[HcssError]

DAMAGED = "it is damaged or of a form that is not supported"

MAX_VALUES = 2**28
"""Largest variable that is read as a whole: 2 GiB in double precision."""

MAX_IMAGE_PIXELS = 2**26
"""Largest image that is read as a whole: 8192 x 8192."""


HEAP, SEARCHED = b"GCOL\1\0\0\0", 2**24
"""How a collection of texts begins in HDF5 files, and the first bytes that are searched: values come later."""


class Reading:
    """Turns exceptions raised in a ``with`` block, except those of this package, into one with path and cause.

    Parameters
    ----------
    path : path-like or file-like
        The input file.
    error : type
        What to raise.
    what : str
        What is wrong with the file, in its message.
    """

    def __init__(self, path: Any, error: _Error, what: str = DAMAGED) -> None:
        self._path, self._error, self._what = path, error, what

    def __enter__(self) -> Self:
        with self._told():
            if isinstance(self._path, str | os.PathLike):
                require_no_stream(self._path, self._error)
                if os.path.isfile(self._path):
                    _require_heaps_that_end(self._path)
        return self

    def __exit__(self, _type: object, raised: BaseException | None, _traceback: object) -> None:
        if isinstance(raised, Exception):
            with self._told():
                raise raised

    @contextmanager
    def _told(self) -> Iterator[None]:
        name = _name(self._path)
        try:
            yield
        except (HcssError, ImportError):
            raise
        except MemoryError as cause:
            raise self._error(f"cannot read {name}: it declares more values than fit into memory") from cause
        except FileNotFoundError as cause:
            raise self._error(f"cannot read {name}: there is no such file") from cause
        except Exception as cause:
            text = str(cause) if isinstance(cause, OSError) else f"{type(cause).__name__}: {cause}"
            raise self._error(f"cannot read {name}: {self._what}: {shown_line(text)}") from cause

    @staticmethod
    def argument(error: _Error) -> Callable[[Callable[_P, _T]], Callable[_P, _T]]:
        """Return a decorator that does the same for a function whose first argument is the path of an input file."""

        def decorate(function: Callable[_P, _T]) -> Callable[_P, _T]:
            @wraps(function)
            def guarded(*args: _P.args, **kwargs: _P.kwargs) -> _T:
                with Reading(next(iter((*args, *kwargs.values()))), error):
                    return function(*args, **kwargs)

            return guarded

        return decorate

    @staticmethod
    @contextmanager
    def quiet() -> Iterator[None]:
        """Suppress the warnings of file libraries about unusual attributes, which the user cannot change."""
        with netcdf_lock(), warnings.catch_warnings():  # not thread safe either
            warnings.simplefilter("ignore")
            yield

    def first_bytes(self, count: int = 8) -> bytes:
        """Return the first bytes of the file, which tell its format."""
        with self, open(self._path, "rb") as file:
            return file.read(count)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of an archive that :meth:`Writing.arrays` wrote, whose checksum must agree."""
        from hcss_twin.core.records import read_arrays

        with self:
            return read_arrays(self._path)

    def require_size(self, shape: Sequence[int]) -> None:
        """Reject an array of the file whose declared shape is too large, before it is read."""
        require_size(self._path, shape, self._error)

    @property
    def is_netcdf(self) -> bool:
        """Whether the file begins as NetCDF files do."""
        return self.first_bytes().startswith(NETCDF)

    @contextmanager
    def netcdf(self) -> Iterator[Any]:
        """Open a NetCDF file whose variables are read as a whole; what the block raises is turned, too."""
        with self, NetcdfFile(self._path) as dataset:
            for name, variable in dataset.variables.items():
                require_size(self._path, variable.shape, self._error, what=f"values of {name}")
            yield dataset


def require_no_stream(path: str | os.PathLike[str], error: _Error) -> None:
    """Reject pipes, sockets and devices, also behind links: a reader would wait for ever, or never find an end."""
    try:
        kind = stat.S_IFMT(os.stat(path).st_mode)
    except (OSError, ValueError):  # there is no such file: the reader says it
        return
    if kind not in (stat.S_IFREG, stat.S_IFDIR):
        raise error(f"cannot read {_name(path)}: it is a {_STREAMS.get(kind, 'device')}; allowed: a file on disk")


_STREAMS = {stat.S_IFIFO: "pipe", stat.S_IFSOCK: "socket"}


def _require_heaps_that_end(path: str | os.PathLike[str]) -> None:
    """Reject a HDF5 file with an object of no size, behind which the library (2.0) would look for the next for ever.

    A collection has its size at byte 8, then objects: a number (2 bytes), 6 others, the size of the content (8 bytes)
    and the content, padded to multiples of 8. Number 0 is free space, whose size includes these 16 bytes (HDF5 File
    Format Specification, section III.E).
    """
    with open(path, "rb") as file:
        if file.read(4) != b"\x89HDF":
            return
        with mmap.mmap(file.fileno(), min(os.path.getsize(path), SEARCHED), access=mmap.ACCESS_READ) as data:
            at = data.find(HEAP)
            while at >= 0 and at + 16 <= len(data):
                end, position = at + struct.unpack_from("<Q", data, at + 8)[0], at + 16
                while position + 16 <= min(end, len(data)):
                    number, size = struct.unpack_from("<H6xQ", data, position)
                    step = (16 + (size + 7) // 8 * 8 if number else size) % 2**64
                    if step == 0:
                        raise OSError("a collection of texts has an object of no size")
                    position += step
                at = data.find(HEAP, at + 1)


def require_size(path: Any, shape: Sequence[int], error: _Error, limit: int = MAX_VALUES, what: str = "values") -> None:
    """Reject an array whose declared shape is too large, before it is read; raises ``error``."""
    count = 1
    for size in shape:
        count *= int(size)
    if count > limit:
        sizes = " x ".join(map(str, shape))
        raise error(f"cannot read {_name(path)}: it declares {sizes} {what}; allowed: {limit} in all; cut out a part")


def shown_line(text: str) -> str:
    """Return a message of another library as one line of at most 200 characters."""
    line = " ".join(text.split())
    return line if len(line) <= 200 else f"{line[:197]}..."


def _name(path: Any) -> str:
    return os.fspath(path) if isinstance(path, str | os.PathLike) else type(path).__name__
