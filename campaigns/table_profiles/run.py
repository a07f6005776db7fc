"""200 profiles beside a table of the 1976 US Standard: which are taken for other air?

    python campaigns/table_profiles/run.py     # about 10 seconds of processor time

Writes ``table.csv`` beside this file.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from profiles import cases

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.atmosphere.same_profile import difference

sys.path.append(str(Path(__file__).parents[1]))

from campaign_table import line, write_table


def verdict(content: str, folder: Path) -> str:
    """Return how a profile differs from that of the table; empty if it does not."""
    (folder / "own.csv").write_text(content)
    catalog = Catalog(base=folder)
    return difference(load_profile("own.csv", catalog), load_profile("us-standard-1976", catalog))


def main() -> None:
    """Compare every profile and write how many are mistaken."""
    mistaken: dict[str, list[bool]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for kind, number, content in cases():
            found = verdict(content, Path(folder))
            wrong = bool(found) != (kind == "bad")
            mistaken.setdefault(kind, []).append(wrong)
            if wrong:
                print(kind, number, found or "taken for the same air")
    lines = (line(f"{kind} profiles", len(wrong), sum(wrong)) for kind, wrong in mistaken.items())
    write_table(Path(__file__).with_name("table.csv"), lines)


if __name__ == "__main__":
    main()
