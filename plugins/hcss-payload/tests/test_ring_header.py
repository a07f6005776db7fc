"""The header for C and C++: its layout is that of ring.py, and its clients read whole frames and post poses."""

import os
import shutil
import subprocess
import sysconfig
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hcss_payload.live import ring as ring_module
from hcss_payload.live.command import serve
from hcss_payload.live.ring import HEADER, MAGIC, MOST_SLOTS, SLOT, VERSION, Ring, RingShape

HERE = Path(__file__).parent
EXAMPLES = HERE.parent / "examples"
STRICT = ("-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
LINES = 40


def _compiler(*names):
    return next((found for name in names if (found := shutil.which(name))), None)


C = _compiler(*(sysconfig.get_config_var("CC") or "").split()[:1], "cc", "gcc", "clang")
CPP = _compiler("c++", "g++", "clang++")
needs_c = pytest.mark.skipif(C is None, reason="no C compiler")
needs_cpp = pytest.mark.skipif(CPP is None, reason="no C++ compiler")


def _include():
    result = CliRunner().invoke(serve, ["--include"])
    assert result.exit_code == 0
    return result.output.strip()


def _compiled(compiler, standard, source, tmp_path):
    program = tmp_path / "program"
    command = [compiler, f"-std={standard}", *STRICT, str(source), f"-I{_include()}", "-lrt", "-o", str(program)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return str(program)


@contextmanager
def _ring(name, dtype=np.uint16):
    ring = Ring.create(f"{name}-{os.getpid()}", RingShape(4, 2, 3, 5, np.dtype(dtype)), os.getpid())
    try:
        yield ring
    finally:
        ring.close(delete=True)


@needs_c
def test_every_offset_and_size_of_the_header_is_that_of_python(tmp_path):
    printed = subprocess.run([_compiled(C, "c11", HERE / "ring_layout.c", tmp_path)], capture_output=True, check=True)
    in_c = {
        (part, name): (int(offset), int(size))
        for part, name, offset, size in (line.split() for line in printed.stdout.decode().splitlines())
    }
    in_python = {("header", "all"): (0, HEADER.itemsize), ("slot", "all"): (0, SLOT.itemsize)}
    for part, dtype in (("header", HEADER), ("slot", SLOT)):
        for name in dtype.names:
            kind, offset = dtype.fields[name][:2]
            in_python[part, name] = offset, kind.itemsize
    constants = {"magic": MAGIC, "version": VERSION, "line": ring_module._LINE, "slots": MOST_SLOTS}
    in_python |= {("constants", name): (value, 0) for name, value in constants.items()}
    assert in_c == in_python


@needs_c
def test_a_client_in_c_counts_the_frames_that_it_missed(tmp_path):
    assert len((EXAMPLES / "client.c").read_text().splitlines()) <= LINES
    program = _compiled(C, "gnu11", EXAMPLES / "client.c", tmp_path)
    with _ring("hcss-test-c") as ring:
        ring.header["ready"] = 1
        # Every second number is missing, as if its frame had been overtaken.
        with subprocess.Popen([program, f"/{ring.memory.name}", "5"], stdout=subprocess.PIPE, text=True) as client:
            number, until = 0, time.monotonic() + 20.0
            while client.poll() is None and time.monotonic() < until:
                ring.begin(number)[:] = number
                ring.publish(number, number, np.eye(8)[-1], time.monotonic_ns(), state_number=7)
                number += 2
                time.sleep(0.05)
            printed = client.communicate(timeout=20.0)[0]
    frames, rest = printed.split(" frames, ")
    assert frames == "5"
    assert 4 <= int(rest.split()[0]) < number  # one before each of five but perhaps the first, more if it was slow
    assert printed.endswith("state 7\n")


@needs_c
def test_a_client_in_c_never_takes_a_frame_that_is_being_written(tmp_path):
    source = tmp_path / "once.c"
    source.write_text(
        '#include "hcss_ring.h"\n#include <stdio.h>\nint main(int n, char **names) {\n'
        "    struct hcss_ring_header *ring = n > 1 ? hcss_ring_open(names[1]) : NULL;\n"
        "    struct hcss_ring_frame frame;\n    unsigned short image[30];\n"
        '    if (!ring) return printf("no server"), 0;\n    int is_read = hcss_ring_read(ring, 0, &frame, image);\n'
        '    printf("%d %d", is_read, is_read ? image[29] : 0);\n    return 0;\n}\n'
    )
    program = _compiled(C, "gnu11", source, tmp_path)

    def read():
        return subprocess.run([program, f"/{ring.memory.name}"], capture_output=True, text=True, check=True).stdout

    with _ring("hcss-test-once") as ring:
        assert read() == "no server"  # not ready yet
        ring.header["ready"] = 1
        assert read() == "0 0"
        ring.begin(0)[:] = 5
        assert read() == "0 0"
        ring.publish(0, 1, np.eye(8)[-1], 0)
        assert read() == "1 5"
        ring.slots[0]["sequence"] += np.uint64(1)
        assert read() == "0 0"
        ring.slots[0]["sequence"] += np.uint64(1)
        for field, value in (("version", 3), ("slots", 1000), ("slots", 2**63), ("type", 7), ("rows", 2**40)):
            before = int(ring.header[field])
            ring.header[field] = value
            assert read() == "no server", field
            ring.header[field] = before
        assert read() == "1 5"


@needs_cpp
@pytest.mark.parametrize(("dtype", "standard"), [(np.uint16, "c++11"), (np.float32, "c++17")])
def test_a_client_in_cpp_gets_the_frame_of_its_pose(dtype, standard, tmp_path):
    assert len((EXAMPLES / "client.cpp").read_text().splitlines()) <= LINES
    program, posted = _compiled(CPP, standard, EXAMPLES / "client.cpp", tmp_path), []
    with _ring("hcss-test-cpp", dtype) as ring:

        def answer():
            until = time.monotonic() + 20.0
            while not posted and time.monotonic() < until:
                if (letter := ring.newest(0)) is not None:
                    posted.append(letter)
                    ring.begin(0)[:] = np.arange(30).reshape(2, 3, 5)
                    ring.publish(0, letter.pose_number, letter.values, 0, state_number=3)

        ring.header["ready"] = 1
        server = threading.Thread(target=answer)
        server.start()
        pose = ("2.5", "7e6", "1", "2", "0", "0.6", "0", "0.8")
        done = subprocess.run([program, f"/{ring.memory.name}", *pose], capture_output=True, text=True, check=False)
        server.join()
    assert done.stdout == "frame 0, state 3, mean 14.5\n"
    assert posted[0].values.tolist() == [float(value) for value in pose]
    assert posted[0].target_count == -1
