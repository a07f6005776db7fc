"""Choose the tests that only the whole check runs: the dearest ones, until the rest is done in minutes.

::

    export HCSS_TEST_TIMES=$PWD/test-times.txt     # processor time of each test, whatever else the machine does
    bash .ci/run full                              # or parts of the tests, one after another
    python tests/choose_long.py $HCSS_TEST_TIMES

What remains of README's second command runs in less than 6 minutes on two processors, and ``.ci/run`` with the tests of
the other packages in less than 12. The dearest tests go first, so that as few laws as possible are left to the whole
check. Tests that were not measured stay what they are.
"""

import argparse
import json
import re
from pathlib import Path

BUDGET_S, OTHERS_S = 580.0, 430.0
"""Processor time of what remains of README's second command, and of other packages."""

OTHERS = re.compile(r"plugins/hcss-(dataset|examples|explore|follow|light|lowtran7|payload|skies)/")
"""Packages that are no part of README's second command."""


def main() -> None:
    """Read the times and write ``long.json``."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("times", type=Path)
    given = parser.parse_args()
    lines = given.times.read_text(encoding="utf-8").splitlines()
    seconds = {name: float(each) for each, _, name in (line.partition(" ") for line in lines)}
    path = Path(__file__).with_name("long.json")
    chosen = [name for name in json.loads(path.read_text(encoding="utf-8")) if name not in seconds]
    for is_other, budget in ((False, BUDGET_S), (True, OTHERS_S)):
        of_these = {name: each for name, each in seconds.items() if bool(OTHERS.match(name)) == is_other}
        dearest = sorted(of_these, key=of_these.__getitem__, reverse=True)
        left = sum(of_these.values())
        while left > budget:
            left -= of_these[dearest[0]]
            chosen.append(dearest.pop(0))
        print(f"{len(of_these)} tests of {sum(of_these.values()):.0f} s: {left:.0f} s of {len(dearest)} remain")
    path.write_text(json.dumps(sorted(chosen), indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
