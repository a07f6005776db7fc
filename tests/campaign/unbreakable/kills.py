"""Commands that write, killed at random moments: torn files, tracebacks, orphans, hangs?

The number of a row determines command, signal, its receivers and the moment, as a share of the time that the command
takes when it is left alone. Every tenth command is repeated: it must succeed and remove the drafts of the killed one.
"""

import os
import random
import shutil
import signal
import tempfile
import time
from collections import Counter
from functools import cache
from pathlib import Path

from campaign_processes import HERE, Command, left_files, torn_files

RESULTS = HERE / "results-kills.json"
COUNT = 500
REPEATED = 10
"""One of so many commands is repeated."""

KNOWN = ("313",)
"""Rows with a traceback that is Python's own: SIGINT before the first statement of ours that handles it has run."""

SET = [
    *("--set", "radiance.model=as-printed", "--set", "sea.model=cox-munk", "--set", "optics.provider=mie"),
    *("--set", "image.rows=64", "--set", "image.columns=64", "--set", "frames.count=3", "--set", 'bands=["mwir"]'),
    *("--set", "output.certificate=20", "--set", 'output.variables=["radiance","truth"]'),
]
RUN = ["run", "stratus", *SET]
SWEEP = ["sweep", "stratus", *SET, "--over", "seed={count = 6}", "-o", "swept"]
DRAWS = ["propagate", *RUN[1:], "--draws", "4", "--uncertain", "sea.temperature=normal:291:0.5", "-o", "drawn.nc"]
SENSE = ["--set", "sensor.parameters={noise = 'nedt', nedt = 0.05}"]

COMMANDS = {
    "run": [*RUN, "-o", "cube.nc"],
    "run, 2 workers": [*RUN, "-o", "cube.nc", "--workers", "2"],
    "run, Zarr": [*RUN, "-o", "cube.zarr"],
    "run, Zarr, 2 workers": [*RUN, "-o", "cube.zarr", "--workers", "2"],
    "run and sense": [*RUN, *SENSE, "-o", "cube.nc"],
    "sense": ["sense", "{sound}/cube.nc", "--sensor", "generic-mwir", "-o", "sensed.nc"],
    "sweep": SWEEP,
    "sweep, 2 workers": [*SWEEP, "--workers", "2"],
    "sweep with dataset": [*SWEEP, "--dataset", "swept.nc"],
    "propagate": DRAWS,
    "propagate, 2 workers": [*DRAWS, "--workers", "2", "--cube-of", "1"],
    "export FITS": ["export", "{sound}/cube.nc", "--to", "fits", "-o", "radiance.fits"],
    "export ENVI": ["export", "{sound}/cube.nc", "--to", "envi", "-o", "radiance.img"],
    "export GeoTIFF": ["export", "{sound}/cube.nc", "--to", "geotiff", "-o", "radiance.tif"],
    "export PNG": ["export", "{sound}/cube.nc", "--to", "png", "-o", "radiance.png"],
    "preview": ["preview", "{sound}/cube.nc", "-o", "."],
    "report": ["report", "{sound}/cube.nc", "-o", "page.html"],
    "report of a sweep": ["report", "{sound}/swept", "-o", "page.html"],
    "volume": ["volume", "{sound}/cube.nc", "-o", "volume.png", "--occupancy", "voxels.nc"],
    "import": ["import", "{sound}/image.npy", "--pixel-size", "1 km", "--to", "clouds"],
    "match": ["match", "{sound}/image.npy", "--pixel-size", "1 km", "-o", "matched.toml"],
    "fit": ["fit", "{sound}/image.npy", "--pixel-size", "1 km", "-o", "posterior.nc", "--octaves", "0", "4",
            "--samples", "100", *(word for name in ("gamma=3", "H=0.6", "Lx=8", "Ly=8") for word in ("--fix", name))],
    "evaluate": ["evaluate", "{sound}/cube.nc", "{sound}/cube.nc", "-o", "page.html", "--json", "numbers.json"],
    "import an atmosphere": ["atmosphere", "import", "{sound}/modtran.tp7", "-o", "table.nc",
                             "--profile", "us-standard-1976"],
    "plot an atmosphere": ["atmosphere", "plot", "band-model", "-o", "atmosphere.png"],
    "new plugin": ["new-plugin", "clouds", "campaign", "--folder", "plugin"],
}  # fmt: skip
"""Commands by name; all but the last replace what they have written, or go on with it."""

FORCED = ("run", "sense", "report", "export", "volume", "evaluate", "propagate", "match", "import")
"""Beginnings of the names of commands that need ``--force`` to replace their output."""

