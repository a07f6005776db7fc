"""What breaks the package: damaged files, random scenarios, limits of keys, and odd air.

    python campaigns/unbreakable/run.py files                # all of one part: up to two hours
    python campaigns/unbreakable/run.py limits --rows 20     # the first 20 rows
    python campaigns/unbreakable/run.py limits --summary     # only what the file of rows says

Each row is determined by its key. Rows go to ``rows-PART.json`` as they are computed; rows that are there are not
computed again. The line of the part in ``table.csv`` is written when all are there.
"""

import argparse
import os
import sys
import tempfile
from importlib import import_module
from pathlib import Path

from campaign_rows import compute_rows, read_rows

sys.path.append(str(Path(__file__).parents[1]))

from campaign_table import line, read_table, write_table

PARTS = {"files": "damaged_files", "scenarios": "schema_scenarios", "limits": "limits", "airs": "air_rows"}


HERE = Path(__file__).parent
TABLE = HERE / "table.csv"


def counted(name, rows):
    """Return the line of a part: what was tried, and how much of it ended in a problem."""
    tried = sum(count for row in rows.values() for what, count in row["outcomes"].items() if what != "not damaged")
    return line(name, tried, sum(len(row["escaped"] if "escaped" in row else row["problems"]) for row in rows.values()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--rows", type=int, help="the first rows only")
    parser.add_argument("--jobs", type=int, default=2, help="rows at a time")
    parser.add_argument("--summary", action="store_true", help="compute nothing")
    given = parser.parse_args()
    part = import_module(PARTS[given.part])
    path = HERE / f"rows-{given.part}.json"
    if given.summary:
        rows = read_rows(path)
    else:
        with tempfile.TemporaryDirectory() as cache:
            os.environ["HCSS_CACHE_DIR"] = cache
            part.prepare()
            rows = compute_rows(path, part.keys()[: given.rows], part.compute, given.jobs)
    print("\n".join(part.summary(rows)))
    if rows.keys() >= set(part.keys()):
        known = {each["what"]: each for each in read_table(TABLE)} if TABLE.exists() else {}
        known[given.part] = counted(given.part, rows)
        write_table(TABLE, (known[each] for each in PARTS if each in known))


if __name__ == "__main__":
    main()
