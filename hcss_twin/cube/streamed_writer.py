"""Writing of a cube frame by frame, whatever its format, and from a thread of its own.

A cube grows under a hidden name, so that the final name only ever holds a finished one.
"""

from __future__ import annotations

import contextlib
import math
import os
import secrets
import shutil
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from threading import RLock
from types import TracebackType
from typing import Any, ClassVar, Self

from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError
from hcss_twin.cube.frames import WrittenFrames, check_frame, plain_bytes
from hcss_twin.cube.geometry import PixelGeometry
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, Attribute, CubeHeader, check_attributes


class StreamedWriter(ABC):
    """Context manager that streams frames, or parts of them, into a cube that grows under a hidden name.

    The name ends in ``.partial``, in the same folder. Leaving the block with all frames written gives the cube its own
    name, in place of an older one; leaving it through any exception removes it. Memory does not depend on the number of
    frames. Calls from several threads take turns.

    Parameters
    ----------
    path : path-like
        Final name; its folder must exist.
    header : CubeHeader
        Everything but the frames.
    compression : int, optional
        zlib level 1 to 9; None stores plain numbers.
    tile : (int, int), optional
        Rows and columns of the tiles in which frames will come, which become the chunks.

    Raises
    ------
    CubeError
        On a folder that is missing or cannot be written, a full disk, or frames that do not match the header.
    """

    overhead_bytes: ClassVar[int] = 0
    """Size of a cube beside its numbers."""

    library_errors: ClassVar[tuple[type[Exception], ...]] = (OSError,)
    """Exceptions of the library where it cannot write."""

    def __init__(
        self,
        path: str | os.PathLike[str],
        header: CubeHeader,
        *,
        compression: int | None = None,
        tile: tuple[int, int] | None = None,
    ) -> None:
        if compression is not None and not 1 <= compression <= 9:
            raise CubeError(f"compression: {compression}; a zlib level from 1 to 9, or none, is allowed")
        self.path = Path(path)
        self.header = header
        self.compression = compression
        self.tile = tile
        self._partial = self.path.with_name(f".{self.path.name}.{secrets.token_hex(4)}.partial")
        self._geometry = PixelGeometry(header)
        self._written = WrittenFrames(header)
        self._turn = RLock()

    def __enter__(self) -> Self:
        self._claim()
        try:
            with self._explained():
                self._open()
        except BaseException:
            self._discard()
            raise
        return self

    def write_frame(self, index: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Write one frame; frames may come in any order, each once. See :meth:`write_tile`."""
        self.write_tile(index, None, arrays)

    def write_tile(self, index: int, place: tuple[slice, slice] | None, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Write a part of one frame; parts may come in any order, each pixel once.

        Parameters
        ----------
        index : int
            Number of the frame, from 0.
        place : (slice, slice) or None
            Rows and columns of the cube; None for all of them.
        arrays : mapping of str to ndarray
            One array per variable of the header, without the time dimension, of the type in its spec.

        Raises
        ------
        CubeError
            If arrays do not match the header, a value is not allowed, or the disk refuses.
        """
        with self._turn:
            if not self._is_open:
                raise CubeError(f"{self.path}: not open for writing; frames are written inside a 'with' block")
            window = self._written.room_for(index, place)
            check_frame(self.header, index, arrays, place)
            with self._explained():
                for name, array in arrays.items():
                    self._array(name)[(index, ..., *window)] = array
                names, time_s = self._geometry.of_frames, self.header.frame_times_s[index]
                for name, array in self._geometry.values(names, window, time_s).items():
                    self._array(name)[(index, *window)] = array
            self._written.add(index, window)

    def set_attributes(self, attributes: Mapping[str, Attribute]) -> None:
        """Add global attributes that are known only once frames are written.

        Parameters
        ----------
        attributes : mapping
            Names that the cube does not have yet.

        Raises
        ------
        CubeError
            If a name is taken, a value cannot be stored, or the disk refuses.
        """
        if not self._is_open:
            raise CubeError(f"{self.path}: not open for writing; attributes are set inside a 'with' block")
        check_attributes(attributes)
        taken = self._attribute_names()
        for name in attributes:
            if name == FORMAT_ATTRIBUTE or name in taken:
                raise CubeError(f"attribute {name}: the cube has it already; it cannot be given again")
        with self._explained():
            self._add_attributes(attributes)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._turn:
            try:
                if kind is None:
                    self._written.require_all(self.path)
                    with self._explained():
                        self._finish()
            finally:
                # once finished the partial name is gone and this does nothing
                self._discard()

    def _claim(self) -> None:
        """Create the partial name, which says more about what is wrong with a path than libraries do."""
        if not self.path.parent.is_dir():
            raise CubeError(f"cannot write {self.path}: there is no folder {self.path.parent}")
        self._require_replaceable()
        try:
            free = shutil.disk_usage(self.path.parent).free
            self._create()
        except OSError as error:
            raise CubeError(f"cannot write {self.path}: {error.strerror}") from error
        needed = self._plain_bytes()
        if self.compression is None and needed > free:
            self._discard()
            raise CubeError(
                f"cannot write {self.path}: it needs {needed / 1e6:.1f} MB, the disk has {free / 1e6:.1f} MB free"
            )

    @contextlib.contextmanager
    def _explained(self) -> Iterator[None]:
        """Turn errors of the library, which do not say the cause, into one with path and free space."""
        try:
            yield
        except self.library_errors as error:
            cause = getattr(error, "strerror", None) or str(error)
            try:
                free = float(shutil.disk_usage(self.path.parent).free)
            except OSError:
                free = math.nan
            full = "the disk is full: " if free < self.overhead_bytes else ""
            raise CubeError(
                f"cannot write {self.path}: {full}{cause} (free on this disk: {free / 1e6:.1f} MB; "
                f"the cube needs up to {self._plain_bytes() / 1e6:.1f} MB)"
            ) from error

    def _plain_bytes(self) -> int:
        """Return the size of the cube without compression."""
        return plain_bytes(self.header) + self.overhead_bytes

    @property
    @abstractmethod
    def _is_open(self) -> bool:
        """Whether frames can be written."""

    @abstractmethod
    def _require_replaceable(self) -> None:
        """Refuse a path that has something else than an older cube."""

    @abstractmethod
    def _create(self) -> None:
        """Make the partial name, empty."""

    @abstractmethod
    def _open(self) -> None:
        """Open it and define all variables."""

    @abstractmethod
    def _array(self, name: str) -> Any:
        """Return what takes the values of a variable by index."""

    @abstractmethod
    def _attribute_names(self) -> Collection[str]:
        """Return the names of the global attributes."""

    @abstractmethod
    def _add_attributes(self, attributes: Mapping[str, Attribute]) -> None:
        """Add global attributes."""

    @abstractmethod
    def _finish(self) -> None:
        """Mark the cube as finished and give it its name."""

    @abstractmethod
    def _discard(self) -> None:
        """Remove what has the partial name, if anything has."""


MAX_WAITING = 2
"""Frames in the queue, including the one that is being written."""

MAX_WAITING_BYTES = 256 * 2**20
"""Larger frames wait alone, so that memory holds two frames: one computed and one written."""


class BackgroundWriter:
    """Context manager that writes frames in the background, while the next are computed.

    A thread calls the writer, one frame after the other; nothing else may call it, or any netCDF function, between
    the first frame and the end of the block, because the library is not thread safe. What the writer raises is raised
    by the next :meth:`write_frame`, or at the end of the block. A block that is left through an exception waits for
    the frame that is being written, and for no other.

    Parameters
    ----------
    writer : StreamedWriter
        Open, and still open at the end of the block.
    """

    def __init__(self, writer: StreamedWriter) -> None:
        self._writer = writer
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="cube")
        self._waiting: deque[Future[None]] = deque()

    def __enter__(self) -> Self:
        return self

    def write_frame(self, index: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Hand over a frame; the arrays must not be changed afterwards. Waits while enough frames wait.

        Raises
        ------
        CubeError
            If an earlier frame could not be written.
        """
        self._hand_over(arrays, self._writer.write_frame, index, arrays)

    def write_tile(self, index: int, place: tuple[slice, slice] | None, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Hand over a part of a frame, as :meth:`write_frame` does a whole one."""
        self._hand_over(arrays, self._writer.write_tile, index, place, arrays)

    def _hand_over(self, arrays: Mapping[str, NDArray[Any]], write: Callable[..., None], *arguments: Any) -> None:
        size = sum(array.nbytes for array in arrays.values())
        most = MAX_WAITING if size * MAX_WAITING <= MAX_WAITING_BYTES else 1
        while self._waiting and (len(self._waiting) >= most or self._waiting[0].done()):
            self._waiting[0].result()
            self._waiting.popleft()
        self._waiting.append(self._thread.submit(write, *arguments))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            while kind is None and self._waiting:
                self._waiting[0].result()
                self._waiting.popleft()
        finally:
            self._stop()

    def _stop(self) -> None:
        """Drop frames that wait and return when the thread is idle, however often the user interrupts that."""
        interrupted: KeyboardInterrupt | None = None
        while True:
            try:
                for each in self._waiting:
                    each.cancel()
                # the only thread takes tasks in order: after this one it is idle
                self._thread.submit(_nothing).result()
                break
            except KeyboardInterrupt as again:
                interrupted = again
        self._thread.shutdown(wait=False)
        if interrupted is not None:
            raise interrupted


def _nothing() -> None:
    pass
