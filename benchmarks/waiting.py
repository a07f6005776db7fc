"""Where people wait: processor time of whole commands, beside another version, floors and peers, in one run.

    python benchmarks/waiting.py [--rows sweep,views] [--against FOLDER] [--rounds 3]

Every row is a command, less another one if only their difference counts, divided by what it made. ``--against`` names
a checkout of another version, whose commands alternate with ours, so that both meet the same load. Tables and other
results are removed before each command whose row says ``cold``; kernels are compiled before. All rows together take an
hour.
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parents[1]
PIXELS, FRAMES = 512, 32


def settings(**keys: object) -> list[str]:
    """Return options that set keys of a scenario; ``__`` in a name is a point."""
    return [word for key, value in keys.items() for word in ("--set", f"{key.replace('__', '.')}={value}")]


def run(scene: str, *options: str) -> list[str]:
    """Return the words of a command that computes a scene."""
    return ["run", scene, "-o", "cube.nc", "--force", *options]


SMALL = settings(image__rows=64, image__columns=64, frames__count=1)
DOT = settings(image__rows=8, image__columns=8, frames__count=1, output__certificate=0)
NIGHT = settings(time="2024-04-20T00:30:00+10:00", bands='["lwir"]', output__certificate=0)
CHEAP = settings(radiance__model='"as-printed"', sea__model='"cox-munk"', optics__provider='"mie"')
WIDE = settings(image__rows=500, image__columns=500, image__pixel_size=500, frames__count=1)
FROM_800_KM = settings(platform__altitude='"800 km"')


def stream(scene: str, frames: int, variables: str, *options: str) -> list[str]:
    """Return the words of a command that streams large frames of two bands."""
    size = settings(image__rows=PIXELS, image__columns=PIXELS, frames__count=frames, bands='["mwir-3.7", "lwir-10.8"]')
    return run(scene, *size, *settings(output__certificate=0, output__variables=variables), *options)


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes
    ----------
    name, aim : str
    command, less : sequence of str
        Words after ``hcss``; the time of ``less`` is subtracted, if there is one.
    per : float
        What the command makes, in the unit of ``scale``.
    unit : str
    scale : float
        Units in one second.
    cold : bool
        Whether results of earlier runs are removed before.
    """

    name: str
    aim: str
    command: Sequence[str]
    less: Sequence[str] = ()
    per: float = 1.0
    unit: str = "s"
    scale: float = 1.0
    cold: bool = False


def difference(name: str, aim: str, command: Sequence[str], less: Sequence[str], bands: int) -> Row:
    """Return a row of nanoseconds for each pixel and frame, or pixel, frame and band."""
    return Row(name, aim, command, less, PIXELS * PIXELS * (FRAMES - 1) * bands, "ns", 1e9)


MASK, RADIANCE = '["cloud_mask"]', '["radiance"]'
TEMPERATURE = '["radiance", "brightness_temperature"]'
STRATOCUMULUS = settings(clouds__type='"stratocumulus"')
SENSOR = settings(sensor__name='"generic-mwir"')
ROWS = {
    "seeds": Row(
        "sweep, 100 seeds", "6", ["sweep", "stratus", "-o", "out", *SMALL, "--over", "seed={count = 100}"], cold=True
    ),
    "sea": Row(
        "sweep, 30 sea temperatures",
        "5",
        ["sweep", "stratus", "-o", "out", *SMALL, "--over", "sea.temperature={from = 288, to = 294, steps = 30}"],
        cold=True,
    ),
    "draws": Row(
        "propagation, 100 draws",
        "8",
        ["run", "stratus", "-o", "out.nc", *SMALL, "--draws", "100", "--uncertain", "sea.temperature=uniform:289:293"],
        cold=True,
    ),
    "default": Row("default scene", "that of 0.1.0", run("stratus"), cold=True),
    "compile-3": Row("compile, one layer, 1e-3", "0.4", run("stratus", *DOT), run("stratus", *NIGHT, *DOT), cold=True),
    "compile-4": Row(
        "compile, one layer, 1e-4",
        "1",
        run("stratus", *DOT, *settings(accuracy=1e-4)),
        run("stratus", *NIGHT, *DOT),
        cold=True,
    ),
    "two-layers": Row(
        "compile, two layers, 1e-3", "2", run("cirrus-over-cumulus", *DOT), run("stratus", *NIGHT, *DOT), cold=True
    ),
    "sun": Row(
        "compile, sun moves 0.25 deg",
        "",
        run("stratus", *settings(image__rows=8, image__columns=8, frames__count=60, output__certificate=0)),
        run("stratus", *DOT),
        cold=True,
    ),
    "views": Row(
        "wide field of 250 km", "4", run("stratus", *WIDE, *FROM_800_KM, *settings(output__certificate=0)), cold=True
    ),
    "temperature": difference(
        "brightness temperature, per value",
        "1",
        stream("stratus", FRAMES, TEMPERATURE),
        stream("stratus", FRAMES, RADIANCE),
        2,
    ),
    "sensor": difference(
        "sensor, per pixel and band",
        "2.5",
        stream("stratus", FRAMES, RADIANCE, *SENSOR),
        stream("stratus", FRAMES, RADIANCE),
        1,
    ),
    "waves": difference(
        "resolved waves, per pixel",
        "40",
        stream("stratus", FRAMES, RADIANCE, *settings(sea__waves='"resolved"', image__pixel_size=2)),
        stream("stratus", 1, RADIANCE, *settings(sea__waves='"resolved"', image__pixel_size=2)),
        1,
    ),
    "stratus": difference(
        "scene of stratus, per pixel", "", stream("stratus", FRAMES, RADIANCE), stream("stratus", 1, RADIANCE), 1
    ),
    "cumulus": difference(
        "mask of cumulus, per pixel", "7", stream("cumulus", FRAMES, MASK), stream("cumulus", 1, MASK), 1
    ),
    "stratocumulus": difference(
        "mask of stratocumulus, per pixel",
        "7",
        stream("stratus", FRAMES, MASK, *STRATOCUMULUS),
        stream("stratus", 1, MASK, *STRATOCUMULUS),
        1,
    ),
    "simulated": difference(
        "mask of simulated, per pixel", "6", stream("simulated", FRAMES, MASK), stream("simulated", 1, MASK), 1
    ),
    "samples": difference(
        "two layers, 3 x 3 samples, per sample",
        "25",
        stream("cirrus-over-cumulus", FRAMES, RADIANCE, *settings(image__samples_per_pixel=3)),
        stream("cirrus-over-cumulus", 1, RADIANCE, *settings(image__samples_per_pixel=3)),
        9,
    ),
    "night": Row("night, one band, kept tables", "0.7", run("stratus", *NIGHT, *settings(frames__count=1))),
    "mask": Row("mask alone", "0.7", run("stratus", *settings(frames__count=1, output__variables=MASK))),
    "frames": Row(
        "frames of one pixel, each",
        "0.1",
        run("stratus", *CHEAP, *NIGHT, *settings(image__rows=1, image__columns=1, frames__count=2001)),
        run("stratus", *CHEAP, *NIGHT, *settings(image__rows=1, image__columns=1, frames__count=1)),
        2000,
        "ms",
        1e3,
    ),
}


