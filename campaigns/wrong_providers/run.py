"""Which wrong providers does the conformance kit refuse, and does it accept all right ones?

    python campaigns/wrong_providers/run.py                          # all, some minutes
    python campaigns/wrong_providers/run.py --match radiance         # those with this in their name
    python campaigns/wrong_providers/run.py --summary

Rows go to ``rows.json`` as they are found, and counts to ``table.csv``. Providers that have a row are not run
again (``--fresh`` runs them).
"""

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path

from kit_run import laws_broken
from right_providers import right_providers
from wrong_providers import wrong_providers

sys.path.append(str(Path(__file__).parents[1]))

from campaign_table import line, write_table

ROWS = Path(__file__).with_name("rows.json")

TOGETHER = 20
"""Providers of one start of pytest; their rows are written together."""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--match", nargs="+", default=[""], help="only names that contain one of these")
    parser.add_argument("--fresh", action="store_true", help="run those in the rows again")
    parser.add_argument("--summary", action="store_true", help="run nothing")
    given = parser.parse_args()
    rows = json.loads(ROWS.read_text(encoding="utf-8")) if ROWS.exists() else {}
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
            ROWS.write_text(json.dumps(ordered, indent=1) + "\n", encoding="utf-8")
    kinds = {name: right.kind for name, (right, _) in every.items()}
    write_table(Path(__file__).with_name("table.csv"), table(rows, kinds))
    for name, row in rows.items():
        if row["right"] == bool(row["refused_by"]):
            print(f"  {name}: {row['sentence']}: {', '.join(row['refused_by']) or 'passes'}")


def table(rows, kinds):
    """Yield lines by kind: wrong providers and those that no law refuses; right ones and those that a law refuses."""
    for kind in dict.fromkeys(kinds.values()):
        own = [row for name, row in rows.items() if kinds[name] == kind]
        wrong, right = ([bool(row["refused_by"]) for row in own if row["right"] == each] for each in (False, True))
        yield line(f"wrong {kind}", len(wrong), wrong.count(False))
        yield line(f"right {kind}", len(right), right.count(True))


if __name__ == "__main__":
    main()