WHOLE_S = 300.0
"""A whole command on a busy machine takes no longer."""

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
CODES = {
    signal.SIGKILL: (-signal.SIGKILL,),
    signal.SIGTERM: (143, -signal.SIGTERM),
    signal.SIGINT: (130, -signal.SIGINT),
}


def keys():
    """Return the numbers of all rows, as text."""
    return [str(number) for number in range(COUNT)]


def arguments_of(name, sound):
    """Return the arguments of a command."""
    return [each.replace("{sound}", str(sound)) for each in COMMANDS[name]]


@cache
def sound():
    """Write the files that commands read, and return their folder, which exists as long as this process."""
    import numpy as np
    from input_files import noise, write_airs

    kept = tempfile.TemporaryDirectory()
    folder = Path(kept.name) / "sound"
    for name in ("run", "sweep"):
        assert Command(COMMANDS[name], folder).finish() == (0, [])
    np.save(folder / "image.npy", np.kron(noise(), np.ones((2, 2))))
    write_airs(folder)
    return folder, kept


@cache
def usual_s(name):
    """Return the time that a command takes when it is left alone."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.monotonic()
        command = Command(arguments_of(name, sound()[0]), Path(folder) / "out")
        code, problems = command.finish(WHOLE_S)
        if code != 0 or problems:
            raise RuntimeError(f"{name}: {code} {problems} {command.said()}")
        return time.monotonic() - start


def prepare():
    """Write the files that commands read."""
    sound()


def compute(key):
    """Return the row of a key."""
    draw = random.Random(f"kill {key}")
    name, number = draw.choice(list(COMMANDS)), draw.choice(SIGNALS)
    share = draw.uniform(0.0, 1.0)
    group = number != signal.SIGKILL and draw.random() < 0.5
    after_s = share * usual_s(name)
    before = _state(sound()[0])
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "out"
        command = Command(arguments_of(name, sound()[0]), folder)
        code = command.wait(after_s)
        start = time.monotonic()
        if killed := code is None:
            (os.killpg if group else os.kill)(command.process.pid, number)
        code, problems = command.finish()
        row = {
            "command": name,
            "signal": number.name,
            "to": "group" if group else "process",
            "after_s": round(after_s, 2),
            "ended_s": round(time.monotonic() - start, 2),
            "code": code,
            "killed": killed,
        }
        if code not in (0, *(CODES[number] if killed else ())):
            problems.append(f"exit code {code}: {command.said()[-300:]}")
        if number != signal.SIGKILL:
            problems += [f"left {each}" for each in left_files(folder)]
            problems += [f"left in the folder of temporary files: {each.name}" for each in command.temporary.iterdir()]
        problems += torn_files(folder)
        if _state(sound()[0]) != before:
            problems.append("an input has changed")
        if int(key) % REPEATED == 0:
            row["repeated"] = True
            problems += _repeat(name, folder)
    return row | {"problems": problems}


def _repeat(name, folder):
    """Run a command again where it was killed; return what is wrong."""
    if name == "new plugin":
        shutil.rmtree(folder / "plugin", ignore_errors=True)
    force = ["--force"] if name.startswith(FORCED) else []
    command = Command([*arguments_of(name, sound()[0]), *force], folder)
    code, problems = command.finish(WHOLE_S)
    if code != 0:
        problems.append(f"exit code {code}: {command.said()[-300:]}")
    problems += [f"left {each}" for each in left_files(folder)]
    return [f"repeated: {each}" for each in [*problems, *torn_files(folder)]]


def _state(folder):
    return {path: (path.stat().st_size, path.stat().st_mtime_ns) for path in sorted(folder.rglob("*"))}


def summary(rows):
    """Return lines of text."""
    killed = [row for row in rows.values() if row["killed"]]
    kinds = len({row["command"] for row in killed})
    yield f"{len(rows)} commands of {kinds} kinds, {len(killed)} killed before their end"
    yield f"  signals: {dict(Counter(row['signal'] for row in killed))}"
    if killed:
        slow = max(killed, key=lambda row: row["ended_s"])
        yield f"  longest time to end: {slow['ended_s']} s ({slow['command']}, {slow['signal']} at {slow['after_s']} s)"
    yield f"  repeated: {sum('repeated' in row for row in rows.values())}"
    yield f"  with problems: {sum(bool(row['problems']) for row in rows.values())}"
    for key, row in rows.items():
        for problem in row["problems"]:
            yield f"  {key} {row['command']}, {row['signal']} to {row['to']} after {row['after_s']} s: {problem}"
