"""Tables of errors in docs/development/light.md, from those of tiers.py.

python plugins/hcss-light/benchmarks/tables.py [--check]
"""

from __future__ import annotations

import csv
import re
import sys
from pathlib import Path

PLUGIN = Path(__file__).parents[1]
PAGE = PLUGIN.parents[1] / "docs" / "development" / "light.md"
TIERS = ("columns", "slant", "source")
HIDDEN = 3.0
"""Standard errors of the mean below which an rms is hidden in the noise, as in hcss_light.stated."""


def markdown(path: Path) -> str:
    """Return the table of bias and rms: kelvin by night, percent by day."""
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    cases: dict[tuple[str, float, str, str], dict[str, dict[str, str]]] = {}
    for row in rows:
        if row["band"] == "mwir" or row["sun"] == "night":
            key = row["type"], float(row["view_deg"]), row["band"], row["sun"]
            cases.setdefault(key, {})[row["tier"]] = row
    kinds = list(dict.fromkeys(row["type"] for row in rows))
    lines = ["| type | view | band | columns | slant | source |", "|---|---|---|---|---|---|"]
    for key in sorted(cases, key=lambda key: (kinds.index(key[0]), key[1], key[2], key[3] == "day")):
        kind, view, band, sun = key
        name = "10.8 um" if band == "lwir" else f"3.75 um, {sun}"
        cells = " | ".join(_cell(cases[key][tier], sun) for tier in TIERS)
        lines.append(f"| {kind} | {view:g} | {name} | {cells} |")
    return "\n".join(lines)


def of_layers() -> str:
    """Return the table of two layers."""
    with (PLUGIN / "benchmarks" / "errors-layers.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["band"] == "mwir" or row["sun"] == "night"]
    cases: dict[tuple[str, float, str, str], dict[str, dict[str, str]]] = {}
    for row in rows:
        key = f"{row['lower']} under {row['upper']}", float(row["view_deg"]), row["band"], row["sun"]
        cases.setdefault(key, {})[row["tier"]] = row
    lines = ["| layers | view | band | columns | source |", "|---|---|---|---|---|"]
    for key in sorted(cases, key=lambda key: (*key[:3], key[3] == "day")):
        layers, view, band, sun = key
        name = "10.8 um" if band == "lwir" else f"3.75 um, {sun}"
        cells = " | ".join(_cell(cases[key][tier], sun) for tier in ("columns", "source"))
        lines.append(f"| {layers} | {view:g} | {name} | {cells} |")
    return "\n".join(lines)


def _cell(row: dict[str, str], sun: str) -> str:
    if sun == "night":
        return f"{float(row['bias_K']):+.2f} / {float(row['rms_K']):.2f} K"
    bias, rms, hidden = (100.0 * each for each in (float(row["bias"]), float(row["rms"]), HIDDEN * float(row["noise"])))
    return f"{bias:+.1f} / {'< ' if rms < hidden else ''}{max(rms, hidden):.1f} %"


def main() -> int:
    """Write the tables; with ``--check`` say whether the page has others."""
    tables = {
        "table": markdown(PLUGIN / "src" / "hcss_light" / "errors.csv"),
        "pixels of 20 m": markdown(PLUGIN / "benchmarks" / "errors-20m.csv"),
        "layers": of_layers(),
    }
    text = PAGE.read_text(encoding="utf-8")
    own = text
    for name, table in tables.items():
        whole = f"<!-- {name} -->\n{table}\n<!-- end -->"
        own = re.sub(f"<!-- {name} -->.*?<!-- end -->", lambda _, whole=whole: whole, own, flags=re.DOTALL)
    if own != text and "--check" in sys.argv[1:]:
        print(f"{PAGE.name} has other tables than those of the measurements")
        return 1
    PAGE.write_text(own, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
