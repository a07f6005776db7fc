"""102 changes of plugins and 102 accidents: which change the fingerprint of their code?

    python tests/campaign/stale_results/run.py     # about 3 minutes of processor time

Writes ``results.csv`` beside this file.
"""

from __future__ import annotations

import csv
import tempfile
from collections import Counter
from pathlib import Path

from layouts import cases, outcome

RESULTS = Path(__file__).parent / "results.csv"


def main() -> None:
    """Run every case and write the outcomes."""
    counts: Counter[tuple[str, str]] = Counter()
    with RESULTS.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("kind", "place", "home", "accident", "outcome"))
        for case in cases():
            with tempfile.TemporaryDirectory() as folder:
                found = outcome(case, Path(folder) / "plugin")
            rows.writerow((*case, found))
            counts[case[0], found] += 1
            if found != "right":
                print(*case, found, sep="; ", flush=True)
    for (kind, found), count in sorted(counts.items()):
        print(kind, found, count)


if __name__ == "__main__":
    main()
