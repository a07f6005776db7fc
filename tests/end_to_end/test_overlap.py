"""Frames are computed and written at the same time: the cube is the same, and whichever side fails ends both."""

import os
import signal
import subprocess
import sys
import threading
import time

import netCDF4
import numpy as np
import pytest
from cheap import CHEAP, NARROW
from example_cube import example_frame, example_header
from scipy.ndimage import gaussian_filter

from hcss_twin import Scenario, make_plan
from hcss_twin.core.errors import CubeError, ProviderError
from hcss_twin.cube.streamed_writer import MAX_WAITING, MAX_WAITING_BYTES, BackgroundWriter
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.engine import simulate
from hcss_twin.engine.compile import compile_tables
from hcss_twin.engine.simulate import overlaps
from hcss_twin.engine.stream import stream
from hcss_twin.models.clouds.fractal.generator import FractalClouds

SMALL = {"image.rows": 48, "image.columns": 64, "frames.count": 6, "bands": NARROW, **CHEAP}
posix = pytest.mark.skipif(os.name != "posix", reason="signals and limits of POSIX")


def planned(**overrides):
    return make_plan(Scenario.load("stratus", {**SMALL, **overrides}))


@pytest.mark.parametrize("compression", [0, 1])
def test_the_cube_is_the_same_to_the_byte_written_beside_the_computing_or_in_between(
    tmp_path, monkeypatch, compression
):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    plan = planned(**{"output.variables": ["all"], "output.compression": compression})
    assert overlaps(plan)
    beside = simulate.run(plan, tmp_path / "beside.nc").read_bytes()
    monkeypatch.setattr(simulate, "overlaps", lambda plan: False)
    assert simulate.run(plan, tmp_path / "between.nc").read_bytes() == beside


