"""Only a finished cube ever has the final name, whatever happens to the process, the disk or the power."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from example_cube import example_frame, example_header

import hcss_twin
from hcss_twin.core.errors import CubeError
from hcss_twin.core.files import draft_of
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.writer import CubeWriter
from hcss_twin.cube.zarr_writer import cube_writer

SETUP = """
import sys
from example_cube import example_frame, example_header
from hcss_twin.cube.requested_variables import expand
from hcss_twin.cube.writer import CubeWriter
"""
posix = pytest.mark.skipif(os.name != "posix", reason="signals and limits of POSIX")


BENCHMARKS = Path(hcss_twin.__file__).parents[1] / "benchmarks"


def child(script, *arguments, **options):
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(Path(hcss_twin.__file__).parents[1]), str(Path(__file__).parents[1])]),
    }
    return subprocess.Popen(
        [sys.executable, "-c", SETUP + script, *map(str, arguments)],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def write(path, header):
    with CubeWriter(path, header) as writer:
        for index in range(header.frames):
            writer.write_frame(index, example_frame(header, index))


@pytest.mark.parametrize("error", [RuntimeError("boom"), KeyboardInterrupt(), SystemExit(3), MemoryError()])
def test_any_exception_leaves_nothing_behind_and_passes_through(tmp_path, error):
    header = example_header()

    def interrupted():
        with CubeWriter(tmp_path / "c.nc", header) as writer:
            writer.write_frame(0, example_frame(header, 0))
            assert [path.suffix for path in tmp_path.iterdir()] == [".partial"]
            raise error

    with pytest.raises(type(error)) as caught:
        interrupted()
    assert caught.value is error
    assert list(tmp_path.iterdir()) == []


def test_an_older_cube_stays_until_a_new_one_is_finished(tmp_path):
    path = tmp_path / "c.nc"
    write(path, example_header(attributes={"title": "old"}))
    before = path.read_bytes()
    header = example_header(attributes={"title": "new"})
    with pytest.raises(CubeError, match="3 of 3 frames"), CubeWriter(path, header):
        assert path.read_bytes() == before
    assert path.read_bytes() == before
    write(path, header)
    with open_cube(path) as cube:
        assert cube.attrs["title"] == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_header_that_cannot_be_written_leaves_nothing_behind(tmp_path):
    with (
        pytest.raises(CubeError, match="Conventions"),
        CubeWriter(tmp_path / "c.nc", example_header(attributes={"Conventions": "mine"})),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_failure_while_finishing_leaves_nothing_behind(tmp_path, monkeypatch, step):
    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, step, fail)
    with pytest.raises(CubeError, match=r"c\.nc: No space left on device"):
        write(tmp_path / "c.nc", example_header())
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_while_finishing_leaves_nothing_behind(tmp_path, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write(tmp_path / "c.nc", example_header())
    assert list(tmp_path.iterdir()) == []


@posix
@pytest.mark.parametrize(("number", "left"), [(signal.SIGKILL, 1), (signal.SIGINT, 0)])
def test_a_killed_process_leaves_at_most_the_partial_file(tmp_path, number, left):
    script = """
import signal, time
# Where tests run in the background of a script, SIGINT is ignored, and children inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
header = example_header()
with CubeWriter(sys.argv[1], header) as writer:
    writer.write_frame(0, example_frame(header, 0))
    print("ready", flush=True)
    time.sleep(60)
"""
    path = tmp_path / "c.nc"
    with child(script, path) as process:
        assert process.stdout.readline() == "ready\n"
        process.send_signal(number)
        process.communicate(timeout=30)
    assert process.returncode != 0
    remains = list(tmp_path.iterdir())
    assert len(remains) == left
    for partial in remains:
        assert partial.name.startswith(".c.nc.")
        assert partial.suffix == ".partial"
        # even renamed by hand it is not taken for a cube
        partial.rename(path)
        with pytest.raises(CubeError):
            open_cube(path)


@posix
@pytest.mark.parametrize("compression", [None, 1])
@pytest.mark.parametrize("limit", [5_000, 100_000, 400_000])
def test_a_file_that_can_grow_no_further_is_an_error_that_names_path_and_space(tmp_path, limit, compression):
    """A limit on file size fails writes as a full disk does; a cube of 1.3 MB meets it at several stages."""
    script = """
import resource
from hcss_twin.core.errors import CubeError
from hcss_twin.core.files import draft_of
path, limit, compression = sys.argv[1], int(sys.argv[2]), eval(sys.argv[3])
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
header = example_header(rows=100, columns=100)
try:
    with CubeWriter(path, header, compression=compression) as writer:
        for index in range(3):
            writer.write_frame(index, example_frame(header, index))
