"""Frames and poses in shared memory: a ring of frames with sequence numbers, and a letter box for poses.

A writer makes a sequence number odd, writes, and makes it even; a reader copies and looks whether the number is even
and unchanged. Nobody ever waits for a lock, so a process that dies leaves the others alone: the next writer begins with
the next odd number. Numbers of poses are labels that clients choose; the sequence number of the letter box alone says
that there is a new one. The order of writes is that of processors of the kinds x86-64, which keep it; on others a
reader may see half a frame in rare cases. ``include/hcss_ring.h`` has the same layout for C and C++.
"""

from __future__ import annotations

import shutil
import sys
from dataclasses import dataclass
from multiprocessing import resource_tracker, shared_memory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.checks import PayloadError, require_within
from hcss_payload.pose import Pose

MAGIC = 0x68637373_6C697665
VERSION = 4

MOST_SLOTS = 1024

MOST_TARGETS, MOST_BANDS = 64, 16
"""Targets of a frame that a letter holds, and their bands."""

TARGET_VALUES = 6
"""Values of a target before its intensities: latitude, longitude, altitude, velocity toward east, north and up."""

TYPES = (np.dtype(np.float32), np.dtype(np.uint16))

HEADER = np.dtype(
    [
        *((name, np.uint64) for name in ("magic", "version", "slots", "bands", "rows", "columns", "type", "pid")),
        *((name, np.uint64) for name in ("frames", "skipped", "refused", "stalls", "ready", "stop")),
        *((name, np.uint64) for name in ("refused_pose", "state_number", "letter", "pose_number")),
        ("pose", np.float64, 8),
        ("targets", np.int64),
        ("target", np.float64, (MOST_TARGETS, TARGET_VALUES + MOST_BANDS)),
    ]
)
SLOT = np.dtype(
    [
        *((name, np.uint64) for name in ("sequence", "number", "pose_number", "state_number")),
        ("pose", np.float64, 8),
        ("published_ns", np.int64),
    ]
)
_FOLDER = "/dev/shm"
"""Where Linux has shared memory."""

_LINE = 64
"""Bytes to which parts are aligned."""

_TRIES = 1000

NUMBERS = 2**64
"""Numbers of poses and letters, after which they begin again."""


def is_later(number: int, than: int) -> bool:
    """Return whether a number follows another one, or is the same, in a count that begins again at ``NUMBERS``."""
    return (number - than) % NUMBERS < NUMBERS // 2


@dataclass(frozen=True)
class Letter:
    """What a client posted.

    Attributes
    ----------
    sequence : int
        Of the letter box; it grows by 2 with each letter.
    pose_number : int
        The client's label.
    values : ndarray (8,)
        Time, position and quaternion.
    target_count : int
        Of targets; -1: those of the server.
    targets : ndarray (N, 6 + bands)
        As many of them as the letter box holds.
    """

    sequence: int
    pose_number: int
    values: NDArray[np.float64]
    target_count: int
    targets: NDArray[np.float64]


@dataclass(frozen=True)
class RingShape:
    """Number of frames, and their bands, rows, columns and type."""

    slots: int
    bands: int
    rows: int
    columns: int
    dtype: np.dtype[Any]

    def __post_init__(self) -> None:
        require_within("slots", self.slots, 4, MOST_SLOTS)

    @property
    def frame_bytes(self) -> int:
        """Bytes of one frame."""
        return self.bands * self.rows * self.columns * self.dtype.itemsize

    @property
    def size(self) -> int:
        """Bytes of the memory."""
        return _up(HEADER.itemsize) + self.slots * (_up(SLOT.itemsize) + _up(self.frame_bytes))


