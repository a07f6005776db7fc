"""What the certificate costs: its share of whole runs of a shipped scenario, with and without kept tables.

    python benchmarks/certificate.py [--scenario stratus] [--pixels 24 300] [--rounds 3]

Runs with and without take turns, and the share is that of a round; tables and cloud optics are kept in a folder of
their own. The plan counts as part of the run, the start of Python does not.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import tempfile
import time
from pathlib import Path

from hcss_twin import Scenario, make_plan
from hcss_twin.scene.simulate import run


def seconds(name: str, pixels: int, output: Path) -> float:
    """Time of a run from the scenario to the finished cube."""
    start = time.perf_counter()
    run(make_plan(Scenario.load(name, {"output.certificate": pixels})), output)
    return time.perf_counter() - start


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenario", default="stratus")
    parser.add_argument("--pixels", type=int, nargs="+", default=[24])
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["HCSS_CACHE_DIR"] = str(Path(folder) / "cache")
        output = Path(folder) / "cube.nc"
        seconds(given.scenario, 1, output)  # compiles kernels
        for pixels in given.pixels:
            for kept in (False, True):
                found = []
                for _ in range(given.rounds):
                    both = []
                    for number in (0, pixels):
                        if not kept:
                            shutil.rmtree(Path(folder) / "cache" / "tables", ignore_errors=True)
                        both.append(seconds(given.scenario, number, output))
                    found.append(both)
                without, with_it = (statistics.median(each) for each in zip(*found, strict=True))
                share = statistics.median((b - a) / b for a, b in found)
                print(
                    f"{given.scenario}, {pixels} pixels, {'kept' if kept else 'new'} tables: {without:.2f} s without, "
                    f"{with_it:.2f} s with the certificate, {100 * share:.0f} % of the run",
                    flush=True,
                )


if __name__ == "__main__":
    main()
