"""Format-independent writing of a cube, frame by frame, optionally in a background thread.

A cube is written under a hidden name, so that the final name always refers to a finished cube.
"""

from __future__ import annotations

import contextlib
import math
import os
import shutil
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from threading import RLock
from types import TracebackType
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import CubeError
from hcss_twin.core.files import Writing, draft_of, require_first
from hcss_twin.cube.frames import WrittenFrames, check_frame, plain_bytes
from hcss_twin.cube.geometry import PixelGeometry
from hcss_twin.cube.header import FORMAT_ATTRIBUTE, Attribute, CubeHeader, check_attributes
from hcss_twin.cube.packing import packed
from hcss_twin.cube.variables import VariableSpec


class StreamedWriter(ABC):
    """Context manager that streams frames, or parts of them, into a cube under a hidden name.

    The hidden name ends in ``.partial``, in the same folder. When the block ends with all frames written, the
    cube is renamed and replaces an older one; any exception removes it. Memory use does not depend on the
    number of frames. Calls from several threads are serialised.

    Parameters
    ----------
    path : path-like
        Final name; its folder must exist.
    header : CubeHeader
        Everything except the frames.
    compression : int, optional
        zlib level 1 to 9; None: uncompressed.
    tile : (int, int), optional
        Rows and columns of the tiles in which frames will be written; also the chunk size.
    replace : bool, optional
        Whether to replace an existing cube, or one that another process writes in the meantime.

    Raises
    ------
    CubeError
        If the folder is missing or not writable, the disk is full, or frames do not match the header.
    """

    overhead_bytes: ClassVar[int] = 0
    """Size of a cube without its data values."""

    library_errors: ClassVar[tuple[type[Exception], ...]] = (OSError, UnicodeError)
    """Exceptions by which the library reports write errors."""

    def __init__(
        self,
        path: str | os.PathLike[str],
        header: CubeHeader,
        *,
        compression: int | None = None,
        tile: tuple[int, int] | None = None,
        replace: bool = True,
    ) -> None:
        if compression is not None and not 1 <= compression <= 9:
            raise CubeError(f"compression: {compression}; a zlib level from 1 to 9, or none, is allowed")
        self.path = Path(path)
        self.header = header
        self.compression = compression
        self.tile = tile
        self.replace = replace
        self._partial = draft_of(self.path)
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
        """Write one frame; frames may be written in any order, each once. See :meth:`write_tile`."""
        self.write_tile(index, None, arrays)

    def write_tile(self, index: int, region: tuple[slice, slice] | None, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Write a part of one frame; parts may be written in any order, each pixel once.

        Parameters
        ----------
        index : int
            Number of the frame, from 0.
        region : (slice, slice) or None
            Rows and columns of the cube; None for all of them.
        arrays : mapping of str to ndarray
            One array per variable of the header, without the time dimension, of the type in its spec.

        Raises
        ------
        CubeError
            If arrays do not match the header, a value is not allowed, or writing fails.
        """
        with self._turn:
            self._require_open()
            window = self._written.room_for(index, region)
            check_frame(self.header, index, arrays, region)
            with self._explained():
                for spec in self.header.variables:
                    self._array(spec.name)[(index, ..., *window)] = _stored(spec, arrays[spec.name])
                for name, array in self._geometry_of(index, window).items():
                    self._array(name)[(index, *window)] = array
            self._written.add(index, window)

    def write_frames(self, first: int, frames: Sequence[Mapping[str, NDArray[Any]]]) -> None:
        """Write consecutive whole frames at once: for small ones, calls of the library take longer than the data.

        Parameters
        ----------
        first : int
            Number of the first frame.
        frames : sequence of mapping
            At least one, each as for :meth:`write_frame`.
        """
        with self._turn:
            self._require_open()
            numbers = range(first, first + len(frames))
            for index, arrays in zip(numbers, frames, strict=True):
                window = self._written.room_for(index, None)
                check_frame(self.header, index, arrays)
            geometry = [self._geometry_of(index, window) for index in numbers]
            with self._explained():
                for spec in self.header.variables:
                    together = np.stack([arrays[spec.name] for arrays in frames])
                    self._array(spec.name)[first : numbers.stop] = _stored(spec, together)
                for name in geometry[0]:
                    self._array(name)[first : numbers.stop] = np.stack([arrays[name] for arrays in geometry])
            for index in numbers:
                self._written.add(index, window)

    def _geometry_of(self, index: int, window: tuple[slice, slice]) -> dict[str, NDArray[Any]]:
        return self._geometry.values(self._geometry.of_frames, window, self.header.frame_times_s[index])

    def _require_open(self) -> None:
        if not self._is_open:
            raise CubeError(f"{self.path}: not open for writing; frames are written inside a 'with' block")

    def set_attributes(self, attributes: Mapping[str, Attribute]) -> None:
        """Add global attributes that are known only once frames are written.

        Parameters
        ----------
        attributes : mapping
            Names that the cube does not have yet.

        Raises
        ------
        CubeError
            If a name is in use, a value cannot be stored, or writing fails.
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
                # after a successful end the partial name no longer exists and this does nothing
                self._discard()

    def _claim(self) -> None:
        """Create the partial file here, because its errors describe a bad path better than those of the library."""
        if not self.path.parent.is_dir():
            raise CubeError(f"cannot write {self.path}: there is no folder {self.path.parent}")
        self._require_replaceable()
        Writing.remove_orphans(self.path.parent)
        try:
            free = shutil.disk_usage(self.path.parent).free
            self._create()
        except OSError as error:
            raise CubeError(f"cannot write {self.path}: {error.strerror}") from error
        if not self.replace:
            try:
                require_first(self._partial, self.path, CubeError)
            except CubeError:
                self._discard()
                raise
        needed = self._plain_bytes()
        if self.compression is None and needed > free:
            self._discard()
            raise CubeError(
                f"cannot write {self.path}: it needs {needed / 1e6:.1f} MB, the disk has {free / 1e6:.1f} MB free"
            )

    @contextlib.contextmanager
    def _explained(self) -> Iterator[None]:
        """Convert uninformative library errors into a CubeError with path and free space."""
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
        """Return the uncompressed size of the cube."""
        return plain_bytes(self.header) + self.overhead_bytes

    @property
    @abstractmethod
    def _is_open(self) -> bool:
        """Whether frames can be written."""

    @abstractmethod
    def _require_replaceable(self) -> None:
        """Raise if the path is something other than an older cube."""

    @abstractmethod
    def _create(self) -> None:
        """Create the empty partial file or folder."""

    @abstractmethod
    def _open(self) -> None:
        """Open the partial cube and define all variables."""

    @abstractmethod
    def _array(self, name: str) -> Any:
        """Return the array-like object that stores the values of a variable."""

    @abstractmethod
    def _attribute_names(self) -> Collection[str]:
        """Return the names of the global attributes."""

    @abstractmethod
    def _add_attributes(self, attributes: Mapping[str, Attribute]) -> None:
        """Add global attributes."""

    @abstractmethod
    def _finish(self) -> None:
        """Mark the cube as finished and rename it."""

    @abstractmethod
    def _discard(self) -> None:
        """Remove the partial file or folder, if it exists."""


MAX_WAITING = 2
"""Number of frames in the queue, including the one being written."""

MAX_WAITING_BYTES = 256 * 2**20
"""Larger frames are queued one at a time: memory then holds two, one being computed and one being written."""


def _stored(spec: VariableSpec, values: NDArray[Any]) -> NDArray[Any]:
    return values if spec.packing is None else packed(values, spec.packing)


class BackgroundWriter:
    """Context manager that writes frames in the background while the next ones are computed.

    One thread calls the writer, frame by frame; no other code may call it, or any netCDF function, between
    the first frame and the end of the block, because the library is not thread safe. An exception of the
    writer is raised by the next :meth:`write_frame` or at the end of the block. If the block raises an
    exception, only the frame being written is completed.

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
        """Queue a frame, waiting while the queue is full; the arrays must not be modified afterwards.

        Raises
        ------
        CubeError
            If an earlier frame could not be written.
        """
        self._hand_over(frame_bytes(arrays), self._writer.write_frame, index, arrays)

    def write_tile(self, index: int, region: tuple[slice, slice] | None, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Queue a part of a frame, like :meth:`write_frame`."""
        self._hand_over(frame_bytes(arrays), self._writer.write_tile, index, region, arrays)

    def write_frames(self, first: int, frames: Sequence[Mapping[str, NDArray[Any]]]) -> None:
        """Queue consecutive whole frames, like :meth:`write_frame`."""
        self._hand_over(sum(map(frame_bytes, frames)), self._writer.write_frames, first, frames)

    def _hand_over(self, size: int, write: Callable[..., None], *arguments: Any) -> None:
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
        """Discard queued frames and return when the thread is idle, even if the user interrupts repeatedly."""
        interrupted: KeyboardInterrupt | None = None
        while True:
            try:
                for task in self._waiting:
                    task.cancel()
                # the single thread runs tasks in order, so it is idle after this one
                self._thread.submit(_nothing).result()
                break
            except KeyboardInterrupt as again:
                interrupted = again
        self._thread.shutdown(wait=False)
        if interrupted is not None:
            raise interrupted


def frame_bytes(arrays: Mapping[str, NDArray[Any]]) -> int:
    """Return the size of the arrays of a frame."""
    return sum(array.nbytes for array in arrays.values())


def _nothing() -> None:
    pass
