"""The server of live frames in a process of its own."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from hcss_payload import Jitter, PayloadError, Pose, pose_at
from hcss_payload.build import payload_of, scene_of
from hcss_payload.live import LiveClient, LiveTwin, PointTarget, live_pass
from hcss_payload.live.prepared_pass import FrameCost
from hcss_payload.live.ring import Ring, RingShape
from hcss_payload.live.server import Server

import hcss_twin
from hcss_twin.core.catalog import Catalog

SCENE = """
seed = 1
time = 2024-04-20T02:30:00Z
bands = [{name = "lwir", limits = [10.5, 11.0]}]
[place]
latitude = 30.0
longitude = 150.0
[view]
zenith = 0.0
[image]
rows = 64
columns = 64
pixel_size = 100.0
[frames]
count = 2
interval = 10.0
[motion]
platform_speed = 0.0
wind_speed = 10.0
[clouds]
type = "stratus"
generator = "fractal"
coverage = 0.5
coverage_mode = "field"
[sea]
wind_speed = 10.0
model = "cox-munk"
[radiance]
model = "as-printed"
[optics]
provider = "mie"
"""
PASS = """
[camera]
rows = 48
columns = 64
focal_length = 0.15
detector_pitch = 30e-6
[orbit]
provider = "circular"
altitude = 700e3
inclination = 98.2
node_longitude = 156.0
argument = 26.5
[attitude]
provider = "track"
"""
COAST = """
[surfaces]
provider = "coast"
"""
TIMEOUT_S = 60.0


@pytest.fixture
def files(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE + PASS)
    return tmp_path


def command(name):
    options = f"'scene.toml', '--name', '{name}', '--highest-target', '15000', '--rate', '1e6'"
    start = f"from hcss_payload.live.command import serve; serve([{options}])"
    return [sys.executable, "-c", start]


def is_there(name):
    return Path("/dev/shm", name).exists()


@contextmanager
def memory_of(name):
    """What a server shares with its clients."""
    ring = Ring.attach(name)
    try:
        yield ring
    finally:
        ring.close(delete=False)


def _post(ring, values, number, targets=-1):
    """Write a letter as any client may, wait until the server has taken it, and let the next one write."""
    header = ring.header
    header["letter"] += np.uint64(1)
    header["pose"], header["pose_number"], header["targets"] = values, number, targets
    header["letter"] += np.uint64(1)
    time.sleep(0.02)


needs_shm = pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="looks for shared memory in /dev/shm")


@needs_shm
def test_a_served_frame_is_that_of_the_pose_and_sigterm_deletes_the_memory(files):
    name = f"hcss-test-{os.getpid()}"
    scenario = hcss_twin.Scenario.load(files / "scene.toml")
    nominal = payload_of(scenario, Catalog(base=files))
    with (
        subprocess.Popen(command(name), cwd=files, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server,
        LiveTwin(scene_of(scenario), nominal.camera).prepare(
            nominal.trajectory, nominal.attitude, 0.0, 10.0, highest_target_m=15e3
        ) as live,
    ):
        try:
            with LiveClient(name, TIMEOUT_S) as client:
                assert client.shape == (1, 48, 64)
                jitter = Jitter((1e-3, 1e-3, 1e-3))
                for time_s in (0.25, 3.0, 2.0):
                    pose = pose_at(time_s, nominal.trajectory, nominal.attitude, jitter)
                    number = client.send_pose(pose)
                    frame = client.wait(number, TIMEOUT_S)
                    assert (frame.pose_number, frame.time_s) == (number, time_s)
                    assert np.array_equal(frame.image, live.frame(time_s, frame.pose).radiance)
                # Targets that the client decides on with the pose; the next frame has none.
                targets = [PointTarget(30.0, 150.0, 2.5e3, (1e5,)), PointTarget(30.01, 150.0, 2e3, (1e5,))]
                shown = client.wait(client.send_pose(pose, targets), TIMEOUT_S)
                assert np.array_equal(shown.image, live.frame(2.0, shown.pose, targets=targets).radiance)
                assert np.count_nonzero(shown.image > frame.image) == 8
                assert np.array_equal(client.wait(client.send_pose(pose), TIMEOUT_S).image, frame.image)
                with pytest.raises(PayloadError, match=r"target\.intensity: 2 values; allowed: 1, one a band"):
                    client.send_pose(pose, [PointTarget(30.0, 150.0, 0.0, (1.0, 2.0))])
                # Poses in a rush: the last one wins, and none is counted twice or lost.
                for time_s in np.linspace(4.0, 5.0, 200):
                    last = client.send_pose(pose_at(float(time_s), nominal.trajectory, nominal.attitude))
                assert client.wait(last, TIMEOUT_S).time_s == 5.0
                counts = client.counts()
                assert counts["frames"] + counts["skipped"] == 205
                assert counts["skipped"] > 0
                late = client.send_pose(Pose(11.0, pose.position_m, pose.quaternion))
                with pytest.raises(PayloadError, match="pose 206 was refused"):
                    client.wait(late, TIMEOUT_S)
                assert client.counts()["refused"] == 1
                with pytest.raises(TimeoutError, match=r"no frame of pose 207 within 0\.01 s"):
                    client.wait(207, 0.01)
                # Whatever a client writes, dies over or numbers its poses with: the next one starts afresh.
                good = np.array([2.0, *pose.position_m, *pose.quaternion])
                with memory_of(name) as ring:
                    for change in (np.nan, 0.0, 1e300, -1.0):
                        for part in (slice(0, 1), slice(1, 4), slice(4, 8)):
                            values = good.copy()
                            values[part] *= change
                            _post(ring, values, 5)
                    _post(ring, good, 6, targets=1000)
                    _post(ring, good, 2**64 - 1)
                    ring.header["letter"] += np.uint64(1)
                with LiveClient(name, TIMEOUT_S) as after:
                    numbers = [after.send_pose(pose), after.send_pose(pose)]
                    assert numbers == [0, 1]
                    shown = after.wait(numbers[1], TIMEOUT_S)
                    assert (shown.pose_number, shown.time_s) == (1, 2.0)
                    assert np.array_equal(shown.image, frame.image)
        finally:
            server.send_signal(signal.SIGTERM)
        output, errors = server.communicate(timeout=TIMEOUT_S)
    assert server.returncode == 0, errors
    assert f"{name}: 1 x 48 x 64 radiance, times 0 to 10 s\nfast frames: " in output
    assert re.search(r"ms a frame, .* a second; too slow for 1e\+06 \(0\.001 ms\): lines of sight, sky .* ms", output)
    omitted = r"omitted: texture of the sea's temperature \(0\.\d+ % of the radiance\): fast frames show struct"
    assert re.search(omitted, output)
    assert "pose 206: time_s: 11 s; allowed: 0 to 10 s, the pass" in errors
    assert errors.count("pose 5") <= 1  # one line in some seconds, not one for each refused pose
    assert not is_there(name)


@needs_shm
def test_a_scene_that_fast_frames_do_not_show_is_served_with_the_pixels_of_cubes(files):
    name = f"hcss-test-cube-{os.getpid()}"
    (files / "scene.toml").write_text(SCENE + COAST + PASS)
    scenario = hcss_twin.Scenario.load(files / "scene.toml")
    nominal = payload_of(scenario, Catalog(base=files))
    with (
        subprocess.Popen(command(name), cwd=files, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server,
        live_pass(scenario) as live,
    ):
        try:
            with LiveClient(name, TIMEOUT_S) as client:
                for time_s in (0.0, 3.0):
                    pose = pose_at(time_s, nominal.trajectory, nominal.attitude, Jitter((1e-4, 1e-4, 1e-4)))
                    targets = [PointTarget(30.0, 150.0, 2.5e3, (1e5,))]
                    shown = client.wait(client.send_pose(pose, targets), TIMEOUT_S)
                    assert np.array_equal(shown.image, live.frame(time_s, shown.pose, targets=targets).radiance)
        finally:
            server.send_signal(signal.SIGTERM)
        output, errors = server.communicate(timeout=TIMEOUT_S)
    assert server.returncode == 0, errors
    assert re.search(
        r"\ncube frames: .* ms a frame, .* a second; too slow for 1e\+06 \(0\.001 ms\): .*clouds .* ms", output
    )
    assert re.search(r"omitted: waves as shapes.* % of the radiance\): the scene has the sea model 'cox-munk'", output)
    assert "within the footprint" not in output  # a pixel is the mean of several points
    assert "note: frames are those of cubes, since fast frames do not show a map of the ground" in errors


@needs_shm
@pytest.mark.parametrize("end", ["parent", "kill"])
def test_no_memory_is_left_when_the_parent_or_the_server_dies(files, end):
    name = f"hcss-test-{end}-{os.getpid()}"
    start = "import subprocess, sys; server = subprocess.Popen(sys.argv[1:]); print(server.pid, flush=True); input()"
    with subprocess.Popen(
        [sys.executable, "-c", start, *command(name)],
        cwd=files,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as parent:
        number = int(parent.stdout.readline())
        try:
            with LiveClient(name, TIMEOUT_S), memory_of(name) as ring:
                assert int(ring.header["pid"]) == number
            assert is_there(name)  # a client that ends leaves it
        finally:
            if end == "parent":
                parent.kill()
            else:
                os.kill(number, signal.SIGKILL)
                parent.kill()
    until = time.monotonic() + TIMEOUT_S
    while is_there(name) and time.monotonic() < until:
        time.sleep(0.05)
    assert not is_there(name)


class _Prepared:
    """A pass whose frames are empty; the first one ends the server."""

    shape, has_numbers, start_s, stalls, state_number = (1, 2, 3), False, 0.0, 0, 0

    def __init__(self, name):
        self.name, self.frames = name, 0

    def frame(self, time_s, pose=None, out=None, targets=None):
        self.frames += 1
        self.stop()

    def warm_up(self, out=None):
        return FrameCost(1.0, {})

    def look(self):
        return []

    def stop(self):
        with memory_of(self.name) as ring:
            ring.header["stop"] = 1

    def close(self):
        pass


def test_a_pose_that_comes_as_soon_as_the_server_is_ready_is_not_lost():
    prepared = _Prepared(f"hcss-test-early-{os.getpid()}")
    late = threading.Timer(5.0, prepared.stop)

    def ready():
        with LiveClient(prepared.name) as client:
            client.send_pose(Pose(0.0, np.eye(3)[0], np.eye(4)[3]))
        late.start()

    Server(prepared, prepared.name).serve(ready)
    late.cancel()
    assert prepared.frames == 1


def test_a_reader_never_takes_a_frame_that_is_being_written():
    ring = Ring.create(f"hcss-test-ring-{os.getpid()}", RingShape(4, 1, 2, 3, np.dtype(np.float32)), os.getpid())
    try:
        ring.header["ready"] = 1
        client = LiveClient(ring.memory.name)
        assert client.latest() is None
        for number in range(9):
            ring.begin(number)[:] = number
            assert (client.latest() is None) == (number == 0)
            ring.publish(number, number + 1, np.eye(8)[-1], 0)
            assert np.all(client.latest().image == number)
        ring.slots[8 % 4]["sequence"] += np.uint64(1)
        with pytest.raises(PayloadError, match="frames are written faster than read"):
            client.latest()
        client.close()
        with pytest.raises(PayloadError, match="is in use"):
            Ring.create(ring.memory.name, ring.shape, 0)
    finally:
        ring.close(delete=True)
    with pytest.raises(PayloadError, match="no server 'hcss-none'"):
        LiveClient("hcss-none", 0.0)


def test_the_wait_after_a_stall_is_as_long_as_the_frame():
    ring = Ring.create(f"hcss-test-wait-{os.getpid()}", RingShape(4, 1, 2, 3, np.dtype(np.float32)), os.getpid())
    ring.header["ready"] = 1
    takes = (0.4, *[0.005] * 12)

    def serve():
        last = 0
        for number, seconds in enumerate(takes):
            while (letter := ring.newest(last)) is None:
                time.sleep(1e-4)
            last = letter.sequence
            time.sleep(seconds)
            ring.begin(number)
            ring.publish(number, letter.pose_number, letter.values, time.monotonic_ns())

    server = threading.Thread(target=serve)
    server.start()
    late_ms = []
    try:
        with LiveClient(ring.memory.name) as client:
            for _ in takes:
                frame = client.wait(client.send_pose(Pose(0.0, np.eye(3)[0], np.eye(4)[3])), TIMEOUT_S)
                late_ms.append(1e-6 * (time.monotonic_ns() - frame.published_ns))
    finally:
        server.join()
        ring.close(delete=True)
    # It was 320 ms after the first frame, then 250, 200, ...: most of the time of the frame before, without a look.
    assert np.median(late_ms[1:]) < 10.0


def test_memory_that_cannot_be_had_is_named(monkeypatch):
    shape = RingShape(4, 1, 2, 3, np.dtype(np.float32))
    for error in (
        OSError(30, "Read-only file system"),
        FileNotFoundError(2, "No such file"),
        PermissionError(13, "No"),
    ):
        monkeypatch.setattr("multiprocessing.shared_memory.SharedMemory", _raising(error))
        with pytest.raises(PayloadError, match=r"name: .* cannot be created as 'a': "):
            Ring.create("a", shape, 0)
    monkeypatch.undo()
    with pytest.raises(PayloadError, match=r"name: .* are needed, and /dev/shm has .* MiB"):
        Ring.create("a", RingShape(4, 1, 2**20, 2**20, np.dtype(np.float32)), 0)


def _raising(error):
    def raise_it(*args, **kwargs):
        raise error

    return raise_it


def test_memory_of_another_kind_or_size_is_no_server():
    name = f"hcss-test-other-{os.getpid()}"
    ring = Ring.create(name, RingShape(4, 1, 2, 3, np.dtype(np.float32)), os.getpid())
    ring.header["ready"] = 1
    try:
        for field, value in (("version", 3), ("slots", 1000), ("slots", 2**63), ("type", 7), ("rows", 2**40)):
            before = int(ring.header[field])
            ring.header[field] = value
            with pytest.raises(PayloadError, match="is not the memory of a server of this version"):
                LiveClient(name, 0.0)
            ring.header[field] = before
        ring.header["ready"] = 0
        with pytest.raises(PayloadError, match="not ready yet"):
            LiveClient(name, 0.0)
    finally:
        ring.close(delete=True)


def test_a_scene_without_a_camera_is_not_served(files):
    (files / "scene.toml").write_text(SCENE)
    with pytest.raises(hcss_twin.ScenarioError, match=r"camera: is missing; a camera in orbit needs"):
        payload_of(hcss_twin.Scenario.load(files / "scene.toml"), Catalog(base=files))


@needs_shm
def test_a_server_whose_parent_ends_while_it_loads_ends_too(files):
    name = f"hcss-test-orphan-{os.getpid()}"
    # The child sleeps until its parent has ended, as if it took long to load.
    late = command(name)
    late[-1] = f"import time; time.sleep(1.0); {late[-1]}"
    start = "import subprocess, sys; subprocess.Popen(sys.argv[1:])"
    # A session of their own: the process that adopts the child may belong to that of the tests. The call returns
    # when all that write to its pipes have ended.
    ran = subprocess.run(
        [sys.executable, "-c", start, *late],
        cwd=files,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=True,
        start_new_session=True,
    )
    assert "the process that started this one has ended" in ran.stderr
    assert not is_there(name)
