"""Compute items one by one; if one fails, the others are still computed."""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, get_args

from hcss_evaluate.numbers import json_number

from hcss_paper.index import Item
from hcss_paper.reproduction import Reproduction, Row, Verdict, settled
from hcss_twin import __version__
from hcss_twin.reports.figures import Figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Outcome:
    """An item and its result.

    Attributes
    ----------
    item : Item
    result : Reproduction or None
        None if the computation failed.
    error : str
        Type and message of the exception; empty if there was none.
    seed : int
        Seed of the random fields.
    pictures : sequence of bytes
        Drawings as PNG.
    """

    item: Item
    result: Reproduction | None
    error: str
    seed: int
    pictures: Sequence[bytes] = ()

    @property
    def verdict(self) -> str:
        """Verdict of the result, or "failed"."""
        return "failed" if self.result is None else self.result.verdict

    @property
    def worst(self) -> Row | None:
        """The row with the largest relative difference; None if nothing is compared."""
        rows = () if self.result is None else self.result.rows
        return max(
            (row for row in rows if relative(row) is not None), key=lambda row: abs(relative(row) or 0.0), default=None
        )

    @property
    def compared(self) -> int:
        """Number of printed numbers that are compared with computed ones."""
        return sum(row.difference is not None for row in (() if self.result is None else self.result.rows))

    @property
    def free(self) -> frozenset[str]:
        """Names of the fitted inputs, each of which is one number fitted to the paper's numbers."""
        inputs = () if self.result is None else self.result.fitted_inputs
        return frozenset(fitted.name for fitted in inputs if fitted.name is not None)

    @property
    def choices(self) -> frozenset[str]:
        """Interpretations and values in words that were chosen because they give the paper's numbers."""
        inputs = () if self.result is None else self.result.fitted_inputs
        return frozenset(fitted.text for fitted in inputs if fitted.name is None)

    def as_dict(self) -> dict[str, Any]:
        """Return the content of the JSON file."""
        head = {"title": self.item.title, "hcss_twin": __version__, "seed": self.seed, "verdict": self.verdict}
        if self.result is None:
            return {**head, "error": self.error}
        columns = ("published", "computed", "difference", "mixture", "physical")
        return {
            **head,
            "reason": self.result.reason,
            "numbers_compared": self.compared,
            "free_inputs": len(self.free),
            "choices": len(self.choices),
            "rows": [
                {"label": row.label, "unit": row.unit, **{name: json_number(getattr(row, name)) for name in columns}}
                for row in self.result.rows
            ],
            "checks": [{"statement": check.statement, "holds": bool(check.holds)} for check in self.result.checks],
            "fitted_inputs": [asdict(fitted) for fitted in self.result.fitted_inputs],
            "notes": list(self.result.notes),
        }


def totals(outcomes: Sequence[Outcome]) -> list[str]:
    """Return one line for each verdict: items, numbers compared, and the different inputs and choices they need."""
    lines = []
    for verdict in dict.fromkeys((*get_args(Verdict), "failed")):
        of_it = [outcome for outcome in outcomes if outcome.verdict == verdict]
        if of_it:
            numbers, free, choices = (
                sum(outcome.compared for outcome in of_it),
                len(frozenset().union(*(outcome.free for outcome in of_it))),
                len(frozenset().union(*(outcome.choices for outcome in of_it))),
            )
            lines.append(
                f"{len(of_it)} {verdict}: {numbers} numbers compared, {free} fitted inputs and {choices} choices"
            )
    return lines


def relative(row: Row) -> float | None:
    """Return the difference relative to the published number, or None if it is undefined.

    For percentages it is the difference itself, as a fraction.
    """
    if row.difference is None or row.published is None:
        return None
    if row.unit == "%":
        return row.difference / 100.0
    if row.published == 0.0:
        return 0.0 if row.difference == 0.0 else None
    share = row.difference / abs(row.published)
    return share if math.isfinite(share) else None


def require_numbers(result: Reproduction, expected: int) -> None:
    """Raise ValueError if an item does not compare as many printed numbers as the index states."""
    found = sum(row.difference is not None for row in result.rows)
    if found != expected:
        raise ValueError(f"rows: {found} printed numbers are compared, allowed: {expected}, as the index states")


def outcomes(items: Iterable[Item], seed: int) -> Iterator[Outcome]:
    """Compute items one by one; ``seed`` is that of the random fields."""
    for item in items:
        module, _, function = item.target.partition(":")
        try:
            result = settled(getattr(import_module(module), function)(seed))
            require_numbers(result, item.numbers)
            # Drawn here, because a figure may fail only when it is drawn.
            pictures = tuple(small_png(drawing.figure) for drawing in result.drawings)
        except Exception as cause:  # whatever one item raises, the others are still computed
            yield Outcome(item, None, f"{type(cause).__name__}: {cause}", seed)
        else:
            yield Outcome(item, result, "", seed, pictures)


COLOURS = 256
"""Largest number of colours of a palette."""


def small_png(figure: Figure, dpi: int = 110) -> bytes:
    """Return a figure as PNG of at most 256 colours, a quarter to a half smaller for pictures of clouds.

    The same figure gives the same bytes. There is no dithering, so areas of one colour stay uniform. A figure whose
    file is smaller in full colour is not reduced.
    """
    from PIL import Image

    whole = Figures.png(figure, dpi)
    stream = io.BytesIO()
    with Image.open(io.BytesIO(whole)) as image:
        # A palette has no transparency, and figures have a white background.
        opaque = Image.alpha_composite(Image.new("RGBA", image.size, "white"), image.convert("RGBA"))
        palette = opaque.convert("RGB").quantize(COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
        palette.save(stream, "PNG", optimize=True)
    reduced = stream.getvalue()
    return reduced if len(reduced) < len(whole) else whole
