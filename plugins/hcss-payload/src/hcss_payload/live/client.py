"""Client of `hcss serve`: sends poses, and reads frames from shared memory."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from hcss_payload.checks import PayloadError, require_within
from hcss_payload.live.ring import MOST_BANDS, MOST_TARGETS, TARGET_VALUES, Ring, is_later
from hcss_payload.live.target import PointTarget
from hcss_payload.pose import Pose

_NAP_S, _SPIN_S, _BLIND_S = 5e-5, 2e-3, 2e-3
"""Shortest pause, time around that of usual frames in which a client looks without pause, and longest pause."""

_EARLY = 0.8
"""Share of the least time of recent frames after which a client looks without pause."""

_RECENT = 8
"""Frames among which the least time is taken: after a stall of one, the others say how long frames take."""

_PATIENT = 0.01
"""Longer waits make longer pauses: this share of them."""

_TRIES = 100


@dataclass(frozen=True, eq=False)
class ServedFrame:
    """A frame of the server.

    Attributes
    ----------
    number, pose_number : int
        Of the frame, from 0, and of the pose that :meth:`LiveClient.send_pose` returned; after 2^64 - 1 follows 0.
    pose_values : ndarray (8,)
        Time, position and quaternion of the pose.
    image : ndarray of float32 or uint16 (bands, rows, columns)
        Radiance, or digital numbers of a sensor with a converter.
    published_ns : int
        When the server had it, on the clock ``time.monotonic_ns``.
    state_number : int
        How many images the scene has assimilated; 0: the scenario alone.
    """

    number: int
    pose_number: int
    pose_values: NDArray[np.float64]
    image: NDArray[np.float32] | NDArray[np.uint16]
    published_ns: int
    state_number: int = 0

    @property
    def time_s(self) -> float:
        """Time of the pose."""
        return float(self.pose_values[0])

    @cached_property
    def pose(self) -> Pose:
        """The pose, whose checks take as long as the hand-over of the frame."""
        return Pose(self.time_s, self.pose_values[1:4], self.pose_values[4:])


class LiveClient:
    """Connection to a server; use it in a ``with`` block. One client at a time may send poses.

    Parameters
    ----------
    name : str
        Of the shared memory, as ``hcss serve --name``.
    timeout_s : float
        Time to wait until the server is ready.

    Raises
    ------
    PayloadError
        If there is no server by then.
    """

    def __init__(self, name: str, timeout_s: float = 60.0) -> None:
        self._recent_s: deque[float] = deque(maxlen=_RECENT)
        self._refused_before = 0
        until = time.monotonic() + timeout_s
        while True:
            try:
                self._ring = Ring.attach(name)
                if int(self._ring.header["ready"]):
                    break
                self._ring.close(delete=False)
                why: object = "it is not ready yet"
            except (OSError, PayloadError, ValueError) as error:  # no memory, or not yet filled
                why = error
            if time.monotonic() >= until:
                raise PayloadError(
                    f"name: no server '{name}' ({why}) within {timeout_s:g} s; allowed: a running `hcss serve`, which "
                    "may compile for minutes before it is ready"
                )
            time.sleep(0.02)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Bands, rows and columns of frames."""
        return self._ring.shape.bands, self._ring.shape.rows, self._ring.shape.columns

    def send_pose(self, pose: Pose, targets: Sequence[PointTarget] | None = None) -> int:
        """Ask for the frame of a pose, in place of poses that the server has not begun; return the pose's number.

        Parameters
        ----------
        targets : sequence of PointTarget, optional
            Those of this frame, without a temperature and no higher than ``hcss serve --highest-target``.

        Raises
        ------
        PayloadError
            If there are too many, or they have no intensity in some band.
        """
        self._refused_before = int(self._ring.header["refused"])
        if targets is None:
            return self._ring.post(pose)
        bands = self._ring.shape.bands
        require_within("targets", len(targets), 0, MOST_TARGETS)
        require_within("bands of targets", bands, 1, MOST_BANDS)
        values = np.array([target.values(bands) for target in targets]).reshape(len(targets), TARGET_VALUES + bands)
        return self._ring.post(pose, values)

    def latest(self, out: NDArray[np.float32] | NDArray[np.uint16] | None = None) -> ServedFrame | None:
        """Return a copy of the newest frame; None if there is none yet.

        Parameters
        ----------
        out : ndarray of the shape and type of frames, optional
            Where the image is written; by default a new array.
        """
        ring = self._ring
        for _ in range(_TRIES):
            count = int(ring.header["frames"])
            if count == 0:
                return None
            slot, frame = ring.slots[(count - 1) % ring.shape.slots], ring.frames[(count - 1) % ring.shape.slots]
            before = int(slot["sequence"])
            if before % 2 == 0:
                image = np.empty_like(frame) if out is None else out
                np.copyto(image, frame, casting="no")
                values = slot["pose"].copy()
                names = ("number", "pose_number", "published_ns", "state_number")
                number, pose_number, published, state = (int(slot[name]) for name in names)
                if int(slot["sequence"]) == before:
                    return ServedFrame(number, pose_number, values, image, published, state)
        raise PayloadError("latest: frames are written faster than read; allowed: `--slots` for more of them")

    def wait(
        self, pose_number: int, timeout_s: float = 60.0, out: NDArray[np.float32] | NDArray[np.uint16] | None = None
    ) -> ServedFrame:
        """Return the newest frame as soon as it is that of a pose, or of a later one; ``out`` as for :meth:`latest`.

        Raises
        ------
        PayloadError
            If the server has refused the pose, or a later one in its place, or has ended.
        TimeoutError
            If there is none in time.
        """
        start, ring = time.monotonic(), self._ring
        usual_s = min(self._recent_s, default=0.0)
        while True:
            count = int(ring.header["frames"])
            if count and is_later(int(ring.slots[(count - 1) % ring.shape.slots]["pose_number"]), pose_number):
                frame = self.latest(out)
                if frame is not None and is_later(frame.pose_number, pose_number):
                    self._recent_s.append(time.monotonic() - start)
                    return frame
            waited = time.monotonic() - start
            self._require_hope(pose_number)
            if waited > timeout_s:
                raise TimeoutError(f"no frame of pose {pose_number} within {timeout_s:g} s; counts: {self.counts()}")
            # Leaves the processor to others, but looks without pause around the time that frames take; a pause is
            # always short, since the next frame may be faster than any before.
            early = _EARLY * usual_s - waited
            if early > 0.0:
                time.sleep(min(early, _BLIND_S))
            elif waited > usual_s + _SPIN_S:
                time.sleep(min(max(_NAP_S, _PATIENT * waited), _BLIND_S))

    def _require_hope(self, pose_number: int) -> None:
        header = self._ring.header
        if not int(header["ready"]):
            raise PayloadError(f"wait: the server ended before the frame of pose {pose_number}; allowed: a running one")
        refused = int(header["refused_pose"])
        if int(header["refused"]) > self._refused_before and is_later(refused, pose_number):
            raise PayloadError(
                f"wait: pose {pose_number} was refused, or {refused} in its place; allowed: what `hcss serve` says on "
                "standard error"
            )

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
