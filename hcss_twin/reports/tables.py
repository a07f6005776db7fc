"""Tables, labelled lines and numbers as text, shown as HTML on pages and as aligned columns on the terminal."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

__all__ = ["Table"]

WIDTH = 120
"""Longest line of wrapped text on a terminal, characters."""


@dataclass(frozen=True)
class Table:
    """A table of text, for a page or a terminal.

    Attributes
    ----------
    header : sequence of str
    rows : sequence of sequence of str
        Each row must have as many cells as the header, else ValueError. The caller formats the numbers.
    caption : str
    text_columns : int
        Number of text columns from the left. The others hold numbers and are right-aligned.
    """

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""
    text_columns: int = 1

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.header):
                raise ValueError(f"a row of {len(row)} cells in a table of {len(self.header)}: {list(row)}")

    def lines(self) -> Iterator[str]:
        """Yield the caption and the aligned rows."""
        if self.caption:
            yield self.caption
        yield from self.aligned([self.header, *self.rows], self.text_columns)

    @staticmethod
    def aligned(rows: Sequence[Sequence[str]], text_columns: int = 1, indent: str = "  ") -> Iterator[str]:
        """Yield rows as lines with aligned columns: text left, numbers right.

        A row of one cell is a heading: it is not indented and does not widen its column.
        """
        columns = max((len(row) for row in rows), default=0)
        widths = [max(len(row[column]) for row in rows if 1 < len(row) > column) for column in range(columns)]
        for row in rows:
            if len(row) == 1:
                yield row[0]
                continue
            cells = (
                f"{cell:<{width}}" if column < text_columns else f"{cell:>{width}}"
                for column, (cell, width) in enumerate(zip(row, widths, strict=False))
            )
            yield (indent + "  ".join(cells)).rstrip()

    @staticmethod
    def number(value: float | None, digits: int = 4, missing: str = "-") -> str:
        """Return a number with significant digits, or ``missing`` for None and non-finite values."""
        return missing if value is None or not math.isfinite(value) else f"{value + 0.0:.{digits}g}"

    @staticmethod
    def ordinal(number: int) -> str:
        """Return ``1st``, ``2nd``, ``3rd``, ``4th``, ``11th``, ``21st`` and so on."""
        teens = number % 100 in (11, 12, 13)
        return f"{number}{'th' if teens else {1: 'st', 2: 'nd', 3: 'rd'}.get(number % 10, 'th')}"

    @staticmethod
    def labelled(label: str, text: str, size: int, hanging: int = 0) -> str:
        """Return text after its label, wrapped at 120 characters.

        Parameters
        ----------
        label : str
            Empty for lines that belong to the label above.
        text : str
        size : int
            Characters reserved for the label.
        hanging : int
            Extra indent of the second and later lines, characters.
        """
        start = f"  {label:<{size}}"
        after = " " * (len(start) + hanging)
        return textwrap.fill(
            text, WIDTH, initial_indent=start, subsequent_indent=after, break_on_hyphens=False, break_long_words=False
        )

    @staticmethod
    def frames_text(count: int) -> str:
        """Return ``one frame`` or ``N frames``."""
        return "one frame" if count == 1 else f"{count} frames"


def class_text(of: str) -> str:
    """Return a class of pixels in words: only scenarios tell the paper's cloud types from others by their names."""
    return of.removeprefix("paper-")


def bound_text(bound: float | None) -> str:
    """Return the bound of omitted physics relative to the radiance: a percentage, or a factor if 1 or more."""
    if bound is None:
        return "unknown"
    if bound == 0.0:
        return "nothing"
    return f"{bound:.2g} x" if bound >= 1.0 else f"{100.0 * bound:.2g} %"
