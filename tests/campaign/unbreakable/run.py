"""What breaks the package: kills, damaged files, random scenarios, bombs, faults, limits of keys, and odd air.

    python tests/campaign/unbreakable/run.py files                # all of one part: up to two hours
    python tests/campaign/unbreakable/run.py kills --rows 20      # the first 20 rows
    python tests/campaign/unbreakable/run.py faults --summary     # only what the file of results says

Each row is determined by its key. Rows go to ``results-PART.json`` as they are computed; rows that are there are not
computed again.
"""

import argparse
import os
import tempfile
from importlib import import_module
from pathlib import Path

from campaign_rows import compute_rows, read_rows

PARTS = {
    "files": "damaged_files",
    "kills": "kills",
    "scenarios": "schema_scenarios",
    "faults": "faults",
    "limits": "limits",
    "airs": "air_rows",
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--rows", type=int, help="the first rows only")
    parser.add_argument("--jobs", type=int, default=2, help="rows at a time")
    parser.add_argument("--results", type=Path, help="another file")
    parser.add_argument("--summary", action="store_true", help="compute nothing")
    given = parser.parse_args()
    part = import_module(PARTS[given.part])
    results = given.results or part.RESULTS
    if given.summary:
        rows = read_rows(results)
    else:
        with tempfile.TemporaryDirectory() as cache:
            os.environ["HCSS_CACHE_DIR"] = cache
            part.prepare()
            rows = compute_rows(results, part.keys()[: given.rows], part.compute, given.jobs)
    print("\n".join(part.summary(rows)))


if __name__ == "__main__":
    main()
