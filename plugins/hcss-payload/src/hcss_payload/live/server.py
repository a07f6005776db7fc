"""Server of live frames: takes the newest pose and commands, and publishes frames in shared memory and by sockets."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.checks import PayloadError
from hcss_payload.live.folder_watch import FolderWatch
from hcss_payload.live.gateway import Gateway, Request, image_fields
from hcss_payload.live.messages import (
    AssimilateCommand,
    DescribeCommand,
    ElementsCommand,
    PoseCommand,
    StopCommand,
    command_of,
)
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
    gateway : Gateway, optional
        Sockets for commands and frames; closed with the server.
    images : FolderWatch, optional
        Whose new files the scene assimilates.

    Attributes
    ----------
    cost : FrameCost or None
        What a frame takes; None until a first one, which compiles, has been computed.
    """

    cost: FrameCost | None = None

    def __init__(
        self,
        live: PreparedPass,
        name: str,
        slots: int = 4,
        parent: int | None = None,
        gateway: Gateway | None = None,
        images: FolderWatch | None = None,
    ) -> None:
        self._live, self._parent, self._gateway, self._images = live, parent, gateway, images
        bands, rows, columns = live.shape
        dtype = np.dtype(np.uint16 if live.has_numbers else np.float32)
        self._ring = Ring.create(name, RingShape(slots, bands, rows, columns, dtype), os.getpid())
        self._radiance = np.empty(live.shape, np.float32) if live.has_numbers else None
        self._stopped, self._number = False, 0
        self._elements: list[PointTarget] | None = None
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
        if self._gateway is not None:
            self._gateway.close()
        self._ring.close(delete=True)
        self._live.close()

    def _stop(self, number: int, frame: FrameType | None) -> None:
        self._stopped = True

    def _loop(self) -> None:
        # The first letter may come before this line: clients write as soon as they see that the server is ready.
        ring, header, last = self._ring, self._ring.header, 0
        busy, looked = time.monotonic(), 0.0
        while not self._stopped and not int(header["stop"]):
            request = None if self._gateway is None else self._gateway.receive()
            if request is not None:
                self._answer(request)
            letter = ring.newest(last)
            now = time.monotonic()
            if now - looked > LOOK_S:
                looked = now
                if self._parent is not None and os.getppid() != self._parent:
                    return
                self._follow(now)
            if request is not None or letter is not None:
                busy = now
            elif now - busy > SPIN_S:
                time.sleep(NAP_S if now - busy < IDLE_S else LONG_NAP_S)
            if letter is None:
                continue
            header["skipped"] += np.uint64(max(0, (letter.sequence - last) % NUMBERS // 2 - 1))
            last = letter.sequence
            try:
                self._open(letter)
            except (HcssError, ArithmeticError, ValueError) as error:  # whatever numbers a client sends
                header["refused_pose"] = letter.pose_number
                header["refused"] += np.uint64(1)
                self._refusals.add(letter.pose_number, error)

    def _follow(self, now_s: float) -> None:
        """Let the scene assimilate new images, and say which ones it could not."""
        for path in () if self._images is None else self._images.new(now_s):
            self._live.assimilate(None, file=str(path))
        for refusal in self._live.look():
            with suppress(OSError):  # nobody reads it
                print(refusal, file=sys.stderr, flush=True)

    def _open(self, letter: Letter) -> None:
        if letter.target_count > MOST_TARGETS:
            raise PayloadError(f"targets: {letter.target_count}; allowed: up to {MOST_TARGETS}")
        posted = None if letter.target_count < 0 else letter.targets
        targets = None if posted is None else [PointTarget.of_values(target.tolist()) for target in posted]
        self._show(letter.values, letter.pose_number, targets)

    def _answer(self, request: Request) -> None:
        """Do what a message asks for, and reply; what is wrong with it is the reply, too."""
        assert self._gateway is not None
        image = None
        try:
            fields, image = self._obey(request)
        except (HcssError, ArithmeticError, ValueError) as error:
            fields = {"error": type(error).__name__, "message": str(error)}
        self._gateway.reply(request, fields, image)

    def _obey(self, request: Request) -> tuple[Mapping[str, Any], NDArray[Any] | None]:
        """Return fields and image of the reply to a message."""
        command = command_of(request.parts)
        match command:
            case PoseCommand():
                return self._show(command.values(), command.pose_number, command.point_targets())
            case ElementsCommand():
                targets = command.point_targets()
                for target in targets or ():
                    target.require_bands(self._live.shape[0])
                self._elements = targets
                return {"targets": None if targets is None else len(targets)}, None
            case AssimilateCommand():
                if not Path(command.file).is_file():
                    raise PayloadError(f"file: '{command.file}' is no file; allowed: one with an image")
                return {"state_number": self._live.assimilate(None, begins_s=command.begins_s, file=command.file)}, None
            case DescribeCommand():
                return self._description(), None
            case StopCommand():
                self._stopped = True
                return {"stopping": True}, None

    def _description(self) -> dict[str, Any]:
        names = ("frames", "skipped", "refused", "stalls", "state_number")
        return {
            "memory": self._ring.memory.name,
            "shape": list(self._live.shape),
            "type": self._ring.shape.dtype.name,
            "start_s": self._live.start_s,
            "end_s": self._live.end_s,
            "method": self._live.method,
            "states": [asdict(state) for state in self._live.states],
            **{name: int(self._ring.header[name]) for name in names},
        }

    def _show(
        self, values: NDArray[np.float64], pose_number: int, targets: Sequence[PointTarget] | None
    ) -> tuple[dict[str, Any], NDArray[Any]]:
        """Compute and publish the frame of a pose (8,); return what readers of sockets get."""
        pose = Pose(float(values[0]), values[1:4], values[4:])
        number, targets = self._number, self._elements if targets is None else targets
        image = self._ring.begin(number)
        if self._radiance is None:
            self._live.frame(pose.time_s, pose, image, targets)  # type: ignore[arg-type]
        else:
            frame = self._live.frame(pose.time_s, pose, self._radiance, targets)
            np.copyto(image, frame.digital_number, casting="unsafe")  # type: ignore[arg-type]
        published_ns = time.monotonic_ns()
        state = self._live.state_number
        self._ring.publish(number, pose_number, values, published_ns, state)
        self._ring.header["stalls"] = self._live.stalls
        self._number += 1
        fields = {"frame": number, "pose_number": pose_number, "time_s": pose.time_s, "state_number": state}
        fields |= image_fields(image)
        if self._gateway is not None:
            self._gateway.publish(fields | {"published_ns": published_ns}, image)
        return fields, image


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
