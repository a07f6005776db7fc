"""200 profiles beside a table of the 1976 US Standard: which are taken for other air?

    python tests/campaign/table_profiles/run.py     # about 10 seconds of processor time

Writes ``results.csv`` beside this file.
"""

from __future__ import annotations

import csv
import tempfile
from collections import Counter
from pathlib import Path

from profiles import cases

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.atmosphere.same_profile import difference

RESULTS = Path(__file__).parent / "results.csv"


def verdict(content: str, folder: Path) -> str:
    """Return how a profile differs from that of the table; empty if it does not."""
    (folder / "own.csv").write_text(content)
    catalog = Catalog(base=folder)
    return difference(load_profile("own.csv", catalog), load_profile("us-standard-1976", catalog))


def main() -> None:
    """Compare every profile and write the verdicts."""
    counts: Counter[tuple[str, bool]] = Counter()
    with RESULTS.open("w", newline="", encoding="utf-8") as file, tempfile.TemporaryDirectory() as folder:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("kind", "number", "difference"))
        for kind, number, content in cases():
            found = verdict(content, Path(folder))
            rows.writerow((kind, number, found))
            counts[kind, bool(found)] += 1
            if bool(found) != (kind == "bad"):
                print(kind, number, found or "taken for the same air")
    for (kind, refused), count in sorted(counts.items()):
        print(kind, "refused" if refused else "accepted", count)


if __name__ == "__main__":
    main()
