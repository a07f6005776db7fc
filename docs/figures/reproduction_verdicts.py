"""Put the verdicts of ``hcss reproduce`` into docs/development/reproduction.md.

::

    hcss reproduce --json found.json
    python docs/figures/reproduction_verdicts.py found.json            # prints the table
    python docs/figures/reproduction_verdicts.py found.json --write    # puts it into the page
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from pathlib import Path
from typing import Any

from hcss_paper.index import heading
from hcss_paper.reproduction import Row
from hcss_paper.run import relative

PAGE = Path(__file__).parents[1] / "development" / "reproduction.md"
BEGIN, END = "<!-- made by docs/figures/reproduction_verdicts.py -->\n", "<!-- end -->\n"


def table(found: dict[str, Any]) -> str:
    """Return the verdicts as Markdown."""
    counts = Counter(each["verdict"] for each in found.values())
    lines = [
        f"{len(found)} items: {', '.join(f'{count} {name}' for name, count in sorted(counts.items()))}.",
        "",
        "| item | verdict | largest difference | why it is not reproducible |",
        "|---|---|---|---|",
    ]
    for name, each in found.items():
        agrees = each["verdict"].startswith("reproduced")
        why = "" if agrees else each.get("reason", each.get("error", ""))
        cells = (heading(name), each["verdict"], largest(each), why)
        lines.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    return "\n".join(lines) + "\n"


def largest(item: dict[str, Any]) -> str:
    """Return the largest difference of an item's rows, as a share of what is printed."""
    keys = ("label", "unit", "published", "computed", "physical")
    shares = [relative(Row(**{key: row[key] for key in keys})) for row in item.get("rows", ())]
    known = [abs(share) for share in shares if share is not None]
    return f"{100 * max(known):.2g} %" if known else "-"


def main() -> None:
    """Print the table, or write it into the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("found", type=Path)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    made = table(json.loads(arguments.found.read_text(encoding="utf-8")))
    if not arguments.write:
        sys.stdout.write(made)
        return
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    PAGE.write_text(f"{before}{BEGIN}{made}{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
