"""What the certificate costs: its share of whole runs of a shipped scenario, by what was kept from earlier runs.

    python benchmarks/certificate.py [--scenario stratus] [--pixels 24 300] [--rounds 3]

Runs with and without take turns. The share is that of the shortest time of each, as others may use the machine; that of
processor time, of all threads, counts their waiting not at all. What is kept lies in a folder of its own: nothing
but cloud optics; or the tables of the scene, with another seed each time; or all of the same scene. The plan counts as
part of the run, the start of Python does not.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
import time
from pathlib import Path

from hcss_twin import Scenario, make_plan
from hcss_twin.engine.simulate import run


def seconds(name: str, pixels: int, seed: int, output: Path) -> tuple[float, float]:
    """Time of a run from the scenario to the finished cube, and processor time."""
    start, used = time.perf_counter(), time.process_time()
    run(make_plan(Scenario.load(name, {"output.certificate": pixels, "seed": seed})), output)
    return time.perf_counter() - start, time.process_time() - used


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", default="stratus")
    parser.add_argument("--pixels", type=int, nargs="+", default=[24])
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["HCSS_CACHE_DIR"] = str(Path(folder) / "cache")
        output = Path(folder) / "cube.nc"
        seconds(given.scenario, 1, 0, output)  # compiles kernels
        for pixels in given.pixels:
            for kept in ("nothing", "tables", "all"):
                found = []
                for turn in range(given.rounds):
                    both = []
                    for number in (0, pixels):
                        seed = 2 * turn + (number > 0) if kept == "tables" else 0
                        if kept == "nothing":
                            for kind in ("tables", "plans", "references"):
                                shutil.rmtree(Path(folder) / "cache" / kind, ignore_errors=True)
                        elif kept == "all":
                            seconds(given.scenario, number, seed, output)
                        both.append(seconds(given.scenario, number, seed, output))
                    found.append(both)
                told = []
                for kind, name in enumerate(("", " of processor time")):
                    without, with_it = (min(both[place][kind] for both in found) for place in range(2))
                    share = 100.0 * (1.0 - without / with_it)
                    told.append(f"{without:.2f} s{name} without, {with_it:.2f} s with it, {share:.0f} %")
                print(f"{given.scenario}, {pixels} pixels, {kept} kept: {'; '.join(told)}", flush=True)


if __name__ == "__main__":
    main()
