"""Where people wait: what commands and frames take, beside their aims, floors and peers, in one run.

    python benchmarks/waiting.py [--rows seeds,views,sensor] [--against FOLDER] [--rounds 1]

Rows of commands (``waiting_commands.py``) count processor time of a whole process, less that of another command if only
their difference counts; memory is the largest of the process. Tables and other results are removed before cold
commands, and kernels are compiled unless the row is about compiling them. Rows of frames (``waiting_frames.py``) are
medians over frames in one process, with standard errors. ``--against`` names a checkout of another version, whose
commands alternate with ours, so that both meet the same load. Floors and peers are measured in the same run. All rows
together take about ten minutes of processor time.
"""

from __future__ import annotations

import argparse
import os
import statistics
import tempfile
from collections.abc import Sequence
from pathlib import Path

HERE = Path(__file__).parents[1]

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy


def line(name: str, versions: Sequence[object], rounds: int) -> str:
    """Return one line of the table: medians over rounds, aim, floors, and the median of the ratios of pairs."""
    from waiting_commands import ROWS

    row, pairs = ROWS[name], []
    for number in range(rounds):
        if number:
            for version in versions:
                version.begin_round()
        pairs.append([version.of(row) for version in versions])
    cells = []
    for own in zip(*pairs, strict=True):
        known = [each for each in own if each is not None]
        cells.append(f"{statistics.median(known):.3g} {row.unit}".strip() if known else "refused")
    if row.verdict:
        cells[0] += f", {versions[0].verdict(row)}"
    ratios = [old / new for new, *others in pairs for old in others if old is not None and new]
    before = f", {cells[1]} before (x {statistics.median(ratios):.2g})" if ratios else ""
    floors = ", ".join(f"{what} {versions[0].floor(row, program):.2g}" for what, program in row.floors.items())
    return f"| {row.name} | {cells[0]}{before} | {row.aim} | {floors} |"


def main() -> None:
    from waiting_commands import ROWS, Version
    from waiting_frames import ROWS as FRAMES
    from waiting_frames import measured

    names = [*ROWS, *FRAMES]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=lambda text: text.split(","), default=names, help=", ".join(names))
    parser.add_argument("--against", type=Path, help="checkout of another version, for rows of commands")
    parser.add_argument("--rounds", type=int, default=1, help="of rows of commands")
    parser.add_argument("--frames", type=int, default=24, help="of rows of frames")
    given = parser.parse_args()
    unknown = sorted(set(given.rows) - set(names))
    if unknown:
        parser.error(f"no row {', '.join(unknown)}; there are {', '.join(names)}")
    checkouts = [HERE] if given.against is None else [HERE, given.against]
    with tempfile.TemporaryDirectory(prefix="hcss-waiting-") as folder:
        versions = [Version(each.resolve(), Path(folder) / str(number)) for number, each in enumerate(checkouts)]
        print("| what | now | aim | floors and peers |\n|---|---|---|---|", flush=True)
        for name in given.rows:
            if name in ROWS:
                print(line(name, versions, given.rounds), flush=True)
        os.environ["HCSS_CACHE_DIR"] = str(Path(folder) / "frames")
        for cells in measured([name for name in given.rows if name in FRAMES], given.frames):
            print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
