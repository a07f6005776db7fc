"""Bombs and faults: full disks, read-only folders, little memory, processes that are killed, several runs at once.

A command must succeed, or end with one of our exit codes and a message. It leaves no draft, no torn
file and no process.
"""

import os
import resource
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

from bombs import BOMBS
from campaign_processes import Command, left_files, torn_files
from kills import COMMANDS, RUN, SWEEP, WHOLE_S, arguments_of, sound

MEMORY = 3 * 2**30
"""Address space of a command that reads a bomb."""


def keys():
    """Return the names of all bombs and faults."""
    return [*(f"bomb: {name}" for name in BOMBS), *FAULTS]


def prepare():
    """Write the files that commands read."""
    sound()


def compute(key):
    """Return the row of a bomb or fault."""
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "out"
        folder.mkdir()
        codes, problems = _bomb(key, folder) if key.startswith("bomb: ") else FAULTS[key](folder)
        problems += [f"left {each}" for each in left_files(folder)] + torn_files(folder)
    return {"codes": codes, "seconds": round(time.monotonic() - start, 1), "problems": problems}


def _limit(kind, size):
    """Return what limits a resource of a process before it starts."""
    return lambda: resource.setrlimit(kind, (size, size))


def _finished(command, allowed):
    """Wait for a command; return its code and problems."""
    code, problems = command.finish(WHOLE_S)
    if code not in allowed:
        problems.append(f"exit code {code}: {command.said()[-300:]}")
    if code != 0 and not command.said().strip():
        problems.append("says nothing")
    return code, problems


def _one(arguments, folder, allowed=(1, 2), **options):
    code, problems = _finished(Command(arguments, folder, **options), allowed)
    return [code], problems


def _bomb(key, folder):
    write, name, arguments = BOMBS[key.removeprefix("bomb: ")]
    file = folder.parent / name
    write(file)
    words = [each.replace("{file}", str(file)) for each in arguments]
    return _one(words, folder, preexec_fn=_limit(resource.RLIMIT_AS, MEMORY))


