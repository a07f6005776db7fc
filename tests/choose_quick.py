"""Choose the quick subset: the cheapest test files that run, with their collection, in less than a minute on two
processors.

::

    python -m pytest --durations=0 --durations-min=0.001 -q > durations.txt
    python tests/choose_quick.py durations.txt

Files are taken in the order of their time per test until the budget is spent, so that each save checks most laws.
"""

import argparse
import json
import re
from collections import defaultdict
from pathlib import Path

BUDGET_S = 25.0
"""Processor time of all chosen files, without collection."""


def main() -> None:
    """Read the durations that pytest printed and write ``quick.json``."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("durations", type=Path)
    parser.add_argument("--budget", type=float, default=BUDGET_S, help="seconds of processor time")
    given = parser.parse_args()
    seconds: dict[str, float] = defaultdict(float)
    tests: dict[str, set[str]] = defaultdict(set)
    line = re.compile(r"^([0-9.]+)s (?:call|setup|teardown) +tests/(\S+?\.py)::(.*)$")
    for match in filter(None, map(line.match, given.durations.read_text(encoding="utf-8").splitlines())):
        seconds[match[2]] += float(match[1])
        tests[match[2]].add(match[3])
    folder = Path(__file__).parent
    for path in folder.rglob("test_*.py"):  # files without a test that is worth a line
        seconds.setdefault(path.relative_to(folder).as_posix(), 0.0)
    chosen, spent = [], 0.0
    for name in sorted(seconds, key=lambda each: seconds[each] / max(len(tests[each]), 1)):
        if not (folder / name).exists() or spent + seconds[name] > given.budget:
            continue
        chosen.append(name)
        spent += seconds[name]
    (folder / "quick.json").write_text(json.dumps(sorted(chosen), indent=1) + "\n", encoding="utf-8")
    print(f"{len(chosen)} of {len(seconds)} files, {spent:.0f} s")


if __name__ == "__main__":
    main()
