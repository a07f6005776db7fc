"""Peak memory of whole runs with few and with many frames, each in a process of its own.

::

    python benchmarks/memory.py                                  # `stratus`, 8 against 2000 frames of 800 x 800: 17 GB
    python benchmarks/memory.py --set image.rows=200 --set image.columns=200
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path


def child(scenario: str, frames: int, assignments: list[str]) -> None:
    """Run and print the peak resident size in MB."""
    from regression import peak_memory_mb

    from hcss_twin import Scenario, make_plan
    from hcss_twin.engine.simulate import run
    from hcss_twin.scenario.overrides import parse_assignment

    # Close frames: the sun stays up, and tables are few.
    overrides = {"frames.interval": 0.1, **dict(map(parse_assignment, assignments)), "frames.count": frames}
    with tempfile.TemporaryDirectory() as folder:
        run(make_plan(Scenario.load(scenario, overrides)), Path(folder) / "cube.nc")
    print(peak_memory_mb())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", default="stratus")
    parser.add_argument("--frames", type=int, nargs="+", default=[8, 2000])
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--child", type=int, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child is not None:
        child(given.scenario, given.child, given.set)
        return
    for frames in given.frames:
        command = [sys.executable, __file__, "--scenario", given.scenario, "--child", str(frames)]
        for each in given.set:
            command += ["--set", each]
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
        print(f"{frames} frames: {float(done.stdout.split()[-1]):.0f} MB", flush=True)


if __name__ == "__main__":
    main()