@contextmanager
def _mounted(folder, *options):
    """Mount a folder in memory; needs the rights of root."""
    subprocess.run(["mount", "-t", "tmpfs", "-o", ",".join(options), "tmpfs", folder], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", folder], check=True)


def _full_disk(name):
    def fault(folder):
        with _mounted(folder, "size=16k"):
            codes, problems = _one(arguments_of(name, sound()[0]), folder, (0, 1))  # 0: what is written is small
            return codes, problems + [f"left {each}" for each in left_files(folder)] + torn_files(folder)

    return fault


def _read_only(name):
    def fault(folder):
        with _mounted(folder, "ro"):
            return _one(arguments_of(name, sound()[0]), folder, (1,))

    return fault


def _large_files(name):
    """Files may not be larger than 8 kB: the error comes from write() itself."""
    return lambda folder: _one(
        arguments_of(name, sound()[0]), folder, (1,), preexec_fn=_limit(resource.RLIMIT_FSIZE, 8192)
    )


def _little_memory(megabytes):
    return lambda folder: _one(
        [*RUN, "--set", "image.rows=4000", "--set", "image.columns=4000", "-o", "cube.nc"],
        folder, (0, 1, 2), preexec_fn=_limit(resource.RLIMIT_AS, megabytes * 2**20),
    )  # fmt: skip


def _environment(**variables):
    def fault(folder):
        values = {name: value.replace("{folder}", str(folder.parent)) for name, value in variables.items()}
        return _one([*RUN, "-o", "cube.nc"], folder, (0, 1), environment=values)

    return fault


def _parallel(arguments, count, winners):
    """Start equal commands at once; return what fails if not so many succeed."""

    def fault(folder):
        commands = []
        for number in range(count):
            own = Command(arguments, folder.parent / f"process-{number}")
            commands.append(own)
        ended = [_finished(each, (0, 1)) for each in commands]
        codes = [code for code, _ in ended]
        problems = [problem for _, own in ended for problem in own]
        if codes.count(0) not in winners:
            problems.append(f"exit codes {codes}")
        return codes, problems

    return fault


def _same_output(arguments, count, winners):
    return lambda folder: _parallel(
        [str(folder / each) if each in OUTPUTS else each for each in arguments], count, winners
    )(folder)


OUTPUTS = ("cube.nc", "swept")


def _killed_worker(name, allowed):
    """Kill a worker as soon as there are two, or the first of a sweep, which may need no other."""

    def fault(folder):
        command = Command(arguments_of(name, sound()[0]), folder)
        deadline = time.monotonic() + 50
        workers = []
        enough = 1 if name.startswith("sweep") else 2
        while time.monotonic() < deadline and command.process.poll() is None and len(workers) < enough:
            others = [each for each in command.alive() if each.pid != command.process.pid]
            workers = [each for each in others if "resource_tracker" not in " ".join(each.cmdline())]
            time.sleep(0.2)
        if workers:
            workers[0].kill()
        code, problems = _finished(command, allowed)
        return [code], problems + ([] if workers else ["no worker to kill"])

    return fault


def _killed_scheduler(arguments):
    """Kill the Dask scheduler while it computes."""

    def fault(folder):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        dask = ["--host", "127.0.0.1", "--port", str(port), "--no-dashboard"]
        scheduler = Command(dask, folder.parent / "scheduler", ("-m", "distributed.cli.dask_scheduler"))
        worker = Command([f"tcp://127.0.0.1:{port}", "--no-nanny", "--no-dashboard"], folder.parent / "worker",
                         ("-m", "distributed.cli.dask_worker"))  # fmt: skip
        command = Command([*arguments, "--scheduler", f"tcp://127.0.0.1:{port}"], folder)
        try:
            time.sleep(_moment(command, worker))
            scheduler.process.kill()
            code, problems = _finished(command, (0, 1))
        finally:
            for each in (scheduler, worker):
                each.process.kill()
                each.process.wait()
        return [code], problems

    return fault


def _moment(command, worker):
    """Wait until the worker has begun to work for a command; return no further delay."""
    deadline = time.monotonic() + 40
    while time.monotonic() < deadline and command.process.poll() is None and "Starting" not in worker.said():
        time.sleep(0.2)
    return 3.0


def _gone_folder(folder):
    """The current folder is removed while the command starts."""
    inner = folder / "inner"
    command = Command([*RUN, "-o", "cube.nc"], inner)
    shutil.rmtree(inner)
    code, problems = _finished(command, (0, 1, 2))
    return [code], problems


def _closed_pipe(folder):
    """What reads the output has ended."""
    reading, writing = os.pipe()
    os.close(reading)
    process = subprocess.run(
        [sys.executable, "-m", "hcss_twin", "schema"], cwd=folder, stdout=writing, stderr=subprocess.PIPE, text=True
    )
    os.close(writing)
    problems = [process.stderr[-300:]] if "Traceback" in process.stderr or "Exception" in process.stderr else []
    return [process.returncode], problems


FAULTS = {
    **{f"full disk: {name}": _full_disk(name) for name in COMMANDS if name not in ("new plugin", "plot an atmosphere")},
    **{f"file size: {name}": _large_files(name) for name in ("run", "run, Zarr", "sweep", "report", "fit")},
    **{f"read-only: {name}": _read_only(name) for name in COMMANDS},
    **{f"{size} MB of memory": _little_memory(size) for size in (400, 800, 1200, 2000)},
    "no home": _environment(HOME="", HCSS_CACHE_DIR=""),
    "cache is a file": _environment(HCSS_CACHE_DIR="/dev/null"),
    "cache on a full device": _environment(HCSS_CACHE_DIR="/dev/full/x"),
    "no folder of temporary files": _environment(TMPDIR="{folder}/none"),
    "letters of C": _environment(LC_ALL="C", LANG="C", PYTHONUTF8="0"),
    "three equal runs": _same_output([*RUN, "-o", "cube.nc"], 3, (1,)),
    "two equal sweeps": _same_output(SWEEP, 2, (1,)),
    "five runs with one empty cache": _parallel([*RUN, "-o", "cube.nc"], 5, (5,)),
    "killed worker: run": _killed_worker("run, 2 workers", (0, 1)),
    "killed worker: sweep": _killed_worker("sweep, 2 workers", (0, 1)),
    "killed worker: propagate": _killed_worker("propagate, 2 workers", (0, 1)),
    "killed scheduler: sweep": _killed_scheduler(SWEEP),
    "killed scheduler: run": _killed_scheduler([*RUN, "-o", "cube.nc"]),
    "current folder removed": _gone_folder,
    "closed pipe": _closed_pipe,
}


def summary(rows):
    """Return lines of text."""
    yield f"{len(rows)} bombs and faults, {sum(bool(row['problems']) for row in rows.values())} with problems"
    longest = max(rows, key=lambda key: rows[key]["seconds"], default=None)
    if longest is not None:
        yield f"  longest: {rows[longest]['seconds']} s ({longest})"
    for key, row in rows.items():
        yield from (f"  {key}: {problem}" for problem in row["problems"])
