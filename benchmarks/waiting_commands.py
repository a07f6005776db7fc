"""Rows of ``waiting.py`` that are whole commands: what they are, and one measurement of each."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from geometries import geometry


def settings(**keys: object) -> list[str]:
    """Return options that set keys of a scenario; ``__`` in a name is a point."""
    return [word for key, value in keys.items() for word in ("--set", f"{key.replace('__', '.')}={value}")]


def run(scene: str, *options: str) -> list[str]:
    """Return the words of a command that computes a scene."""
    return ["run", scene, "-o", "cube.nc", "--force", *options]


def sweep(over: str, *options: str) -> list[str]:
    """Return the words of a sweep of small scenes of stratus."""
    return ["sweep", "stratus", "-o", "out", *SMALL, "--over", over, *options]


SMALL = settings(image__rows=64, image__columns=64, frames__count=1)
DOT = settings(image__rows=8, image__columns=8, frames__count=1, output__certificate=0)
NIGHT = settings(time="2024-04-20T00:30:00+10:00", bands='["lwir"]', output__certificate=0)
CHEAP = settings(radiance__model='"as-printed"', sea__model='"cox-munk"', optics__provider='"mie"')
FROM_800_KM = settings(platform__altitude='"800 km"', frames__count=1)
ONE_PIXEL = [*CHEAP, *NIGHT, *settings(image__rows=1, image__columns=1)]
AT_NIGHT = run("stratus", *NIGHT, *DOT)
ONE_LAYER, TWO_LAYERS = run("stratus", *DOT), run("cirrus-over-cumulus", *DOT)
COARSE, FINE = (run("stratus", *DOT, *settings(accuracy=accuracy)) for accuracy in (1e-1, 1e-4))
MOVING_SUN = run("stratus", *DOT, *settings(frames__count=60))
SEEDS = sweep("seed={count = 100}")
CHEAP_SEEDS = sweep("seed={count = 100}", *CHEAP, *NIGHT)


def seen_from(number: int, tilt: float) -> list[str]:
    """Return settings of one of the random geometries: sun, and view at a share ``tilt`` of its zenith."""
    keys = geometry(number, tilt)
    return settings(time=keys["time"], view__zenith=keys["view"]["zenith"], view__azimuth=keys["view"]["azimuth"])


def square(pixels: int) -> list[str]:
    """Return settings of a wide field of pixels of 500 m."""
    return [*settings(image__rows=pixels, image__columns=pixels, image__pixel_size=500), *FROM_800_KM]


PYTHON = "import numpy"
LIBRARIES = "import numpy, numba, scipy.special, netCDF4, pydantic"
WRITES = """
import netCDF4, numpy
with netCDF4.Dataset("floor.nc", "w") as file:
    for name in ("time", "band", "y", "x"):
        file.createDimension(name, None if name == "time" else 1)
    variables = [file.createVariable(name, "f4", ("time", "band", "y", "x")) for name in ("one", "other")]
    for frame in range(2000):
        for variable in variables:
            variable[frame] = numpy.ones((1, 1, 1), "f4")
"""
"""Python programs that are floors of rows."""


@dataclass(frozen=True)
class Taken:
    """What a command took: processor time and time that passed, both in s, and its largest memory in MB."""

    cpu: float
    passed: float
    memory: float
    output: str


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes
    ----------
    name, aim : str
    command, less : sequence of str
        Words after ``hcss``; what ``less`` takes with kept tables and kernels is subtracted, if there is one.
    quantity : str
        Name of an attribute of :class:`Taken`; "ratio": time that passes with ``less`` over that with ``command``.
    per : float
        What the command makes, in the unit of ``scale``.
    unit : str
    scale : float
        Units in one second or MB.
    cold : bool
        Whether results of earlier runs are removed before.
    compiles : bool
        Whether kernels compiled by earlier runs are hidden.
    floors : mapping of str to str
        Python programs whose same quantity, in the same unit, is a floor.
    verdict : bool
        Whether the certificate's verdict belongs into the line.
    tilt : float
        The row is measured in several geometries, whose views have this share of the zeniths of a random draw; 0: in
        that of the scene alone.
    """

    name: str
    aim: str
    command: Sequence[str]
    less: Sequence[str] = ()
    quantity: str = "cpu"
    per: float = 1.0
    unit: str = "s"
    scale: float = 1.0
    cold: bool = False
    compiles: bool = False
    floors: Mapping[str, str] = field(default_factory=dict)
    verdict: bool = False
    tilt: float = 0.0


