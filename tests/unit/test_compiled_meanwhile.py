"""Kernels compiled in copies of the process: handed over in the cache, and nothing waits for ever or is left."""

import multiprocessing
import os
import sys
import threading
import time
from pathlib import Path
from typing import NamedTuple

import netCDF4
import pytest
from numba import njit

from hcss_twin.core import kernels, processes

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are copied on Linux only")


class Work(NamedTuple):
    """Stands for a kernel; whichever process is to compile it writes its number."""

    file: Path
    function: str = "none"
    module: str = "nowhere"
    then: object = None

    def compile(self):
        self.file.write_text(str(os.getpid()))
        if self.then:
            self.then()


@pytest.fixture(autouse=True)
def copies(monkeypatch):
    """One copy, in spite of the threads of pytest-xdist and of a single processor."""
    monkeypatch.setattr(processes, "can_copy", lambda: True)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
    yield
    assert kernels._copies is None
    assert [each for each in multiprocessing.active_children() if each._target is kernels._compile_all] == []


def compile_one():
    njit(lambda x: x + 1.0)(1.0)


def in_a_thread():
    thread = threading.Thread(target=compile_one)
    thread.start()
    thread.join()


def test_a_block_that_compiles_has_its_kernels_compiled_by_a_copy_whose_threads_may_compile(tmp_path):
    listed = [Work(tmp_path / "one", then=in_a_thread), Work(tmp_path / "two", "other")]
    with kernels.compiling_meanwhile(lambda: listed):
        assert not listed[0].file.exists()
        compile_one()
        kernels.wait_for_kernels()
        assert {int(each.file.read_text()) for each in listed}.isdisjoint({os.getpid()})


def test_a_block_that_compiles_nothing_starts_nothing(tmp_path):
    with kernels.compiling_meanwhile(lambda: [Work(tmp_path / "one")]):
        kernels.wait_for_kernels()
    assert not (tmp_path / "one").exists()


def test_a_kernel_that_fails_in_a_copy_is_left_to_the_process_in_silence(tmp_path, capfd):
    listed = [Work(tmp_path / "fails", "compile_one", __name__, lambda: 1 / 0), Work(tmp_path / "after")]
    with kernels.compiling_meanwhile(lambda: listed):
        compile_one()
        kernels.wait_for_kernels()
        assert not kernels._copies.compiled(compile_one)
    assert listed[1].file.exists()
    assert capfd.readouterr().err == ""


def test_a_kernel_that_a_copy_is_about_to_compile_is_awaited_while_others_are_compiled(tmp_path):
    other = Work(tmp_path / "other")

    def until_the_other_is_compiled():
        end = time.monotonic() + 60.0
        while not other.file.exists() and time.monotonic() < end:
            time.sleep(0.01)

    listed = [Work(tmp_path / "long", "compile_one", __name__, until_the_other_is_compiled), other]
    with kernels.compiling_meanwhile(lambda: listed):
        compile_one()
        while not listed[0].file.exists():
            time.sleep(0.01)
        assert kernels._copies.compiled(compile_one)
        assert int(listed[0].file.read_text()) != os.getpid() == int(listed[1].file.read_text())


def twice(x):
    return 2.0 * x


def test_a_kernel_that_a_copy_compiled_for_other_arguments_is_compiled_for_these(tmp_path, monkeypatch):
    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(tmp_path))
    kernel = kernels.kernel()(twice)
    with kernels.compiling_meanwhile(lambda: [Work(tmp_path / "one", "twice", __name__)]):
        compile_one()
        kernels.wait_for_kernels()
        assert kernel(1.5) == 3.0


def test_a_file_that_is_written_when_copies_start_can_be_read_while_they_compile(tmp_path):
    listed = [Work(tmp_path / "long", then=lambda: time.sleep(300))]
    with kernels.compiling_meanwhile(lambda: listed):
        with netCDF4.Dataset(tmp_path / "cube.nc", "w") as cube:
            compile_one()
            while not listed[0].file.exists():
                time.sleep(0.01)
            cube.title = "written"
        with netCDF4.Dataset(tmp_path / "cube.nc") as cube:
            assert kernels._copies.is_alive()
            assert cube.title == "written"


def test_copies_end_with_the_block_also_by_an_interrupt(tmp_path):
    listed = [Work(tmp_path / "hangs", then=lambda: time.sleep(300))]
    start = time.monotonic()
    interrupted = pytest.raises(KeyboardInterrupt)
    with interrupted, kernels.compiling_meanwhile(lambda: listed):
        compile_one()
        raise KeyboardInterrupt
    assert time.monotonic() - start < 100
