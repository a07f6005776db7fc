"""Ratios of times of the baseline scene, for information: ``counts.py`` is the gate.

    python benchmarks/baseline.py                 # print (some minutes; 20 GB of disk for a moment)
    python benchmarks/baseline.py --update        # and write benchmarks/baseline.json and the page
    python benchmarks/baseline.py --parts a c     # some of them

The scene is ``stratus``: 8 frames of 800 x 800 pixels, three bands, accuracy 1e-3, radiance model ``physical``. What is
above and what is below a ratio take turns, and the shortest time of each counts: others may use the machine. Tables and
cubes lie in a folder of their own, which is removed.
"""

from __future__ import annotations

import argparse
import os
import platform
import tempfile
from pathlib import Path

from baseline_ratios import PARTS
from hcss_bench.stages import private_cache
from page import put
from regression import Ratio, read_ratios, write_ratios

COMMITTED = Path(__file__).with_name("baseline.json")


def measure(parts: list[str], rounds: int, where: Path) -> dict[str, Ratio]:
    """Measure and print a row for each ratio."""
    print("| ratio | measured | aim | reached | seconds here, for information | what |")
    print("|---|---|---|---|---|---|")
    found = {}
    with tempfile.TemporaryDirectory(prefix=".hcss-baseline-", dir=where) as name:
        folder = Path(name)
        with private_cache(folder / "cache"):
            for part in parts:
                for ratio, told in PARTS[part](rounds, folder):
                    found[ratio.name] = ratio
                    aim = f"{'at most' if ratio.better == 'lower' else 'at least'} {ratio.aim:.4g}"
                    print(
                        f"| {ratio.name} | {ratio.value:.4g} | {aim} | {'yes' if ratio.reached else 'NO'} | {told} | "
                        f"{ratio.what} |",
                        flush=True,
                    )
    return found


def table(ratios: dict[str, Ratio]) -> str:
    """Return committed ratios as a table in Markdown."""
    lines = ["| ratio | measured | aim | reached | what |", "|---|---|---|---|---|"]
    for each in ratios.values():
        value = f"{each.value:.3g}" if each.value < 1e5 else f"{each.value:.1e}"
        aim = f"{'at most' if each.better == 'lower' else 'at least'} {each.aim:.3g}"
        lines.append(f"| {each.name} | {value} | {aim} | {'yes' if each.reached else '**no**'} | {each.what} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parts", nargs="+", choices=list(PARTS), default=list(PARTS))
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--folder", type=Path, default=Path("."), help="where cubes are written for a moment")
    parser.add_argument("--update", action="store_true", help="commit what was measured")
    given = parser.parse_args()
    before = read_ratios(COMMITTED) if COMMITTED.exists() else {}
    found = measure(given.parts, given.rounds, given.folder)
    if given.update:
        others = {name: ratio for name, ratio in before.items() if name[0] not in given.parts}
        both = others | found
        about = {
            "about": "ratios of benchmarks/baseline.py; aims in seconds are over the import of the same run",
            "machine": f"{platform.machine()}, {os.cpu_count()} CPUs, Python {platform.python_version()}",
        }
        write_ratios(COMMITTED, {name: both[name] for name in sorted(both)}, about)
        put("baseline", table(read_ratios(COMMITTED)))


if __name__ == "__main__":
    main()
