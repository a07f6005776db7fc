"""Client of `hcss serve`: sends poses, and reads frames from shared memory."""

from __future__ import annotations

import time
from dataclasses import dataclass
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from hcss_payload.checks import PayloadError
from hcss_payload.live.ring import Ring
from hcss_payload.pose import Pose

_NAP_S, _SPIN_S = 5e-5, 2e-3
_TRIES = 100


@dataclass(frozen=True, eq=False)
class ServedFrame:
    """A frame of the server.

    Attributes
    ----------
    number, pose_number : int
        Of the frame, from 0, and of the pose that :meth:`LiveClient.send_pose` returned.
    time_s : float
        Of the pose.
    pose : Pose
    image : ndarray of float32 or uint16 (bands, rows, columns)
        Radiance, or digital numbers of a sensor with a converter.
    published_ns : int
        When the server had it, on the clock ``time.monotonic_ns``.
    """

    number: int
    pose_number: int
    time_s: float
    pose: Pose
    image: NDArray[np.float32] | NDArray[np.uint16]
    published_ns: int


class LiveClient:
    """Connection to a server; use it in a ``with`` block. One client at a time may send poses.

    Parameters
    ----------
    name : str
        Of the shared memory, as ``hcss serve --name``.
    timeout_s : float
        Time to wait for the server.

    Raises
    ------
    PayloadError
        If there is no server by then.
    """

    def __init__(self, name: str, timeout_s: float = 0.0) -> None:
        until = time.monotonic() + timeout_s
        while True:
            try:
                self._ring = Ring.attach(name)
            except (FileNotFoundError, PayloadError, ValueError) as error:  # no memory, or not yet filled
                if time.monotonic() >= until:
                    raise PayloadError(
                        f"name: no server '{name}' ({error}); allowed: a running `hcss serve`"
                    ) from error
            else:
                break
            time.sleep(0.02)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Bands, rows and columns of frames."""
        return self._ring.shape.bands, self._ring.shape.rows, self._ring.shape.columns

    def send_pose(self, pose: Pose) -> int:
        """Ask for the frame of a pose, in place of poses that the server has not begun; return the pose's number."""
        return self._ring.post(pose)

    def latest(self) -> ServedFrame | None:
        """Return a copy of the newest frame; None if there is none yet."""
        ring = self._ring
        for _ in range(_TRIES):
            count = int(ring.header["frames"])
            if count == 0:
                return None
            slot, frame = (each[(count - 1) % ring.shape.slots] for each in (ring.slots, ring.frames))
            before = int(slot["sequence"])
            if before % 2 == 0:
                image, values = frame.copy(), slot["pose"].copy()
                number, pose_number, published = (int(slot[n]) for n in ("number", "pose_number", "published_ns"))
                if int(slot["sequence"]) == before:
                    pose = Pose(float(values[0]), values[1:4], values[4:])
                    return ServedFrame(number, pose_number, pose.time_s, pose, image, published)
        raise PayloadError("latest: frames are written faster than read; allowed: `--slots` for more of them")

    def wait(self, pose_number: int, timeout_s: float = 1.0) -> ServedFrame:
        """Return the newest frame as soon as it is that of a pose, or of a later one.

        Raises
        ------
        TimeoutError
            If there is none in time.
        """
        start = time.monotonic()
        while True:
            count = int(self._ring.header["frames"])
            if count and int(self._ring.slots[(count - 1) % self._ring.shape.slots]["pose_number"]) >= pose_number:
                frame = self.latest()
                if frame is not None and frame.pose_number >= pose_number:
                    return frame
            waited = time.monotonic() - start
            if waited > timeout_s:
                raise TimeoutError(f"no frame of pose {pose_number} within {timeout_s:g} s; counts: {self.counts()}")
            if waited > _SPIN_S:
                time.sleep(_NAP_S)

    def counts(self) -> dict[str, int]:
        """Return numbers of frames, of poses that newer ones replaced, of refused poses, and of late tiles of sky."""
        return {name: int(self._ring.header[name]) for name in ("frames", "skipped", "refused", "stalls")}

    def stop_server(self) -> None:
        """Ask the server to end."""
        self._ring.header["stop"] = 1

    def close(self) -> None:
        """Let go of the memory."""
        self._ring.close(delete=False)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
