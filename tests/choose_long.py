"""Choose the tests that only the whole check runs: the dearest ones, until the rest is done in minutes.

::

    bash .ci/run full > durations.txt       # prints the durations of all tests
    python tests/choose_long.py durations.txt

What remains of the core runs in less than 6 minutes on two processors (README's second command), and with the rest of
the plugins, checks and installations in less than 12 (`.ci/run`). The dearest tests go first, so that as few laws as
possible are left to the whole check.
"""

import argparse
import json
import re
from collections import defaultdict
from pathlib import Path

CORE_S, PLUGINS_S = 600.0, 300.0
"""Processor time of what remains: of the core's tests, and of those of all packages that only `.ci/run` tests."""

OF_CI = ("hcss-light", "hcss-payload", "hcss-skies", "hcss-examples", "hcss-lowtran7")
"""Packages whose tests are no part of README's second command."""

_LINE = re.compile(r"^([0-9.]+)s (?:call|setup|teardown) +(\S+?\.py::.*)$")


def main() -> None:
    """Read the durations that pytest printed and write ``long.json``."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("durations", type=Path)
    given = parser.parse_args()
    seconds: dict[str, float] = defaultdict(float)
    for match in filter(None, map(_LINE.match, given.durations.read_text(encoding="utf-8").splitlines())):
        seconds[match[2].strip()] += float(match[1])
    chosen: list[str] = []
    for of_ci, budget in ((False, CORE_S), (True, PLUGINS_S)):
        some = {
            name: took
            for name, took in seconds.items()
            if name.startswith(tuple(f"plugins/{p}/" for p in OF_CI)) == of_ci
        }
        left = sum(some.values())
        for name in sorted(some, key=some.__getitem__, reverse=True):
            if left <= budget:
                break
            chosen.append(name)
            left -= some[name]
        print(f"{len(some)} tests of {sum(some.values()):.0f} s: {left:.0f} s remain")
    path = Path(__file__).with_name("long.json")
    path.write_text(json.dumps(sorted(chosen), indent=1) + "\n", encoding="utf-8")
    print(f"{path.name}: {len(chosen)} tests")


if __name__ == "__main__":
    main()