except CubeError as error:
    print(error)
"""
    path = tmp_path / "c.nc"
    process = child(script, path, limit, compression)
    output, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (0, "")
    assert output.startswith(f"cannot write {path}: ")
    assert "free on this disk" in output
    assert list(tmp_path.iterdir()) == []


def test_a_cube_larger_than_the_free_space_is_refused_before_the_first_frame(tmp_path):
    header = example_header(rows=1_000_000, columns=1_000_000)
    with (
        pytest.raises(CubeError, match=r"c\.nc: it needs \d+\.\d MB, the disk has"),
        CubeWriter(tmp_path / "c.nc", header),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_is_named_with_its_cause(tmp_path):
    header = example_header()
    with (
        pytest.raises(CubeError, match=r"there is no folder .*missing"),
        CubeWriter(tmp_path / "missing" / "c.nc", header),
    ):
        pass
    with pytest.raises(CubeError, match="it is a folder"), CubeWriter(tmp_path, header):
        pass
    with pytest.raises(CubeError, match="it is a device"), CubeWriter(Path(os.devnull), header):
        pass
    with pytest.raises(CubeError, match="too long"), CubeWriter(tmp_path / ("n" * 250), header):
        pass


@posix
@pytest.mark.skipif(os.name == "posix" and os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_folder_without_permission_is_named_with_its_cause(tmp_path):
    folder = tmp_path / "locked"
    folder.mkdir(mode=0o555)
    with pytest.raises(CubeError, match="ermission denied"), CubeWriter(folder / "c.nc", example_header()):
        pass


@posix
@pytest.mark.skipif(not BENCHMARKS.exists(), reason="not in an installed package")
def test_memory_does_not_grow_with_the_number_of_frames(tmp_path):
    script = (
        f"import sys; sys.path.insert(0, {str(BENCHMARKS)!r})"
        + """
from regression import peak_memory_mb
frames = int(sys.argv[2])
base = example_header()
header = example_header(
    rows=200, columns=200, frame_times_s=tuple(map(float, range(frames))), solar_zenith_deg=(20.0,) * frames,
    solar_azimuth_deg=(0.0,) * frames, variables=tuple(expand(["radiance", "cloud_top_altitude"], {})),
    bands=(*base.bands, type(base.bands[0])("LWIR", 8.0, 14.0, 11.0)),
)
frame = example_frame(header, 0)
with CubeWriter(sys.argv[1], header, compression=eval(sys.argv[3])) as writer:
    for index in range(frames):
        writer.write_frame(index, frame)
print(peak_memory_mb())
"""
    )
    peak = {}
    for frames in (8, 200):
        process = child(script, tmp_path / f"{frames}.nc", frames, None)
        output, errors = process.communicate(timeout=60)
        assert (process.returncode, errors) == (0, "")
        peak[frames] = float(output)
    assert (tmp_path / "200.nc").stat().st_size > 100e6
    assert peak[200] - peak[8] < 30


@pytest.mark.parametrize("name", ["c.nc", "c.zarr"])
def test_the_later_of_two_writers_of_a_new_cube_is_refused(tmp_path, name):
    if name.endswith("zarr"):
        pytest.importorskip("zarr")
    path, header = tmp_path / name, example_header()

    def writer(replace=False):
        return cube_writer(path)(path, header, replace=replace)

    def fill(opened):
        for index in range(header.frames):
            opened.write_frame(index, example_frame(header, index))

    with writer() as first:
        with pytest.raises(CubeError, match="is writing it"), writer():
            pass
        fill(first)
    path.rename(tmp_path / "aside")

    def late():
        with writer() as second:
            fill(second)
            (tmp_path / "aside").rename(path)  # as if another machine had begun earlier

    with pytest.raises(CubeError, match="another process has written it"):
        late()
    assert [each.name for each in tmp_path.iterdir()] == [name]
    open_cube(path).close()


def test_the_next_run_removes_the_drafts_of_ended_processes_only(tmp_path):
    with subprocess.Popen([sys.executable, "-c", ""]) as ended:
        pass
    ours = draft_of(tmp_path / "d.nc").name
    names = [ours.replace(f"-{os.getpid()}.", f"-{process}.") for process in (ended.pid, os.getppid())]
    elsewhere = names[0].replace(ours.split("-")[2], "00000000")
    for each in (ours, *names, elsewhere, ".other.partial"):
        (tmp_path / each).touch()
    write(tmp_path / "c.nc", example_header())
    assert {each.name for each in tmp_path.iterdir()} == {"c.nc", ours, names[1], elsewhere, ".other.partial"}
