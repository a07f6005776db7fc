"""Exit code, message and worker processes of a command that is stopped from outside."""

import os
import signal
import subprocess
import sys
import time

import psutil
import pytest

from hcss_twin.cli.main import cli, main
from hcss_twin.core.processes import worker_pool

pytestmark = pytest.mark.skipif(os.name == "nt", reason="POSIX signals")

PARENT = """
import os, time
from hcss_twin.engine.parts import Workers

def work(seconds):
    time.sleep(seconds)
    return os.getpid()

if __name__ == "__main__":
    with Workers.of(2) as workers:
        print(*{each.result() for each in [workers.executor.submit(work, 0.5) for _ in range(2)]}, flush=True)
        list(workers.executor.map(work, [60, 60]))
"""


COPIED = """
import time
from hcss_twin.core.processes import start_worker

if __name__ == "__main__":
    print(*(start_worker(time.sleep, 60).pid for _ in range(2)), flush=True)
    time.sleep(60)
"""


@pytest.mark.parametrize("code", [PARENT, COPIED])
def test_workers_end_within_a_second_of_a_killed_parent(tmp_path, code):
    script = tmp_path / "parent.py"
    script.write_text(code)
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True) as process:
        workers = [psutil.Process(int(word)) for word in process.stdout.readline().split()]
        assert len(workers) == 2
        process.kill()
        deadline = time.monotonic() + 1
        while (alive := [each for each in workers if is_alive(each)]) and time.monotonic() < deadline:
            time.sleep(0.05)
        for each in alive:
            each.kill()
    assert not alive


def test_a_worker_starts_with_blocked_interrupts_and_before_it_loads_the_engine():
    with worker_pool(1) as pool:
        assert signal.SIGINT in pool.submit(signal.pthread_sigmask, signal.SIG_BLOCK, []).result()
        assert not pool.submit(modules_of_the_engine).result()


def modules_of_the_engine():
    """Return the modules of the engine that this process has loaded."""
    return [name for name in sys.modules if name.startswith("hcss_twin.engine")]


def test_an_interrupted_pool_does_not_wait_for_its_work():
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        interrupt_work_of(300)
    assert time.monotonic() - start < 150


def interrupt_work_of(seconds):
    with worker_pool(1) as pool:
        pool.submit(os.getpid).result()
        pool.submit(time.sleep, seconds)
        raise KeyboardInterrupt


def is_alive(process):
    """Return whether a process runs; one that has ended may remain as a zombie."""
    return process.is_running() and process.status() != psutil.STATUS_ZOMBIE


def exit_code_of(load, monkeypatch):
    """The exit code of the program whose commands are loaded by ``load``."""
    monkeypatch.setattr(cli, "main", load)
    before = {each: signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)}
    try:
        with pytest.raises(SystemExit) as left:
            main()
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)
    return left.value.code


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupt_that_a_library_turned_into_another_error_is_an_interrupt(monkeypatch, capsys, number, code):
    def load(**_):
        try:
            exec(f"import signal\nsignal.raise_signal({int(number)})")
        except KeyboardInterrupt:
            raise ImportError("the extension could not be loaded") from None

    assert exit_code_of(load, monkeypatch) == code
    assert capsys.readouterr().err == "interrupted\n"


def test_a_command_without_enough_memory_says_so(monkeypatch, capsys):
    def load(**_):
        raise MemoryError("Unable to allocate 7 TiB")

    assert exit_code_of(load, monkeypatch) == 1
    assert capsys.readouterr().err.startswith("error: memory ran out: Unable to allocate 7 TiB; ")
