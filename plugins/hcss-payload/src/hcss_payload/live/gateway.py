"""ZeroMQ sockets of a server: commands with replies, and frames for any number of readers, on this machine only.

Nobody who connects can hold up the server: it never waits for a socket, replies and frames for those who do not read
them are dropped, and what is no command is answered with an error.
"""

from __future__ import annotations

import importlib
import json
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_payload.checks import PayloadError

FRAMES_WAITING, REPLIES_WAITING = 4, 64
"""Frames and replies that wait for a slow reader; more are dropped."""

_REQUESTS = 64
"""Commands of one client that wait for the server; the client's socket then waits."""

_PART_BYTES = 2**20
"""Largest part of a message; whoever sends a larger one is disconnected."""

_LINGER_MS = 500

_TCP = re.compile(r"tcp://127\.0\.0\.1:([0-9]{1,5})")


@dataclass(frozen=True)
class Request:
    """A message of a client.

    Attributes
    ----------
    parts : tuple of bytes
    """

    parts: tuple[bytes, ...]
    _envelope: tuple[bytes, ...]


class Gateway:
    """Sockets at an endpoint.

    Parameters
    ----------
    endpoint : str
        Of commands: ``"ipc://PATH"`` or ``"tcp://127.0.0.1:PORT"``. Frames are at :attr:`frames_endpoint`.

    Attributes
    ----------
    frames_endpoint : str
        The path with ``-frames``, or the next port.

    Raises
    ------
    PayloadError
        If the endpoint is not on this machine, or in use, or pyzmq is missing.
    """

    def __init__(self, endpoint: str) -> None:
        self.frames_endpoint = frames_endpoint_of(endpoint)
        try:
            zmq: Any = importlib.import_module("zmq")
        except ImportError as error:
            raise PayloadError("zmq: pyzmq is missing; allowed: pip install 'hcss-payload[zmq]'") from error
        self._zmq = zmq
        self._context = zmq.Context()
        self._commands, self._frames = self._context.socket(zmq.ROUTER), self._context.socket(zmq.PUB)
        self._commands.setsockopt(zmq.RCVHWM, _REQUESTS)
        for socket, waiting in ((self._commands, REPLIES_WAITING), (self._frames, FRAMES_WAITING)):
            socket.setsockopt(zmq.SNDHWM, waiting)
            socket.setsockopt(zmq.LINGER, _LINGER_MS)
            socket.setsockopt(zmq.MAXMSGSIZE, _PART_BYTES)
        try:
            self._commands.bind(endpoint)
            self._frames.bind(self.frames_endpoint)
        except zmq.ZMQError as error:
            self.close()
            raise PayloadError(
                f"zmq: '{endpoint}' cannot be used: {error}; allowed: an address that no other program uses, in a "
                "folder that exists"
            ) from error

    def receive(self) -> Request | None:
        """Return the next message; None if there is none."""
        try:
            identity, *parts = self._commands.recv_multipart(self._zmq.NOBLOCK)
        except self._zmq.Again:
            return None
        # Sockets of the kind REQ put an empty part before the message, others need not.
        envelope = (identity, parts.pop(0)) if len(parts) > 1 and not parts[0] else (identity,)
        return Request(tuple(parts), envelope)

    def reply(self, request: Request, fields: Mapping[str, Any], image: NDArray[Any] | None = None) -> None:
        """Answer a message, unless its client has gone or does not read."""
        parts = [*request._envelope, json.dumps(fields).encode()]
        self._send(self._commands, parts if image is None else [*parts, image.tobytes()])

    def publish(self, fields: Mapping[str, Any], image: NDArray[Any]) -> None:
        """Give a frame to all that read."""
        self._send(self._frames, [b"frame", json.dumps(fields).encode(), image.tobytes()])

    def _send(self, socket: Any, parts: Sequence[bytes]) -> None:
        with suppress(self._zmq.ZMQError):
            socket.send_multipart(parts, self._zmq.NOBLOCK)

    def close(self) -> None:
        """Close the sockets, after what has been sent has gone out."""
        for socket in (self._commands, self._frames):
            socket.close()
        self._context.term()


def frames_endpoint_of(endpoint: str) -> str:
    """Return the address of frames beside that of commands.

    Raises
    ------
    PayloadError
        If the address is not one of this machine.
    """
    if endpoint.startswith("ipc://") and len(endpoint) > len("ipc://"):
        return f"{endpoint}-frames"
    found = _TCP.fullmatch(endpoint)
    if found is None or not 1 <= int(found[1]) <= 65534:
        raise PayloadError(
            f"zmq: '{endpoint}'; allowed: addresses of this machine alone, 'ipc://PATH' or 'tcp://127.0.0.1:PORT' with "
            "a port of 1 to 65534 (frames take the next one)"
        )
    return f"tcp://127.0.0.1:{int(found[1]) + 1}"


def image_fields(image: NDArray[Any]) -> dict[str, Any]:
    """Return what a reader needs to make an array of bytes again."""
    return {"shape": list(image.shape), "type": np.dtype(image.dtype).name}
