"""Computing items one after the other: one that fails does not keep the others from being computed."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import Any

from hcss_twin.core.json_numbers import json_number
from hcss_twin.paper.item import Item, Reproduction, Row
from hcss_twin.paper.verdict import settled
from hcss_twin.report.page.pictures import small_png
from hcss_twin.version import __version__


@dataclass(frozen=True)
class Outcome:
    """An item and what came of it.

    Attributes
    ----------
    item : Item
    found : Reproduction or None
        None where it failed.
    error : str
        Type and message of the exception; empty where there was none.
    seconds : float
        It took.
    seed : int
        Of random fields.
    pictures : sequence of bytes
        Its drawings as PNG.
    """

    item: Item
    found: Reproduction | None
    error: str
    seconds: float
    seed: int
    pictures: Sequence[bytes] = ()

    @property
    def verdict(self) -> str:
        """One of the three, or "failed"."""
        return "failed" if self.found is None else self.found.verdict

    @property
    def worst(self) -> Row | None:
        """The row with the largest relative difference; None where nothing is compared."""
        rows = () if self.found is None else self.found.rows
        return max((row for row in rows if relative(row) is not None), key=_size, default=None)

    def as_dict(self) -> dict[str, Any]:
        """What is written as JSON."""
        made = {"title": self.item.title, "hcss_twin": __version__, "seed": self.seed}
        if self.found is None:
            return {**made, "verdict": "failed", "error": self.error}
        return {
            **made,
            "verdict": self.found.verdict,
            "reason": self.found.reason,
            "rows": [
                {
                    "label": row.label,
                    "unit": row.unit,
                    "published": json_number(row.published),
                    "computed": json_number(row.computed),
                    "difference": json_number(row.difference),
                    "physical": json_number(row.physical),
                }
                for row in self.found.rows
            ],
            "checks": [{"statement": each.statement, "holds": bool(each.holds)} for each in self.found.checks],
            "fitted_inputs": [asdict(each) for each in self.found.fitted_inputs],
            "notes": list(self.found.notes),
        }


def relative(row: Row) -> float | None:
    """Return a row's difference as a share of what is published; None where there is no such share.

    Of percentages it is the difference itself: they are shares already.
    """
    if row.difference is None or row.published is None:
        return None
    if row.unit == "%":
        return row.difference / 100.0
    if row.published == 0.0:
        return 0.0 if row.difference == 0.0 else None
    share = row.difference / abs(row.published)
    return share if math.isfinite(share) else None


def _size(row: Row) -> float:
    return abs(relative(row) or 0.0)


def outcomes(items: Iterable[Item], seed: int) -> Iterator[Outcome]:
    """Compute items, each when it is asked for.

    Parameters
    ----------
    items : iterable of Item
    seed : int
        Of random fields.
    """
    for item in items:
        start = time.monotonic()
        found, error = None, ""
        pictures: tuple[bytes, ...] = ()
        try:
            made = settled(_target(item)(seed))
            # drawn here because a figure may raise only when it is drawn
            pictures = tuple(small_png(drawing.figure) for drawing in made.drawings)
            found = made
        except Exception as cause:  # whatever one item raises, the others are still wanted
            error = f"{type(cause).__name__}: {cause}"
        yield Outcome(item, found, error, time.monotonic() - start, seed, pictures)


def _target(item: Item) -> Any:
    module, _, function = item.target.partition(":")
    return getattr(import_module(module), function)
