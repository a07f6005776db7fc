"""Which mechanical mutations of the code do the tests detect?

    python campaigns/mutations/run.py --number 300 --seed 16            # hours
    python campaigns/mutations/run.py --tests quick                     # with the tests of the quick subset alone
    python campaigns/mutations/run.py --common ../old                   # of lines that an old checkout has, too
    python campaigns/mutations/run.py --common ../old --there           # the same ones, tried in the old checkout

Works on copies of the tree in ``--work``. First all tests run once without a mutation: they must pass, and it is noted
which of them run which mutated function. Then each mutation is tried on the tests that reach it, the most particular
ones first, until one fails or ``--budget`` seconds of tests have passed. Rows go to ``rows-*.json`` after each one; a
second call goes on with those that are missing, and one of other code, number or seed begins anew. ``table.csv`` counts
the mutations that no test detects. Survivors are printed: some change no result that could be asked for.
With ``--common``, call this with the Python of an environment in which the tree that is tried is installed.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import queue
import random
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
from functions import functions
from nearest import nearest, reach

sys.path.append(str(Path(__file__).parents[1]))

from campaign_table import line, read_table, write_table

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
KIND = ("number", "seed", "tests", "sample")
"""Options by which rows are told apart, beside the code."""


def main() -> None:
    options = _options()
    work = Path(options.work)
    other = functions(Path(options.common)) if options.common else None
    pairs = draw(functions(ROOT), options.number, options.seed, other)
    mutations = {number: pair[options.there] for number, pair in enumerate(pairs, 1)}
    if options.sample:
        kept_numbers = random.Random(options.seed).sample(sorted(mutations), options.sample)
        mutations = {number: mutations[number] for number in sorted(kept_numbers)}
    benches: queue.Queue[Bench] = queue.Queue()
    tree = Path(options.common) if options.there else ROOT
    first = Bench(tree, work, 0)
    benches.put(first)
    for number in range(1, options.jobs):
        benches.put(Bench(tree, work, number))
    paths = options.paths
    if options.tests == "quick":
        quick = quick_tests(first, "--quick")
        paths = sorted({name.partition("::")[0] for name in quick})
    tests = reach(first, {number: mutation.function for number, mutation in mutations.items()}, paths)
    failing = sorted(name for name, each in tests.items() if each["failed"])
    print(f"{len(tests)} tests, {len(failing)} fail without a mutation", *failing, sep="\n  ", flush=True)
    allowed = set(tests) - set(failing)
    drawn = json.dumps([(each.function.file, each.row, each.line) for each in mutations.values()])
    lines = hashlib.sha256(drawn.encode()).hexdigest()
    about = {"code": first.fingerprint, "lines": lines, **{name: getattr(options, name) for name in KIND}}
    rows_file = HERE / f"rows-{options.tests}{'-there' * options.there}.json"
    kept = json.loads(rows_file.read_text(encoding="utf-8")) if rows_file.exists() else {}
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
            rows_file.write_text(json.dumps({"about": about, "mutations": rows}, indent=1) + "\n", encoding="utf-8")
            print(number, row["outcome"], row.get("by", ""), row["seconds"], flush=True)

    tried = {int(name) for name, row in rows.items() if row["outcome"] != "interrupted"}
    missing = [each for each in mutations if each not in tried]
    with ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(one, missing))
    for number, mutation in mutations.items():
        if rows[str(number)]["outcome"] not in ("killed", "timeout"):
            where = f"{mutation.function.file}:{mutation.row} {mutation.function.name}"
            print(f"{number} {rows[str(number)]['outcome']}: {where}\n  {mutation.line.strip()}")
    kind = options.tests + (", before" if options.there else "")
    written = list(table(rows, kind))
    names = {row["what"] for row in written}
    write_table(
        HERE / "table.csv", [*written, *(row for row in read_table(HERE / "table.csv") if row["what"] not in names)]
    )


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
    parser.add_argument("--common", default="", help="a checkout of another version: only lines that it has, too")
    parser.add_argument("--there", action="store_true", help="try the mutations in that checkout")
    parser.add_argument("--sample", type=int, default=0, help="so many of the mutations, drawn by the seed; 0: all")
    parser.add_argument("--paths", nargs="+", default=["tests"], help="folders or files of tests")
    return parser.parse_args()


if __name__ == "__main__":
    main()
