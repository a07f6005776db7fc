"""102 changes of plugins and 102 accidents: which change the fingerprint of their code?

    python campaigns/stale_results/run.py     # about 3 minutes of processor time

Writes ``table.csv`` beside this file and prints the cases that are wrong.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from layouts import cases, outcome

sys.path.append(str(Path(__file__).parents[1]))

from campaign_table import line, write_table


def main() -> None:
    """Run every case and write how many are wrong."""
    found: dict[str, list[bool]] = {}
    for case in cases():
        with tempfile.TemporaryDirectory() as folder:
            said = outcome(case, Path(folder) / "plugin")
        found.setdefault(case[0], []).append(said != "right")
        if said != "right":
            print(*case, said, sep="; ", flush=True)
    lines = (line(kind, len(wrong), sum(wrong)) for kind, wrong in found.items())
    write_table(Path(__file__).with_name("table.csv"), lines)


if __name__ == "__main__":
    main()
