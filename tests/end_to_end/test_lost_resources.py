"""What a run says when the system has no shared memory, no memory, or no workers of a cluster."""

import itertools
import logging
import os
import resource
import socket
import subprocess
import sys
import threading
import time

import pytest
from cheap import CHEAP_OPTIONS

from hcss_twin.core.errors import CatalogError, CubeError, HcssError, ProviderDefect
from hcss_twin.core.memory import OutOfMemory, naming_memory
from hcss_twin.core.processes import worker_pool
from hcss_twin.engine import cluster
from hcss_twin.engine.cluster import Cluster

pytestmark = pytest.mark.skipif(os.name == "nt", reason="POSIX")

RUN = [
    *("run", "stratus", *CHEAP_OPTIONS, "--set", "frames.count=2", "--set", "bands=[[10.5, 10.6]]"),
    *("--set", "image.rows=8", "--set", "image.columns=8", "--set", "output.certificate=0", "-o", "cube.nc"),
]

WITHOUT_SEMAPHORES = """
import errno
import multiprocessing.synchronize

def refuse(*given):
    raise OSError(errno.EROFS, "Read-only file system")

multiprocessing.synchronize._multiprocessing.SemLock = refuse
from hcss_twin.core.processes import worker_pool

if __name__ == "__main__":
    with worker_pool(2) as pool:
        print(list(pool.map(abs, [-1, -2, -3])))
"""
"""What a read-only or missing /dev/shm does: sem_open fails."""


def test_processes_work_without_semaphores(tmp_path):
    script = tmp_path / "pool.py"
    script.write_text(WITHOUT_SEMAPHORES)
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout, done.stderr) == (0, "[1, 2, 3]\n", "")


def fail(error):
    raise error


def test_workers_raise_here_what_they_raise_there_and_say_how_they_died():
    with worker_pool(1) as pool:
        assert list(pool.map(abs, [-1, 2])) == [1, 2]
        with pytest.raises(CatalogError, match="not there"):
            pool.submit(fail, CatalogError("not there")).result()
        with pytest.raises(Exception, match="SIGKILL"):
            pool.submit(os.kill, pool.submit(os.getpid).result(), 9).result()
        assert pool.submit(abs, -3).result() == 3


def _by_provider():
    try:
        raise MemoryError("Unable to allocate 8.00 GiB for an array with shape (1073741824,)")
    except MemoryError as error:
        raise ProviderDefect("cloud generator 'fractal': thickness_m() raised MemoryError") from error


@pytest.mark.parametrize(
    "raises",
    [
        _by_provider,
        lambda: fail(MemoryError()),
        lambda: fail(OSError(12, "Cannot allocate memory")),
        lambda: fail(ImportError("libx.so: failed to map segment from shared object")),
        lambda: fail(RuntimeError("can't start new thread")),
        lambda: fail(RuntimeError("NetCDF: Memory allocation (malloc) failure")),
    ],
)
def test_memory_that_ran_out_is_named_with_what_there_is_and_what_needs_less(raises):
    with pytest.raises(OutOfMemory, match=r"memory ran out: .* available; .*image\.window") as caught, naming_memory():
        raises()
    assert "thickness_m" not in str(caught.value)


def test_other_errors_are_not_taken_for_memory():
    for error in (ProviderDefect("x"), ValueError("memory"), OSError(2, "No such file"), CatalogError("cannot read x")):
        with pytest.raises(type(error)) as caught, naming_memory():
            raise error
        assert caught.value is error


@pytest.mark.long
def test_a_scene_that_does_not_fit_is_refused_with_the_limit(tmp_path):
    limit = 600 * 2**20
    done = subprocess.run(
        [sys.executable, "-m", "hcss_twin", *RUN, "--set", "image.rows=9000", "--set", "image.columns=9000"],
        cwd=tmp_path, capture_output=True, text=True, timeout=300,
        env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
    )  # fmt: skip
    assert done.returncode == 1
    assert "memory ran out" in done.stderr
    assert f"of the {limit / 1e6:.0f} MB that its limit" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.glob("*.nc"))


class Client:
    status = "running"

    def __init__(self, workers):
        self._workers = iter(workers)

    def nthreads(self):
        return dict.fromkeys(next(self._workers), 1)


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(cluster, "LOOK_S", 0.01)
    monkeypatch.setattr(cluster, "FIRST_NOTICE_S", 0.15)


def test_a_cluster_without_workers_is_reported_sparsely_and_given_up_after_the_limit(quick, caplog):
    start = time.monotonic()
    with caplog.at_level(logging.WARNING), pytest.raises(CubeError, match=r"no workers at tcp://here:1 for .*kept"):
        Cluster(Client(itertools.repeat(())), "tcp://here:1", CubeError, 0.6).wait(lambda: False)
    assert 0.6 <= time.monotonic() - start < 5.0
    assert "no workers at tcp://here:1" in caplog.records[0].message
    assert 2 <= len(caplog.records) <= 3  # after 0, 0.15, 0.45 s


def test_workers_that_come_back_end_the_wait(quick, caplog):
    client, ready = Client(itertools.chain([(), ()], itertools.repeat(("a",)))), itertools.count()
    with caplog.at_level(logging.WARNING):
        Cluster(client, "tcp://here:1", CubeError, 0.05).wait(lambda: next(ready) > 20)
    assert len(caplog.records) == 1


def test_a_scheduler_that_goes_while_something_waits_is_an_error(quick):
    client = Client(itertools.repeat(("a",)))
    client.status = "connecting"
    with pytest.raises(CubeError, match="connection to the Dask scheduler at tcp://here:1 is lost"):
        Cluster(client, "tcp://here:1", CubeError, None).wait(lambda: False)


@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("here", "is not the address of a Dask scheduler; allowed: tcp://HOST:PORT"),
        ("tcp://127.0.0.1:99999", "no Dask scheduler answers"),
        ("tcp://no.such.host.invalid:1", "no Dask scheduler answers"),
        (f"tcp://{'a' * 80}.invalid:1", "no Dask scheduler answers"),
    ],
)
def test_addresses_without_a_scheduler_are_refused(address, message):
    with pytest.raises(HcssError, match=message), Cluster.connected(address, HcssError):
        raise AssertionError


def test_a_scheduler_that_dies_while_a_client_connects_is_one_line(capfd, monkeypatch):
    """Dask printed two tracebacks."""
    monkeypatch.setattr(cluster, "CONNECT_S", 1)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def hang_up():
            while True:
                try:
                    server.accept()[0].close()
                except OSError:
                    return

        threading.Thread(target=hang_up, daemon=True).start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        with pytest.raises(CubeError, match="no Dask scheduler answers at"), Cluster.connected(address, CubeError):
            raise AssertionError
        server.shutdown(socket.SHUT_RDWR)
    assert "Traceback" not in "".join(capfd.readouterr())
