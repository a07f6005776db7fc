"""Are good orbits and geometries accepted with the right positions, and bad ones refused or noted by name?

    python campaigns/trajectories/run.py                   # all inputs: some minutes; writes table.csv
    python campaigns/trajectories/run.py --part orbits     # one part, shown only

Expected positions come from SGP4 and ERFA; each input is determined by its number. Inputs that fail are printed.
"""

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path

import geometry_inputs
import orbit_inputs
from judge import judged

sys.path.append(str(Path(__file__).parents[1]))

from campaign_table import line, write_table

PARTS = {"orbits": orbit_inputs, "geometries": geometry_inputs}


def table(part, rows):
    """Yield lines: good inputs that are refused, questioned or wrong, and bad ones that are not named."""
    errors = [row["error_m"] for row in rows["good"] if row["error_m"] is not None]
    yield line(f"good {part}", len(rows["good"]), sum(map(fails, rows["good"])), "error, m", errors)
    yield line(f"bad {part}", len(rows["bad"]), sum(not row["named"] for row in rows["bad"]))


def fails(row):
    """Whether a good input is refused, questioned or wrong."""
    return bool(row["refused"] or row["questions"] or (row["error_m"] or 0.0) > row.get("within_m", 0.0))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--part", choices=PARTS, help="one of them only")
    given = parser.parse_args()
    lines = []
    with tempfile.TemporaryDirectory() as cache:
        os.environ["HCSS_CACHE_DIR"] = cache
        for part in [given.part] if given.part else PARTS:
            rows = {kind: [judged(each) for each in getattr(PARTS[part], kind)()] for kind in ("good", "bad")}
            lines += table(part, rows)
            failures = [row for row in rows["good"] if fails(row)] + [row for row in rows["bad"] if not row["named"]]
            print(*map(json.dumps, failures), sep="\n")
    if not given.part:
        write_table(Path(__file__).with_name("table.csv"), lines)


if __name__ == "__main__":
    main()
