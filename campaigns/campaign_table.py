"""The committed table of a campaign: what was tried, how often, how often it failed, and quantiles of a measure.

Rows, from which a campaign computes it, lie beside it in ``rows*`` and are not committed.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path

import numpy as np

FIELDS = ("what", "tried", "failed", "measure", "median", "95 %", "largest")


def line(what: str, tried: int, failed: int, measure: str = "", values: Iterable[float] = ()) -> dict[str, str]:
    """Return a line; the quantiles are those of the values of the measure."""
    values = list(values)
    quantiles = [f"{each:.3g}" for each in np.quantile(values, (0.5, 0.95, 1.0))] if values else [""] * 3
    return dict(zip(FIELDS, (what, str(tried), str(failed), measure, *quantiles), strict=True))


def write_table(path: Path, lines: Iterable[dict[str, str]]) -> None:
    """Write and print the table."""
    lines = list(lines)
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, FIELDS, lineterminator="\n")
        table.writeheader()
        table.writerows(lines)
    for each in lines:
        print("; ".join(f"{name}: {value}" for name, value in each.items() if value))


def read_table(path: Path) -> list[dict[str, str]]:
    """Return the lines of a table."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))
