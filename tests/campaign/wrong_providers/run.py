"""Which wrong providers does the conformance kit refuse, and does it accept all right ones?

    python tests/campaign/wrong_providers/run.py                          # all, some minutes
    python tests/campaign/wrong_providers/run.py --match radiance         # those with this in their name
    python tests/campaign/wrong_providers/run.py --summary

Rows go to ``results.json`` as they are found; providers that are there are not run again (``--fresh`` runs them).
"""

import argparse
import json
import os
import tempfile
from collections import Counter
from pathlib import Path

from kit_run import laws_broken
from right_providers import right_providers
from wrong_providers import wrong_providers

RESULTS = Path(__file__).with_name("results.json")

TOGETHER = 20
"""Providers of one start of pytest; their rows are written together."""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--match", nargs="+", default=[""], help="only names that contain one of these")
    parser.add_argument("--results", type=Path, default=RESULTS)
    parser.add_argument("--fresh", action="store_true", help="run those in the results again")
    parser.add_argument("--summary", action="store_true", help="run nothing")
    given = parser.parse_args()
    rows = json.loads(given.results.read_text(encoding="utf-8")) if given.results.exists() else {}
    rights = {each.name: each for each in right_providers()}
    every = {name: (right, None) for name, right in rights.items()}
    every |= {wrong.name: (rights[wrong.right], wrong) for wrong in wrong_providers()}
    with tempfile.TemporaryDirectory() as cache:
        os.environ.setdefault("HCSS_CACHE_DIR", cache)
        wanted = [name for name in every if any(part in name for part in given.match)]
        wanted = [] if given.summary else [name for name in wanted if given.fresh or name not in rows]
        for start in range(0, len(wanted), TOGETHER):
            names = wanted[start : start + TOGETHER]
            refused = laws_broken([(*every[name], None) for name in names])
            for name, (laws, seconds) in zip(names, refused, strict=True):
                right, wrong = every[name]
                rows[name] = {
                    "right": wrong is None,
                    "sentence": (wrong or right).sentence,
                    "refused_by": laws,
                    "seconds": round(seconds, 2),
                }
                print(name, rows[name]["seconds"], laws[:2], flush=True)
            ordered = {each: rows[each] for each in every if each in rows}
            given.results.write_text(json.dumps(ordered, indent=1) + "\n", encoding="utf-8")
    print("\n".join(summary(rows, rights)))


def summary(rows, rights):
    """Return lines of text: how many are refused, per kind, and the survivors."""
    wrong = {name: row for name, row in rows.items() if not row["right"]}
    lines = [f"{sum(bool(row['refused_by']) for row in wrong.values())} of {len(wrong)} wrong providers are refused"]
    kinds = Counter(), Counter()
    for name, row in wrong.items():
        kind = next(right.kind for right in rights.values() if name.startswith(f"{right.name}."))
        kinds[0][kind] += 1
        kinds[1][kind] += bool(row["refused_by"])
    lines += [f"  {kind}: {kinds[1][kind]} of {count}" for kind, count in kinds[0].items()]
    lines += [f"  passes: {name}: {row['sentence']}" for name, row in wrong.items() if not row["refused_by"]]
    refused = {name: row["refused_by"] for name, row in rows.items() if row["right"] and row["refused_by"]}
    lines.append(f"{len(refused)} of {sum(row['right'] for row in rows.values())} right providers are refused")
    return [*lines, *(f"  {name}: {', '.join(laws)}" for name, laws in refused.items())]


if __name__ == "__main__":
    main()
