"""Try the drawn mutations on the tests: ``python tests/campaign/mutations/run.py --out results.json``.

Works on copies of the tree in ``--work``. First all tests run once without a mutation: they must pass, and it is noted
which of them run which mutated function. Then each mutation is tried on the tests that reach it, the most particular
ones first, until one fails or ``--budget`` seconds of tests have passed. The results are written after each mutation; a
second call goes on with those that are missing. ``report.py`` sums them up.
"""

from __future__ import annotations

import argparse
import json
import queue
import subprocess
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import place
from bench import Bench, quick_tests
from functions import PACKAGE
from nearest import nearest, reach

HERE = Path(__file__).parent
ROOT = HERE.parents[2]


def main() -> None:
    options = _options()
    work = Path(options.work)
    benches: queue.Queue[Bench] = queue.Queue()
    first = Bench(ROOT, work, 0)
    benches.put(first)
    for number in range(1, options.jobs):
        benches.put(Bench(ROOT, work, number))
    places = {each["id"]: (each, place.find(each, first.functions)) for each in place.mutations()}
    tests = reach(first, {number: where for number, (_, where) in places.items()}, options.paths)
    failing = sorted(name for name, each in tests.items() if each["failed"])
    print(f"{len(tests)} tests, {len(failing)} fail without a mutation", flush=True)
    allowed = set(tests) - set(failing)
    if options.tests == "quick":
        allowed &= quick_tests(first, options.quick)
    out = Path(options.out)
    results = json.loads(out.read_text(encoding="utf-8")) if out.exists() else {"mutations": {}}
    results |= {
        "commit_of_package": _commit(),
        "tests": options.tests,
        "seconds_of_tests": options.budget,
        "unmutated": {"tests": len(tests), "failing": failing},
    }
    lock = threading.Lock()

    def one(number: int) -> None:
        mutation, where = places[number]
        bench = benches.get()
        try:
            result = _try(bench, mutation, where, tests, allowed, options)
        finally:
            benches.put(bench)
        with lock:
            results["mutations"][str(number)] = result
            results["mutations"] = dict(sorted(results["mutations"].items(), key=lambda item: int(item[0])))
            out.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
            print(number, result["outcome"], result.get("by", ""), result["seconds"], flush=True)

    tried = {int(name) for name, each in results["mutations"].items() if each["outcome"] != "interrupted"}
    missing = options.only or [number for number in places if number not in tried]
    with ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(one, missing))


def _try(
    bench: Bench,
    mutation: dict[str, Any],
    where: place.Place,
    tests: dict[str, dict[str, Any]],
    allowed: set[str],
    options: argparse.Namespace,
) -> dict[str, Any]:
    if where.function is None:
        return {"outcome": where.problem, "seconds": 0.0}
    chosen = nearest(tests, mutation["id"], allowed, options.budget)
    usual = sum(tests[name]["seconds"] for name in chosen)
    about = {"file": where.function.file, "row": where.row, "tests": len(chosen)}
    if not chosen:
        return {"outcome": "survived", **about, "seconds": 0.0}
    start = time.perf_counter()
    with bench.changed(where.function.file, place.mutated_text(mutation, where)):
        outcome, by = bench.judge(chosen, options.limit)
    seconds = round(time.perf_counter() - start, 1)
    if outcome == "timeout" and 3 * usual > options.limit:
        outcome = "too slow to tell"
    return {"outcome": outcome, **({"by": by} if by else {}), **about, "seconds": seconds}


def _commit() -> str:
    command = ["git", "-C", str(ROOT), "log", "-1", "--format=%H", "--", PACKAGE]
    return subprocess.run(command, text=True, capture_output=True).stdout.strip()


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--tests", choices=("auto", "quick"), default="auto", help="all tests, or only those of --quick"
    )
    parser.add_argument("--quick", default="--quick", help="options with which pytest runs the quick subset")
    parser.add_argument("--only", type=int, nargs="+", default=[], help="numbers of mutations")
    parser.add_argument("--out", default=str(HERE / "results.json"), help="file of results")
    parser.add_argument("--jobs", type=int, default=1, help="mutations at a time, each with a copy of the tree")
    parser.add_argument("--limit", type=float, default=240.0, help="seconds after which a mutation hangs")
    parser.add_argument("--budget", type=float, default=60.0, help="seconds of tests per mutation")
    parser.add_argument("--work", default=f"{tempfile.gettempdir()}/hcss-mutations", help="folder of copies and caches")
    parser.add_argument("--paths", nargs="+", default=["tests"], help="folders or files of tests")
    return parser.parse_args()


if __name__ == "__main__":
    main()
