"""Each omission of forty scenes switched on and off: is any pixel beyond its bound?

    python campaigns/omissions/run.py               # 40 scenes: about 10 minutes of processor time
    python campaigns/omissions/run.py --scenes 5    # the first 5
    python campaigns/omissions/run.py --summary     # only what the file of rows says

Scene number i is always the same. Rows go to ``rows.json`` beside this file as they are found; scenes that are there
are not computed again. The table is ``table.csv``.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from omission_scenes import SCENES, as_json, check

sys.path.append(str(Path(__file__).parents[1]))

from campaign_table import line, write_table

HERE = Path(__file__).parent
ROWS = HERE / "rows.json"


def table(known: dict[str, list[dict[str, Any]]]) -> Iterator[dict[str, str]]:
    """Yield a line for each omission: pixels, those beyond its bound, and the change of each scene."""
    rows = [row for own in known.values() for row in own]
    for what in sorted({row["what"] for row in rows}):
        own = [row for row in rows if row["what"] == what]
        changes = [row["change"] / (row["bound"] + row["error"]) for row in own]
        pixels, beyond = (sum(row[name] for row in own) for name in ("pixels", "beyond"))
        yield line(f"{what} ({len(own)} scenes)", pixels, beyond, "largest change / (bound + table error)", changes)
    waves = [1.0 - row["within_estimate"] for row in rows if row["what"] == "waves as shapes"]
    yield line("waves beyond their estimate (scenes)", len(waves), 0, "share of pixels", waves)
    for what in sorted({row["what"] for row in rows if row["rms"] is not None}):
        ratios = [row["rms"] / row["estimate"] for row in rows if row["what"] == what and row["estimate"]]
        above = sum(each > 1.0 for each in ratios)
        yield line(f"{what} beyond its estimate (scenes)", len(ratios), above, "rms / estimate", ratios)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=SCENES, help="how many, from number 0")
    parser.add_argument("--summary", action="store_true", help="compute nothing")
    options = parser.parse_args()
    known = json.loads(ROWS.read_text()) if ROWS.exists() else {}
    if not options.summary:
        with tempfile.TemporaryDirectory() as folder:
            os.environ["HCSS_CACHE_DIR"] = folder
            for number in range(options.scenes):
                if str(number) not in known:
                    known[str(number)] = [as_json(row) for row in check(number)]
                    ROWS.write_text(json.dumps(known, indent=1) + "\n")
    write_table(HERE / "table.csv", table(known))


if __name__ == "__main__":
    main()
