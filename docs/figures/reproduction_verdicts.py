"""Put the verdicts of ``hcss reproduce`` into docs/development/reproduction.md.

::

    hcss reproduce --json found.json
    python docs/figures/reproduction_verdicts.py found.json            # prints the table
    python docs/figures/reproduction_verdicts.py found.json --write    # puts it into the page
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
from pathlib import Path
from typing import Any

from hcss_paper.index import heading
from hcss_paper.reproduction import Row
from hcss_paper.run import relative

PAGE = Path(__file__).parents[1] / "development" / "reproduction.md"
CHECKLIST = Path(__file__).with_name("paper_checklist.csv")
"""What the paper has, in 54 numbered items, each with a command."""

BLOCKED = {
    "table-4-swir": "tried about 40 variants, up to three free inputs: 4.8 % rms at best; spectra are not published",
    "table-8-ev": "tried 1280 readings of eq 21; the images are not published",
    "table-9-ev": "tried the same readings for EV and Den; the images are not published",
    "figure-9": "the satellite images are not published",
    "figure-14": "the real image is not published",
}
"""Items that depend on unpublished data, and what was tried."""
BEGIN, END = "<!-- made by docs/figures/reproduction_verdicts.py -->\n", "<!-- end -->\n"


def table(found: dict[str, Any]) -> str:
    """Return the verdicts as Markdown."""
    lines = [
        "| verdict | items | numbers compared | fitted inputs | choices |",
        "|---|---|---|---|---|",
        *(_total(name, list(items)) for name, items in _by_verdict(found)),
        "",
        "| item | verdict | largest difference | of the mixture | numbers, inputs, choices | why not reproducible |",
        "|---|---|---|---|---|---|",
    ]
    for name, each in found.items():
        agrees = each["verdict"].startswith("reproduced")
        why = "" if agrees else each.get("reason", each.get("error", ""))
        cells = (
            heading(name),
            each["verdict"],
            largest(each),
            largest(each, "mixture"),
            ", ".join(map(str, sizes(each))),
            why,
        )
        lines.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    return "\n".join([*lines, "", *checklist(found)]) + "\n"


def checklist(found: dict[str, Any]) -> list[str]:
    """Return the lines of a table of the paper's items, each with its command and what came out."""
    lines = ["| items of the paper | what | command | result |", "|---|---|---|---|"]
    with CHECKLIST.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            names = [word for word in row["commands"].split() if word in found]
            results = [f"{heading(name)}: {found[name]['verdict']}" for name in names]
            results += [f"blocked: {BLOCKED[name]}" for name in names if name in BLOCKED]
            commands = ", ".join(f"`{command}`" for command in row["commands"].split("; "))
            lines.append(f"| {row['items']} | {row['what']} | {commands} | {'; '.join(results) or 'runs'} |")
    return lines


def sizes(item: dict[str, Any]) -> tuple[int, int, int]:
    """Return how many numbers are compared, how many inputs were fitted, and how many choices were made."""
    compared = sum(row["difference"] is not None for row in item.get("rows", ()))
    inputs = item.get("fitted_inputs", ())
    named = sum(each["name"] is not None for each in inputs)
    return compared, named, len(inputs) - named


def _by_verdict(found: dict[str, Any]) -> list[tuple[str, list[dict[str, Any]]]]:
    verdicts = sorted({each["verdict"] for each in found.values()})
    return [(name, [each for each in found.values() if each["verdict"] == name]) for name in verdicts]


def _total(verdict: str, items: list[dict[str, Any]]) -> str:
    """Return a row of totals; an input or choice that serves several items counts once."""
    inputs = [each for item in items for each in item.get("fitted_inputs", ())]
    named = {each["name"] for each in inputs if each["name"] is not None}
    chosen = {each["text"] for each in inputs if each["name"] is None}
    numbers = sum(sizes(item)[0] for item in items)
    return f"| {verdict} | {len(items)} | {numbers} | {len(named)} | {len(chosen)} |"


def largest(item: dict[str, Any], column: str = "computed") -> str:
    """Return the largest difference of an item's rows from a column, as a share of what is printed."""
    rows = [Row(row["label"], row["unit"], row["published"], row[column]) for row in item.get("rows", ())]
    shares = [relative(row) for row in rows]
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
