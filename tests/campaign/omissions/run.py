"""Each omission of forty scenes switched on and off: is any pixel beyond its bound?

    python tests/campaign/omissions/run.py               # 40 scenes: about 10 minutes of processor time
    python tests/campaign/omissions/run.py --scenes 5    # the first 5
    python tests/campaign/omissions/run.py --summary     # only what the file of results says

Scene number i is always the same. Rows go to ``results.json`` beside this file as they are found; scenes that are there
are not computed again.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
from pathlib import Path
from typing import Any

from omission_scenes import SCENES, as_json, check

RESULTS = Path(__file__).parent / "results.json"


def summary(known: dict[str, list[dict[str, Any]]]) -> list[str]:
    """Return a line for each omission."""
    rows = [row for own in known.values() for row in own]
    pixels = sum(max((row["pixels"] for row in own), default=0) for own in known.values())
    lines = [f"{len(known)} scenes of {pixels} pixels, {sum(row['pixels'] for row in rows)} comparisons"]
    for what in sorted({row["what"] for row in rows}):
        own = [row for row in rows if row["what"] == what]
        tight = max(row["change"] / (row["bound"] + row["error"]) for row in own)
        beyond = sum(row["beyond"] for row in own)
        pixels = sum(row["pixels"] for row in own)
        lines.append(
            f"{what}: {len(own)} scenes, {pixels} pixels, {beyond} beyond, at most {tight:.2f} of bound and table error"
        )
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=SCENES, help="how many, from number 0")
    parser.add_argument("--summary", action="store_true", help="compute nothing")
    options = parser.parse_args()
    known = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    if not options.summary:
        with tempfile.TemporaryDirectory() as folder:
            os.environ["HCSS_CACHE_DIR"] = folder
            for number in range(options.scenes):
                if str(number) not in known:
                    known[str(number)] = [as_json(row) for row in check(number)]
                    RESULTS.write_text(json.dumps(known, indent=1) + "\n")
    print("\n".join(summary(known)))


if __name__ == "__main__":
    main()
