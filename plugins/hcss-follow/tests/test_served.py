"""``hcss serve --follow``: an image in the folder takes over without a jump; a replay has the same bits."""

import json
import os
import subprocess
import sys
import time
from contextlib import contextmanager
from datetime import timedelta

import netCDF4
import numpy as np
import pytest
from conftest import TIME, field, state_of
from hcss_follow.analysis import Image

import hcss_twin

pytest.importorskip("hcss_payload", reason="hcss-payload serves frames")
pytest.importorskip("zmq", reason="extra zmq of hcss-payload")

pytestmark = pytest.mark.long

SIDE, STEP, PATIENCE_S, KEYFRAME_S, FIRST_S = 64, timedelta(minutes=15), 1200.0, 4.0, 8.0
SCENE = {
    "time": (TIME + STEP).isoformat(), "place": {"latitude": 0.0, "longitude": 0.0}, "bands": [[10.3, 11.3]],
    "accuracy": 0.005, "sea": {"temperature": 299.0},
    "image": {"rows": 48, "columns": 48, "pixel_size": 3000.0}, "frames": {"count": 2, "interval": 180.0},
    "motion": {"platform_speed": 0.0, "wind_speed": 0.0}, "slant": {"parallax": "off", "shadows": "off"},
    "clouds": {
        "type": "deep-convection", "base": 500.0, "top": 1500.0, "water_content": 0.6, "thickness_min": 0.01,
        "generator": "followed", "parameters": {"state": "twin.state.nc"},
    },
    "camera": {"rows": 24, "columns": 24, "focal_length": 1.0, "detector_pitch": 50e-6, "points": 1},
    "orbit": {"provider": "geostationary", "longitude": 0.0},
    "attitude": {"provider": "track"},
}  # fmt: skip


def _write(path):
    """Write the next image, first row south; a program that puts it into the folder renames it there."""
    with netCDF4.Dataset(path, "w") as file:
        for name in ("y", "x"):
            file.createDimension(name, SIDE)
        degrees = np.arange(SIDE) * 3000.0 / 111_195.0
        for name, axis, units in (("latitude", "y", "degrees_north"), ("longitude", "x", "degrees_east")):
            file.createVariable(name, "f8", (axis,))[:] = degrees - degrees.mean()
            file[name].units = units
        variable = file.createVariable("IR_108", "f4", ("y", "x"))
        variable[:] = field(SIDE, shift=(4.0, -6.0)) - 8.0
        variable.units, variable.long_name = "K", "brightness temperature, 2020-09-06 00:30 UTC"


@contextmanager
def _asked(folder, *options):
    """Serve the scene of a folder, and give a function that returns the reply to a command."""
    import zmq

    endpoint = f"ipc://{folder}/commands"
    options = ["twin.json", "--name", f"hcss-test-followed-{os.getpid()}", "--zmq", endpoint, "--margin", "4", *options]
    options += ["--method", "keyframes", "--keyframe", str(KEYFRAME_S)]
    command = [sys.executable, "-m", "hcss_twin", "serve", *options]
    with (
        (folder / "errors.txt").open("w") as errors,
        subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=errors) as server,
        zmq.Context() as context,
        context.socket(zmq.REQ) as socket,
    ):
        socket.setsockopt(zmq.RCVTIMEO, int(1e3 * PATIENCE_S))
        socket.setsockopt(zmq.LINGER, 0)
        socket.connect(endpoint)

        def ask(**command):
            socket.send_json(command)
            fields, *image = socket.recv_multipart()
            reply = json.loads(fields)
            assert "error" not in reply, reply
            return (reply, np.frombuffer(image[0], np.float32)) if image else reply

        try:
            yield ask
            ask(command="stop")
            assert server.wait(PATIENCE_S) == 0, (folder / "errors.txt").read_text()
        finally:
            server.kill()


def _poses():
    """Return a function of time that gives the fields of the nominal pose."""
    from hcss_payload import pose_at
    from hcss_payload.build import payload_of

    from hcss_twin.providers import Catalog

    payload = payload_of(hcss_twin.Scenario.from_dict(SCENE), Catalog())

    def pose(time_s):
        at = pose_at(time_s, payload.trajectory, payload.attitude)
        return {"time_s": time_s, "position_m": at.position_m.tolist(), "quaternion": at.quaternion.tolist()}

    return pose


def _jump(frames):
    away = np.abs(np.diff(np.stack(frames), axis=0)).mean(axis=1)
    return float(np.max(away[1:-1] / np.maximum(away[:-2], away[2:])))


def test_an_image_in_the_folder_takes_over_and_a_replay_has_the_same_bits(tmp_path):
    given = [Image(field(SIDE, shift=(2.0 * n, -3.0 * n)), TIME + n * STEP) for n in range(2)]
    state_of(given, latitude=0.0, longitude=0.0).write(tmp_path / "twin.state.nc")
    (tmp_path / "twin.json").write_text(json.dumps(SCENE))
    (tmp_path / "images").mkdir()
    pose = _poses()
    with _asked(tmp_path, "--follow", "images") as ask:
        before, _ = ask(command="pose", **pose(FIRST_S))
        assert before["state_number"] == 0
        _write(tmp_path / "images" / "next.part")
        (tmp_path / "images" / "next.part").rename(tmp_path / "images" / "0030.nc")
        until = time.monotonic() + PATIENCE_S
        while not (states := ask(command="describe")["states"]) and time.monotonic() < until:
            time.sleep(0.2)
        (change,) = states
        times_s = np.arange(FIRST_S, change["ends_s"] + 20.0, 0.5).tolist()
        first = [ask(command="pose", **pose(at)) for at in times_s]
    numbers = [fields["state_number"] for fields, _ in first]
    assert numbers == [int(at >= change["begins_s"]) for at in times_s]
    frames = [image for _, image in first]
    assert frames[-1].mean() < 0.95 * frames[0].mean()  # 8 K colder
    assert _jump(frames) < 1.5
    begun = numbers.index(1)
    assert _jump([*frames[:begun], *frames[-20:]]) > 3.0  # a state that begins at once is seen
    with _asked(tmp_path) as ask:
        image = str(tmp_path / "images" / "0030.nc")
        assert ask(command="assimilate", file=image, begins_s=change["begins_s"]) == {"state_number": 1}
        for time_s, (fields, frame) in zip(times_s, first, strict=True):
            again, repeated = ask(command="pose", **pose(time_s))
            assert again["state_number"] == fields["state_number"]
            assert np.array_equal(repeated, frame)
        assert ask(command="describe")["states"] == [change]
