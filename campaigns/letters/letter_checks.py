"""A server of live frames, hostile clients, and what they may not change."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import zmq
from hcss_payload import pose_at
from hcss_payload.build import payload_of
from hcss_payload.checks import PayloadError
from hcss_payload.live.client import LiveClient
from hcss_payload.live.gateway import frames_endpoint_of
from hcss_payload.live.ring import Ring
from hostile import Case, hostile_letters, pose_message

from hcss_twin import Scenario
from hcss_twin.providers import Catalog

PATIENCE_S = 20.0

SCENE = """
time = 2024-04-20T02:30:00Z
bands = [{name = "lwir", limits = [10.5, 11.0]}]
place = {latitude = 30.0, longitude = 150.0}
image = {rows = 64, columns = 64, pixel_size = 100.0}
frames = {count = 2, interval = 10.0}
clouds = {type = "stratus", generator = "fractal", coverage = 0.5, coverage_mode = "field"}
sea = {wind_speed = 10.0, model = "cox-munk"}
radiance.model = "as-printed"
optics.provider = "mie"
camera = {rows = 48, columns = 64, focal_length = 0.15, detector_pitch = 30e-6}
orbit = {provider = "circular", altitude = 700e3, inclination = 98.2, node_longitude = 156.0, argument = 26.5}
attitude.provider = "track"
"""


class Served:
    """A running server.

    Attributes
    ----------
    name, endpoint : str
        Of its memory and its sockets.
    values : ndarray (8,)
        Time, position and quaternion of a good pose.
    """

    def __init__(self, folder: Path, endpoint: str, server: subprocess.Popen[str]) -> None:
        self.name, self.endpoint, self.process = f"hcss-letters-{os.getpid()}", endpoint, server
        scenario = Scenario.load(folder / "scene.toml")
        payload = payload_of(scenario, Catalog(base=folder))
        pose = pose_at(2.0, payload.trajectory, payload.attitude)
        self.values = np.array([2.0, *pose.position_m, *pose.quaternion])
        self.context, self._sockets = zmq.Context(), list[zmq.Socket[Any]]()
        self._good: bytes | None = None

    def wait_until_ready(self) -> None:
        """Wait for the first frame, which may compile for minutes; the error has what a server that ended has said."""
        while self.process.poll() is None:
            with suppress(PayloadError), LiveClient(self.name, 1.0):
                return
        assert self.process.stderr is not None
        raise RuntimeError(self.process.stderr.read())

    def client(self, kind: int = zmq.DEALER, endpoint: str = "") -> zmq.Socket[Any]:
        """Return a new socket for commands."""
        made = self.context.socket(kind)
        self._sockets.append(made)
        made.setsockopt(zmq.LINGER, 0)
        made.setsockopt(zmq.RCVTIMEO, int(1e3 * PATIENCE_S))
        made.connect(endpoint or self.endpoint)
        return made

    def close(self) -> None:
        """Close all sockets."""
        for made in self._sockets:
            made.close()
        self.context.term()

    def is_sound(self, client: zmq.Socket[Any]) -> bool:
        """Return whether the server runs and gives a good pose the frame that it gave the first one."""
        client.send(json.dumps(pose_message(self.values, targets=False)).encode())
        try:
            fields, image = client.recv_multipart()[-2:]
        except (zmq.Again, ValueError):
            return False
        if self._good is None:
            self._good = image
        return self.process.poll() is None and "error" not in json.loads(fields) and image == self._good


@contextmanager
def served(folder: Path, endpoint: str | None = None) -> Iterator[Served]:
    """Run a server whose frames are ready."""
    (folder / "scene.toml").write_text(SCENE)
    endpoint = endpoint or f"ipc://{folder}/commands"
    options = ["--name", f"hcss-letters-{os.getpid()}", "--zmq", endpoint, "--highest-target", "15000"]
    start = f"from hcss_payload.live.command import serve; serve(['scene.toml', *{options!r}])"
    command = [sys.executable, "-c", start]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as server:
        running = Served(folder, endpoint, server)
        try:
            running.wait_until_ready()
            yield running
        finally:
            running.close()
            server.terminate()
            server.communicate(timeout=PATIENCE_S)


def message_failures(running: Served, cases: Iterable[Case]) -> Iterator[tuple[str, str]]:
    """Yield the kind of each message and what was wrong with the answer, or an empty text."""
    client = running.client()
    for number, (kind, parts, field) in enumerate(cases):
        client.send_multipart([b"", *parts])
        try:
            _, reply = client.recv_multipart()
            said = json.loads(reply)
        except (zmq.Again, ValueError) as error:
            yield kind, f"no answer ({error!r})"
            client = running.client()
            continue
        wrong = "" if field in said.get("message", "") and said.get("error") else f"{field}: {reply!r:.200}"
        if number % 25 == 0 and not running.is_sound(client):
            wrong = wrong or "the next good pose has another frame or none"
        yield kind, wrong


def letter_failures(running: Served, count: int) -> Iterator[tuple[str, str]]:
    """Yield the same of letters that are written into the shared memory."""
    client, ring = running.client(), Ring.attach(running.name)
    header = ring.header
    for values, targets in hostile_letters(running.values, count):
        before = int(header["refused"])
        header["letter"] += np.uint64(1)
        header["pose"], header["pose_number"], header["targets"] = values, 5, targets
        header["letter"] += np.uint64(1)
        until = time.monotonic() + PATIENCE_S
        while int(header["refused"]) == before and time.monotonic() < until:
            time.sleep(1e-3)
        refused = int(header["refused"]) == before + 1
        yield "letter in memory", "" if refused and running.is_sound(client) else f"not refused: {values}, {targets}"
    del header
    ring.close(delete=False)


def crowd_failures(running: Served) -> Iterator[tuple[str, str]]:
    """Yield the same of clients that do not read, vanish, flood, or are many; the next good pose must be answered."""
    client, good = running.client(), json.dumps(pose_message(running.values, targets=False)).encode()
    reader = running.client(zmq.SUB, frames_endpoint_of(running.endpoint))  # never reads
    reader.setsockopt(zmq.SUBSCRIBE, b"")
    silent = running.client()
    for _ in range(2000):  # never reads an answer, so that the queues fill
        silent.send(good)
    yield "does not read", "" if running.is_sound(client) else "no answer"
    for _ in range(50):
        gone = running.client()
        gone.send(good)
        gone.close()
    yield "vanishes", "" if running.is_sound(client) else "no answer"
    for size in (2**20 + 1, 5 * 2**20):  # the server ends such a connection
        large = running.client()
        large.send(b"x" * size)
        time.sleep(0.2)
        yield "too large a part", "" if running.is_sound(client) else "no answer"
        large.close()
    if running.endpoint.startswith("tcp"):
        port = int(running.endpoint.rsplit(":", 1)[1])
        rng = np.random.default_rng(53)
        for number in range(40):
            with socket.create_connection(("127.0.0.1", port + number % 2)) as raw:
                raw.sendall(rng.integers(0, 256, 1 + 37 * number, np.uint8).tobytes())
        yield "no ZeroMQ at all", "" if running.is_sound(client) else "no answer"
    sound: list[bool] = []
    many = [threading.Thread(target=lambda: sound.append(running.is_sound(running.client()))) for _ in range(40)]
    for thread in many:
        thread.start()
    for thread in many:
        thread.join()
    for each in sound:
        yield "40 clients at once", "" if each else "another frame or none"
    for _ in range(40 - len(sound)):
        yield "40 clients at once", "no answer"
