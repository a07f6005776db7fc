"""Sum up results of ``run.py``: ``python report.py results-0.1.0.json``.

Equivalent mutations (equivalent.json, each with its reason) change no result that could be asked for: they are counted
apart. ``--survivors`` lists the others that no test killed; ``--quick=OPTIONS`` also counts how many were first killed
by a test that pytest runs with these options in the present tree, by default ``--quick``.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections import Counter
from pathlib import Path

from bench import Bench, quick_tests
from place import HERE, ROOT, mutations


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("results", type=Path)
    parser.add_argument("--survivors", action="store_true", help="list them")
    parser.add_argument("--quick", nargs="?", const="--quick", help="options with which pytest runs the quick subset")
    options = parser.parse_args()
    results = json.loads(options.results.read_text(encoding="utf-8"))["mutations"]
    equivalent = json.loads((HERE / "equivalent.json").read_text(encoding="utf-8"))
    counts: dict[str, Counter[str]] = {}
    for each in mutations():
        result = results.get(str(each["id"]), {"outcome": "not tried"})
        outcome = result["outcome"].partition(":")[0]
        if outcome == "survived" and str(each["id"]) in equivalent:
            outcome = "equivalent"
        for package in (each["package"], "all"):
            counts.setdefault(package, Counter())[outcome] += 1
        if options.survivors and outcome not in ("killed", "timeout", "equivalent", "not tried", "lost"):
            where = f"{result.get('file', each['file'])}:{result.get('row', '?')} {each['function']}"
            print(f"{each['id']:3} {outcome}, {result.get('tests', 0)} tests: {where}")
            print(f"      {each['line']}\n      {each['mutated']}")
    for package, count in counts.items():
        killed = count["killed"] + count["timeout"]
        tried = count.total() - count["equivalent"] - count["lost"] - count["not tried"]
        share = f"{100 * killed / max(tried, 1):.0f} % of {tried} killed"
        print(f"{package:8} {share}: " + ", ".join(f"{number} {name}" for name, number in count.items()))
    if options.quick:
        with tempfile.TemporaryDirectory() as work:
            quick = quick_tests(Bench(ROOT, Path(work), 0), options.quick)
        first = [each["by"] for each in results.values() if each["outcome"] == "killed"]
        print(f"{sum(name in quick for name in first)} of {len(first)} first killed by a test of the quick subset")


if __name__ == "__main__":
    main()
