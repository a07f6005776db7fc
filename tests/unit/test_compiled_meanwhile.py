"""Kernels compiled in a copy of the process: only its cache matters, and nothing waits for ever."""

import sys
import threading
import time

import pytest
from numba import njit

from hcss_twin.core import kernels, processes

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are copied on Linux only")


@pytest.fixture(autouse=True)
def copies(monkeypatch):
    """Copies in spite of the threads of pytest-xdist."""
    monkeypatch.setattr(processes, "can_copy", lambda: True)


def compile_one():
    njit(lambda x: x + 1.0)(1.0)


def locked():
    """Work of threads that compile, as those of clouds do."""
    thread = threading.Thread(target=compile_one)
    thread.start()
    thread.join()


def test_a_block_that_compiles_has_its_work_done_by_a_copy_whose_threads_may_compile(tmp_path):
    done = tmp_path / "done"
    with kernels.compiling_meanwhile(lambda: (locked(), done.touch())):
        assert not done.exists()
        compile_one()
    kernels.wait_for_kernels()
    assert done.exists()


def test_a_block_that_compiles_nothing_starts_nothing(tmp_path):
    with kernels.compiling_meanwhile((tmp_path / "done").touch):
        pass
    kernels.wait_for_kernels()
    assert not (tmp_path / "done").exists()


def test_work_that_hangs_or_fails_is_ended_in_silence(monkeypatch, capfd):
    monkeypatch.setattr(kernels, "LONGEST_S", 0.1)
    start = time.monotonic()
    for work in (lambda: time.sleep(300), lambda: 1 / 0):
        with kernels.compiling_meanwhile(work):
            compile_one()
        kernels.wait_for_kernels()
    assert time.monotonic() - start < 100
    assert not capfd.readouterr().err