START = {"Python with numpy": PYTHON, "with numba, scipy, netCDF4": LIBRARIES}
FIELD_500_KM = run("stratus", *square(1000))
ROWS = {
    "first": Row(
        "first run on a machine", "12", run("stratus"), cold=True, compiles=True, floors={"libraries": LIBRARIES}
    ),
    "default": Row("default scene", "that of 0.1.0", run("stratus"), cold=True, verdict=True, tilt=1.0),
    "compile-3": Row("compile, one layer, 1e-3", "1.2", ONE_LAYER, ONE_LAYER, cold=True, tilt=1.0),
    "compile-1": Row("compile, one layer, 1e-1", "0.4", COARSE, COARSE, cold=True, tilt=1.0),
    "compile-4": Row("compile, one layer, 1e-4", "3", FINE, FINE, cold=True, tilt=1.0),
    "two-layers": Row("compile, two layers, 1e-3", "6", TWO_LAYERS, TWO_LAYERS, cold=True, tilt=1.0),
    "sun": Row("compile, sun moves 0.25 deg", "", MOVING_SUN, MOVING_SUN, cold=True, tilt=1.0),
    "compile-night": Row("compile, night LWIR", "0.35", AT_NIGHT, AT_NIGHT, cold=True),
    "views": Row(
        "wide field of 250 km", "8", run("stratus", *square(500), *settings(output__certificate=0)), cold=True, tilt=0.5
    ),
    "500-km": Row("500 km at 500 m by day", "18", FIELD_500_KM, cold=True, verdict=True, tilt=0.5),
    "500-km-memory": Row("the same, memory", "1000", FIELD_500_KM, quantity="memory", unit="MB", cold=True),
    "seeds": Row("sweep, 100 seeds", "4", SEEDS, cold=True, tilt=1.0),
    "memory": Row(
        "the same, memory", "400", SEEDS, quantity="memory", unit="MB", cold=True, floors={"libraries": LIBRARIES}
    ),
    "workers": Row(
        "sweep, 100 cheap points, 2 workers, times as fast",
        "1.6",
        [*CHEAP_SEEDS, "--workers", "2"],
        CHEAP_SEEDS,
        quantity="ratio",
        unit="",
        cold=True,
    ),
    "sea": Row(
        "sweep, 30 sea temperatures", "6", sweep("sea.temperature={from=288, to=294, steps=30}"), cold=True, tilt=1.0
    ),
    "draws": Row(
        "propagation, 100 draws",
        "7",
        [
            "propagate",
            "stratus",
            "-o",
            "out.nc",
            *SMALL,
            "--draws",
            "100",
            "--uncertain",
            "sea.temperature=uniform:289:293",
        ],
        cold=True,
        tilt=1.0,
    ),
    "night": Row(
        "night, one band, kept tables", "0.7", run("stratus", *NIGHT, *settings(frames__count=1)), floors=START
    ),
    "mask": Row(
        "mask alone",
        "0.7",
        run("stratus", *settings(frames__count=1, output__variables='["cloud_mask"]')),
        floors=START,
    ),
    "frames": Row(
        "frames of one pixel, each",
        "0.1",
        run("stratus", *ONE_PIXEL, *settings(frames__count=4001)),
        run("stratus", *ONE_PIXEL, *settings(frames__count=1)),
        per=4000,
        unit="ms",
        scale=1e3,
        floors={"netCDF4, two variables": WRITES},
    ),
}


class Refused(Exception):
    """A command ended with an error."""