class Version:
    """Commands of one checkout, with its own folder and cache."""

    def __init__(self, checkout: Path, folder: Path) -> None:
        self._folder = folder
        self._cache = folder / "cache"
        self._environment = os.environ | {
            "PYTHONPATH": str(checkout),
            "HCSS_CACHE_DIR": str(self._cache),
            "OMP_NUM_THREADS": "1",
        }
        folder.mkdir()

    def seconds(self, command: Sequence[str], cold: bool) -> float | None:
        """Return the processor time of a command; None if this version refuses it."""
        if cold:
            shutil.rmtree(self._cache, ignore_errors=True)
        shutil.rmtree(self._folder / "out", ignore_errors=True)
        (self._folder / "out.nc").unlink(missing_ok=True)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(
            [sys.executable, "-m", "hcss_twin.cli", *command],
            cwd=self._folder,
            env=self._environment,
            capture_output=True,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode not in (0, 1):  # 1: a certificate failed
            print(done.stderr.decode()[-300:], file=sys.stderr)
            return None
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def of(self, row: Row) -> float | None:
        """Return one measurement of a row in its unit."""
        taken = self.seconds(row.command, row.cold)
        less = self.seconds(row.less, row.cold) if row.less else 0.0
        return None if taken is None or less is None else (taken - less) * row.scale / row.per


def line(row: Row, versions: Sequence[Version], rounds: int) -> str:
    """Return one line of the table: medians, and the median of the ratios of pairs."""
    for version in versions:  # compiles kernels, keeps tables of both commands
        version.seconds(row.command, cold=False)
        if row.less:
            version.seconds(row.less, cold=False)
    pairs = [[version.of(row) for version in versions] for _ in range(rounds)]
    cells = []
    for own in zip(*pairs, strict=True):
        known = [each for each in own if each is not None]
        cells.append(f"{statistics.median(known):.3g} {row.unit}" if known else "refused")
    ratios = [old / new for new, *others in pairs for old in others if old is not None and new]
    return f"| {row.name} | {' | '.join(cells)} | {f'{statistics.median(ratios):.2g}' if ratios else ''} | {row.aim} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=lambda text: text.split(","), default=list(ROWS), help=", ".join(ROWS))
    parser.add_argument("--against", type=Path, help="checkout of another version")
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    checkouts = [HERE] if given.against is None else [HERE, given.against]
    with tempfile.TemporaryDirectory(prefix="hcss-waiting-") as name:
        versions = [Version(each.resolve(), Path(name) / str(number)) for number, each in enumerate(checkouts)]
        named = ["now", "before"][: len(versions)]
        print(f"| processor time | {' | '.join(named)} | before / now | aim |\n|---|{'---|' * (len(named) + 2)}")
        for each in given.rows:
            print(line(ROWS[each], versions, given.rounds), flush=True)


if __name__ == "__main__":
    main()
