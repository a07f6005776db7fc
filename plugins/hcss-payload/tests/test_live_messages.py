"""ZeroMQ sockets of a server: replies in lockstep, published frames, errors that name the field, this machine alone."""

import json
import os
import threading

import numpy as np
import pytest
from hcss_payload.checks import PayloadError
from hcss_payload.live.gateway import Gateway, frames_endpoint_of
from hcss_payload.live.messages import command_of
from hcss_payload.live.prepared_pass import FrameCost, StateChange
from hcss_payload.live.server import Server

POSE = {"command": "pose", "time_s": 2.0, "position_m": [7e6, 0.0, 0.0], "quaternion": [0.0, 0.6, 0.0, 0.8]}
TARGET = {"latitude_deg": 30.0, "longitude_deg": 150.0, "altitude_m": 2e3, "intensity": [1e5]}
TIMEOUT_MS = 20_000


class _Pass:
    """Frames that hold their time and the number of their targets."""

    shape, has_numbers, start_s, end_s, stalls, state_number, method = (1, 2, 3), False, 0.0, 10.0, 0, 4, "fast"

    def frame(self, time_s, pose=None, out=None, targets=None):
        if time_s > self.end_s:
            raise PayloadError(f"time_s: {time_s:g} s; allowed: 0 to 10 s, the pass")
        out[:] = time_s + 100.0 * (-1 if targets is None else len(targets))

    def warm_up(self, out=None):
        return FrameCost(1.0, {})

    states = (StateChange(5, 7.0, 17.0),)

    def assimilate(self, image, time=None, begins_s=None, file=None):
        return 5 if begins_s is None else int(begins_s)

    def look(self):
        return []

    def close(self):
        pass


def _serve(talk, endpoint):
    """Run a server while a function talks to it, and return what that returned."""
    zmq = pytest.importorskip("zmq", reason="extra zmq")
    said, server = [], Server(_Pass(), f"hcss-test-zmq-{os.getpid()}", gateway=Gateway(endpoint))

    def client():
        context = zmq.Context()
        try:
            said.append(talk(context))
        finally:
            server._stopped = True
            context.destroy(linger=0)

    talking = threading.Thread(target=client)
    server.serve(talking.start)
    talking.join()
    return said[0]


def _asks(context, endpoint, *messages):
    replies = []
    with context.socket(3) as socket:  # REQ
        socket.setsockopt(27, TIMEOUT_MS)  # RCVTIMEO
        socket.connect(endpoint)
        for message in messages:
            socket.send(message if isinstance(message, bytes) else json.dumps(message).encode())
            fields, *image = socket.recv_multipart()
            replies.append((json.loads(fields), np.frombuffer(image[0], np.float32) if image else None))
    return replies


def test_commands_are_answered_in_lockstep(tmp_path):
    endpoint, image = f"ipc://{tmp_path}/commands", tmp_path / "image.nc"
    image.write_bytes(b"x")

    def talk(context):
        return _asks(
            context, endpoint,
            {"command": "describe"}, {**POSE, "pose_number": 9}, {**POSE, "targets": [TARGET, TARGET]},
            {"command": "elements", "targets": [TARGET]}, POSE, {"command": "elements"}, POSE,
            {**POSE, "time_s": 11.0}, b"{", {"command": "elements", "targets": [{**TARGET, "intensity": [1.0, 2.0]}]},
            {"command": "assimilate", "file": str(image)}, {"command": "assimilate", "file": "none"},
            {"command": "assimilate", "file": str(image), "begins_s": 7},
            {"command": "describe"}, {"command": "stop"},
        )  # fmt: skip

    replies = iter(_serve(talk, endpoint))
    described, _ = next(replies)
    assert (described["shape"], described["type"], described["method"]) == ([1, 2, 3], "float32", "fast")
    assert (described["start_s"], described["end_s"], described["frames"]) == (0.0, 10.0, 0)
    frame, values = next(replies)
    expected = {"frame": 0, "pose_number": 9, "time_s": 2.0, "state_number": 4, "shape": [1, 2, 3], "type": "float32"}
    assert frame == expected
    assert values.tolist() == [-98.0] * 6
    assert next(replies)[1][0] == 202.0
    assert next(replies)[0] == {"targets": 1}
    assert next(replies)[1][0] == 102.0  # those of the server now
    assert next(replies)[0] == {"targets": None}
    assert next(replies)[1][0] == -98.0
    errors = [next(replies)[0] for _ in range(3)]
    assert [error["error"] for error in errors] == ["PayloadError"] * 3
    assert errors[0]["message"] == "time_s: 11 s; allowed: 0 to 10 s, the pass"
    assert errors[1]["message"].startswith("message: no JSON (")
    assert errors[2]["message"].startswith("target.intensity: 2 values; allowed: 1")
    assert next(replies)[0] == {"state_number": 5}
    assert next(replies)[0]["message"] == "file: 'none' is no file; allowed: one with an image"
    assert next(replies)[0] == {"state_number": 7}  # begins when it began in the run that is repeated
    described, _ = next(replies)
    assert described["frames"] == 4  # a refused pose has none
    assert described["states"] == [{"number": 5, "begins_s": 7.0, "ends_s": 17.0}]
    assert next(replies)[0] == {"stopping": True}