class Version:
    """Commands of one checkout, with its own folder and cache."""

    def __init__(self, checkout: Path, folder: Path) -> None:
        self._folder = folder
        self._cache = folder / "cache"
        self._taken: dict[tuple[tuple[str, ...], bool, bool], Taken | None] = {}
        self._environment = os.environ | {
            "PYTHONPATH": str(checkout),
            "HCSS_CACHE_DIR": str(self._cache),
            "OMP_NUM_THREADS": "1",
        }
        self._environment.pop("PYTHONDONTWRITEBYTECODE", None)  # Python would compile all files at each start
        folder.mkdir()

    def begin_round(self) -> None:
        """Forget what commands took: rows of one round share a command."""
        self._taken.clear()

    def of(self, row: Row, more: Sequence[str] = ()) -> float | None:
        """Return one measurement of a row, with more options, in its unit; None if this version refuses it."""
        taken = self.taken([*row.command, *more], row.cold, row.compiles)
        less = self.taken([*row.less, *more], row.quantity == "ratio", False) if row.less else None
        if taken is None or (row.less and less is None):
            return None
        if row.quantity == "ratio":
            return None if less is None else less.passed / taken.passed
        own = getattr(taken, row.quantity) - (0.0 if less is None else getattr(less, row.quantity))
        return float(own * row.scale / row.per)

    def floor(self, row: Row, program: str) -> float:
        """Return what a Python program takes, in the unit of a row."""
        start = self._process(["-c", PYTHON])
        taken = self._process(["-c", program])
        least = start if row.per > 1.0 else Taken(0.0, 0.0, 0.0, "")
        return float((getattr(taken, row.quantity) - getattr(least, row.quantity)) * row.scale / min(row.per, 2000.0))

    def verdict(self, row: Row, more: Sequence[str] = ()) -> str:
        """Return the verdict of the certificate of a row's command with more options."""
        taken = self.taken([*row.command, *more], row.cold, row.compiles)
        words = ("computed as specified", "NOT as specified", "computed, NOT CHECKED")
        lines = [] if taken is None else [each.strip() for each in taken.output.splitlines()]
        return next((line.split(":")[0] for line in lines if line.startswith(words)), "no certificate")

    def taken(self, command: Sequence[str], cold: bool, compiles: bool) -> Taken | None:
        """Return what a command takes; of cold commands the first measurement of the round."""
        key = tuple(command), cold, compiles
        if key not in self._taken:
            result = self._measured(command, cold, compiles)
            if not cold or (result is not None and "compiling kernels" in result.output and not compiles):
                result = self._measured(command, cold, compiles)  # with kernels and tables of the first
            self._taken[key] = result
        return self._taken[key]

    def _measured(self, command: Sequence[str], cold: bool, compiles: bool) -> Taken | None:
        if cold:
            shutil.rmtree(self._cache, ignore_errors=True)
        shutil.rmtree(self._folder / "out", ignore_errors=True)
        (self._folder / "out.nc").unlink(missing_ok=True)
        kernels = self._folder / "kernels"
        shutil.rmtree(kernels, ignore_errors=True)
        own_kernels = {"NUMBA_CACHE_DIR": str(kernels)} if compiles else {}
        try:
            return self._process(["-m", "hcss_twin", *command], own_kernels)
        except Refused as error:
            print(error, file=sys.stderr)
            return None

    def _process(self, words: Sequence[str], more: Mapping[str, str] | None = None) -> Taken:
        output = self._folder / "output"
        begun = time.perf_counter()
        with output.open("wb") as file:
            process = subprocess.Popen(
                [sys.executable, *words],
                cwd=self._folder,
                env=self._environment | dict(more or {}),
                stdout=file,
                stderr=subprocess.STDOUT,
            )
            _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        passed, text = time.perf_counter() - begun, output.read_text(errors="replace")
        if process.returncode and not (process.returncode == 1 and "NOT as specified" in text):  # by its certificate
            raise Refused(text[-300:])
        return Taken(usage.ru_utime + usage.ru_stime, passed, usage.ru_maxrss * 1.024e-3, text)
