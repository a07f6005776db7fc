"""Choose the tests of the core that only the whole check runs: the dearest ones, until the rest is done in minutes.

::

    bash .ci/run full > durations.txt       # prints the durations of all tests
    python tests/choose_long.py durations.txt

What remains runs in less than 6 minutes on two processors (README's second command). The dearest tests go first, so
that as few laws as possible are left to the whole check.
"""

import argparse
import json
import re
from collections import defaultdict
from pathlib import Path

BUDGET_S = 520.0
"""Processor time of what remains. Durations are longer where other work takes part of the processors."""

_LINE = re.compile(r"^([0-9.]+)s (?:call|setup|teardown) +((\S+?\.py)::.*)$")


def main() -> None:
    """Read the durations that pytest printed and write ``long.json``."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("durations", type=Path)
    parser.add_argument("--budget", type=float, default=BUDGET_S, help="seconds of what remains")
    given = parser.parse_args()
    root, seconds = Path(__file__).parents[1], defaultdict[str, float](float)
    for match in filter(None, map(_LINE.match, given.durations.read_text(encoding="utf-8").splitlines())):
        if (root / match[3]).exists():  # tests of some packages are named from their own folder
            seconds[match[2].strip()] += float(match[1])
    left, chosen = sum(seconds.values()), []
    for name in sorted(seconds, key=seconds.__getitem__, reverse=True):
        if left <= given.budget:
            break
        chosen.append(name)
        left -= seconds[name]
    path = Path(__file__).with_name("long.json")
    path.write_text(json.dumps(sorted(chosen), indent=1) + "\n", encoding="utf-8")
    print(f"{len(seconds)} tests of {sum(seconds.values()):.0f} s: {left:.0f} s remain without {len(chosen)}")


if __name__ == "__main__":
    main()
