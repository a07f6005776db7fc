"""Where people wait: what commands and frames take, beside their aims, floors and peers, in one run.

    python benchmarks/waiting.py [--rows seeds,views,sensor] [--against FOLDER] [--rounds 1] [--geometries 5]

Rows of commands (``waiting_commands.py``) count processor time of a whole process, less that of another command with
kept tables if only their difference counts: compiling a scene is a run of it less the next run of it. Memory is the
largest of the process. Tables and other results are removed before cold commands, and kernels are compiled unless the
row is about compiling them. Where the sun matters, rows are medians over several suns and views, the same for all
versions: one lucky geometry costs a quarter of the median. Rows of frames (``waiting_frames.py``) are
medians over frames in one process, with standard errors. ``--against`` names a checkout of another version, whose
commands alternate with ours, so that both meet the same load. Floors and peers are measured in the same run. All rows
together take about three quarters of an hour of processor time.
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


def line(name: str, versions: Sequence[object], rounds: int, geometries: int) -> str:
    """Return one line of the table: medians over rounds and geometries, aim, floors, median of the ratios of pairs."""
    from waiting_commands import ROWS, seen_from

    row, pairs = ROWS[name], []
    places = [seen_from(number, row.tilt) for number in range(1, geometries + 1)] if row.tilt else [[]]
    for number in range(rounds):
        if number:
            for version in versions:
                version.begin_round()
        pairs += [[version.of(row, place) for version in versions] for place in places]
    cells = []
    for own in zip(*pairs, strict=True):
        known = [each for each in own if each is not None]
        cells.append(f"{statistics.median(known):.3g} {row.unit}".strip() if known else "refused")
        if len(known) > 1:
            cells[-1] += f" ({min(known):.3g} to {max(known):.3g})"
        if known and len(known) < len(own):
            cells[-1] += f", {len(own) - len(known)} of {len(own)} refused"
    if row.verdict:
        cells[0] += f", {', '.join(sorted({versions[0].verdict(row, place) for place in places}))}"
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
    parser.add_argument("--geometries", type=int, default=5, help="suns and views of rows where they matter")
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
                print(line(name, versions, given.rounds, given.geometries), flush=True)
        os.environ["HCSS_CACHE_DIR"] = str(Path(folder) / "frames")
        for cells in measured([name for name in given.rows if name in FRAMES], given.frames):
            print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
