"""States of a scene and their keyframes, which processes of their own compute (:mod:`.keyframe_worker`)."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import threading
from multiprocessing import Pipe, shared_memory
from multiprocessing.connection import wait
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.checks import PayloadError
from hcss_payload.live.keyframe_worker import Failed, Ready, Setup, Wanted

SLOTS = 6
"""Keyframes of a state that are in memory: those around a frame, the next one, and some of frames before."""

_END_S = 5.0


class StateProcess:
    """One state of a scene, and the process that computes its keyframes.

    Parameters
    ----------
    number : int
        Of the state.
    setup : Setup
        Without memory.

    Attributes
    ----------
    ready : Ready or None
        None until its keyframes can be computed.
    failed : str
        Why they cannot.
    is_over : bool
        Whether another state has taken its place.
    frames : ndarray of float32 (SLOTS, B, rows, columns)
    """

    def __init__(self, number: int, setup: Setup) -> None:
        self.number, self.failed = number, ""
        self.ready: Ready | None = None
        self.is_over = False
        shape = (SLOTS, *setup.shape)
        self._memory = shared_memory.SharedMemory(create=True, size=4 * int(np.prod(shape)))
        self.frames: NDArray[np.float32] = np.ndarray(shape, np.float32, self._memory.buf)
        self._held = np.full(SLOTS, -1)
        self._asked = np.full(SLOTS, -1)
        self.connection, theirs = Pipe()
        command = "from hcss_payload.live.keyframe_worker import main; main()"
        self._process = subprocess.Popen(
            [sys.executable, "-c", command, str(theirs.fileno())], pass_fds=[theirs.fileno()]
        )
        theirs.close()
        setup = setup.with_memory(self._memory.name, SLOTS)
        # An image does not fit into the pipe, and the process reads it only when it has loaded its modules.
        threading.Thread(target=self._send, args=(setup,), daemon=True).start()

    def has(self, number: int) -> bool:
        """Return whether a keyframe is in memory."""
        return int(self._held[number % SLOTS]) == number

    def ask(self, number: int, time_s: float) -> None:
        """Let a keyframe be computed, unless it is there or on its way."""
        slot = number % SLOTS
        if number not in (int(self._held[slot]), int(self._asked[slot])):
            self._held[slot], self._asked[slot] = -1, number
            self._send(Wanted(number, time_s, slot))

    def keyframe(self, number: int) -> NDArray[np.float32]:
        """Return a keyframe that is in memory."""
        frame: NDArray[np.float32] = self.frames[number % SLOTS]
        return frame

    def receive(self) -> None:
        """Take what the process has sent."""
        try:
            while not self.failed and self.connection.poll():
                self._take(self.connection.recv())
        except (EOFError, OSError):
            self.failed = "its process ended"

    def _take(self, message: Ready | Wanted | Failed) -> None:
        match message:
            case Ready():
                self.ready = message
            case Failed():
                self.failed = message.error
            case Wanted():
                if int(self._asked[message.slot]) == message.number:
                    self._held[message.slot] = message.number

    def forget(self, from_slot: int) -> None:
        """Forget the keyframes of a slot and of those after it."""
        self._held[from_slot:] = self._asked[from_slot:] = -1

    def end(self) -> None:
        """Let the process end, and delete its memory, without waiting."""
        if self.is_over:
            return
        self.is_over = True
        if self.ready is None:
            self._process.terminate()
        else:
            self._send(None)
        del self.frames
        self._memory.close()
        self._memory.unlink()

    def close(self) -> None:
        """End, and wait until the process has."""
        self.end()
        try:
            self._process.wait(_END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self.connection.close()

    def _send(self, message: Any) -> None:
        with contextlib.suppress(OSError):
            self.connection.send(message)


def wait_for(states: list[StateProcess]) -> None:
    """Wait until a process has sent something.

    Raises
    ------
    PayloadError
        If one cannot compute its keyframes.
    """
    for state in states:
        if state.failed:
            raise PayloadError(f"keyframes: {state.failed}; allowed: a scene that frames of cubes show")
    wait([state.connection for state in states])
    for state in states:
        state.receive()
