"""Sweeps in several processes: the bytes of the serial run, whatever is killed, and no point computed twice."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter

import psutil
import pytest
from cheap import CHEAP_OPTIONS

pytestmark = [pytest.mark.long, pytest.mark.skipif(os.name == "nt", reason="POSIX signals")]

HCSS = [sys.executable, "-m", "hcss_twin"]
SMALL = [
    *CHEAP_OPTIONS,
    *("--set", "image.rows=8", "--set", "image.columns=8", "--set", "frames.count=1"),
    *("--set", 'bands=["lwir-10.8"]', "--set", "output.certificate=2"),
]
OVER = ["--over", "view.zenith=[0, 20, 40]", "--over", "seed={count = 4}"]
POINTS = 12

PLUGIN = '''
"""A cloud generator that ends its process for one seed and refuses another."""
import os

import numpy as np

from hcss_twin.providers import CloudDeclaration
from hcss_twin.providers.registry import ProviderSpec, hookimpl


@hookimpl
def hcss_register_cloud_generators():
    return [ProviderSpec("trap", "trap:Trap", None, 3, "a trap")]


class Trap:
    declares = CloudDeclaration()

    def __init__(self, inputs, parameters):
        self._thickness = inputs.layer.thickness_max_m
        if inputs.seed == 101:  # not a seed of the probes
            os._exit(9)
        if inputs.seed == 102:
            raise RuntimeError("not this one")

    def thickness_m(self, time_s, rows, columns):
        return np.full((rows.stop - rows.start, columns.stop - columns.start), self._thickness, np.float32)
'''


@pytest.fixture
def environment(tmp_path):
    return {
        **os.environ,
        "SOURCE_DATE_EPOCH": "1700000000",
        "HCSS_CACHE_DIR": str(tmp_path / "cache"),
        "OMP_NUM_THREADS": "1",
    }


def command(folder, *more):
    return [*HCSS, "sweep", "stratus", *SMALL, *OVER, "-o", str(folder), *more]


def run(arguments, environment, **more):
    return subprocess.run(arguments, env=environment, capture_output=True, text=True, timeout=300, **more)


def computed(folder):
    """Points that were computed, one entry each time."""
    log = folder / "points.jsonl"
    lines = log.read_text().splitlines() if log.exists() else []
    records = []
    for line in lines:
        with contextlib.suppress(ValueError):  # being written
            records.append(json.loads(line))
    return records


def wait_for(folder, count, process):
    deadline = time.monotonic() + 200
    while len(computed(folder)) < count:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)


def workers_of(process):
    return psutil.Process(process.pid).children()


def bytes_of(folder):
    return {path.name: path.read_bytes() for path in folder.glob("*.nc")}


def test_a_sweep_survives_a_killed_worker_and_a_kill_of_all_to_the_bit(tmp_path, environment):
    serial, folder = tmp_path / "serial", tmp_path / "cluster"
    done = run(command(serial, "--dataset", str(serial / "all.nc")), environment)
    assert done.returncode == 0, done.stderr

    # In a process group of its own, so that nothing but this process gets the signal.
    process = subprocess.Popen(
        command(folder, "--workers", "2"), env=environment, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    wait_for(folder, 2, process)
    workers_of(process)[-1].kill()
    wait_for(folder, 5, process)
    workers = workers_of(process)
    process.kill()
    process.communicate()
    psutil.wait_procs(workers, timeout=30)

    before = {path.name: (path.stat().st_ino, path.stat().st_mtime_ns) for path in folder.glob("point-*.nc")}
    logged = {record["point"] for record in computed(folder)}
    assert 5 <= len(before) < POINTS
    assert len(before) >= len(logged)
    done = run(command(folder, "--workers", "2", "--dataset", str(folder / "all.nc"), "--json"), environment)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    # Nothing done twice: what had its name stayed the same file, and the others were computed once.
    after = {path.name: (path.stat().st_ino, path.stat().st_mtime_ns) for path in folder.glob("point-*.nc")}
    assert {name: after[name] for name in before} == before
    assert len(answer["computed"]) == POINTS - len(before)
    assert Counter(record["point"] for record in computed(folder)) == dict.fromkeys(range(POINTS), 1)
    # Nothing lost, and every byte that of the serial run.
    assert bytes_of(folder) == bytes_of(serial)
    assert len(bytes_of(folder)) == POINTS + 1
    assert not list(folder.glob(".*"))


def test_a_point_that_kills_its_worker_twice_has_failed_and_the_others_are_done(tmp_path, environment):
    (tmp_path / "trap.py").write_text(PLUGIN)
    about = tmp_path / "trap-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: trap\nVersion: 1\n")
    (about / "entry_points.txt").write_text("[hcss_twin]\ntrap = trap\n")
    path = os.pathsep.join([str(tmp_path), *filter(None, [environment.get("PYTHONPATH")])])
    folder = tmp_path / "sweep"
    done = run(
        [*HCSS, "sweep", "stratus", *SMALL, "--set", "clouds.generator=trap", "--over", "seed=[100,101,102,103,104]",
         "-o", str(folder), "--workers", "2", "--json"],
        {**environment, "PYTHONPATH": path},
    )  # fmt: skip
    assert done.returncode == 1, done.stderr
    assert done.stderr.endswith("error: 2 of 5 points failed\n")
    errors = {record["point"]: record["error"] for record in json.loads(done.stdout)["failed"]}
    assert set(errors) == {1, 2}
    assert "the worker processes of both attempts died" in errors[1]
    assert "not this one" in errors[2]
    assert sorted(path.name for path in folder.glob("*.nc")) == [f"point-000{n}.nc" for n in (0, 3, 4)]


def test_an_interrupt_ends_the_workers_and_says_nothing_else(tmp_path, environment):
    folder, temporary = tmp_path / "sweep", tmp_path / "temporary"
    temporary.mkdir()
    process = subprocess.Popen(
        command(folder, "--workers", "2"), env=environment | {"TMPDIR": str(temporary)}, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    wait_for(folder, 2, process)
    workers = workers_of(process)
    # A terminal sends Ctrl-C to all.
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert errors.split() == ["interrupted"]
    assert not psutil.wait_procs(workers, timeout=30)[1]
    index = json.loads((folder / "index.json").read_text())
    assert index["states"]["done"] == len(computed(folder)) == len(bytes_of(folder))
    assert not list(folder.glob(".*"))
    assert not list(temporary.iterdir())


def test_a_scheduler_elsewhere_makes_the_same_bytes(tmp_path, environment):
    few = ["--over", "view.zenith=[0, 20]", "--over", "seed={count = 2}"]
    serial, folder = tmp_path / "serial", tmp_path / "cluster"
    assert run([*HCSS, "sweep", "stratus", *SMALL, *few, "-o", str(serial)], environment).returncode == 0
    # Two threads in one worker: points take turns, because the library for cubes is not thread safe.
    code = (
        "import sys\n"
        "from distributed import LocalCluster\n"
        "if __name__ == '__main__':\n"
        "    with LocalCluster(n_workers=1, threads_per_worker=2, dashboard_address='127.0.0.1:0') as cluster:\n"
        "        print(cluster.scheduler_address, flush=True)\n"
        "        sys.stdin.read()\n"
    )
    script = tmp_path / "cluster.py"
    script.write_text(code)
    with subprocess.Popen(
        [sys.executable, script], env=environment | {"SOURCE_DATE_EPOCH": "1"}, cwd=tmp_path, text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as cluster:  # fmt: skip
        address = cluster.stdout.readline().strip()
        done = run([*HCSS, "sweep", "stratus", *SMALL, *few, "-o", str(folder), "--scheduler", address], environment)
        cluster.stdin.close()
    assert done.returncode == 0, done.stderr
    assert bytes_of(folder) == bytes_of(serial)
