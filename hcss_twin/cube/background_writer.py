"""Frames written by a thread of their own, while the next are computed."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import Any, Self

from numpy.typing import NDArray

from hcss_twin.cube.streamed_writer import StreamedWriter

MAX_WAITING = 2
"""Frames handed over and not yet on their way to the disk, the one being written included."""

MAX_WAITING_BYTES = 256 * 2**20
"""Larger frames wait alone, so that memory stays that of two frames: one made and one written."""


class BackgroundWriter:
    """Context manager that hands frames to the writer of a cube in the order given.

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
