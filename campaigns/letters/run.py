"""Hostile messages, letters and clients of `hcss serve`: does one crash it, get no named error, or change a frame?

    python campaigns/letters/run.py     # about a minute of processor time

Writes ``table.csv`` beside this file and prints what failed.
"""

from __future__ import annotations

import itertools
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1]))

from campaign_table import line, write_table
from hostile import hostile_messages
from letter_checks import crowd_failures, letter_failures, message_failures, served

LETTERS = 150
PORT = 47251


def main() -> None:
    """Send everything, and write how often the server failed."""
    found: dict[str, list[bool]] = {}
    with tempfile.TemporaryDirectory() as folder, served(Path(folder)) as running:
        cases = hostile_messages(running.values)
        failures = itertools.chain(
            message_failures(running, cases), letter_failures(running, LETTERS), crowd_failures(running)
        )
        _count(failures, found)
    with tempfile.TemporaryDirectory() as folder, served(Path(folder), f"tcp://127.0.0.1:{PORT}") as running:
        _count(((f"{kind} (tcp)", wrong) for kind, wrong in crowd_failures(running)), found)
    write_table(
        Path(__file__).with_name("table.csv"), (line(kind, len(all_), sum(all_)) for kind, all_ in found.items())
    )


def _count(failures: Iterable[tuple[str, str]], found: dict[str, list[bool]]) -> None:
    for kind, wrong in failures:
        found.setdefault(kind, []).append(bool(wrong))
        if wrong:
            print(kind, wrong, sep=": ", flush=True)


if __name__ == "__main__":
    main()