def test_small_frames_written_together_give_the_bytes_of_frames_written_one_by_one(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    plan = planned(**{"frames.count": 9, "image.rows": 8, "output.variables": ["all"]})
    together = simulate.run(plan, tmp_path / "together.nc").read_bytes()
    monkeypatch.setattr(simulate, "BATCH_BYTES", 0)
    monkeypatch.delattr(BackgroundWriter, "write_frames")  # not needed for single frames
    assert simulate.run(plan, tmp_path / "single.nc").read_bytes() == together


class Recorder:
    """In place of a CubeWriter: a disk as slow as the test says."""

    def __init__(self):
        self.written = []
        self.may_write = threading.Event()
        self.busy = False

    def write_frame(self, index, arrays):
        self.busy = True
        assert self.may_write.wait(20)
        self.written.append((index, arrays))
        self.busy = False


def test_frames_are_taken_while_earlier_ones_are_written_and_come_out_in_order():
    recorder = Recorder()
    frames = [{"a": np.full(3, number)} for number in range(20)]
    with BackgroundWriter(recorder) as writer:
        for number in range(MAX_WAITING):
            writer.write_frame(number, frames[number])
        assert recorder.written == []
        recorder.may_write.set()
        for number in range(MAX_WAITING, 20):
            writer.write_frame(number, frames[number])
    assert [index for index, _ in recorder.written] == list(range(20))
    assert all(arrays is frame for (_, arrays), frame in zip(recorder.written, frames, strict=True))


@pytest.mark.parametrize(("size", "most"), [(10, MAX_WAITING), (MAX_WAITING_BYTES // MAX_WAITING + 1, 1)])
def test_the_number_of_waiting_frames_is_bounded_and_large_ones_wait_alone(size, most):
    recorder = Recorder()
    frame = {"a": np.broadcast_to(np.uint8(0), size)}  # takes no memory
    with BackgroundWriter(recorder) as writer:
        for number in range(most):
            writer.write_frame(number, frame)
        handed = threading.Event()
        threading.Timer(0.3, recorder.may_write.set).start()

        def see():
            handed.wait(0.15)
            assert not handed.is_set()

        watcher = threading.Thread(target=see)
        watcher.start()
        writer.write_frame(most, frame)
        handed.set()
        watcher.join()
        assert recorder.written  # the first had to go before another was taken
    assert len(recorder.written) == most + 1


def test_an_error_of_the_writer_is_raised_by_the_next_frame_and_at_the_end_at_the_latest(tmp_path):
    header = example_header()
    frames = [example_frame(header, index) for index in range(3)]
    wrong = {name: array[..., :-1] for name, array in frames[0].items()}
    given = []

    def write(numbered):
        with CubeWriter(tmp_path / "c.nc", header) as file, BackgroundWriter(file) as writer:
            for index, frame in numbered:
                given.append(index)
                writer.write_frame(index, frame)
                time.sleep(0.05)

    with pytest.raises(CubeError, match=r"frame 0, .* shape"):
        write([(0, wrong), (1, frames[1]), (2, frames[2])])
    assert given == [0, 1]
    with pytest.raises(CubeError, match="already written"):
        write([*enumerate(frames), (2, frames[2])])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("overlap", [True, False])
@pytest.mark.parametrize(
    ("raised", "expected"), [(ValueError("boom"), ProviderError), (KeyboardInterrupt(), KeyboardInterrupt)]
)
def test_what_stops_the_computing_of_a_frame_stops_the_run_and_leaves_nothing(
    tmp_path, monkeypatch, overlap, raised, expected
):
    plan = planned()
    thickness, asked = FractalClouds.thickness_m, []

    def failing(self, time_s, rows, columns):
        asked.append(time_s)
        if time_s == plan.frame_times_s[3]:
            raise raised
        return thickness(self, time_s, rows, columns)

    monkeypatch.setattr(FractalClouds, "thickness_m", failing)
    monkeypatch.setattr(simulate, "overlaps", lambda plan: overlap)
    with pytest.raises(expected):
        simulate.run(plan, tmp_path / "c.nc")
    assert max(asked) == plan.frame_times_s[3]
    assert list(tmp_path.iterdir()) == []


@posix
def test_a_file_that_can_grow_no_further_stops_the_run_and_leaves_nothing(tmp_path):
    script = f"""
import resource, sys
from hcss_twin import Scenario, make_plan
from hcss_twin.core.errors import CubeError
from hcss_twin.engine.simulate import run
plan = make_plan(Scenario.load("stratus", {{**{SMALL!r}, "frames.count": 60}}))
made = []
def counted(frames, count):
    for frame in frames:
        made.append(frame.arrays["cloud_mask"].sum())
        if len(made) == 1:
            resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))
        yield frame
try:
    run(plan, sys.argv[1], counted)
except CubeError as error:
    print(error)
print(len(made))
"""
    done = subprocess.run(
        [sys.executable, "-c", script, tmp_path / "c.nc"], capture_output=True, text=True, timeout=120
    )
    message, made = done.stdout.splitlines()
    assert message.startswith(f"cannot write {tmp_path / 'c.nc'}: "), done.stderr
    assert int(made) < 20
    assert list(tmp_path.iterdir()) == []


@posix
def test_interrupts_wait_for_the_frame_being_written_however_many_they_are():
    recorder = Recorder()
    interrupts = []

    def interrupt(number, frame):
        interrupts.append(number)
        raise KeyboardInterrupt

    def write():
        with BackgroundWriter(recorder) as writer:
            signal.setitimer(signal.ITIMER_REAL, 0.1, 0.05)
            for number in range(10):
                writer.write_frame(number, {"a": np.zeros(1)})

    before = signal.signal(signal.SIGALRM, interrupt)
    threading.Timer(0.5, recorder.may_write.set).start()
    try:
        with pytest.raises(KeyboardInterrupt):
            write()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert len(interrupts) > 3
    assert not recorder.busy
    assert [index for index, _ in recorder.written] == [0]


@pytest.fixture
def image(tmp_path):
    """An image in a NetCDF file, as the cloud generators that read one want it."""
    path = tmp_path / "image.nc"
    with netCDF4.Dataset(path, "w") as file:
        for name, size in (("y", 80), ("x", 96)):
            file.createDimension(name, size)
            axis = file.createVariable(name, "f8", (name,))
            axis.units = "m"
            axis[:] = 200.0 * np.arange(size)
        data = file.createVariable("data", "f4", ("y", "x"))
        data[:] = gaussian_filter(np.random.default_rng(0).normal(size=(80, 96)), 3.0)
    return str(path)


@pytest.mark.parametrize(("generator", "parameters"), [("fractal", {}), ("imagery", {"method": "coverage"})])
def test_our_providers_open_no_netcdf_file_while_frames_are_computed(
    tmp_path, monkeypatch, image, generator, parameters
):
    if generator != "fractal":
        parameters = {**parameters, "image": image}
    plan = planned(
        **{
            "image.pixel_size": 200.0,
            "clouds.generator": generator,
            "clouds.parameters": parameters,
            "sea.model": "rough-sea",
            "sea.waves": "on",
            "frames.count": 2,
            "bands": ["lwir-10.8"],
            "output.variables": ["all"],
        }
    )
    assert overlaps(plan)
    tables = compile_tables(plan)

    def refused(*arguments, **options):
        raise AssertionError(f"opened {arguments}")

    monkeypatch.setattr(netCDF4, "Dataset", refused)
    assert len(list(stream(plan, tables))) == 2