def _up(size: int) -> int:
    return -(-size // _LINE) * _LINE


class Ring:
    """Shared memory of a server and its clients.

    Attributes
    ----------
    frames : list of ndarray (bands, rows, columns)
        The frames of the ring.
    """

    def __init__(self, memory: shared_memory.SharedMemory, shape: RingShape) -> None:
        self.memory, self.shape = memory, shape
        self.header = np.ndarray((), HEADER, memory.buf)
        self.slots: list[dict[str, NDArray[Any]]] = []
        self.frames: list[NDArray[Any]] = []
        start = _up(HEADER.itemsize)
        for _ in range(shape.slots):
            slot = np.ndarray((), SLOT, memory.buf, start)
            self.slots.append({name: slot[name] for name in SLOT.names or ()})  # a look-up by name takes long
            start += _up(SLOT.itemsize)
            self.frames.append(np.ndarray((shape.bands, shape.rows, shape.columns), shape.dtype, memory.buf, start))
            start += _up(shape.frame_bytes)

    @classmethod
    def create(cls, name: str, shape: RingShape, pid: int) -> Ring:
        """Create the memory; the process that creates it deletes it.

        Raises
        ------
        PayloadError
            If the name is in use, or there is no such memory.
        """
        memory = _create(name, shape.size)
        ring = cls(memory, shape)
        values = (shape.slots, shape.bands, shape.rows, shape.columns, TYPES.index(shape.dtype), pid)
        for field, value in zip(("slots", "bands", "rows", "columns", "type", "pid"), values, strict=True):
            ring.header[field] = value
        ring.header["version"] = VERSION
        ring.header["magic"] = MAGIC
        return ring

    @staticmethod
    def require_name(name: str) -> None:
        """Raise a :class:`PayloadError` unless shared memory of a name can be created now."""
        memory = _create(name, _LINE)
        memory.close()
        memory.unlink()

    @classmethod
    def attach(cls, name: str) -> Ring:
        """Open the memory of a server.

        Raises
        ------
        FileNotFoundError
            If there is none.
        PayloadError
            If it is not that of a server of this version.
        """
        memory = attached(name)
        shape = _shape_in(memory)
        if shape is None:
            memory.close()
            raise PayloadError(f"name: '{name}' is not the memory of a server of this version; allowed: `hcss serve`'s")
        return cls(memory, shape)

    def post(self, pose: Pose, targets: NDArray[np.float64] | None = None) -> int:
        """Put a pose into the letter box, in place of one that is there, and return its number; for one client.

        Parameters
        ----------
        targets : ndarray (N, 6 + bands), optional
            Those of its frame; by default the server's.
        """
        header = self.header
        number = (int(header["pose_number"]) + 1) % NUMBERS
        # The next odd number, also after a client that died while it wrote.
        writing = ((int(header["letter"]) + 1) | 1) % NUMBERS
        header["letter"] = writing
        header["pose"][0] = pose.time_s
        header["pose"][1:4] = pose.position_m
        header["pose"][4:] = pose.quaternion
        header["targets"] = -1 if targets is None else len(targets)
        if targets is not None:
            header["target"][: len(targets), : targets.shape[1]] = targets
        header["pose_number"] = number
        header["letter"] = (writing + 1) % NUMBERS
        return number

    def newest(self, after: int) -> Letter | None:
        """Return what is in the letter box; None if it is what had a sequence number, or is being written."""
        header = self.header
        for _ in range(_TRIES):
            before = int(header["letter"])
            if before == after:
                return None
            number, values, count = int(header["pose_number"]), header["pose"].copy(), int(header["targets"])
            targets = header["target"][: max(0, min(count, MOST_TARGETS)), : TARGET_VALUES + self.shape.bands].copy()
            if before % 2 == 0 and int(header["letter"]) == before:
                return Letter(before, number, values, count, targets)
        return None

    def publish(
        self, number: int, pose_number: int, pose: NDArray[np.float64], published_ns: int, state_number: int = 0
    ) -> None:
        """Make the frame of a slot visible, whose writing :meth:`begin` announced."""
        slot = self.slots[number % self.shape.slots]
        slot["number"][...], slot["pose_number"][...], slot["published_ns"][...] = number, pose_number, published_ns
        slot["state_number"][...] = self.header["state_number"] = state_number
        slot["pose"][:] = pose
        slot["sequence"] += np.uint64(1)
        self.header["frames"] = number + 1

    def begin(self, number: int) -> NDArray[np.float32] | NDArray[np.uint16]:
        """Announce the writing of a frame, and return where to."""
        slot = self.slots[number % self.shape.slots]
        if int(slot["sequence"]) % 2 == 0:  # odd after a frame that failed
            slot["sequence"] += np.uint64(1)
        frame: NDArray[np.float32] = self.frames[number % self.shape.slots]
        return frame

    def close(self, delete: bool) -> None:
        """Let go of the memory, and delete it for all."""
        del self.header
        self.slots.clear()
        self.frames.clear()
        self.memory.close()
        if delete:
            self.memory.unlink()


def attached(name: str) -> shared_memory.SharedMemory:
    """Return shared memory that another process deletes."""
    if sys.version_info >= (3, 13):
        return shared_memory.SharedMemory(name, track=False)
    memory = shared_memory.SharedMemory(name)
    # Otherwise the end of this process would delete the memory of the other.
    resource_tracker.unregister(memory._name, "shared_memory")  # type: ignore[attr-defined]
    return memory


def _create(name: str, size: int) -> shared_memory.SharedMemory:
    """Create shared memory; raises :class:`PayloadError`."""
    try:
        free = shutil.disk_usage(_FOLDER).free
    except OSError:  # of this system it is somewhere else, or missing
        free = size
    if free < size:
        # Without this, writing to a page that does not exist would kill the process.
        raise PayloadError(
            f"name: {size / 2**20:.3g} MiB of shared memory are needed, and {_FOLDER} has {free / 2**20:.3g} MiB; "
            "allowed: fewer --slots, or more memory (for containers --shm-size)"
        )
    try:
        return shared_memory.SharedMemory(name, create=True, size=size)
    except FileExistsError as error:
        raise PayloadError(f"name: '{name}' is in use; allowed: the name of no other shared memory") from error
    except (OSError, ValueError) as error:
        raise PayloadError(
            f"name: shared memory cannot be created as '{name}': {error}; allowed: a plain name, and a system with "
            f"shared memory ({_FOLDER} on Linux) that may be written"
        ) from error


def _shape_in(memory: shared_memory.SharedMemory) -> RingShape | None:
    """Return the shape of a server's ring; None if the memory is not one of this version."""
    if memory.size < HEADER.itemsize:
        return None
    header = np.ndarray((), HEADER, memory.buf)
    if int(header["magic"]) != MAGIC or int(header["version"]) != VERSION or int(header["type"]) >= len(TYPES):
        return None
    slots, bands, rows, columns = (int(header[key]) for key in ("slots", "bands", "rows", "columns"))
    if not 4 <= slots <= MOST_SLOTS:
        return None
    shape = RingShape(slots, bands, rows, columns, TYPES[int(header["type"])])
    return shape if shape.size <= memory.size else None
