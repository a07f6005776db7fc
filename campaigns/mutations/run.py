"""Which mechanical mutations of the code do the tests detect?

    python campaigns/mutations/run.py --number 300 --seed 16            # hours
    python campaigns/mutations/run.py --tests quick                     # with the tests of the quick subset alone

Works on copies of the tree in ``--work``. First all tests run once without a mutation: they must pass, and it is noted
which of them run which mutated function. Then each mutation is tried on the tests that reach it, the most particular
ones first, until one fails or ``--budget`` seconds of tests have passed. Rows go to ``rows.json`` after each mutation;
a second call goes on with those that are missing, and one of other code, number or seed begins anew. ``table.csv``
counts the mutations that no test detects. Survivors are printed: some change no result that could be asked for.
"""

from __future__ import annotations

import argparse
import json
import queue
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from bench import Bench, quick_tests
from draw import SHARES, Mutation, draw
from nearest import nearest, reach

sys.path.append(str(Path(__file__).parents[1]))

from campaign_table import line, write_table

HERE = Path(__file__).parent
ROOT, ROWS = HERE.parents[1], HERE / "rows.json"


def main() -> None:
    options = _options()
    work = Path(options.work)
    benches: queue.Queue[Bench] = queue.Queue()
    first = Bench(ROOT, work, 0)
    benches.put(first)
    for number in range(1, options.jobs):
        benches.put(Bench(ROOT, work, number))
    mutations = dict(enumerate(draw(first.functions, options.number, options.seed), 1))
    quick = ("--quick",) if options.tests == "quick" else ()
    tests = reach(first, {number: each.function for number, each in mutations.items()}, options.paths, quick)
    failing = sorted(name for name, each in tests.items() if each["failed"])
    print(f"{len(tests)} tests, {len(failing)} fail without a mutation", flush=True)
    allowed = set(tests) - set(failing)
    if options.tests == "quick":
        allowed &= quick_tests(first, "--quick")
    about = {"code": first.fingerprint, **{name: getattr(options, name) for name in ("number", "seed", "tests")}}
    kept = json.loads(ROWS.read_text(encoding="utf-8")) if ROWS.exists() else {}
    rows: dict[str, dict[str, Any]] = kept.get("mutations", {}) if kept.get("about") == about else {}
    lock = threading.Lock()

    def one(number: int) -> None:
        bench = benches.get()
        try:
            row = _try(bench, number, mutations[number], tests, allowed, options)
        finally:
            benches.put(bench)
        with lock:
            rows[str(number)] = row
            ROWS.write_text(json.dumps({"about": about, "mutations": rows}, indent=1) + "\n", encoding="utf-8")
            print(number, row["outcome"], row.get("by", ""), row["seconds"], flush=True)

    tried = {int(name) for name, row in rows.items() if row["outcome"] != "interrupted"}
    missing = [each for each in mutations if each not in tried]
    with ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(one, missing))
    for number, mutation in mutations.items():
        if rows[str(number)]["outcome"] not in ("killed", "timeout"):
            where = f"{mutation.function.file}:{mutation.row} {mutation.function.name}"
            print(f"{number} {rows[str(number)]['outcome']}: {where}\n  {mutation.line.strip()}")
    write_table(HERE / "table.csv", table(rows, options.tests))


def table(rows: dict[str, dict[str, Any]], tests: str) -> Iterator[dict[str, str]]:
    """Yield a line for each package: mutations, and those that no test detects."""
    for package in SHARES:
        outcomes = [row["outcome"] for row in rows.values() if row["package"] == package]
        yield line(f"{package}, tests: {tests}", len(outcomes), sum(each == "survived" for each in outcomes))


def _try(
    bench: Bench,
    number: int,
    mutation: Mutation,
    tests: dict[str, dict[str, Any]],
    allowed: set[str],
    options: argparse.Namespace,
) -> dict[str, Any]:
    chosen = nearest(tests, number, allowed, options.budget)
    usual = sum(tests[name]["seconds"] for name in chosen)
    row = {"package": mutation.package, "outcome": "survived", "tests": len(chosen), "seconds": 0.0}
    if not chosen:
        return row
    start = time.perf_counter()
    with bench.changed(mutation.function.file, mutation.text):
        row["outcome"], row["by"] = bench.judge(chosen, options.limit)
    row["seconds"] = round(time.perf_counter() - start, 1)
    if row["outcome"] == "timeout" and 3 * usual > options.limit:
        row["outcome"] = "too slow to tell"
    return row


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--number", type=int, default=100, help="of mutations")
    parser.add_argument("--seed", type=int, default=16)
    parser.add_argument("--tests", choices=("auto", "quick"), default="auto", help="all, or those of the quick subset")
    parser.add_argument("--jobs", type=int, default=1, help="mutations at a time, each with a copy of the tree")
    parser.add_argument("--limit", type=float, default=240.0, help="seconds after which a mutation hangs")
    parser.add_argument("--budget", type=float, default=60.0, help="seconds of tests per mutation")
    parser.add_argument("--work", default=f"{tempfile.gettempdir()}/hcss-mutations", help="folder of copies and caches")
    parser.add_argument("--paths", nargs="+", default=["tests"], help="folders or files of tests")
    return parser.parse_args()


if __name__ == "__main__":
    main()
