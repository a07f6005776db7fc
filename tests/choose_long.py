"""Choose the tests that only the whole check runs: the dearest ones, until the rest is done in minutes.

::

    bash .ci/run full > durations.txt       # prints the durations of all tests
    python tests/choose_long.py durations.txt

What remains of README's second command runs in less than 6 minutes on two processors, and ``.ci/run`` with the tests of
the other packages in less than 12. The dearest tests go first, so that as few laws as possible are left to the whole
check.
"""

import argparse
import json
import re
from collections import defaultdict
from pathlib import Path

BUDGET_S, OTHERS_S = 520.0, 380.0
"""Processor time of what remains of README's second command, and of other packages.

Durations are longer where other work takes part of the processors.
"""

OTHERS = re.compile(r"plugins/hcss-(dataset|examples|explore|light|lowtran7|payload|pyxel|skies)/")
"""Packages that are no part of README's second command."""

_LINE = re.compile(r"^([0-9.]+)s (?:call|setup|teardown) +((\S+?\.py)::.*)$")


def main() -> None:
    """Read the durations that pytest printed and write ``long.json``."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("durations", type=Path)
    given = parser.parse_args()
    root, seconds = Path(__file__).parents[1], defaultdict[str, float](float)
    for match in filter(None, map(_LINE.match, given.durations.read_text(encoding="utf-8").splitlines())):
        if (root / match[3]).exists():  # tests of some packages are named from their own folder
            seconds[match[2].strip()] += float(match[1])
    chosen = list[str]()
    for is_other, budget in ((False, BUDGET_S), (True, OTHERS_S)):
        of_these = {name: each for name, each in seconds.items() if bool(OTHERS.match(name)) == is_other}
        dearest = sorted(of_these, key=of_these.__getitem__, reverse=True)
        left = sum(of_these.values())
        while left > budget:
            left -= of_these[dearest[0]]
            chosen.append(dearest.pop(0))
        print(f"{len(of_these)} tests of {sum(of_these.values()):.0f} s: {left:.0f} s of {len(dearest)} remain")
    path = Path(__file__).with_name("long.json")
    path.write_text(json.dumps(sorted(chosen), indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
