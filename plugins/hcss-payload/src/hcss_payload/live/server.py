"""Server of live frames: takes the newest pose, and publishes its frame in shared memory."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from types import FrameType

import numpy as np
from numpy.typing import NDArray

from hcss_payload.live.ring import Ring, RingShape
from hcss_payload.live.target import PointTarget
from hcss_payload.live.twin import PreparedPass
from hcss_payload.pose import Pose
from hcss_twin.errors import HcssError

SPIN_S, NAP_S, LOOK_S = 2e-3, 5e-5, 0.5
"""Time for which a server looks for poses without pause after a frame, its pauses, and time between two looks for its
parent."""

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
    """

    def __init__(self, live: PreparedPass, name: str, slots: int = 4, parent: int | None = None) -> None:
        self._live, self._parent = live, parent
        bands, rows, columns = live.shape
        dtype = np.dtype(np.uint16 if live.has_numbers else np.float32)
        self._ring = Ring.create(name, RingShape(slots, bands, rows, columns, dtype), os.getpid())
        self._radiance = np.empty(live.shape, np.float32) if live.has_numbers else None
        self._stopped = False

    def serve(self, ready: Callable[[], None]) -> None:
        """Serve until SIGTERM, SIGINT, the client's stop, or the end of the parent; then delete the memory."""
        before = {each: signal.signal(each, self._stop) for each in (signal.SIGTERM, signal.SIGINT)}
        try:
            self._ring.header["ready"] = 1
            ready()
            self._loop()
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
            self.close()

    def close(self) -> None:
        """Delete the memory and end the threads."""
        self._ring.close(delete=True)
        self._live.close()

    def _stop(self, number: int, frame: FrameType | None) -> None:
        self._stopped = True

    def _loop(self) -> None:
        ring, header, last, number = self._ring, self._ring.header, 0, 0
        busy, looked = time.monotonic(), 0.0
        while not self._stopped and not int(header["stop"]):
            posted = ring.newest(last)
            now = time.monotonic()
            if now - looked > LOOK_S:
                looked = now
                if self._parent is not None and os.getppid() != self._parent:
                    return
            if posted is None:
                if now - busy > SPIN_S:
                    time.sleep(NAP_S if now - busy < IDLE_S else LONG_NAP_S)
                continue
            busy = now
            pose_number, values, targets = posted
            header["skipped"] += np.uint64(pose_number - last - 1)
            last = pose_number
            try:
                self._make(number, pose_number, values, targets)
            except HcssError as error:
                header["refused"] += np.uint64(1)
                print(f"pose {pose_number}: {error}", file=sys.stderr, flush=True)
                continue
            number += 1
            header["stalls"] = self._live.stalls

    def _make(
        self, number: int, pose_number: int, values: NDArray[np.float64], posted: NDArray[np.float64] | None
    ) -> None:
        pose = Pose(float(values[0]), values[1:4], values[4:])
        targets = None if posted is None else [PointTarget.of_values(each.tolist()) for each in posted]
        target = self._ring.begin(number)
        if self._radiance is None:
            self._live.frame(pose.time_s, pose, target, targets)  # type: ignore[arg-type]
        else:
            frame = self._live.frame(pose.time_s, pose, self._radiance, targets)
            np.copyto(target, frame.digital_number, casting="unsafe")  # type: ignore[arg-type]
        self._ring.publish(number, pose_number, values, time.monotonic_ns())
