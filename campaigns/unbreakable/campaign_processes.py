"""Commands in processes of their own, and what must hold after any of them has ended, however it has."""

import json
import os
import secrets
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import netCDF4
import numpy as np
import psutil

from hcss_twin.cube.header import FORMAT_ATTRIBUTE
from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE
from hcss_twin.cube.zarr_writer import is_zarr
from hcss_twin.sweeps.dataset import MARK as SWEEP

sys.path.append(str(Path(__file__).parents[2] / "tests" / "stability"))

MARK = "HCSS_CAMPAIGN"
"""Environment variable by which the processes of a command are known."""

LONGEST_S = 60.0
"""A command that takes longer to end hangs."""

ORPHAN_S = 3.0
"""Time in which the processes of a command end after it."""


class Command:
    """A command that runs in a folder, with a folder of its own for temporary files."""

    def __init__(self, arguments, folder, program=("-m", "hcss_twin"), **options):
        self.folder, self.temporary = folder, folder.parent / f"{folder.name}-tmp"
        for each in (self.folder, self.temporary):
            each.mkdir(exist_ok=True)
        self.mark = secrets.token_hex(8)
        environment = {**os.environ, MARK: self.mark, "TMPDIR": str(self.temporary), "OMP_NUM_THREADS": "1"}
        environment |= options.pop("environment", {})
        self._output = self.folder.parent / f"{folder.name}.txt"
        with self._output.open("wb") as output:
            self.process = subprocess.Popen(
                [sys.executable, *program, *map(str, arguments)],
                cwd=folder, env=environment, stdout=output, stderr=output, start_new_session=True, **options,
            )  # fmt: skip

    def wait(self, seconds):
        """Return the exit code, or None if the command runs longer."""
        with suppress(subprocess.TimeoutExpired):
            return self.process.wait(seconds)
        return None

    def alive(self):
        """Return the processes of the command that run."""
        found = []
        for each in psutil.process_iter():
            with suppress(psutil.Error):
                if each.status() != psutil.STATUS_ZOMBIE and each.environ().get(MARK) == self.mark:
                    found.append(each)
        return found

    def finish(self, longest_s=LONGEST_S):
        """Wait for the end of the command and of all of its processes; return the code and what is wrong."""
        code, problems = self.wait(longest_s), []
        if code is None:
            problems.append(f"hangs: {self.said()[-200:]}")
        else:
            deadline = time.monotonic() + ORPHAN_S
            while (left := self.alive()) and time.monotonic() < deadline:
                time.sleep(0.1)
            problems += [f"orphan: {' '.join(each.cmdline())[:100]}" for each in left]
        for each in self.alive():
            with suppress(psutil.Error):
                each.kill()
        self.process.wait()
        said = self.said()
        # The tracker of a killed process removes its semaphores, and says so.
        for word in ("Traceback", "Exception ignored", "leaked", "Segmentation", "Fatal Python"):
            if word in said and not (word == "leaked" and code == -signal.SIGKILL):
                problems.append(f"{word}: {said[said.index(word) :][-400:]}")
        return code, problems

    def said(self):
        """Return what the command and its processes have printed."""
        return self._output.read_text(errors="replace")


def torn_files(folder):
    """Return what is wrong with files that have a final name: each must be whole, and its radiance positive."""
    with _ONE_AT_A_TIME:
        return _torn_files(folder)


_ONE_AT_A_TIME = threading.Lock()
"""The netCDF library is not thread safe."""


def _torn_files(folder):
    return [
        problem
        for path in sorted(folder.rglob("*"))
        if not path.name.startswith(".") and not any(is_zarr(each) for each in path.parents)
        if (problem := _torn(path)) is not None
    ]


def _torn(path):
    try:
        if path.suffix == ".nc" or is_zarr(path):
            return _wrong_values(path)
        if path.suffix == ".html":
            whole = path.read_text(encoding="utf-8").rstrip().endswith("</html>")
            return None if whole else f"{path.name}: not whole"
        if path.suffix in (".png", ".gif", ".tif"):
            from PIL import Image

            with Image.open(path) as picture:
                for frame in range(getattr(picture, "n_frames", 1)):
                    picture.seek(frame)
                    picture.load()
        elif path.suffix == ".json":
            json.loads(path.read_text(encoding="utf-8"))
        elif path.suffix == ".fits":
            from astropy.io import fits

            fits.open(path, memmap=False)[0].data.sum()
    except Exception as error:
        return f"{path.name}: {type(error).__name__}: {error}"
    return None


def _wrong_values(path):
    if is_zarr(path):
        with open_cube(path) as cube:
            return _wrong_radiance(path, cube.radiance.values, SENSOR_ATTRIBUTE in cube.attrs)
    with netCDF4.Dataset(path) as file:
        values = {name: variable[...] for name, variable in file.variables.items()}
        about = file.ncattrs()
    if FORMAT_ATTRIBUTE not in about or SWEEP in about or "radiance" not in values:
        return None
    return _wrong_radiance(path, np.ma.filled(values["radiance"], np.nan), SENSOR_ATTRIBUTE in about)


def _wrong_radiance(path, radiance, is_measured):
    if not np.all(np.isfinite(radiance)) or (not is_measured and np.any(radiance < 0.0)):
        return f"{path.name}: radiance that is not finite or negative"
    return None


def left_files(folder):
    """Return the names of drafts."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob(".*.partial"))
