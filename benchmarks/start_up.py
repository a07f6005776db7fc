"""What commands cost before they do anything: seconds that pass and seconds of processor, the least of some rounds.

::

    python benchmarks/start_up.py [--scenario stratus] [--rounds 9]

Kernels are compiled and tables kept before the first round. Where others use the machine, trust the processor's
seconds.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time

HCSS = [sys.executable, "-m", "hcss_twin"]
NIGHT = "time=2024-04-20T00:30:00+10:00"
SCENE = """
import sys, time
from hcss_twin.cli import main
import hcss_twin.engine.simulate as simulation
whole = simulation.run
def clocked(*arguments):
    start = time.perf_counter(), time.process_time()
    result = whole(*arguments)
    print("scene", time.perf_counter() - start[0], time.process_time() - start[1])
    return result
simulation.run = clocked
sys.argv = ["hcss", *sys.argv[1:]]
main()
"""


def clocked(command: list[str], folder: str) -> tuple[float, float]:
    """Seconds of one process, less those of the scene if it tells them."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, text=True, check=True)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    for line in done.stdout.splitlines():
        if line.startswith("scene "):
            of_scene = [float(word) for word in line.split()[1:]]
            return wall - of_scene[0], cpu - of_scene[1]
    return wall, cpu


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", default="stratus")
    parser.add_argument("--rounds", type=int, default=9)
    given = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    scene = ["run", given.scenario, "--force", "-o", "cube.nc", "--set", "output.certificate=0"]
    commands = {
        "python": [sys.executable, "-c", "pass"],
        "import numpy": [sys.executable, "-c", "import numpy"],
        "import numpy, hcss_twin": [sys.executable, "-c", "import numpy, hcss_twin"],
        "import hcss_twin; hcss_twin.simulate": [sys.executable, "-c", "import hcss_twin; hcss_twin.simulate"],
        "hcss --help": [*HCSS, "--help"],
        "hcss plugins": [*HCSS, "plugins"],
        f"hcss plan {given.scenario}": [*HCSS, "plan", given.scenario],
        f"hcss run {given.scenario}, less the scene": [sys.executable, "-c", SCENE, *scene],
        f"hcss run {given.scenario}, LWIR at night": [*HCSS, *scene, "--set", NIGHT, "--set", 'bands=["lwir"]'],
        f"hcss run {given.scenario}, mask alone": [*HCSS, *scene, "--set", 'output.variables=["cloud_mask"]'],
    }
    with tempfile.TemporaryDirectory() as folder:
        for command in commands.values():
            clocked(command, folder)
        found = {name: [] for name in commands}
        for _ in range(given.rounds):
            for name, command in commands.items():
                found[name].append(clocked(command, folder))
    print("| command | seconds | of processor |\n|---|---|---|")
    for name, times in found.items():
        wall, cpu = (min(each) for each in zip(*times, strict=True))
        print(f"| `{name}` | {wall:.2f} | {cpu:.2f} |")


if __name__ == "__main__":
    main()