def test_frames_are_published_to_all_that_read(tmp_path):
    zmq = pytest.importorskip("zmq", reason="extra zmq")
    endpoint = f"ipc://{tmp_path}/commands"

    def talk(context):
        readers = [context.socket(zmq.SUB) for _ in range(3)]
        for reader in readers:
            reader.setsockopt(zmq.SUBSCRIBE, b"frame")
            reader.setsockopt(zmq.RCVTIMEO, TIMEOUT_MS)
            reader.connect(frames_endpoint_of(endpoint))
        # Subscriptions take a moment: poses are repeated until each reader has a frame.
        asking = threading.Event()

        def ask():
            while not asking.wait(0.01):
                _asks(context, endpoint, POSE)

        asker = threading.Thread(target=ask)
        asker.start()
        received = [reader.recv_multipart() for reader in readers]
        for reader in readers:
            reader.close()
        asking.set()
        asker.join()
        return received

    for topic, fields, image in _serve(talk, endpoint):
        assert topic == b"frame"
        assert json.loads(fields)["published_ns"] > 0
        assert np.frombuffer(image, np.float32).tolist() == [-98.0] * 6


@pytest.mark.parametrize(
    "endpoint",
    ["tcp://0.0.0.0:5555", "tcp://*:5555", "tcp://192.168.0.1:5555", "tcp://127.0.0.1:65535", "tcp://127.0.0.1:0", "",
     "tcp://127.0.0.1:*", "tcp://localhost.example.org:5555", "udp://127.0.0.1:5555", "ipc://", "inproc://a", "5555"],
)  # fmt: skip
def test_other_machines_cannot_connect(endpoint):
    with pytest.raises(PayloadError, match=r"zmq: .*; allowed: addresses of this machine alone"):
        Gateway(endpoint)


def test_an_address_in_use_is_named(tmp_path):
    pytest.importorskip("zmq", reason="extra zmq")
    assert frames_endpoint_of("tcp://127.0.0.1:5555") == "tcp://127.0.0.1:5556"
    with pytest.raises(PayloadError, match=r"zmq: 'ipc:///none/here' cannot be used: .*; allowed: an address that no"):
        Gateway("ipc:///none/here")


@pytest.mark.parametrize(
    ("message", "error"),
    [
        ({"command": "pos"}, r"command: 'pos'; allowed: .*; closest is 'pose'"),
        ({**POSE, "time": 1.0}, r"time: no key of 'pose'; allowed: .*; closest is 'time_s'"),
        ({**POSE, "time_s": "2"}, r"time_s: '2'; allowed: a valid number"),
        ({**POSE, "time_s": True}, r"time_s: True; allowed: a valid number"),
        ({**POSE, "position_m": [1.0, 2.0]}, r"position_m: \[1\.0, 2\.0\]; allowed: at least 3 items"),
        ({**POSE, "targets": [{**TARGET, "altitude_m": float("nan")}]}, r"targets\.0\.altitude_m: nan; allowed: "),
        ({"command": "assimilate", "file": "a.nc", "begins_s": "7"}, r"begins_s: '7'; allowed: a valid number"),
        ({"command": "assimilate"}, r"file: is missing; allowed: a value, which 'assimilate' needs"),
    ],
)
def test_what_is_wrong_with_a_command_is_named(message, error):
    with pytest.raises(PayloadError, match=error):
        command_of([json.dumps(message).encode()])


def test_good_commands_are_taken():
    assert command_of([json.dumps(POSE).encode()]).values().tolist() == [2.0, 7e6, 0.0, 0.0, 0.0, 0.6, 0.0, 0.8]
    whole = {**POSE, "time_s": 2, "targets": [{**TARGET, "velocity_m_s": [1, 2, 3]}], "pose_number": 2**64 - 1}
    (target,) = command_of([json.dumps(whole).encode()]).point_targets()
    assert (target.latitude_deg, target.velocity_m_s, target.intensity) == (30.0, (1.0, 2.0, 3.0), (1e5,))
    assert command_of([json.dumps({**POSE, "targets": []}).encode()]).point_targets() == []
    assert command_of([b'{"command": "elements"}']).point_targets() is None
