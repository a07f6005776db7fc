"""Server of live frames: takes the newest pose, and publishes its frame in shared memory."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from types import FrameType

import numpy as np

from hcss_payload.checks import PayloadError
from hcss_payload.live.prepared_pass import FrameCost, PreparedPass
from hcss_payload.live.ring import MOST_TARGETS, NUMBERS, Letter, Ring, RingShape
from hcss_payload.live.target import PointTarget
from hcss_payload.pose import Pose
from hcss_twin.providers import HcssError

SPIN_S, NAP_S, LOOK_S = 2e-3, 5e-5, 0.5
"""Time for which a server looks for poses without pause after a frame, its pauses, and time between two looks for its
parent."""

QUIET_S = 5.0
"""Least time between two lines about refused poses."""

IDLE_S, LONG_NAP_S = 1.0, 2e-3
"""Time after a frame from which on pauses are long."""


class Server:
    """Publishes frames until it is told to stop.

    Parameters
    ----------
    live : PreparedPass
        The frames; closed with the server.
    name : str
        Of the shared memory.
    slots : int
        Frames in the ring.
    parent : int, optional
        Process with whose end the server ends, if that has started this one.

    Attributes
    ----------
    cost : FrameCost or None
        What a frame takes; None until a first one, which compiles, has been computed.
    """

    cost: FrameCost | None = None

    def __init__(self, live: PreparedPass, name: str, slots: int = 4, parent: int | None = None) -> None:
        self._live, self._parent = live, parent
        bands, rows, columns = live.shape
        dtype = np.dtype(np.uint16 if live.has_numbers else np.float32)
        self._ring = Ring.create(name, RingShape(slots, bands, rows, columns, dtype), os.getpid())
        self._radiance = np.empty(live.shape, np.float32) if live.has_numbers else None
        self._stopped = False
        self._refusals = _Refusals()

    def serve(self, ready: Callable[[], None]) -> None:
        """Serve until SIGTERM, SIGINT, the client's stop, or the end of the parent; then delete the memory."""
        before = {number: signal.signal(number, self._stop) for number in (signal.SIGTERM, signal.SIGINT)}
        try:
            self.cost = self._live.warm_up(self._radiance)
            self._ring.header["ready"] = 1
            ready()
            self._loop()
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
            self.close()

    def close(self) -> None:
        """Delete the memory and end the threads."""
        self._ring.header["ready"] = 0  # for clients that wait
        self._refusals.close()
        self._ring.close(delete=True)
        self._live.close()

    def _stop(self, number: int, frame: FrameType | None) -> None:
        self._stopped = True

    def _loop(self) -> None:
        # The first letter may come before this line: clients write as soon as they see that the server is ready.
        ring, header, last, number = self._ring, self._ring.header, 0, 0
        busy, looked = time.monotonic(), 0.0
        while not self._stopped and not int(header["stop"]):
            letter = ring.newest(last)
            now = time.monotonic()
            if now - looked > LOOK_S:
                looked = now
                if self._parent is not None and os.getppid() != self._parent:
                    return
            if letter is None:
                if now - busy > SPIN_S:
                    time.sleep(NAP_S if now - busy < IDLE_S else LONG_NAP_S)
                continue
            busy = now
            header["skipped"] += np.uint64(max(0, (letter.sequence - last) % NUMBERS // 2 - 1))
            last = letter.sequence
            try:
                self._make(number, letter)
            except (HcssError, ArithmeticError, ValueError) as error:  # whatever numbers a client sends
                header["refused_pose"] = letter.pose_number
                header["refused"] += np.uint64(1)
                self._refusals.add(letter.pose_number, error)
                continue
            number += 1
            header["stalls"] = self._live.stalls

    def _make(self, number: int, letter: Letter) -> None:
        values = letter.values
        if letter.target_count > MOST_TARGETS:
            raise PayloadError(f"targets: {letter.target_count}; allowed: up to {MOST_TARGETS}")
        posted = None if letter.target_count < 0 else letter.targets
        pose = Pose(float(values[0]), values[1:4], values[4:])
        targets = None if posted is None else [PointTarget.of_values(values.tolist()) for values in posted]
        target = self._ring.begin(number)
        if self._radiance is None:
            self._live.frame(pose.time_s, pose, target, targets)  # type: ignore[arg-type]
        else:
            frame = self._live.frame(pose.time_s, pose, self._radiance, targets)
            np.copyto(target, frame.digital_number, casting="unsafe")  # type: ignore[arg-type]
        self._ring.publish(number, letter.pose_number, values, time.monotonic_ns())


class _Refusals:
    """Lines on standard error about refused poses: of the first, then at most one in some seconds, with their count."""

    def __init__(self) -> None:
        self._said_s, self._silent, self._last = -np.inf, 0, ""

    def add(self, pose_number: int, error: Exception) -> None:
        """Count a refused pose, and say so unless a line was written shortly before."""
        self._last = f"pose {pose_number}: {error}"
        if time.monotonic() - self._said_s < QUIET_S:
            self._silent += 1
            return
        self._say()

    def close(self) -> None:
        """Say how many there were since the last line."""
        if self._silent:
            self._silent -= 1  # the last of them is named
            self._say()

    def _say(self) -> None:
        more = f" (and {self._silent} more before it)" if self._silent else ""
        self._said_s, self._silent = time.monotonic(), 0
        with suppress(OSError):  # nobody reads them
            print(f"{self._last}{more}", file=sys.stderr, flush=True)
